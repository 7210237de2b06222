"""What paths cost and how far they are from the straight line, for people who choose a method."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.evaluation.target_paths import ROW
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph

_TIMES = np.linspace(0.0, 1.0, 11)


@dataclass(frozen=True)
class PathFigures:
    """One path, in the unit of the vertices.

    Attributes:
        method: How it was made, with what ``auto`` chose.
        extra: Morph targets that it needs besides the target itself.
        bytes: What they add to a file that stores an index and three 32-bit numbers a moved vertex.
        largest: Largest distance from the straight line at the same time, over eleven times.
        mean: Mean distance from it, over the times and the vertices that the target moves.
        between: Largest and mean distance from the shapes on the way, where there are any.
    """

    method: str
    extra: int
    bytes: int
    largest: float
    mean: float
    between: tuple[float, float] | None


def path_figures(morph: Morph, shapes: Mapping[float, Mesh] | None = None) -> PathFigures:
    """Measure a path; shapes are in-betweens that were made for its target, by time."""
    moved: NDArray[np.bool_] = np.any(morph.delta, axis=1) | np.any(morph.bends, axis=(0, 2))
    off = _offsets(morph, moved)
    between = None
    if shapes:
        gaps = [
            np.linalg.norm(morph.at(time) - shape.vertices, axis=1)
            for time, shape in shapes.items()
        ]
        between = _largest(*gaps), _mean(np.array(gaps)[:, moved])
    text = morph.method if morph.choice is None else morph.choice.text
    rows = sum(int(bend.any(axis=1).sum()) for bend in morph.bends)
    return PathFigures(text, len(morph.bends), ROW * rows, _largest(off), _mean(off), between)


def _offsets(morph: Morph, moved: NDArray[np.bool_]) -> NDArray[np.float64]:
    """(T, M) distances of the moved vertices from the straight line."""
    found = np.zeros((len(_TIMES), int(moved.sum())))
    weights = np.array([curve(_TIMES) for curve in morph.bend_curves]).reshape(-1, len(_TIMES))
    bends = morph.bends[:, moved]
    for row, weight in zip(found, weights.T, strict=True):
        row[:] = np.linalg.norm(np.einsum("k,kvc->vc", weight, bends), axis=1)
    return found


def _largest(*distances: NDArray[np.float64]) -> float:
    return max((float(each.max(initial=0.0)) for each in distances), default=0.0)


def _mean(distances: NDArray[np.float64]) -> float:
    return float(distances.mean()) if distances.size else 0.0
