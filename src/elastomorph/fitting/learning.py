"""From a recorded movement to the path that follows it best."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from elastomorph.curves import CurveNetwork, extract_curves, require_curves_of
from elastomorph.errors import MeshError, ParameterError, TopologyError, warn
from elastomorph.evaluation.confidence import LEAST, ConfidenceLike, counted_of, require_some
from elastomorph.evaluation.curve_errors import CurveVertices
from elastomorph.evaluation.evaluation import recorded_motion
from elastomorph.fitting.learned import Learned, PathErrors, never_worse
from elastomorph.fitting.path_fit import PathFit, Splines
from elastomorph.fitting.recordings import MOST_KNOTS, Recordings, enough_knots, path_through
from elastomorph.fitting.repetitions import Wanted, learned_evenly
from elastomorph.fitting.takes import Take
from elastomorph.model.mesh import require_same_topology
from elastomorph.model.sequence import MeshSequence
from elastomorph.numbers import is_whole

__all__ = ["SHAPES", "TIMINGS", "learn"]

Recorded = MeshSequence | str | Path

SHAPES = ("free", "scanned")
TIMINGS = ("recorded", "even")
# What comes back by more than this part of its way holds several movements, or a part of one.
_SEVERAL, _PART = 0.5, 0.25
# Faces of which one is so many times as large as the other are not in the same unit.
_SIZES = 2.0


def learn(
    recording: Recorded | Sequence[Recorded],
    bends: int = 1,
    *,
    shapes: str = "free",
    timing: str = "recorded",
    knots: int | None = None,
    curves: CurveNetwork | None = None,
    confidence: ConfidenceLike | Sequence[ConfidenceLike | None] | None = None,
    least_confidence: float = LEAST,
    progress: Callable[[str], None] | None = None,
) -> Learned:
    """The path that follows a recorded movement best: Δ, a curve for Δ, and bends.

        V(t) = V₀ + a(t)·Δ + Σ_k b_k(t)·D_k

    over all frames. V₀ is the first frame and Δ the way to the last, both exact; the curves are
    cubic splines, a from 0 to 1, b_k zero at both ends. What is made small is the largest error of
    a vertex in any frame, and the largest mean error of a curve of the face, both as parts of those
    of the straight line; neither is ever larger than that. a(t) - t is the curve of the last bend,
    Δ itself, which costs no further target where a format can play it on Δ.

    Paths of fewer bends come first: a bend more leaves neither of the two larger, on all vertices.

    Several recordings are repetitions: they share the D_k and keep ends and timing of their own.
    Each is also left out once, to see if the path carries over.

    Args:
        recording: The movement from neutral to target, or its files; or several, of one mesh.
        bends: How many shapes D_k, from 0 on; each needs a frame between the ends.
        shapes: ``free``, or ``scanned``: the D_k are what recorded frames are off the straight
            path, so that each belongs to a scan.
        timing: ``recorded``: the path has the timing of the recording in it. ``even``: it goes on
            at an even pace, a(t) = t, and the timing is beside it; so it is of several recordings.
        knots: How many times the pieces of the curves meet at, from 0 on, with equally many frames
            between them; fewer where there are too few frames. By default seven, or of a single
            recording so many that they are not what limits the path.
        curves: The curves that errors are means over; found by `extract_curves` by default. All
            vertices together are one on a mesh without polygons.
        confidence: As of `evaluate`; of several recordings a list.
        least_confidence: The confidence from which on a vertex counts; 0 lets all count.
        progress: Called with what is being done.

    Returns:
        The path, a `Morph` with its errors. It leads between the ends of the first recording.

    Raises:
        FileError: A recording or confidence named by its files cannot be read.
        ParameterError: A setting is out of its range, or there are too few frames.
        TopologyError: Recordings are of different meshes.
        MeshError: A recording does not move, holds several movements, or starts at one place.
        CurveError: The curves belong to another mesh.
    """
    _require_settings(bends, shapes, timing, knots)
    takes = _takes(recording, curves, confidence, least_confidence)
    _require_movements([take.motion for take in takes], bends)
    wanted = Wanted(bends, knots, shapes == "scanned")
    say = progress or (lambda _: None)
    even = timing == "even" or len(takes) > 1
    path = learned_evenly(takes, wanted, say) if even else _as_recorded(takes[0], wanted, say)
    return replace(path, method=f"learned {bends}")


def _takes(
    recording: Recorded | Sequence[Recorded],
    curves: CurveNetwork | None,
    confidence: ConfidenceLike | Sequence[ConfidenceLike | None] | None,
    least: float,
) -> list[Take]:
    """What was recorded, along the same curves."""
    several = isinstance(recording, Sequence) and not isinstance(recording, str)
    given: list[Any] = list(recording) if several else [recording]  # type: ignore[arg-type]
    if not given:
        raise ParameterError("there is nothing to learn from: give at least one recording")
    trusted: list[Any] = list(confidence) if several and confidence is not None else [confidence]  # type: ignore[arg-type]
    if len(trusted) == 1:
        trusted *= len(given) if confidence is None else 1
    if len(trusted) != len(given):
        raise ParameterError(
            f"'confidence' of {len(given)} recordings must be as many, found {len(trusted)}"
        )
    takes: list[Take] = []
    for number, (each, sure) in enumerate(zip(given, trusted, strict=True), start=1):
        motion, mask = recorded_motion(each, sure, least)
        try:
            require_same_topology((takes[0].motion if takes else motion).mesh, motion.mesh)
        except TopologyError as error:
            raise TopologyError(
                f"recording {number} is of another mesh than the first: {error}"
            ) from error
        along = takes[0].along if takes else _along(motion, curves)
        if mask is not None:
            require_some(mask, along)
        takes.append(Take(motion, along, counted_of(mask)))
    return takes


def _as_recorded(take: Take, wanted: Wanted, say: Callable[[str], None]) -> Learned:
    """The path with the timing of the recording in it."""
    times = take.motion.times
    straight = take.errors(take.line, times)
    recordings = Recordings([take.motion], [times], take.along, take.counted)
    best = replace(take.line, errors=straight, straight=straight)
    start: tuple[PathFit, Splines] | None = None
    # From fewer bends to more: where fitted from nothing these come out worse on all vertices, they
    # are fitted from the path of fewer, and else that one stays.
    for count in range(wanted.bends + 1):
        say(f"fitting {count} of {wanted.bends} bends")
        knots, limited = enough_knots(recordings, count, wanted.knots)
        splines = Splines.at(times, knots)

        def measured(path: Learned, fewer: PathErrors = best.errors) -> tuple[float, PathErrors]:
            errors = take.errors(path, times)
            return errors.part_of(fewer), errors

        for origin in (None,) if start is None or wanted.recorded else (None, start):
            fit = path_through(recordings, splines, count, recorded=wanted.recorded, start=origin)
            path, worst, errors = never_worse(take.line, fit, splines, measured)
            if worst <= 1.0:
                best = replace(path, errors=errors, straight=straight)
                start = fit, splines
                break
    return replace(best, knots=knots, knots_are_the_limit=limited)


def _along(recording: MeshSequence, curves: CurveNetwork | None) -> CurveVertices:
    """The curves that errors are means over."""
    count = len(recording.mesh.vertices)
    if curves is None and not len(recording.mesh.faces):
        every = np.arange(count)
        return CurveVertices(every, every[:1], np.array([count]))
    network = extract_curves(recording.mesh) if curves is None else curves
    require_curves_of(network, count, "the first frame")
    return CurveVertices.of(network, count)


def _require_settings(bends: int, shapes: str, timing: str, knots: int | None) -> None:
    for name, text, known in (("shapes", shapes, SHAPES), ("timing", timing, TIMINGS)):
        if text not in known:
            raise ParameterError(f"{name} must be {' or '.join(known)}, found {text!r}")
    for name, value, most in (("bends", bends, np.inf), ("knots", knots or 0, MOST_KNOTS)):
        if not is_whole(value) or not 0 <= value <= most:
            bound = "of 0 or more" if most == np.inf else f"from 0 to {most}"
            raise ParameterError(f"{name} must be a whole number {bound}, found {value!r}")
    most = MOST_KNOTS if knots is None else knots
    if bends > most + 2:
        raise ParameterError(
            f"curves with {most} knots tell {most + 2} bends apart, {bends} were asked for: "
            f"give {bends - 2} knots or more"
        )


def _require_movements(takes: Sequence[MeshSequence], bends: int) -> None:
    for number, take in enumerate(takes, start=1):
        which = f"recording {number}" if len(takes) > 1 else "the recording"
        _require_frames(take, bends, which)
        _require_one_movement(take, which)
    _require_repetitions(takes)


def _require_frames(take: MeshSequence, bends: int, which: str) -> None:
    inner = len(take) - 2
    if bends > inner:
        need = "1 bend needs a frame" if bends == 1 else f"{bends} bends need a frame each"
        fewer = f"{inner} or fewer" if inner else "0, the straight line"
        raise ParameterError(
            f"{need} between the ends, but {which} of {len(take)} frames has {inner}: ask for "
            f"{fewer}"
        )


def _require_repetitions(takes: Sequence[MeshSequence]) -> None:
    """Refuse recordings in different units, and one given twice, which carries over to itself."""
    for number, take in enumerate(takes[1:], start=2):
        times = take.mesh.diameter / takes[0].mesh.diameter
        if not 1 / _SIZES < times < _SIZES:
            raise MeshError(
                f"recording {number} is {times:.3g} times as large as the first: repetitions are "
                "of one face in one unit"
            )
        for before, other in enumerate(takes[: number - 1], start=1):
            if len(take) == len(other) and np.array_equal(take.frames, other.frames):
                raise ParameterError(
                    f"recordings {before} and {number} are the same: give each repetition once"
                )


def _require_one_movement(take: MeshSequence, which: str) -> None:
    """Refuse a recording that leads nowhere or holds several movements; warn of a turn back."""
    if not take.mesh.diameter > 0:
        raise MeshError(
            "all vertices of the first frame are at one place, so its diameter D is 0 and errors "
            "cannot be given as a fraction of it"
        )
    # Means of distances, not of squares: one stray vertex is no movement.
    away = np.array([np.linalg.norm(each - take.frames[0], axis=1).mean() for each in take.frames])
    if not away.any():
        raise MeshError(f"{which} does not move: all of its frames are the first one")
    behind = (np.maximum.accumulate(away) - away) / away.max()
    if behind.max() > _SEVERAL:
        back = int(np.argmax(behind > _SEVERAL))
        apex = int(away[: back + 1].argmax())
        raise MeshError(
            f"{which} holds more than one movement: it goes away from its first frame until "
            f"frame {apex} ({take.names[apex]}), and then comes back by {behind.max():.0%} of its "
            f"way, but a path leads from a neutral to one target; end it there with "
            f"part(0, {apex}) or --frames 0-{apex}, or take every movement of it by --movements"
        )
    if behind[-1] > _PART:
        apex = int(away.argmax())
        warn(
            f"{which} turns back after frame {apex} ({take.names[apex]}) and ends with "
            f"{away[-1] / away[apex]:.0%} of its way, in the middle of a movement; to end it at "
            f"the apex, part(0, {apex}) or --frames 0-{apex}"
        )
