"""Which vertices hang together."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["component_of", "connected_parts"]


def component_of(count: int, edges: NDArray[np.integer]) -> NDArray[np.int32]:
    """The connected component of each vertex.

    Args:
        count: Number of vertices V.
        edges: (E, 2) pairs of vertices, in any order, repeats allowed.

    Returns:
        (V,) numbers from 0; a vertex on no edge is a component of its own.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    # Ones are added up where an edge repeats: in 8 bits 256 of them would make none.
    graph = coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int32)


def connected_parts(count: int, edges: NDArray[np.integer]) -> list[NDArray[np.int64]]:
    """The vertices of each connected component.

    Args:
        count: Number of vertices.
        edges: (E, 2) pairs of vertices.

    Returns:
        Rising vertex indices of each component, in the order of their first vertices.
    """
    part_of = component_of(count, edges)
    order = np.argsort(part_of, kind="stable")
    starts = np.flatnonzero(np.diff(part_of[order], prepend=-1))
    return np.split(order.astype(np.int64), starts[1:])
