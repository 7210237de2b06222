"""At which frames of a recorded motion scanned in-betweens pay most, and how much they pay."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork, extract_curves, require_curves_of
from elastomorph.errors import ElastomorphWarning, ParameterError
from elastomorph.evaluation.curve_errors import CurveErrors, CurveVertices, frame_errors
from elastomorph.evaluation.key_frames import EFFORT, Choice, LargestError, MeanSquare, best_frames
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence, require_motion
from elastomorph.numbers import as_number
from elastomorph.paths.through import law_for, through

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
