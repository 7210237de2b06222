"""Are two lists of polygons the same, whatever their order and whichever corner comes first?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.polygons import Polygons

__all__ = [
    "EitherWay",
    "corners_either_way",
    "corresponding_corners",
    "reversed_polygons",
    "turned_corners",
]


@dataclass(frozen=True, eq=False)
class EitherWay:
    """Polygons that are the same but for the way round some of them run.

    Attributes:
        corners: (C,) for each corner of our polygons the corner of theirs at the same vertex.
        turned: (F,) which of our polygons run the other way round among theirs.
    """

    corners: NDArray[np.int64]
    turned: NDArray[np.bool_]


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


def corners_either_way(ours: Polygons, theirs: Polygons) -> EitherWay | None:
    """For each corner of our polygons the same corner among theirs, whichever way they run.

    Args:
        ours: Polygons.
        theirs: Polygons with the same numbering of vertices.

    Returns:
        None where the polygons do not even name the same vertices next to each other.
    """
    our_turns, their_turns = _runs_down(ours), _runs_down(theirs)
    our_source, their_source = turned_corners(ours, our_turns), turned_corners(theirs, their_turns)
    found = corresponding_corners(
        Polygons(ours.indices[our_source], ours.offsets),
        Polygons(theirs.indices[their_source], theirs.offsets),
    )
    if found is None:
        return None
    corners = np.empty_like(found)
    corners[our_source] = their_source[found]
    partner = theirs.corner_faces[corners[ours.offsets[:-1]]]
    return EitherWay(corners, our_turns != their_turns[partner])


def reversed_polygons(faces: Polygons) -> Polygons:
    """The same polygons run the other way round, each from the same first vertex."""
    return Polygons(
        faces.indices[turned_corners(faces, np.ones(len(faces), dtype=bool))], faces.offsets
    )


def _runs_down(faces: Polygons) -> NDArray[np.bool_]:
    """(F,) whether the vertex after the least is larger than the one before it."""
    if not len(faces):
        return np.zeros(0, dtype=bool)
    least = np.minimum.reduceat(faces.indices, faces.offsets[:-1])
    at = np.flatnonzero(faces.indices == least[faces.corner_faces])
    _, first = np.unique(faces.corner_faces[at], return_index=True)
    corner = at[first]
    starts, sizes = faces.offsets[:-1], faces.sizes
    before = starts + (corner - starts - 1) % sizes
    after = starts + (corner - starts + 1) % sizes
    return np.asarray(faces.indices[after] > faces.indices[before])


def turned_corners(faces: Polygons, turned: NDArray[np.bool_]) -> NDArray[np.int64]:
    """(C,) the corner to read at each place for some polygons to run the other way round.

    Args:
        faces: Polygons.
        turned: (F,) which of them; each keeps its first vertex.
    """
    place = np.arange(faces.indices.size)
    starts, sizes = faces.offsets[:-1][faces.corner_faces], faces.sizes[faces.corner_faces]
    backwards = starts + (starts - place) % sizes
    return np.asarray(np.where(turned[faces.corner_faces], backwards, place), dtype=np.int64)
