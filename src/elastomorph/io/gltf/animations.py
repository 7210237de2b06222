"""Weight animations: paths and performances as keys that every player interpolates linearly.

The keys are LINEAR. CUBICSPLINE would be exact for cubic bend curves with two keys, but Blender's
importer drops the tangents, and two keys of zero without tangents are no bend at all; a straight
line between keys is played alike everywhere, and costs a few kilobytes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import ParameterError
from elastomorph.io.blend_shapes import driven_weights, require_turn
from elastomorph.io.gltf.accessor_writer import AccessorWriter
from elastomorph.io.gltf.morph_targets import KeptMorph, MorphTargets
from elastomorph.rig import Rig
from elastomorph.rig.performance import HeadTurn
from elastomorph.rig.timing import Timing, linear

Performance = tuple[ArrayLike, ArrayLike, str]
"""Times (T,) in seconds, weights (T, J) of the sliders of a rig, and a name."""

_FINEST = 4096
_BETWEEN = 8
# A frame closer to a corner than this part of a frame is left out: the corner is the key.
_BESIDE = 1e-3


@dataclass(frozen=True, eq=False)
class Clip:
    """An animation of the morph target weights."""

    name: str
    times: NDArray[np.float32]  # (T,) seconds, rising
    weights: NDArray[np.float32]  # (T, targets)
    key_error: float  # Largest distance of a vertex from its path between keys, fraction of D


def slider_clips(
    rig: Rig, targets: MorphTargets, tolerance: float, fps: float, timing: Timing = linear
) -> list[Clip]:
    """One clip a morph, of its name, that plays its path in one second.

    The keys lie on the frames of 1/fps s, no more of them than the tolerance asks for; where even
    all frames are too few, on halves, quarters, … of frames. Moments at which two pieces of a
    bend curve meet, as at a scanned in-between, are keys too.
    """
    scale = rig.neutral.diameter or 1.0
    clips = []
    for (name, morph), kept in zip(rig.morphs.items(), targets.morphs, strict=True):
        curves = [*kept.curves, *([] if kept.fold is None else [kept.fold])]
        moved = [morph.delta, *kept.displacements]
        sizes = np.array([np.linalg.norm(field, axis=1).max() / scale for field in moved])
        times, error = np.array([0.0, 1.0]), 0.0
        if curves or timing is not linear:
            breaks = np.unique([time for curve in curves for time in curve.breaks[1:-1]])
            moves = partial(_moves, timing, kept, sizes)
            times, error = _keys(moves, _moments(timing, breaks), tolerance, fps)
        weights = np.zeros((len(times), len(targets.names)), dtype=np.float32)
        _fill(weights, kept, timing.at(times))
        clips.append(Clip(name, times.astype(np.float32), weights, error))
    return clips


def recorded_clips(
    rig: Rig,
    targets: MorphTargets,
    animation: Performance | Sequence[Performance],
    turn: HeadTurn | None,
) -> list[Clip]:
    """Recorded performances, one or several, in all frames of which the head may turn."""
    # One of them is a tuple that ends with its name.
    alone = len(animation) > 0 and isinstance(animation[-1], str)
    played: Any = [animation] if alone else animation
    clips = [performance_clip(rig, targets, *each) for each in played]
    require_turn(turn, sum(len(clip.times) for clip in clips))
    return clips


def performance_clip(
    rig: Rig, targets: MorphTargets, times: ArrayLike, weights: ArrayLike, name: str
) -> Clip:
    """A recorded performance of this name, one key a frame."""
    exact, table = driven_weights(rig, times, weights)
    seconds = exact.astype(np.float32)
    if seconds[0] < 0 or not np.isfinite(seconds).all() or (np.diff(seconds) <= 0).any():
        raise ParameterError(
            "the times of an animation must be seconds from 0 that rise from row to row in single "
            "precision"
        )
    found = np.zeros((len(table), len(targets.names)), dtype=np.float32)
    for column, kept in enumerate(targets.morphs):
        _fill(found, kept, table[:, column])
    return Clip(name, seconds, found, 0.0)


def weight_animation(
    accessors: AccessorWriter, clip: Clip, moved: Sequence[tuple[int, NDArray[np.int64]]]
) -> dict[str, Any]:
    """An animation of the weights of some nodes, by the numbers of the targets of each."""
    found: dict[str, Any] = {"name": clip.name, "channels": [], "samplers": []}
    for node, numbers in moved:
        times, weights = accessors.keys(clip.times, clip.weights[:, numbers])
        target = {"node": node, "path": "weights"}
        found["channels"].append({"sampler": len(found["samplers"]), "target": target})
        sampler = {"input": times, "interpolation": "LINEAR", "output": weights}
        found["samplers"].append(sampler)
    return found


def _fill(weights: NDArray[np.float32], kept: KeptMorph, t: NDArray[np.float64]) -> None:
    weights[:, kept.first : kept.first + 1 + len(kept.curves)] = kept.weights(t).T


def _moves(
    timing: Timing, kept: KeptMorph, sizes: NDArray[np.float64], when: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(1 + curves, T) how far Δ and each bend move a vertex at most."""
    return sizes[:, None] * kept.weights(timing.at(when))


def _moments(timing: Timing, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """The moments of a clip, to rounding, at which a timing passes some times of the path."""
    if timing is linear:
        return times
    grid = np.linspace(0.0, 1.0, _FINEST + 1)
    above = timing.at(grid) > times[:, None]
    which, cells = np.nonzero(above[:, 1:] != above[:, :-1])
    low, high = grid[cells], grid[cells + 1]
    for _ in range(40):
        middle = (low + high) / 2
        passed = (timing.at(middle) > times[which]) == above[which, cells + 1]
        low, high = np.where(passed, low, middle), np.where(passed, middle, high)
    return np.unique(high)


def _keys(
    moves: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    corners: NDArray[np.float64],
    tolerance: float,
    fps: float,
) -> tuple[NDArray[np.float64], float]:
    """Times of the keys, and the error they leave."""
    steps = max(1, round(fps))
    if len(corners) > steps:  # of so many short pieces, none stands out
        corners = corners[:0]
    while True:
        frames = np.arange(steps + 1) / steps
        if len(corners):
            apart = np.abs(frames[:, None] - corners).min(axis=1) > _BESIDE / steps
            apart[[0, -1]] = True
            frames = np.union1d(frames[apart], corners)
        places = np.arange((len(frames) - 1) * _BETWEEN + 1) / _BETWEEN
        fine = np.interp(places, np.arange(len(frames)), frames)
        stops = set(np.searchsorted(frames, corners).tolist())
        keys, error = _fewest(moves(fine), fine, stops, tolerance)
        if error <= tolerance or steps * 2 > _FINEST:
            return frames[keys], error
        steps *= 2


def _fewest(
    moves: NDArray[np.float64], fine: NDArray[np.float64], stops: set[int], tolerance: float
) -> tuple[NDArray[np.int64], float]:
    """Greedily, the longest straight piece from each key on, none of them past a stop."""
    last = (len(fine) - 1) // _BETWEEN
    keys, largest = [0], 0.0
    while keys[-1] < last:
        start = keys[-1]
        reached, error = start + 1, _gap(moves, fine, start, start + 1)
        while reached < last and reached not in stops:
            longer = _gap(moves, fine, start, reached + 1)
            if longer > tolerance:
                break
            reached, error = reached + 1, longer
        keys.append(reached)
        largest = max(largest, error)
    return np.array(keys), largest


def _gap(moves: NDArray[np.float64], fine: NDArray[np.float64], start: int, stop: int) -> float:
    """The largest Σ_k |chord - b_k|·max|D_k| between two keys."""
    inside = slice(start * _BETWEEN, stop * _BETWEEN + 1)
    piece, when = moves[:, inside], fine[inside]
    part = (when - when[0]) / (when[-1] - when[0])
    chord = piece[:, :1] * (1 - part) + piece[:, -1:] * part
    return float(np.abs(chord - piece).sum(axis=0).max())
