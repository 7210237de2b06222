"""At which frames of a recorded motion scanned in-betweens pay most, and how much they pay.

A path through captured frames is linear in them: with the frames' offsets from the straight
path, R_t = Y_t - V₀ - t·Δ, the error of the path through frames f_1 … f_n at time t is

    R_t - Σ_i b_i(t)·R_{f_i}

with cardinal curves b_i, so that many choices of frames are judged by one product of matrices.

The largest error over all vertices is found without looking at all of them. The largest over some
*witnesses* is a lower bound: a choice whose bound is above the true error of another is out, the
choice of the smallest bound is judged on all vertices, and those at which it fails become
witnesses too. When no choice is left, the best one is known for certain.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import combinations
from math import comb, inf

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork, extract_curves, require_curves_of
from elastomorph.errors import ElastomorphWarning, ParameterError
from elastomorph.evaluation.curve_errors import CurveErrors, CurveVertices, counts_of, frame_errors
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence, require_motion
from elastomorph.numbers import as_number
from elastomorph.paths.through import inner_curvatures, law_for, through

EFFORT = 20_000_000.0
"""How many choices times frames are compared at once, unless told: seconds on one core."""
_CHUNK = 1_000_000
_BATCH = 8
_FEW = 16


@dataclass(frozen=True)
class Choice:
    """Frames for in-betweens."""

    frames: tuple[int, ...]  # Indices of the frames, rising
    error: float  # The error of the path through them, by the measure of the judge
    certain: bool = False  # Whether all choices of as many frames were compared


def cardinal_weights(
    keys: NDArray[np.float64], times: NDArray[np.float64], law: str = "spline"
) -> NDArray[np.float64]:
    """(S, T, n) values at times (T,) of the cardinal curves of (S, n) rising keys within (0, 1).

    The same numbers as `elastomorph.paths.through.cardinal_curves`, for all choices at once.
    """
    ends = np.zeros((len(keys), 1))
    breaks = np.concatenate([ends, keys, ends + 1.0], axis=1)
    gaps = np.diff(breaks)[:, None]
    when = times[None, :, None]
    # How far each time has come towards each key, from the key before and from the key after.
    up = np.clip((when - breaks[:, None, :-2]) / gaps[..., :-1], 0.0, 1.0)
    down = np.clip((breaks[:, None, 2:] - when) / gaps[..., 1:], 0.0, 1.0)
    hats = np.minimum(up, down)
    if law == "piecewise":
        return np.asarray(hats)
    if law == "smooth":
        return np.asarray(hats * hats * (3.0 - 2.0 * hats))
    curving = (
        gaps[..., :-1] ** 2 * (up * up * up - up) + gaps[..., 1:] ** 2 * (down * down * down - down)
    ) / 6.0
    return np.asarray(hats + curving @ inner_curvatures(breaks))


class LargestError:
    """The largest error over frames and groups of vertices: LME, or LAE with curves for groups."""

    def __init__(
        self,
        offsets: NDArray[np.float64],
        times: NDArray[np.float64],
        starts: NDArray[np.int64],
        counts: NDArray[np.int64],
        law: str = "spline",
        counted: NDArray[np.bool_] | None = None,
    ) -> None:
        """Judge by (T, N, 3) offsets of the frames from the straight path.

        Groups are (G,) starts and counts among the N vertices; errors are means over each, of the
        vertices that are (T, N) counted, all by default.
        """
        self.times = times
        self._law = law
        self._offsets, self._starts, self._counts = offsets, starts, counts
        self._counted = counted
        self._divisors = np.broadcast_to(counts, (len(times), len(counts)))
        if counted is not None:
            self._divisors = counts_of(counted, starts)
        self._witnesses: list[int] = []

    def best(self, choices: NDArray[np.int64], known: Choice) -> Choice:
        """The best of (S, n) choices, or ``known`` where none is better."""
        every = np.arange(len(self.times))
        news = self._witnesses[::-1]  # the latest first: they threw out choices like these
        bounds = np.zeros(len(choices))
        if news and known.error < inf:
            some = every[:: max(1, len(every) // _FEW)]
            bounds = self._bounds(choices, news[:_BATCH], some)
            choices, bounds = _below(known.error, choices, bounds)
        while True:
            for first in range(0, len(news), _BATCH):
                more = self._bounds(choices, news[first : first + _BATCH], every)
                choices, bounds = _below(known.error, choices, np.maximum(bounds, more))
            if not len(choices):
                return known
            promising = int(bounds.argmin())
            frames = choices[promising]
            error, worst = self._exact(frames)
            if error < known.error:
                known = Choice(tuple(int(frame) for frame in frames), error)
            bounds[promising] = inf
            choices, bounds = _below(known.error, choices, bounds)
            news = [group for group in worst if group not in self._witnesses]
            self._witnesses += news

    def _bounds(
        self, choices: NDArray[np.int64], groups: list[int], frames: NDArray[np.int64]
    ) -> NDArray[np.float64]:
        """(S,) largest error over some groups and frames."""
        counts = self._counts[groups]
        columns = np.concatenate(
            [np.arange(self._starts[g], self._starts[g] + self._counts[g]) for g in groups]
        )
        offsets = np.ascontiguousarray(self._offsets[:, columns]).reshape(len(self.times), -1)
        wanted, times = offsets[frames], self.times[frames]
        bounds = np.empty(len(choices))
        step = max(1, _CHUNK // wanted.size)
        for first in range(0, len(choices), step):
            part = choices[first : first + step]
            missed = cardinal_weights(self.times[part], times, self._law) @ offsets[part]
            missed -= wanted
            np.square(missed, out=missed)
            distances = np.sqrt(missed.reshape(len(part), len(times), -1, 3).sum(axis=3))
            if self._counted is not None:
                distances *= self._counted[frames][:, columns]
            if len(columns) > len(groups):
                distances = np.add.reduceat(distances, np.cumsum(counts) - counts, axis=2)
                distances /= self._divisors[frames][:, groups]
            bounds[first : first + step] = distances.max(axis=(1, 2))
        return bounds

    def _exact(self, frames: NDArray[np.int64]) -> tuple[float, list[int]]:
        """The error over all groups, and the groups that fail most, the worst first."""
        weights = cardinal_weights(self.times[frames][None], self.times, self._law)[0]
        keys = self._offsets[frames].reshape(len(frames), -1)
        largest, worst = np.zeros(len(weights)), np.zeros(len(weights), dtype=np.int64)
        for i, row in enumerate(weights):
            missed = (row @ keys).reshape(-1, 3) - self._offsets[i]
            distances = np.sqrt(np.einsum("ni,ni->n", missed, missed))
            if self._counted is not None:
                distances *= self._counted[i]
            if len(self._starts) < len(distances):
                distances = np.add.reduceat(distances, self._starts) / self._divisors[i]
            worst[i] = distances.argmax()
            largest[i] = distances[worst[i]]
        order = np.argsort(-largest, kind="stable")
        return float(largest.max()), list(dict.fromkeys(worst[order].tolist()))[:_BATCH]


class MeanSquare:
    """The root of the mean squared distance over frames and vertices."""

    def __init__(
        self, offsets: NDArray[np.float64], times: NDArray[np.float64], law: str = "spline"
    ) -> None:
        """Judge by (T, N, 3) offsets of the frames from the straight path."""
        self.times = times
        self._law = law
        self._size = offsets.shape[0] * offsets.shape[1]
        flat = offsets.reshape(len(offsets), -1)
        # Squared distances between linear combinations of frames need their inner products only.
        self._gram = flat @ flat.T

    def best(self, choices: NDArray[np.int64], known: Choice) -> Choice:
        """The best of (S, n) choices, or ``known`` where none is better."""
        if not len(choices):
            return known
        squares = np.empty(len(choices))
        step = max(1, _CHUNK // (len(self.times) * choices.shape[1]))
        for first in range(0, len(choices), step):
            part = choices[first : first + step]
            weights = cardinal_weights(self.times[part], self.times, self._law)
            among = self._gram[part[:, :, None], part[:, None, :]]
            crossed = self._gram[part].transpose(0, 2, 1)
            squares[first : first + step] = (weights * (weights @ among - 2 * crossed)).sum((1, 2))
        first_best = int(squares.argmin())
        square = max(0.0, float(squares[first_best] + np.trace(self._gram)))
        error = (square / self._size) ** 0.5
        if not error < known.error:
            return known
        return Choice(tuple(int(frame) for frame in choices[first_best]), error)


def _below(
    limit: float, choices: NDArray[np.int64], bounds: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """The choices that may still be better, with their bounds."""
    alive = bounds < limit
    return choices[alive], bounds[alive]


def best_frames(
    judge: LargestError | MeanSquare,
    count: int,
    *,
    effort: float = EFFORT,
    progress: Callable[[str], None] = lambda _: None,
) -> list[Choice]:
    """The best choice of n frames for n = 1 … count.

    All choices are compared where that is affordable, as many times T as `effort`. Else all choices
    among every second, third … frame are, and the best of them is improved by moving all its frames
    a little and by exchanging one of them for any other while that helps.
    """
    total = len(judge.times)
    found: list[Choice] = []
    frames: tuple[int, ...] = ()
    for size in range(1, count + 1):
        progress(f"choosing {size} of {total - 2} frames")
        added = [(*frames, new) for new in range(1, total - 1) if new not in frames]
        best = _improved(judge, judge.best(_sorted(added, size), Choice((), inf)), effort)
        step = next(
            step
            for step in range(1, total + 1)
            if size == 1 or comb(len(range(1, total - 1, step)), size) * total <= effort
        )
        choices = _sorted(list(combinations(range(1, total - 1, step), size)), size)
        better = judge.best(choices, best)
        if step > 1 and better is not best:
            better = _improved(judge, better, effort)
        found.append(replace(better, certain=step == 1))
        frames = better.frames
    return found


def _improved(judge: LargestError | MeanSquare, choice: Choice, effort: float) -> Choice:
    """A choice that neither small moves of all frames nor any exchange of one makes better."""
    total = len(judge.times)
    reach = 0
    while (2 * reach + 3) ** len(choice.frames) * total <= effort / 20 and reach < total:
        reach += 1
    while True:
        better = judge.best(_exchanged(choice.frames, total), choice)
        better = judge.best(_moved(better.frames, reach, total), better)
        if better is choice:
            return choice
        choice = better


def _exchanged(frames: tuple[int, ...], total: int) -> NDArray[np.int64]:
    """All choices in which one frame is another."""
    others = [frame for frame in range(1, total - 1) if frame not in frames]
    return _sorted(
        [(*frames[:i], other, *frames[i + 1 :]) for i in range(len(frames)) for other in others],
        len(frames),
    )


def _moved(frames: tuple[int, ...], reach: int, total: int) -> NDArray[np.int64]:
    """All choices in which each frame is at most ``reach`` frames earlier or later."""
    steps = np.arange(-reach, reach + 1)
    axes = np.meshgrid(*(steps + frame for frame in frames), indexing="ij")
    moved = np.stack([axis.ravel() for axis in axes], axis=1)
    apart = (np.diff(moved, axis=1) > 0).all(axis=1)
    return moved[apart & (moved[:, 0] >= 1) & (moved[:, -1] <= total - 2)]


def _sorted(choices: list[tuple[int, ...]], size: int) -> NDArray[np.int64]:
    """(S, n) choices, the frames of each rising."""
    return np.sort(np.array(choices, dtype=np.int64).reshape(-1, size), axis=1)


MEASURES = ("lme", "lae", "mean")
_SMOOTH_LAWS = ("smooth", "spline")


@dataclass(frozen=True, eq=False, repr=False)
class Suggestion(CurveErrors):
    """In-betweens at some frames of a motion and the errors they leave, as fractions of D.

    Attributes:
        frames: Indices of the frames, rising; none for linear interpolation.
        times: Their times within (0, 1).
        names: Their names.
        law: How the path leads through them, what `through` takes as its ``method``; ``linear``
            without any.
        certain: Whether all choices of as many frames were compared.
        morph: The path through them.
        average: (T,) largest E_A over the curves in each frame of the motion.
        maximum: (T,) largest E_M over the curves in each frame.
    """

    frames: tuple[int, ...]
    times: tuple[float, ...]
    names: tuple[str, ...]
    law: str
    certain: bool
    morph: Morph
    average: NDArray[np.float64]
    maximum: NDArray[np.float64]

    @property
    def largest_weight(self) -> float:
        """Largest weight of an in-between at any time; above 1 the path overshoots."""
        return max((curve.height for curve in self.morph.bend_curves), default=0.0)

    def __repr__(self) -> str:
        where = f"{', '.join(self.names)}, {self.law}" if self.names else self.law
        return f"Suggestion({where}: LME {self.lme:.3%}, LAE {self.lae:.3%} of D)"


def suggest_inbetweens(
    truth: MeshSequence,
    count: int,
    *,
    curves: CurveNetwork | None = None,
    measure: str = "lme",
    method: str | None = None,
    effort: float = EFFORT,
    counted: NDArray[np.bool_] | None = None,
    progress: Callable[[str], None] | None = None,
) -> list[Suggestion]:
    """The best frames of a motion for n = 0 … count in-betweens.

    Args:
        truth: The recorded motion, from the neutral to the target.
        count: Most in-betweens, from 0 to the number of frames between the first and the last.
        curves: The curves along which errors are measured; found by `extract_curves` by default.
            A mesh without polygons needs them.
        measure: What the frames are chosen by. ``lme``: the largest error of a vertex over all
            frames. ``lae``: the largest mean over a curve. ``mean``: the root of the mean squared
            distance over all frames and vertices of curves.
        method: How the path leads through them: ``smooth``, ``spline`` or ``piecewise``, see
            `through`. By default the first two are tried, each at its own best frames, and the
            one that leaves less is returned.
        effort: Choices times frames that may be compared at once. All choices are where they are
            few enough: three in-betweens in 100 frames, two in 300. Else the best among every
            second, third … frame is improved by moving and exchanging frames.
        counted: (T, V) which vertices count in which frames, all by default; not for ``mean``.
        progress: Called with a few words before each n.

    Returns:
        count + 1 suggestions, the first with no in-between. More in-betweens are rarely, but now
        and then, worse: a spline may swing.

    Raises:
        ParameterError: The count is out of its range, the measure or method is unknown, or
            `counted` does not fit.
        CurveError: The curves belong to another mesh, or there are none.
        MeshError: All vertices of the first frame are at one place.
    """
    laws = _SMOOTH_LAWS if method is None else (law_for(method, count),)
    require_motion(truth)
    if effort != np.inf:
        as_number(effort, "effort", above=0)
    _require_room(count, len(truth) - 2)
    _require_measure(measure, counted, truth)
    if curves is None:
        curves = extract_curves(truth.mesh)
    require_curves_of(curves, len(truth.mesh.vertices), "the first frame")
    along = CurveVertices.of(curves, len(truth.mesh.vertices))
    suggestions = [_measured(truth, along, counted, "linear", Choice((), 0.0, certain=True))]
    say = progress or (lambda _: None)
    judges = [_judge(truth, along, counted, measure, law) for law in laws]
    found = [best_frames(judge, count, effort=effort, progress=say) for judge in judges]
    for choices in zip(*found, strict=True):
        law, best = min(zip(laws, choices, strict=True), key=lambda pair: pair[1].error)
        suggestions.append(_measured(truth, along, counted, law, best))
    return suggestions


def _require_room(count: int, inner: int) -> None:
    if isinstance(count, bool) or not isinstance(count, int) or not 0 <= count <= inner:
        raise ParameterError(
            f"a motion of {inner + 2} frames has room for 0 to {inner} in-betweens, found {count}"
        )


def _require_measure(measure: str, counted: NDArray[np.bool_] | None, truth: MeshSequence) -> None:
    if measure not in MEASURES:
        raise ParameterError(f"measure must be one of {', '.join(MEASURES)}, found {measure!r}")
    if counted is None:
        return
    if measure == "mean":
        raise ParameterError("'mean' is over all vertices: choose by lme or lae where some count")
    shape = (len(truth), len(truth.mesh.vertices))
    if np.shape(counted) != shape or np.asarray(counted).dtype != np.bool_:
        raise ParameterError(
            f"'counted' must say True or False of each vertex in each frame, the shape {shape}, "
            f"found {np.shape(counted)}"
        )


def _judge(
    truth: MeshSequence,
    along: CurveVertices,
    counted: NDArray[np.bool_] | None,
    measure: str,
    law: str,
) -> LargestError | MeanSquare:
    """The measure on the vertices of the curves; all lengths are fractions of D."""
    offsets = truth.frames[:, along.indices] / truth.mesh.diameter
    first, last = offsets[0].copy(), offsets[-1].copy()
    for frame, time in zip(offsets, truth.times, strict=True):
        frame -= (1.0 - time) * first + time * last
    if measure == "mean":
        return MeanSquare(offsets, truth.times, law)
    own = None if counted is None else counted[:, along.indices]
    if measure == "lae":
        return LargestError(offsets, truth.times, along.starts, along.counts, law, own)
    each = np.arange(len(along.indices))
    return LargestError(offsets, truth.times, each, np.ones_like(each), law, own)


def _measured(
    truth: MeshSequence,
    along: CurveVertices,
    counted: NDArray[np.bool_] | None,
    law: str,
    choice: Choice,
) -> Suggestion:
    """The errors of the path as `elastomorph.evaluate` finds them."""
    times = tuple(float(truth.times[frame]) for frame in choice.frames)
    shapes = {time: truth[frame] for time, frame in zip(times, choice.frames, strict=True)}
    with warnings.catch_warnings():
        # Measured here, so that an overshoot is part of the error; `largest_weight` tells of it.
        warnings.simplefilter("ignore", ElastomorphWarning)
        morph = through(truth.mesh, truth.target, shapes, method=law)
    average, maximum = frame_errors(morph, truth, truth.times, along, counted)
    names = tuple(truth.names[frame] for frame in choice.frames)
    return Suggestion(choice.frames, times, names, law, choice.certain, morph, average, maximum)
