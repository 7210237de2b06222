"""From a recorded movement, or several repetitions of one, to the path that follows it best.

A path says where a face goes, a timing when. Where the two are told apart, each recorded frame has
its own moment s of the path, in order:

    V_r(s) = V₀_r + s·Δ_r + Σ_k b_k(s)·D_k

Repetitions r share the bends; ends and moments are their own. The moments begin where the straight
line is nearest to the frames, and become those at which the path is closest to them.

Recordings as what a path is fitted to: how far their frames are off straight lines.

The curves of a path are fitted to a sample of the vertices: those farthest from the straight lines,
and others spread evenly. Then every vertex is given the shapes that go best with these curves.
Vertices are looked at in blocks, so that long recordings of dense meshes need little memory beside
their own.

Bends may be recorded frames. The bend of a frame is how far it is off the straight path, so that an
artist can sculpt or clean the scan it comes from. Which frames: those whose shapes, with the best
splines for them, leave the least sum of squares, found one after the other and then exchanged while
that helps. All that is needed of the vertices is the matrix of the products of frames.

What was learned from a recording: a path, and how well it follows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork, extract_curves, require_curves_of
from elastomorph.errors import MeshError, ParameterError, TopologyError, warn
from elastomorph.evaluation.confidence import LEAST, ConfidenceLike, counted_of, require_some
from elastomorph.evaluation.curve_errors import (
    CurveErrors,
    CurveVertices,
    frame_errors,
    free_timing,
)
from elastomorph.evaluation.evaluation import recorded_motion
from elastomorph.evaluation.path_fit import (
    Observed,
    PathFit,
    Splines,
    fitted,
    unexplained,
    worst_mended,
)
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import require_same_topology
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence
from elastomorph.numbers import is_whole
from elastomorph.rig.timing import Timing, from_keys, linear

_NONE = np.zeros((0, 0))
# A path carries over if it makes errors of recordings left out so many times smaller.
_CARRIES = 1.01
_PARTS = (1.0, 0.5, 0.25, 0.0)

Found = TypeVar("Found")


@dataclass(frozen=True, eq=False)
class PathErrors(CurveErrors):
    """The errors of a path on a recording, as fractions of D.

    Attributes:
        average: (T,) largest E_A over the curves in each frame.
        maximum: (T,) largest E_M over the curves in each frame.
    """

    average: NDArray[np.float64]
    maximum: NDArray[np.float64]

    @classmethod
    def of(
        cls,
        path: Morph,
        take: MeshSequence,
        moments: NDArray[np.float64],
        along: CurveVertices,
        counted: NDArray[np.bool_] | None = None,
    ) -> PathErrors:
        """Those of a path whose (T,) moments the frames of a recording are compared with."""
        return cls(*frame_errors(path, take, moments, along, counted))

    @classmethod
    def joined(cls, several: Sequence[PathErrors]) -> PathErrors:
        """Those of several recordings, one after the other."""
        parts = [(errors.average, errors.maximum) for errors in several]
        return cls(*map(np.concatenate, zip(*parts, strict=True)))

    def part_of(self, others: PathErrors) -> float:
        """How large the LME or LAE is beside another's, the larger of the two; 0 of nothing."""
        pairs = ((self.lme, others.lme), (self.lae, others.lae))
        return max((own / other if other else np.inf) if own else 0.0 for own, other in pairs)


_NO_ERRORS = PathErrors(_NONE, _NONE)


@dataclass(frozen=True, eq=False)
class Repetition:
    """One of several recordings that one path was learned from, with its own ends and timing.

    Attributes:
        timing: When it is where on the path.
        errors: Those of the path between its ends, at the moments at which they are smallest.
        straight: Those of the straight line, likewise.
        left_out: Those of the path learned from the other recordings, likewise.
    """

    timing: Timing
    errors: PathErrors
    straight: PathErrors
    left_out: PathErrors


@dataclass(frozen=True, eq=False, repr=False)
class Learned(Morph):
    """A path learned from recorded movements: a `Morph` that knows how well it follows.

    Attributes:
        errors: Those of the path on the recording; of several, one after the other.
        straight: Those of the straight line at an even pace. Where the path is apart from its
            timing, each recorded frame picks its own moment, of both.
        timing: When the recording, the first of several, is where on the path; even where the path
            has the timing in it.
        repetitions: The recordings, where there are several.
        knots: How many its curves were given.
        knots_are_the_limit: Whether more knots would help more than more bends.
    """

    errors: PathErrors = _NO_ERRORS
    straight: PathErrors = _NO_ERRORS
    timing: Timing = linear
    repetitions: tuple[Repetition, ...] = ()
    knots: int = 0
    knots_are_the_limit: bool = False

    @property
    def gain(self) -> float:
        """How many times smaller the largest error is than on the straight line."""
        return _ratio(self.straight.lme, self.errors.lme)

    @property
    def carried(self) -> float | None:
        """How many times smaller the mean LME of recordings left out is; None of a single one."""
        if not self.repetitions:
            return None
        straight = np.mean([one.straight.lme for one in self.repetitions])
        return _ratio(
            float(straight), float(np.mean([one.left_out.lme for one in self.repetitions]))
        )

    @property
    def conclusion(self) -> str:
        """Whether the path carries over to another repetition, in a sentence."""
        if self.carried is None:
            return (
                "Learned from one recording: whether it carries over to another repetition, only "
                "another one can tell."
            )
        worse = sum(one.left_out.lme > one.straight.lme for one in self.repetitions)
        count = len(self.repetitions)
        found = (
            f"learned without it, the path divides the largest error of a recording by "
            f"{self.carried:.2f}, and is worse than the straight line on {worse} of {count}"
        )
        if self.carried >= _CARRIES and 2 * worse < count:
            return f"It carries over: {found}."
        return f"It does not carry over: {found}; use it for these recordings only."

    def to_dict(self) -> dict[str, Any]:
        """What was found, ready for JSON; errors are fractions of D."""
        return {
            "method": self.method,
            "bends": len(self.bends),
            "knots": self.knots,
            "knots_are_the_limit": self.knots_are_the_limit,
            "timing": self.timing.name,
            "errors": _facts(self.errors),
            "linear": _facts(self.straight),
            "carried": self.carried,
            "conclusion": self.conclusion,
            "repetitions": [
                {
                    "timing": one.timing.name,
                    "errors": _facts(one.errors),
                    "linear": _facts(one.straight),
                    "left_out": _facts(one.left_out),
                }
                for one in self.repetitions
            ],
        }

    def __repr__(self) -> str:
        return (
            f"Learned({len(self.neutral.vertices):,} vertices, {len(self.bends)} bends: LME "
            f"{self.errors.lme:.3%} of D, linear {self.straight.lme:.3%})"
        )


def bent(bare: Learned, fit: PathFit, splines: Splines, part: float = 1.0) -> Learned:
    """A straight path with a part of the bends of a fit, Δ with its curve the last.

    Each bend is as large as it moves vertices, so that no weight is above 1.
    """
    fields: list[NDArray[np.float64]] = []
    laws: list[BendCurve] = []
    first = int(fit.paced)
    for weights, shape in zip(fit.weights.T[first:], fit.shapes[first:], strict=True):
        peak = splines.curve(weights).peak[1]
        if peak and part and shape.any():
            fields.append(shape.T * (part * peak * bare.neutral.diameter))
            laws.append(splines.curve(weights / peak))
    if fit.paced and part and fit.weights[:, 0].any():
        fields.append(bare.delta)
        laws.append(splines.curve(part * fit.weights[:, 0]))
    stacked = np.array(fields).reshape(-1, *bare.delta.shape)
    return replace(bare, bends=stacked, bend_curves=tuple(laws))


def never_worse(
    bare: Learned,
    fit: PathFit,
    splines: Splines,
    measured: Callable[[Learned], tuple[float, Found]],
) -> tuple[Learned, float, Found]:
    """The path with as much of its bends as leaves no error larger than the straight line's.

    `measured` says how large the errors of a path are beside those, and whatever else it found.
    """
    for part in _PARTS:
        path = bent(bare, fit, splines, part)
        worst, found = measured(path)
        if worst <= 1.0:
            break
    return path, worst, found


def _ratio(before: float, after: float) -> float:
    return before / after if after else float("inf")


def _facts(errors: PathErrors) -> dict[str, float]:
    return {
        "lme": errors.lme,
        "lae": errors.lae,
        "mean_lme": errors.mean_lme,
        "mean_lae": errors.mean_lae,
    }


Floats = NDArray[np.float64]

_RIDGE = 1e-9


def best_recorded(seen: Observed, splines: Splines, count: int) -> list[int]:
    """So many frames whose offsets are the best shapes, in their order."""
    offsets = seen.offsets if seen.counted is None else seen.offsets * seen.counted[:, None]
    rows = offsets.reshape(len(offsets), -1)
    if seen.fixed is not None:
        rows = np.concatenate([rows, seen.fixed.reshape(1, -1)])
    products = rows @ rows.T
    basis = np.linalg.qr(splines.values)[0]
    told = basis.T @ products[: len(offsets)]
    always = [len(offsets)] if seen.fixed is not None else []

    def explained(frames: list[int]) -> float:
        own = always + frames
        grams = products[np.ix_(own, own)]
        grams = grams + _RIDGE * np.trace(grams) * np.eye(len(own))
        return float(np.einsum("mi,mi->", told[:, own], np.linalg.solve(grams, told[:, own].T).T))

    inner = range(1, len(offsets) - 1)
    chosen: list[int] = []
    for _ in range(count):
        chosen.append(max(set(inner) - set(chosen), key=lambda f: explained([*chosen, f])))
    known, better = explained(chosen), True
    while better:
        better = False
        for place in range(count):
            others = [f for k, f in enumerate(chosen) if k != place]
            best = max(set(inner) - set(others), key=lambda f: explained([*others, f]))
            if (found := explained([*others, best])) > known * (1 + 1e-12):
                chosen, known, better = [*others, best], found, True
    return sorted(chosen)


Vertices = NDArray[np.int64] | slice

# So many vertices times frames are fitted at once, and looked at at once.
_SAMPLE, _BLOCK = 150_000, 600_000
_LEAST_SAMPLE = 256
KNOTS, MOST_KNOTS = 7, 64
_NOTHING = 1e-9  # Of D: curves that leave no more are not what limits a path
# Vertices that turn out worse than the sample by this join it, so often at most.
_WORSE, _MORE_ROUNDS = 1.02, 2


@dataclass(frozen=True, eq=False)
class Recordings:
    """One recording or several, each with its ends and the moments of its frames on the path."""

    takes: Sequence[MeshSequence]
    moments: Sequence[Floats]  # (T,) of each, from 0 to 1
    along: CurveVertices
    counted: NDArray[np.bool_] | None = None  # (T, V) of all frames together
    paced: bool = True  # Whether Δ has a curve of its own; for one recording only
    units: Sequence[float] = (1.0,)  # What the errors of each are counted in

    @property
    def diameter(self) -> float:
        """D of the first recording, in the unit of the vertices."""
        return self.takes[0].mesh.diameter

    @property
    def vertex_count(self) -> int:
        """V."""
        return len(self.takes[0].mesh.vertices)

    @property
    def times(self) -> Floats:
        """(T,) the moments of all frames together."""
        return np.concatenate(self.moments)

    def observed(self, vertices: Vertices) -> Observed:
        """What some vertices do, in fractions of D."""
        offsets = np.concatenate(
            [
                _offsets(take, moments, vertices, self.diameter)
                for take, moments in zip(self.takes, self.moments, strict=True)
            ]
        )
        frames = self.takes[0].frames
        delta = (frames[-1, vertices] - frames[0, vertices]).T / self.diameter
        unit = np.repeat(self.units, [len(take) for take in self.takes])[:, None]
        counted = None if self.counted is None else self.counted[:, vertices].astype(np.float64)
        means = _means(self.along, self.vertex_count)[:, vertices]
        sizes = np.asarray(means.sum(axis=1)).ravel()
        some = sizes > 0
        means = means[some].multiply(1 / sizes[some, None]).tocsr()
        return Observed(offsets, delta if self.paced else None, counted, means, unit)

    def blocks(self) -> Iterator[NDArray[np.int64]]:
        """All vertices, some at a time."""
        step = max(1, _BLOCK // len(self.times))
        for start in range(0, self.vertex_count, step):
            yield np.arange(start, min(start + step, self.vertex_count))

    @cached_property
    def sampled(self) -> Observed:
        """What the sample does."""
        return self.observed(self.sample)

    @cached_property
    def sample(self) -> NDArray[np.int64]:
        """Vertices of curves to fit to: all, or those farthest from straight and some others."""
        known = np.unique(self.along.indices)
        room = max(_LEAST_SAMPLE, _SAMPLE // len(self.times))
        if room >= len(known):
            return known
        blocks = [self.observed(own).straight.max(axis=0) for own in self.blocks()]
        order = np.argsort(-np.concatenate(blocks)[known], kind="stable")
        farthest, others = known[order[: room // 2]], np.sort(known[order[room // 2 :]])
        evenly = np.linspace(0, len(others) - 1, room - len(farthest)).astype(np.int64)
        return np.union1d(farthest, others[evenly])


def enough_knots(recordings: Recordings, count: int, knots: int | None) -> tuple[int, bool]:
    """How many knots the curves of so many shapes have, and whether they are the limit.

    They are where curves on them leave more of the squares, with any number of shapes, than so many
    shapes leave with any curves. By default there are as many as it takes for that not to be so.
    """
    seen = recordings.sampled
    bar = unexplained(seen, None, count)
    least = max(KNOTS, count - 2)
    for number in range(least, MOST_KNOTS + 1) if knots is None else (knots,):
        basis = Splines.at(recordings.times, number).values
        if within := not basis.shape[1] or unexplained(seen, basis, count) <= bar + _NOTHING:
            break
    return number, not within


def path_through(
    recordings: Recordings,
    splines: Splines,
    count: int,
    *,
    recorded: bool = False,
    start: tuple[PathFit, Splines] | None = None,
) -> PathFit:
    """The path of so many shapes, over all vertices, that follows all recordings best.

    It starts at one of fewer shapes, on other splines of the same frames, where that is given.
    """
    # Nothing was recorded between the ends, or nothing is asked for.
    if not splines.values.shape[1] or not (count or recordings.paced):
        none = np.zeros((0, 3, recordings.vertex_count))
        return PathFit(np.zeros((0, 0)), none, 0.0, 0.0, paced=False)
    sample, seen = recordings.sample, recordings.sampled
    if recorded:
        return _of_frames(recordings, splines, seen, best_recorded(seen, splines, count))
    first = None
    if start is not None and len(start[0].weights):
        fewer, other = start
        own: Floats = np.linalg.pinv(splines.values) @ other.values @ fewer.weights
        first = replace(fewer, weights=own, shapes=fewer.shapes[:, :, sample])
    fit = fitted(seen, splines, count, first)
    for more in range(_MORE_ROUNDS + 1):
        if len(sample) == recordings.vertex_count:
            return _less_of_delta(fit)
        whole, worst = _to_all(recordings, splines, fit, sample)
        worse = np.flatnonzero(worst > _WORSE * fit.largest)
        unseen = np.setdiff1d(np.intersect1d(worse, recordings.along.indices), sample)
        if not len(unseen) or more == _MORE_ROUNDS:
            break
        worst_first = unseen[np.argsort(-worst[unseen], kind="stable")]
        sample = np.union1d(sample, worst_first[:_LEAST_SAMPLE])
        first = replace(whole, shapes=whole.shapes[:, :, sample])
        fit = fitted(recordings.observed(sample), splines, count, first)
    return _less_of_delta(whole)


def _less_of_delta(fit: PathFit) -> PathFit:
    """The same path, all that its shapes have of Δ given to the curve of Δ."""
    if not fit.paced:
        return fit
    fixed = fit.shapes[0]
    shares = np.einsum("sxn,xn->s", fit.shapes, fixed) / np.square(fixed).sum()
    shares[0] = 0.0
    weights = fit.weights.copy()
    weights[:, 0] += fit.weights @ shares
    return replace(fit, weights=weights, shapes=fit.shapes - shares[:, None, None] * fixed)


def _of_frames(
    recordings: Recordings, splines: Splines, seen: Observed, frames: list[int]
) -> PathFit:
    """The path whose shapes are the offsets of some frames."""
    fit = fitted(seen, splines, len(frames), shapes=seen.recorded(frames))
    every = [recordings.observed(own).recorded(frames) for own in recordings.blocks()]
    return replace(fit, shapes=np.concatenate(every, axis=2))


def _to_all(
    recordings: Recordings, splines: Splines, fit: PathFit, sample: NDArray[np.int64]
) -> tuple[PathFit, Floats]:
    """The path with shapes for all vertices, and (V,) the largest error of each."""
    shapes = np.empty((len(fit.shapes), 3, recordings.vertex_count))
    worst = np.empty(recordings.vertex_count)
    curves = splines.values @ fit.weights
    for own in recordings.blocks():
        seen = recordings.observed(own)
        shapes[:, :, own], worst[own] = worst_mended(seen, curves, fit.largest)
    shapes[:, :, sample] = fit.shapes
    return replace(fit, shapes=shapes), worst


def _offsets(take: MeshSequence, moments: Floats, vertices: Vertices, diameter: float) -> Floats:
    """(T, 3, N) how far frames are off the straight line at their moments."""
    part = take.frames[:, vertices].transpose(0, 2, 1) / diameter
    first, last = part[0].copy(), part[-1].copy()
    part -= first + moments[:, None, None] * (last - first)
    part[[0, -1]] = 0.0
    return part


def _means(along: CurveVertices, vertex_count: int) -> Any:
    """(C, V) sparse ones where a vertex is on a curve."""
    from scipy.sparse import csr_array

    bounds = np.append(along.starts, len(along.indices))
    ones = np.ones(len(along.indices))
    return csr_array((ones, along.indices, bounds), shape=(len(along.counts), vertex_count))


@dataclass(frozen=True, eq=False)
class Take:
    """A recording along curves."""

    motion: MeshSequence
    along: CurveVertices
    counted: NDArray[np.bool_] | None = None  # (T, V) which vertices count; all by default

    @cached_property
    def line(self) -> Learned:
        """The straight line between its ends."""
        none = np.zeros((0, *self.motion.mesh.vertices.shape))
        return Learned(self.motion.neutral, self.motion.target, none, ())

    @cached_property
    def nearest(self) -> Floats:
        """(T,) the moments, in order, at which the straight line is nearest to the frames."""
        points = np.unique(self.along.indices)
        first, last = self.motion.frames[0, points], self.motion.frames[-1, points]
        way = (last - first) / np.square(last - first).sum()
        moments = np.array([((frame[points] - first) * way).sum() for frame in self.motion.frames])
        moments = np.clip(moments, 0.0, 1.0)
        moments[[0, -1]] = 0.0, 1.0
        ahead = np.maximum.accumulate(moments)
        behind = np.minimum.accumulate(moments[::-1])[::-1]
        return np.asarray((ahead + behind) / 2)

    def between(self, path: Morph) -> Learned:
        """A path of others between the ends of this recording."""
        return replace(self.line, bends=path.bends, bend_curves=path.bend_curves)

    def errors(self, path: Morph, moments: Floats) -> PathErrors:
        """Those of a path whose (T,) moments the frames are compared with."""
        return PathErrors.of(path, self.motion, moments, self.along, self.counted)

    def closest(self, path: Morph) -> tuple[PathErrors, Floats]:
        """The errors of a path between its ends at the moments, in order, that make them least."""
        own = self.between(path)
        moments = free_timing(own, self.motion, self.along, counted=self.counted)
        return self.errors(own, moments), moments


def counted_together(takes: Sequence[Take]) -> NDArray[np.bool_] | None:
    """(T, V) which vertices count in the frames of all; None where all do."""
    if all(take.counted is None for take in takes):
        return None
    masks = [
        np.ones(take.motion.frames.shape[:2], dtype=np.bool_)
        if take.counted is None
        else take.counted
        for take in takes
    ]
    return np.concatenate(masks)


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
