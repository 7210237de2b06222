"""Sheets of unit squares, whose folds are known."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

SIDE = 21


def sheet(z: float = 0.0, side: int = SIDE) -> tuple[NDArray[np.float64], list[list[int]]]:
    """Unit squares in the plane of a height, seen from +Z."""
    y, x = np.divmod(np.arange(side * side), side)
    corners = [
        [i, i + 1, i + 1 + side, i + side] for i in range(side * (side - 1)) if i % side < side - 1
    ]
    return np.stack([x, y, np.full(len(x), z)], axis=1).astype(float), corners


def moved(
    points: NDArray[np.float64], vertex: int, by: tuple[float, float, float]
) -> NDArray[np.float64]:
    """The points with one of them elsewhere."""
    there = points.copy()
    there[vertex] += by
    return there
