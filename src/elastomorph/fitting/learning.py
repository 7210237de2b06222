"""From a recorded movement to the path that follows it best."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork, extract_curves, require_curves_of
from elastomorph.errors import MeshError, ParameterError
from elastomorph.evaluation.confidence import LEAST, ConfidenceLike, counted_of, require_some
from elastomorph.evaluation.curve_errors import CurveVertices
from elastomorph.evaluation.evaluation import recorded_motion
from elastomorph.fitting.learned import Learned, PathErrors
from elastomorph.fitting.path_fit import PathFit, Splines
from elastomorph.fitting.recordings import Recordings, path_through
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.sequence import MeshSequence

__all__ = ["KNOTS", "learn"]

Floats = NDArray[np.float64]

KNOTS = 7
_MOST_KNOTS = 64
# Bends are scaled by these until no error is larger than that of the straight line.
_PARTS = (1.0, 0.5, 0.25, 0.0)
# What ends nearer to its first frame than this part of its largest distance from it comes back.
_BACK = 0.25


def learn(
    recording: MeshSequence | str | Path,
    bends: int = 1,
    *,
    curves: CurveNetwork | None = None,
    knots: int = KNOTS,
    confidence: ConfidenceLike | None = None,
    least_confidence: float = LEAST,
    progress: Callable[[str], None] | None = None,
) -> Learned:
    """The path that follows a recorded movement best: Δ, a curve for Δ, and bends.

        V(t) = V₀ + a(t)·Δ + Σ_k b_k(t)·D_k

    over all frames. V₀ is the first frame and Δ the way to the last, both exact; the shapes D_k are
    free, and the curves cubic splines, a from 0 to 1, b_k zero at both ends. What is made small is
    the largest error of a vertex in any frame, and the largest mean error of a curve of the face,
    both as parts of those of the straight line; neither is ever larger than that. a(t) - t is the
    curve of the last bend, Δ itself, which costs no further target where a format can play it on Δ.

    Args:
        recording: The movement, from the neutral to the target. Or what `read_sequence` reads it
            from, such as ``scan.####.obj``.
        bends: How many free shapes D_k, from 0 on; each needs a frame between the ends.
        curves: The curves that errors are means over; found by `extract_curves` by default. All
            vertices together are one on a mesh without polygons.
        knots: How many times the pieces of the curves meet at, from 0 on, with equally many frames
            between them; fewer where there are too few frames.
        confidence: How far vertices are to be trusted, as `evaluate` takes it.
        least_confidence: The confidence from which on a vertex counts; 0 lets all of them count.
        progress: Called with what is being done.

    Returns:
        The path, a `Morph` with its errors.

    Raises:
        FileError: A recording or confidence named by its files cannot be read.
        ParameterError: A setting is out of its range, or there are fewer frames than bends need.
        MeshError: The recording comes back to where it starts, or its first frame is at one place.
        CurveError: The curves belong to another mesh.
    """
    take, mask = recorded_motion(recording, confidence, least_confidence)
    _require_settings(bends, knots, len(take))
    _require_way(take)
    along = _along(take, curves)
    if mask is not None:
        require_some(mask, along)
    none = np.zeros((0, *take.mesh.vertices.shape))
    bare = Learned(take.neutral, take.target, none, (), method=f"learned {bends}")
    recordings = Recordings([take], [take.times], along, counted_of(mask))
    return _fitted(bare, recordings, bends, knots, progress or (lambda _: None))


def _fitted(
    bare: Learned, recordings: Recordings, bends: int, knots: int, say: Callable[[str], None]
) -> Learned:
    """A straight path, bent to follow what was recorded wherever that makes no error larger."""
    (take,) = recordings.takes
    seen = (take, take.times, recordings.along, recordings.counted)
    straight = PathErrors.of(bare, *seen)
    if len(take) == 2:
        return replace(bare, errors=straight, straight=straight)
    say("fitting")
    splines = Splines.at(recordings.times, knots)
    fit = path_through(recordings, splines, bends)
    say("measuring")
    for part in _PARTS:
        morph = _bent(bare, fit, splines, part)
        errors = PathErrors.of(morph, *seen)
        if errors.never_above(straight):
            break
    return replace(morph, errors=errors, straight=straight)


def _bent(bare: Learned, fit: PathFit, splines: Splines, part: float) -> Learned:
    """A straight path with a part of the bends, each as large as it moves vertices; Δ the last."""
    fields: list[Floats] = []
    laws: list[BendCurve] = []
    size = bare.neutral.diameter
    for weights, shape in zip(fit.weights.T[1:], fit.shapes[1:], strict=True):
        peak = splines.curve(weights).peak[1]
        if peak and part and shape.any():
            fields.append(shape.T * (part * peak * size))
            laws.append(splines.curve(weights / peak))
    pace = part * fit.weights[:, 0]
    if pace.any():
        fields.append(bare.delta)
        laws.append(splines.curve(pace))
    stacked = np.array(fields).reshape(-1, *bare.delta.shape)
    return replace(bare, bends=stacked, bend_curves=tuple(laws))


def _along(recording: MeshSequence, curves: CurveNetwork | None) -> CurveVertices:
    """The curves that errors are means over."""
    count = len(recording.mesh.vertices)
    if curves is None and not len(recording.mesh.faces):
        every = np.arange(count)
        return CurveVertices(every, every[:1], np.array([count]))
    network = extract_curves(recording.mesh) if curves is None else curves
    require_curves_of(network, count, "the first frame")
    return CurveVertices.of(network, count)


def _require_settings(bends: int, knots: int, frames: int) -> None:
    for name, value, most in (("bends", bends, np.inf), ("knots", knots, _MOST_KNOTS)):
        whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
        if not whole or not 0 <= value <= most:
            bound = "of 0 or more" if most == np.inf else f"from 0 to {most}"
            raise ParameterError(f"{name} must be a whole number {bound}, found {value!r}")
    inner = frames - 2
    if bends > inner:
        raise ParameterError(
            f"{bends} bends need a frame each between the ends, but this recording of {frames} "
            f"frames has {inner}: ask for {inner} or fewer"
        )
    if bends > knots + 2:
        raise ParameterError(
            f"curves with {knots} knots tell {knots + 2} bends apart, {bends} were asked for: "
            f"give {bends - 2} knots or more"
        )


def _require_way(take: MeshSequence) -> None:
    """Refuse a recording that leads nowhere, as one that holds a movement and its way back."""
    if not take.mesh.diameter > 0:
        raise MeshError(
            "all vertices of the first frame are at one place, so its diameter D is 0 and errors "
            "cannot be given as a fraction of it"
        )
    away = np.array([np.square(frame - take.frames[0]).sum() for frame in take.frames]) ** 0.5
    farthest = int(away.argmax())
    if away[-1] <= _BACK * away[farthest]:
        way = "does not move"
        if away[farthest]:
            way = (
                f"comes back: it is farthest from its first frame at frame {take.names[farthest]}, "
                f"and ends at {away[-1] / away[farthest]:.0%} of that distance"
            )
        raise MeshError(
            f"the recording {way}; a path leads from a neutral to a target, so give a part that "
            "ends at the apex of one movement"
        )
