"""Polygons as half-edges: which polygon is on the other side, and where sides are not two."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.polygons import Polygons

__all__ = ["HalfEdges"]


@dataclass(frozen=True, eq=False)
class HalfEdges:
    """Each polygon corner with the edge that leaves it.

    Attributes:
        faces: The polygons.
        vertex_count: V.
        start: (C,) int64 vertex of each corner.
        end: (C,) vertex of the following corner.
        following: (C,) the following corner of the polygon.
        previous: (C,) the corner before.
        twin: (C,) the one corner whose edge runs the other way; -1 at a border, and where more
            than two polygons meet or two run the same way.
        alike: (C,) how many corners have the same edge in the same direction, itself included.
        against: (C,) how many have it in the other direction.
    """

    faces: Polygons
    vertex_count: int
    start: NDArray[np.int64]
    end: NDArray[np.int64]
    following: NDArray[np.int64]
    previous: NDArray[np.int64]
    twin: NDArray[np.int64]
    alike: NDArray[np.int64]
    against: NDArray[np.int64]

    @classmethod
    def of(cls, faces: Polygons, vertex_count: int) -> HalfEdges:
        """The half-edges of polygons."""
        start = faces.indices.astype(np.int64)
        following = faces.next_corners
        previous = np.empty_like(following)
        previous[following] = np.arange(len(following))
        end = start[following] if start.size else start
        keys, backward = start * vertex_count + end, end * vertex_count + start
        order = np.argsort(keys, kind="stable")
        ordered = keys[order]
        first = np.searchsorted(ordered, backward)
        against = np.searchsorted(ordered, backward, side="right") - first
        alike = np.searchsorted(ordered, keys, side="right") - np.searchsorted(ordered, keys)
        plain = (alike == 1) & (against == 1) & (start != end)
        twin = np.full(len(start), -1, dtype=np.int64)
        twin[plain] = order[first[plain]]
        return cls(faces, vertex_count, start, end, following, previous, twin, alike, against)

    @property
    def proper(self) -> NDArray[np.bool_]:
        """(C,) whether the edge joins two different vertices."""
        return np.asarray(self.start != self.end)

    @property
    def edge_keys(self) -> NDArray[np.int64]:
        """(C,) one number for each edge, whichever way it runs."""
        low, high = np.minimum(self.start, self.end), np.maximum(self.start, self.end)
        return low * self.vertex_count + high
