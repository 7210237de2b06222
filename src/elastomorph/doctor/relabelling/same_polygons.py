"""Are two lists of polygons the same, whatever their order and whichever corner comes first?"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastomorph.polygons import Polygons

__all__ = ["corresponding_corners", "reversed_polygons"]


def corresponding_corners(ours: Polygons, theirs: Polygons) -> NDArray[np.int64] | None:
    """For each corner of our polygons the same corner among theirs.

    Polygons are the same that name the same vertices in the same order round; one that runs the
    other way is another polygon. Where a polygon is there twice, either may be taken.

    Args:
        ours: Polygons.
        theirs: Polygons with the same numbering of vertices.

    Returns:
        (C,) corners, or None where the polygons are not the same.
    """
    if not np.array_equal(np.sort(ours.sizes), np.sort(theirs.sizes)):
        return None
    corners = np.empty(ours.indices.size, dtype=np.int64)
    for size in np.unique(ours.sizes).tolist():
        mine, my_rows = _sorted_rows(ours, size)
        their, their_rows = _sorted_rows(theirs, size)
        if not np.array_equal(my_rows, their_rows):
            return None
        corners[mine] = their
    return corners


def _sorted_rows(faces: Polygons, size: int) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """(F, n) corners and vertices of the polygons of one size, in an order of their own."""
    starts = faces.offsets[:-1][faces.sizes == size]
    vertices = faces.indices[starts[:, None] + np.arange(size)]
    least = vertices == vertices.min(axis=1, keepdims=True)
    first = least.argmax(axis=1)
    for row in np.flatnonzero(least.sum(axis=1) > 1).tolist():
        turns = np.flatnonzero(least[row]).tolist()
        first[row] = min(turns, key=lambda turn, row=row: np.roll(vertices[row], -turn).tolist())  # type: ignore[misc]
    turned = (first[:, None] + np.arange(size)) % size
    rows = np.take_along_axis(vertices, turned, axis=1)
    order = np.lexsort(rows.T[::-1])
    return (starts[:, None] + turned)[order], rows[order]


def reversed_polygons(faces: Polygons) -> Polygons:
    """The same polygons run the other way round, each from the same first vertex."""
    place = np.arange(faces.indices.size) - faces.offsets[:-1][faces.corner_faces]
    sizes = faces.sizes[faces.corner_faces]
    source = faces.offsets[:-1][faces.corner_faces] + (sizes - place) % sizes
    return Polygons(faces.indices[source], faces.offsets)
