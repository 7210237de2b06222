"""Trace the edge loops of a mesh: every edge, followed straight on through every vertex."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves.chains import Chains, ordered_chains
from elastomorph.curves.connectivity import EdgeEnds, edge_ends, straight_successors
from elastomorph.curves.network import Curve
from elastomorph.model.mesh import Mesh, require_mesh

__all__ = ["edge_loops", "previous_visits", "trace_loops"]


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


def previous_visits(loops: Chains) -> NDArray[np.int64]:
    """For each entry of ``loops.items``, the last earlier entry of the same loop and vertex.

    Returns:
        (N,) int64 places in ``loops.items``, -1 where the loop comes to its vertex first.
    """
    count = len(loops.items)
    vertex, entry = np.divmod(
        np.sort(loops.items.astype(np.int64) * count + np.arange(count)), max(count, 1)
    )
    owner = loops.owners()[entry]
    again = np.flatnonzero((vertex[1:] == vertex[:-1]) & (owner[1:] == owner[:-1])) + 1
    previous = np.full(count, -1, dtype=np.int64)
    previous[entry[again]] = entry[again - 1]
    return previous


def _cut_at_crossings(loops: Chains) -> Chains:
    """Cut loops at every vertex that they pass more than once; the cut vertex ends both pieces."""
    previous = previous_visits(loops)
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
