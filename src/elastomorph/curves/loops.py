"""Trace the edge loops of a mesh: every edge, followed straight on through every vertex."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves.network import Curve
from elastomorph.curves.selection import Chains, ordered_chains
from elastomorph.model.mesh import Mesh, require_mesh
from elastomorph.model.polygons import Polygons


def edge_loops(mesh: Mesh) -> tuple[Curve, ...]:
    """Every edge loop of a mesh; each edge lies on exactly one.

    A loop goes straight on through each vertex: to the opposite edge where an even number of edges
    meet, along the border at the border. It ends where the number is odd, where it arrives at a
    border from inside, and at edges shared by three or more polygons. A loop that passes twice
    through a vertex is cut there, so that no curve repeats a vertex.

    Args:
        mesh: Polygons of any size, in any number of components, wound either way.

    Returns:
        The loops, those of the lowest edge first. A vertex lies on several.

    Raises:
        MeshError: It is no mesh.
    """
    require_mesh(mesh, "what loops are traced on")
    loops = _cut_at_crossings(trace_loops(edge_ends(mesh.faces, len(mesh.vertices))))
    return tuple(
        Curve(vertices, closed)
        for vertices, closed in zip(loops.arrays(), loops.closed.tolist(), strict=True)
    )


def trace_loops(ends: EdgeEnds) -> Chains:
    """The vertices of every edge loop, uncut: a loop may pass through a vertex several times."""
    straight = straight_successors(ends).reshape(-1, 2)
    chains = ordered_chains(np.where(straight < 0, -1, straight >> 1).astype(np.int32))
    return _vertices_along(chains, ends.edges)


def _vertices_along(chains: Chains, edges: NDArray[np.int32]) -> Chains:
    """The vertices passed by chains of edges."""
    first, last = chains.offsets[:-1], chains.offsets[1:] - 1
    pairs = edges[chains.items]
    before = np.roll(pairs, 1, axis=0)
    before[first] = pairs[last]
    shared = (pairs[:, 0] == before[:, 0]) | (pairs[:, 0] == before[:, 1])
    start = np.where(shared, pairs[:, 0], pairs[:, 1])
    # The first edge of an open chain starts at the vertex that it does not share with the second.
    open_first, open_last = first[~chains.closed], last[~chains.closed]
    second = np.minimum(open_first + 1, open_last)
    onward = np.where(open_first == open_last, pairs[open_first, 1], start[second])
    start[open_first] = pairs[open_first].sum(axis=1) - onward
    final = pairs[open_last].sum(axis=1) - start[open_last]
    items = np.insert(start, open_last + 1, final)
    offsets = chains.offsets + np.concatenate([[0], np.cumsum(~chains.closed)])
    return Chains(items.astype(np.int32), offsets, chains.closed)


def _cut_at_crossings(loops: Chains) -> Chains:
    """Cut loops at every vertex that they pass more than once; the cut vertex ends both pieces."""
    previous = loops.previous_visits()
    again = previous >= 0
    crossed = again.copy()
    crossed[previous[again]] = True
    if not crossed.any():
        return loops
    owner = loops.owners()
    affected = np.zeros(len(loops.closed), dtype=np.bool_)
    affected[owner[crossed]] = True
    pieces: list[NDArray[np.int32]] = []
    closed: list[bool] = []
    for loop, vertices in enumerate(loops.arrays()):
        if not affected[loop]:
            pieces.append(vertices)
            closed.append(bool(loops.closed[loop]))
            continue
        cuts = np.flatnonzero(crossed[loops.offsets[loop] : loops.offsets[loop + 1]])
        if loops.closed[loop]:
            vertices = np.roll(vertices, -cuts[0])
            vertices = np.append(vertices, vertices[0])
            cuts = np.append(cuts - cuts[0], len(vertices) - 1)
        bounds = np.unique(np.concatenate([[0], cuts, [len(vertices) - 1]]))
        for start, stop in pairwise(bounds.tolist()):
            returns = bool(vertices[start] == vertices[stop])
            pieces.append(vertices[start : stop + (not returns)])
            closed.append(returns)
    lengths = np.array([len(piece) for piece in pieces])
    return Chains(
        np.concatenate(pieces), np.concatenate([[0], np.cumsum(lengths)]), np.array(closed)
    )


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
    """(2 E,) int32, the edge end straight on from each across their vertex; an involution.

    In a full ring of n ends around a vertex that is the opposite one when n is even, and none
    (-1) when n is odd. In a fan with a border on both sides the two border edges continue each
    other and the edges between them end.
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
