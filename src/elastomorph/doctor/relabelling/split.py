"""Are triangles those that the polygons of another list were split into?"""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.polygons import Polygons

__all__ = ["split_polygons"]

# Polygons up to this size are compared with triangles they may have been split into.
_LARGEST = 16


def split_polygons(ours: Polygons, theirs: Polygons, count: int) -> NDArray[np.bool_] | None:
    """Which of their triangles run the other way round than the polygon of ours they are part of.

    Args:
        ours: Polygons, not all of them triangles.
        theirs: Polygons with the same numbering of vertices.
        count: Number of vertices.

    Returns:
        (T,), or None where they are not our polygons, split into triangles.
    """
    sizes = ours.sizes
    if not len(theirs) or (theirs.sizes != 3).any() or sizes.max(initial=0) == 3:
        return None
    if int((sizes - 2).sum()) != len(theirs) or sizes.max() > _LARGEST:
        return None
    parts = []
    for size in np.unique(sizes).tolist():
        starts = ours.offsets[:-1][sizes == size]
        rows = ours.indices[starts[:, None] + np.arange(size)].astype(np.int64)
        parts += [rows[:, list(three)] for three in combinations(range(size), 3)]
    allowed = np.concatenate(parts)
    wanted = _keys(theirs.indices.reshape(-1, 3).astype(np.int64), count)
    forwards = np.isin(wanted, _keys(allowed, count))
    if forwards.all():
        return ~forwards
    backwards = np.isin(wanted, _keys(allowed[:, ::-1], count))
    return ~forwards if (forwards | backwards).all() else None


def _keys(triangles: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """(T,) one number for each triangle and direction, whichever vertex comes first."""
    first = triangles.argmin(axis=1)[:, None]
    turned = np.take_along_axis(triangles, (first + np.arange(3)) % 3, axis=1)
    return np.asarray((turned[:, 0] * count + turned[:, 1]) * count + turned[:, 2])
