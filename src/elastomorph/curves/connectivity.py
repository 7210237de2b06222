"""Which edge goes straight on from which: the rings of edges around the vertices of a mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves.chains import ordered_chains
from elastomorph.model.polygons import Polygons

__all__ = ["EdgeEnds", "edge_ends", "straight_successors"]


@dataclass(frozen=True, eq=False)
class EdgeEnds:
    """The edges of a mesh and the polygon corners between them.

    An *edge end* is one end of one edge: end ``2 e`` is edge e at its lower vertex, ``2 e + 1`` at
    its higher. Two ends at a vertex are neighbours where a polygon has its corner between them.
    No polygon's direction is used, so polygons may be wound either way.

    Attributes:
        edges: (E, 2) int32, every edge once, lower vertex first, ascending (as ``Mesh.edges``).
        neighbours: (2 E, 2) int32, the neighbouring ends, -1 for none.
        on_border: (2 E,) bool, ends with exactly one corner beside them.
    """

    edges: NDArray[np.int32]
    neighbours: NDArray[np.int32]
    on_border: NDArray[np.bool_]


def edge_ends(faces: Polygons, vertex_count: int) -> EdgeEnds:
    """The edges of some polygons, and which of their ends share a corner.

    A vertex repeated in a row within a polygon counts once. Where three or more corners meet in
    an edge end (a non-manifold edge), that end gets no neighbours.

    Args:
        faces: Polygons of any size.
        vertex_count: Number of vertices V.
    """
    starts, following = _corners(faces)
    stops = starts[following]
    edges, edge = _unique_edges(starts, stops, vertex_count)
    ahead = 2 * edge + (starts > stops)
    behind = np.empty_like(ahead)
    behind[following] = ahead ^ 1
    between = ahead != behind
    if not between.all():
        ahead, behind = ahead[between], behind[between]
    neighbours = np.full((2 * len(edges), 2), -1, dtype=np.int32)
    # Polygons wound alike fill one column each way; what finds its column taken tries the other.
    from_ahead = _entered(neighbours, 0, ahead, behind)
    from_behind = _entered(neighbours, 1, behind, ahead)
    crowding = np.concatenate(
        [_entered(neighbours, 1, *from_ahead)[0], _entered(neighbours, 0, *from_behind)[0]]
    )
    on_border = (neighbours[:, 0] < 0) != (neighbours[:, 1] < 0)
    if crowding.size:
        crowded = np.zeros(len(neighbours), dtype=np.bool_)
        crowded[crowding] = True
        neighbours[crowded] = -1
        neighbours[(neighbours >= 0) & crowded[neighbours]] = -1
    return EdgeEnds(edges, neighbours, on_border)


def _entered(
    neighbours: NDArray[np.int32], column: int, end: NDArray[np.int32], other: NDArray[np.int32]
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Enter ``other`` as a neighbour of ``end``, one for each end; returns those without room."""
    entry = np.arange(end.size, dtype=np.int32)
    last = np.empty(len(neighbours), dtype=np.int32)
    last[end] = entry
    fits = (last[end] == entry) & (neighbours[end, column] < 0)
    if fits.all():
        neighbours[end, column] = other
        return end[:0], other[:0]
    neighbours[end[fits], column] = other[fits]
    return end[~fits], other[~fits]


def _corners(faces: Polygons) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """The vertex of each corner and the corner after it, without repeats in a row."""
    starts, following = faces.indices, faces.next_corners
    repeated = starts == starts[following]
    if not repeated.any():
        return starts, following
    sizes = np.bincount(faces.corner_faces[~repeated], minlength=len(faces))
    sizes = sizes[sizes > 0]
    last = np.cumsum(sizes) - 1
    following = np.arange(1, int(sizes.sum()) + 1)
    following[last] = last - sizes + 1
    return starts[~repeated], following


def _unique_edges(
    starts: NDArray[np.int32], stops: NDArray[np.int32], vertex_count: int
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """The (E, 2) edges in ascending order, and which of them each (start, stop) is."""
    keys = np.minimum(starts, stops) * np.int64(vertex_count) + np.maximum(starts, stops)
    order = np.argsort(keys)
    keys = keys[order]
    first = np.ones(len(keys), dtype=np.bool_)
    first[1:] = keys[1:] != keys[:-1]
    edge = np.empty(len(keys), dtype=np.int32)
    edge[order] = np.cumsum(first, dtype=np.int32) - 1
    return np.stack(np.divmod(keys[first], vertex_count), axis=1).astype(np.int32), edge


def straight_successors(ends: EdgeEnds) -> NDArray[np.int32]:
    """The edge end that goes straight on from each edge end, across their common vertex.

    In a full ring of n ends around a vertex that is the opposite one when n is even, and none
    when n is odd. In a fan with a border on both sides the two border edges continue each other
    and the edges between them end.

    Returns:
        (2 E,) int32, an involution: ``s[s[i]] == i`` wherever ``s[i]`` is not -1.
    """
    rings = ordered_chains(ends.neighbours)
    straight = np.full(len(ends.neighbours), -1, dtype=np.int32)
    full = np.flatnonzero(rings.closed & (rings.lengths % 2 == 0))
    full = full[np.argsort(rings.lengths[full], kind="stable")]
    sizes, begins = np.unique(rings.lengths[full], return_index=True)
    for size, same in zip(sizes.tolist(), np.split(full, begins[1:]), strict=False):
        ring = rings.items[rings.offsets[same, None] + np.arange(size)]
        straight[ring] = np.roll(ring, size // 2, axis=1)
    fan = ~rings.closed & (rings.lengths > 1)
    first, last = rings.items[rings.offsets[:-1][fan]], rings.items[rings.offsets[1:][fan] - 1]
    both = ends.on_border[first] & ends.on_border[last]
    first, last = first[both], last[both]
    straight[first], straight[last] = last, first
    return straight
