"""Are two lists of polygons the same: in another order, from another corner, reversed, or split?"""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.polygons import Polygons

# Polygons up to this size are compared with triangles they may have been split into.
_LARGEST = 16


def corresponding_corners(ours: Polygons, theirs: Polygons) -> NDArray[np.int64] | None:
    """(C,) for each corner of our polygons the same corner of theirs; None where they differ.

    Polygons are the same that name the same vertices in the same cyclic order; a reversed one is
    another polygon. Where a polygon is there twice, either may be taken.
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
    """(F, n) corners and vertices of the polygons of one size, each from its least rotation."""
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


def corners_either_way(
    ours: Polygons, theirs: Polygons
) -> tuple[NDArray[np.int64], NDArray[np.bool_]] | None:
    """As `corresponding_corners`, whichever way polygons run, and (F,) which of ours do not agree.

    None where the polygons do not even name the same vertices next to each other.
    """
    our_turns, their_turns = _runs_down(ours), _runs_down(theirs)
    found = corresponding_corners(
        reversed_polygons(ours, our_turns), reversed_polygons(theirs, their_turns)
    )
    if found is None:
        return None
    corners = np.empty_like(found)
    corners[reversed_corners(ours, our_turns)] = reversed_corners(theirs, their_turns)[found]
    partner = theirs.corner_faces[corners[ours.offsets[:-1]]]
    return corners, our_turns != their_turns[partner]


def _runs_down(faces: Polygons) -> NDArray[np.bool_]:
    """(F,) whether the vertex after the least is larger than the one before it."""
    if not len(faces):
        return np.zeros(0, dtype=bool)
    least = np.minimum.reduceat(faces.indices, faces.offsets[:-1])
    at = np.flatnonzero(faces.indices == least[faces.corner_faces])
    corner = at[np.unique(faces.corner_faces[at], return_index=True)[1]]
    starts, sizes = faces.offsets[:-1], faces.sizes
    before = starts + (corner - starts - 1) % sizes
    after = starts + (corner - starts + 1) % sizes
    return np.asarray(faces.indices[after] > faces.indices[before])


def reversed_corners(faces: Polygons, which: NDArray[np.bool_]) -> NDArray[np.int64]:
    """(C,) the corner to read at each place to reverse some polygons; each keeps its first."""
    place = np.arange(faces.indices.size)
    starts, sizes = faces.offsets[:-1][faces.corner_faces], faces.sizes[faces.corner_faces]
    backwards = starts + (starts - place) % sizes
    return np.asarray(np.where(which[faces.corner_faces], backwards, place), dtype=np.int64)


def reversed_polygons(faces: Polygons, which: NDArray[np.bool_] | None = None) -> Polygons:
    """The same polygons, some of them or all run the other way round."""
    which = np.ones(len(faces), dtype=bool) if which is None else which
    return Polygons(faces.indices[reversed_corners(faces, which)], faces.offsets)


def triangles_of(ours: Polygons, theirs: Polygons, count: int) -> NDArray[np.bool_] | None:
    """Whether triangles are our polygons split: (T,) which of them run the other way round.

    None where they are not; ``count`` is the number of vertices.
    """
    sizes = ours.sizes
    if not len(theirs) or (theirs.sizes != 3).any() or sizes.max(initial=0) == 3:
        return None
    if int((sizes - 2).sum()) != len(theirs) or sizes.max() > _LARGEST:
        return None
    rows = []
    for size in np.unique(sizes).tolist():
        starts = ours.offsets[:-1][sizes == size]
        polygons = ours.indices[starts[:, None] + np.arange(size)].astype(np.int64)
        rows += [polygons[:, list(three)] for three in combinations(range(size), 3)]
    allowed = np.concatenate(rows)
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
