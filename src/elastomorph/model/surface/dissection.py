"""An order of elimination for surfaces: cut in halves, the cuts last (nested dissection).

George, SIAM J. Numer. Anal. 10(2), 1973: of N vertices of a surface a cut takes about √N, so that
a Cholesky factor in this order has O(N log N) entries.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.components import component_of

__all__ = ["EliminationTree"]

# Pieces of at most this many vertices are not cut again: small dense matrices are fast.
_LEAF = 120


@dataclass(frozen=True, eq=False)
class EliminationTree:
    """Cuts and pieces of a graph; all neighbours of a piece are in it or in cuts above it.

    Attributes:
        order: (V,) vertices in the order of elimination.
        starts: (N + 1,) where the vertices of each node begin in `order`.
        parents: (N,) the cut that made a node, a later one; -1 for the last cut of a component.
        borders: For each node the places in `order`, rising, of what its elimination joins.
    """

    order: NDArray[np.int64]
    starts: NDArray[np.int64]
    parents: NDArray[np.int64]
    borders: tuple[NDArray[np.int64], ...]

    @classmethod
    def of(cls, points: NDArray[np.float64], ends: NDArray[np.integer]) -> EliminationTree:
        """Cut along the longest side of the box around each piece, at its median.

        Args:
            points: (V, 3) positions; they make cuts short, and do not matter otherwise.
            ends: (E, 2) edges of the graph.
        """
        node_of, parents = _cut(points, ends)
        # Cuts were numbered from the top: eliminated last.
        node_of, parents = len(parents) - 1 - node_of, len(parents) - 1 - parents[::-1]
        parents[parents == len(parents)] = -1
        order = np.argsort(node_of, kind="stable")
        starts = np.searchsorted(node_of[order], np.arange(len(parents) + 1))
        return cls(order, starts, parents, _borders(order, starts, parents, ends))


def _cut(
    points: NDArray[np.float64], ends: NDArray[np.integer]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(V,) the node of each vertex and (N,) the parents, parents before children.

    All pieces of one depth are cut at once.
    """
    count = len(points)
    node_of = np.full(count, -1)
    parents: list[NDArray[np.int64]] = []
    piece_of = component_of(count, ends).astype(np.int64)
    above = np.full(int(piece_of.max()) + 1, -1)
    known, left = 0, np.arange(count)
    while left.size:
        parents.append(above)
        pieces, sizes = piece_of[left], np.bincount(piece_of[left], minlength=len(above))
        leaf = sizes[pieces] <= _LEAF
        node_of[left[leaf]] = known + pieces[leaf]
        left, pieces = left[~leaf], pieces[~leaf]
        second = np.zeros(count, dtype=bool)
        second[left] = _beyond_median(points[left], pieces, len(above))
        inside = node_of[ends] < 0
        ends = ends[inside.all(axis=1) & (piece_of[ends[:, 0]] == piece_of[ends[:, 1]])]
        across = ends[second[ends[:, 0]] != second[ends[:, 1]]]
        sides = [np.unique(across[second[across] == side]) for side in (False, True)]
        numbers = [np.bincount(piece_of[side], minlength=len(above)) for side in sides]
        shorter = numbers[1] < numbers[0]
        for side, wanted in zip(sides, (False, True), strict=True):
            cut = side[shorter[piece_of[side]] == wanted]
            node_of[cut] = known + piece_of[cut]
        left = left[node_of[left] < 0]
        halves, piece_of[left] = np.unique(2 * piece_of[left] + second[left], return_inverse=True)
        above, known = known + halves // 2, known + len(above)
    return node_of, np.concatenate(parents)


def _beyond_median(
    points: NDArray[np.float64], pieces: NDArray[np.int64], count: int
) -> NDArray[np.bool_]:
    """(N,) points in the second half of their piece along the longest side of its box."""
    order = np.argsort(pieces, kind="stable")
    present, firsts = np.unique(pieces[order], return_index=True)
    if not present.size:
        return np.zeros(0, dtype=bool)
    sides = np.maximum.reduceat(points[order], firsts) - np.minimum.reduceat(points[order], firsts)
    axis = np.zeros(count, dtype=np.int64)
    axis[present] = sides.argmax(axis=1)
    along = points[np.arange(len(points)), axis[pieces]]
    order = np.lexsort((along, pieces))
    sizes = np.diff(np.append(firsts, len(pieces)))
    beyond = np.empty(len(pieces), dtype=bool)
    place = np.arange(len(pieces)) - np.repeat(firsts, sizes)
    beyond[order] = 2 * place >= np.repeat(sizes, sizes)
    return beyond


def _borders(
    order: NDArray[np.int64],
    starts: NDArray[np.int64],
    parents: NDArray[np.int64],
    ends: NDArray[np.integer],
) -> tuple[NDArray[np.int64], ...]:
    """What each node is joined with above: its neighbours there, and what its children left."""
    place = np.empty(len(order), dtype=np.int64)
    place[order] = np.arange(len(order))
    low, high = np.sort(place[ends], axis=1).T
    by_low = np.argsort(low, kind="stable")
    low, high = low[by_low], high[by_low]
    firsts = np.searchsorted(low, starts)
    inherited: list[list[NDArray[np.int64]]] = [[] for _ in parents]
    borders = []
    for node, parent in enumerate(parents):
        stop = starts[node + 1]
        reached = [high[firsts[node] : firsts[node + 1]], *inherited[node]]
        border = np.unique(np.concatenate(reached))
        border = border[np.searchsorted(border, stop) :]
        borders.append(border)
        if parent >= 0:
            inherited[parent].append(border)
        inherited[node] = []
    return tuple(borders)
