"""Weight animations: paths and performances as keys that every player interpolates linearly.

The keys are LINEAR. CUBICSPLINE would be exact for cubic bend curves with two keys, but Blender's
importer drops the tangents, and two keys of zero without tangents are no bend at all; a straight
line between keys is played alike everywhere, and costs a few kilobytes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.bend_curve import BendCurve
from elastomorph.errors import ParameterError
from elastomorph.io.gltf.targets import KeptMorph, MorphTargets
from elastomorph.rig import Rig
from elastomorph.timing import Timing, linear

__all__ = ["Clip", "performance_clip", "slider_clips"]

_FINEST = 4096
_BETWEEN = 8


@dataclass(frozen=True, eq=False)
class Clip:
    """An animation of the morph target weights.

    Attributes:
        name: Its name.
        times: (T,) float32 seconds, rising.
        weights: (T, targets) float32.
        key_error: Largest distance of a vertex from its path between keys, fraction of D.
    """

    name: str
    times: NDArray[np.float32]
    weights: NDArray[np.float32]
    key_error: float


def slider_clips(
    rig: Rig, targets: MorphTargets, tolerance: float, fps: float, timing: Timing = linear
) -> list[Clip]:
    """One clip a morph, of its name, that plays its path in one second.

    The keys lie on the frames of 1/fps s, no more of them than the tolerance asks for; where even
    all frames are too few, on halves, quarters, … of frames.

    Args:
        rig: The rig.
        targets: Its morph targets.
        tolerance: Largest distance between keys, as a fraction of D.
        fps: Frames per second.
        timing: The t of the path at each moment of the clip; from 0 to 1 evenly by default.
    """
    scale = rig.neutral.diameter or 1.0
    clips = []
    for (name, morph), kept in zip(rig.morphs.items(), targets.morphs, strict=True):
        curves = [morph.bend_curves[k] for k in kept.bends]
        moved = [morph.delta, *kept.displacements]
        sizes = np.array([np.linalg.norm(field, axis=1).max() / scale for field in moved])

        def moves(
            t: NDArray[np.float64],
            curves: Sequence[BendCurve] = curves,
            sizes: NDArray[np.float64] = sizes,
        ) -> NDArray[np.float64]:
            at = timing.at(t)
            return sizes[:, None] * np.stack([at, *(curve(at) for curve in curves)])

        straight = not curves and timing is linear
        times, error = (np.array([0.0, 1.0]), 0.0) if straight else _keys(moves, tolerance, fps)
        weights = np.zeros((len(times), len(targets.names)), dtype=np.float32)
        _fill(weights, kept, curves, timing.at(times))
        clips.append(Clip(name, times.astype(np.float32), weights, error))
    return clips


def performance_clip(
    rig: Rig, targets: MorphTargets, times: ArrayLike, weights: ArrayLike, name: str
) -> Clip:
    """A recorded performance, one key a frame.

    Args:
        rig: The rig.
        targets: Its morph targets.
        times: (T,) seconds from 0 that rise.
        weights: (T, J) weight of each slider of ``rig.names``, as for `Rig.batch`.
        name: Name of the clip.

    Raises:
        ParameterError: The shapes do not fit, or the times do not rise in single precision.
    """
    table = rig.sliders.drive(rig.sliders.table(weights))
    try:
        seconds = np.asarray(times, dtype=np.float32)
    except (TypeError, ValueError):
        raise ParameterError("the times of an animation must be numbers") from None
    if seconds.shape != (len(table),) or not len(table):
        raise ParameterError(
            f"an animation needs one time for each of its {len(table)} rows of weights, "
            f"found {seconds.shape}"
        )
    if not np.isfinite(seconds).all() or seconds[0] < 0 or (np.diff(seconds) <= 0).any():
        raise ParameterError(
            "the times of an animation must be seconds from 0 that rise from row to row"
        )
    found = np.zeros((len(table), len(targets.names)), dtype=np.float32)
    for column, (morph, kept) in enumerate(zip(rig.morphs.values(), targets.morphs, strict=True)):
        _fill(found, kept, [morph.bend_curves[k] for k in kept.bends], table[:, column])
    return Clip(name, seconds, found, 0.0)


def _fill(
    weights: NDArray[np.float32],
    kept: KeptMorph,
    curves: Sequence[BendCurve],
    times: NDArray[np.float64],
) -> None:
    weights[:, kept.first] = times
    for place, curve in enumerate(curves):
        weights[:, kept.first + 1 + place] = curve(times)


def _keys(
    moves: Callable[[NDArray[np.float64]], NDArray[np.float64]], tolerance: float, fps: float
) -> tuple[NDArray[np.float64], float]:
    """Times of the keys, and the error they leave."""
    steps = max(1, round(fps))
    while True:
        fine = np.arange(steps * _BETWEEN + 1) / (steps * _BETWEEN)
        keys, error = _fewest(moves(fine), steps, tolerance)
        if error <= tolerance or steps * 2 > _FINEST:
            return keys / steps, error
        steps *= 2


def _fewest(
    moves: NDArray[np.float64], steps: int, tolerance: float
) -> tuple[NDArray[np.int64], float]:
    """Greedily, the longest straight piece from each key on."""
    keys, largest = [0], 0.0
    while keys[-1] < steps:
        start = keys[-1]
        reached, error = start + 1, _gap(moves, start, start + 1)
        while reached < steps and (longer := _gap(moves, start, reached + 1)) <= tolerance:
            reached, error = reached + 1, longer
        keys.append(reached)
        largest = max(largest, error)
    return np.array(keys), largest


def _gap(moves: NDArray[np.float64], start: int, stop: int) -> float:
    """The largest Σ_k |chord - b_k|·max|D_k| between two keys."""
    piece = moves[:, start * _BETWEEN : stop * _BETWEEN + 1]
    part = np.linspace(0, 1, piece.shape[1])
    chord = piece[:, :1] * (1 - part) + piece[:, -1:] * part
    return float(np.abs(chord - piece).sum(axis=0).max())
