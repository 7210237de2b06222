"""Paths apart from their timing, learned from one recording or from several repetitions.

A path says where a face goes, a timing when. Where the two are told apart, each recorded frame has
its own moment s of the path, in order:

    V_r(s) = V₀_r + s·Δ_r + Σ_k b_k(s)·D_k

Repetitions r share the bends; ends and moments are their own. The moments begin where the straight
line is nearest to the frames, and become those at which the path is closest to them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from elastomorph.fitting.learned import Learned, PathErrors, Repetition, never_worse
from elastomorph.fitting.path_fit import PathFit, Splines
from elastomorph.fitting.recordings import KNOTS, Recordings, enough_knots, path_through
from elastomorph.fitting.takes import Take, counted_together
from elastomorph.rig.timing import Timing, from_keys

__all__ = ["Wanted", "learned_evenly", "timing_through"]

Floats = NDArray[np.float64]

_ROUNDS = 2
# How far the keys of a timing may leave the moments between them.
_CLOSE, _DIGITS = 0.01, 4


@dataclass(frozen=True)
class Wanted:
    """What paths are made of."""

    bends: int
    knots: int | None  # None: as many as it takes
    recorded: bool  # Whether bends are recorded frames


def learned_evenly(takes: Sequence[Take], wanted: Wanted, say: Callable[[str], None]) -> Learned:
    """The path between the ends of the first recording, with the timing of each beside it."""
    say("fitting")
    limits = [take.closest(take.line)[0] for take in takes]
    path = _path(takes, wanted, limits)
    found = [take.closest(path) for take in takes]
    laws = [
        timing_through(take.motion.times, moments)
        for take, (_, moments) in zip(takes, found, strict=True)
    ]
    path = replace(
        path,
        errors=PathErrors.joined([errors for errors, _ in found]),
        straight=PathErrors.joined(limits),
        timing=laws[0],
    )
    if len(takes) == 1:
        return path
    repetitions = []
    for number, (take, law) in enumerate(zip(takes, laws, strict=True)):
        say(f"leaving out recording {number + 1} of {len(takes)}")
        rest = [k for k in range(len(takes)) if k != number]
        other = _path([takes[k] for k in rest], wanted, [limits[k] for k in rest])
        carried, _ = take.closest(other)
        repetitions.append(Repetition(law, found[number][0], limits[number], carried))
    return replace(path, repetitions=tuple(repetitions))


def _path(takes: Sequence[Take], wanted: Wanted, limits: Sequence[PathErrors]) -> Learned:
    """The path for all recordings, on none worse than the straight line."""
    motions, counted = [take.motion for take in takes], counted_together(takes)
    best = replace(takes[0].line, errors=PathErrors.joined(limits))
    nearest = even = [take.nearest for take in takes]
    start = None
    # Each recording counts alike, however large its movement is.
    units = [limit.lme or 1.0 for limit in limits]
    for count in range(1, wanted.bends + 1):
        # From the moments of the straight line, as if no path of fewer bends were known: what
        # begins at those of one carries over to recordings left out less well.
        moments, fewer, least = even, best, np.inf
        origins: list[tuple[PathFit, Splines] | None] = [None] * _ROUNDS
        origins += [] if wanted.recorded or start is None else [start]
        for origin in origins:
            if origin is not None:
                if best is not fewer:
                    break
                moments = nearest
            together = Recordings(motions, moments, takes[0].along, counted, False, units)
            several = KNOTS if wanted.knots is None and len(takes) > 1 else wanted.knots
            knots, limited = enough_knots(together, count, several)
            splines = Splines.at(together.times, knots)
            own = min(count, splines.values.shape[1])
            fit = path_through(together, splines, own, recorded=wanted.recorded, start=origin)

            def measured(
                path: Learned, known: PathErrors = fewer.errors
            ) -> tuple[float, tuple[float, PathErrors, list[Floats]]]:
                found = [take.closest(path) for take in takes]
                pairs = zip(found, limits, strict=True)
                worst = max(errors.part_of(limit) for (errors, _), limit in pairs)
                together = PathErrors.joined([errors for errors, _ in found])
                moments = [own for _, own in found]
                return max(worst, together.part_of(known)), (worst, together, moments)

            path, worse, (worst, errors, moments) = never_worse(
                takes[0].line, fit, splines, measured
            )
            if worse <= 1.0 and worst < least:
                best, least = replace(path, errors=errors), worst
                nearest, start = moments, (fit, splines)
        best = replace(best, knots=knots, knots_are_the_limit=limited and len(takes) == 1)
    return best


def timing_through(times: Floats, moments: Floats) -> Timing:
    """A timing with few keys through the (T,) moments at which a path is at (T,) times."""
    keys = [0, len(times) - 1]
    while True:
        pairs = [(float(times[k]), float(moments[k])) for k in sorted(keys)]
        law = from_keys([(round(t, _DIGITS), round(moment, _DIGITS)) for t, moment in pairs])
        away = np.abs(law.at(times) - moments)
        if away.max() <= _CLOSE or len(keys) == len(times):
            return law
        keys.append(int(away.argmax()))
