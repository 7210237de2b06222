"""Relabelling where no walk gets everywhere: surfaces that are joined at points or branch at edges.

Vertices are told apart by their colours; where colours leave a choice, one vertex is matched with
the nearest candidate and colours are refined again, until all are matched or a match turns out
wrong and the next candidate is tried.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.half_edges import HalfEdges
from elastomorph.doctor.relabelling.colours import Colouring
from elastomorph.doctor.relabelling.same_polygons import corresponding_corners
from elastomorph.model.polygons import Polygons

__all__ = ["Piece", "branched_match"]

_ATTEMPTS = 400


class Piece:
    """One piece of a mesh, numbered for itself.

    Attributes:
        vertices: (N,) its vertices in the whole mesh, rising.
        faces: Its polygons, vertices counted within the piece.
        points: (N, 3) positions.
    """

    def __init__(
        self, half_edges: HalfEdges, vertices: NDArray[np.int64], positions: NDArray[np.float64]
    ) -> None:
        """Cut the piece out of its mesh."""
        self.vertices = vertices
        inside = np.full(half_edges.vertex_count, -1, dtype=np.int64)
        inside[vertices] = np.arange(len(vertices))
        faces = half_edges.faces
        own = inside[half_edges.start] >= 0
        sizes = faces.sizes[own[faces.offsets[:-1]]] if len(faces) else faces.sizes
        self.faces = Polygons(inside[half_edges.start[own]], np.append(0, np.cumsum(sizes)))
        self.points = positions[vertices]
        self.half_edges = HalfEdges.of(self.faces, len(vertices))


def branched_match(
    ours: Piece, theirs: Piece, seeds: Sequence[tuple[int, int]] = ()
) -> NDArray[np.int64] | None:
    """For each of their vertices ours, numbers within the pieces; None where none was found.

    Args:
        ours: A piece of the neutral.
        theirs: A piece of the target with as many vertices.
        seeds: Pairs known to belong together.
    """
    attempts = [_ATTEMPTS]
    return _search(ours, theirs, list(seeds), attempts)


def _search(
    ours: Piece, theirs: Piece, pairs: list[tuple[int, int]], attempts: list[int]
) -> NDArray[np.int64] | None:
    if attempts[0] <= 0:
        return None
    attempts[0] -= 1
    mine = Colouring(ours.half_edges, [pair[0] for pair in pairs])
    their = Colouring(theirs.half_edges, [pair[1] for pair in pairs])
    mine.exhaust()
    while their.rounds < mine.rounds:
        their.advance()
    my_order, their_order = np.argsort(mine.vertices), np.argsort(their.vertices)
    if not np.array_equal(mine.vertices[my_order], their.vertices[their_order]):
        return None
    _, firsts, counts = np.unique(mine.vertices, return_index=True, return_counts=True)
    if counts.max() == 1:
        match = np.empty(len(my_order), dtype=np.int64)
        match[their_order] = my_order
        renamed = Polygons(match[theirs.faces.indices], theirs.faces.offsets)
        return match if corresponding_corners(ours.faces, renamed) is not None else None
    choice = int(np.argmin(np.where(counts > 1, counts, len(my_order) + 1)))
    vertex = int(firsts[choice])
    candidates = np.flatnonzero(their.vertices == mine.vertices[vertex])
    here = ours.points[vertex] - ours.points.mean(axis=0)
    there = theirs.points[candidates] - theirs.points.mean(axis=0)
    for nearest in np.argsort(np.linalg.norm(there - here, axis=1), kind="stable").tolist():
        pair = (vertex, int(candidates[nearest]))
        found = _search(ours, theirs, [*pairs, pair], attempts)
        if found is not None:
            return found
    return None
