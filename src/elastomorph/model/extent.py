"""Lengths that errors and tolerances are divided by: D of a mesh, and of what targets move."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

__all__ = ["largest_distance", "moved_extent"]

_BLOCK = 512


def largest_distance(points: NDArray[np.float64]) -> float:
    """The largest distance between two of the points, exact up to rounding.

    Only corners of the convex hull can be farthest apart, so the hull is taken first, in the
    dimension that the points really span.

    Args:
        points: (N, 3) coordinates with N ≥ 1.
    """
    from scipy.spatial import ConvexHull, QhullError

    centred = points - points.mean(axis=0)
    singular, axes = np.linalg.svd(centred, full_matrices=False)[1:]
    rank = int((singular > 1e-12 * max(float(singular[0]), np.finfo(float).tiny)).sum())
    candidates = points
    if rank == 0:  # all of them coincide
        candidates = points[:1]
    elif rank == 1:
        along = centred @ axes[0]
        candidates = points[[int(along.argmin()), int(along.argmax())]]
    elif rank >= 2 and len(points) > 50:
        try:
            candidates = points[ConvexHull(centred @ axes[:rank].T).vertices]
        except QhullError:  # nearly degenerate: the exhaustive search is slower, never wrong
            candidates = points
    largest = 0.0
    for start in range(0, len(candidates), _BLOCK):
        offsets = candidates[start : start + _BLOCK, None] - candidates[None, start:]
        largest = max(largest, float(np.einsum("ijk,ijk->ij", offsets, offsets).max()))
    return float(np.sqrt(largest))


def moved_extent(neutral: NDArray[np.float64], targets: Iterable[NDArray[np.float64]]) -> float:
    """D of a rig: the largest distance between two vertices that a target moves.

    A body below the face, which no target moves, does not count: it would loosen every tolerance.

    Args:
        neutral: (V, 3) positions at rest.
        targets: (V, 3) positions of each target.

    Returns:
        A length in the unit of the vertices; 0 where nothing moves.
    """
    moved = np.zeros(len(neutral), dtype=bool)
    for target in targets:
        moved |= (target != neutral).any(axis=1)
    return largest_distance(neutral[moved]) if moved.any() else 0.0
