"""A sparse Cholesky factorisation of the matrix of a surface, with dense algebra by pieces.

Vertices are eliminated in an order that cuts the surface in halves, the cuts last (nested
dissection; George, SIAM J. Numer. Anal. 10(2), 1973): of N vertices a cut takes about √N, so that
the factor has O(N log N) entries. By the multifrontal method (Duff and Reid, ACM TOMS 9(3), 1983)
each node of the elimination tree gathers its rows and what its children left in one dense matrix,
eliminates its own vertices and leaves the rest to its parent.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import MeshError
from elastomorph.model.geometry import component_of

if TYPE_CHECKING:
    from scipy.sparse import csc_array

# Pieces of at most this many vertices are not cut again: small dense matrices are fast.
_LEAF = 120


def symmetric_factor(matrix: csc_array, *, ordered: bool = False) -> Any:
    """A factor of any symmetric sparse matrix, definite or not, real or complex, by SuperLU.

    The diagonal has the pivots, whatever their sign: half the fill, and the inertia can be read
    off. Rows are eliminated as they come where they are ordered, else by minimum degree.

    Raises:
        RuntimeError: The matrix is singular.
    """
    from scipy.sparse.linalg import splu

    return splu(
        matrix,
        permc_spec="NATURAL" if ordered else "MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )


@dataclass(frozen=True, eq=False)
class EliminationTree:
    """Cuts and pieces of a graph; all neighbours of a piece are in it or in cuts above it."""

    order: NDArray[np.int64]  # (V,) vertices in the order of elimination
    starts: NDArray[np.int64]  # (N + 1,) where the vertices of each node begin in `order`
    # (N,) the cut that made a node, a later one; -1 for the last cut of a component.
    parents: NDArray[np.int64]
    # For each node the places in `order`, rising, of what its elimination joins.
    borders: tuple[NDArray[np.int64], ...]

    @classmethod
    def of(cls, points: NDArray[np.float64], ends: NDArray[np.integer]) -> EliminationTree:
        """Cut along the longest side of the box around each piece, at its median.

        Positions (V, 3) make cuts short, and do not matter otherwise; `ends` are (E, 2) edges.
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


Matrix = NDArray[np.float64]
# What is added to the diagonal of a dense matrix that rounding has left without an inverse.
_LEAST_PIVOT = 1e-14
# Ten times more each round: by then the diagonal outweighs all the rest.
_ROUNDS = 32


@dataclass(frozen=True, eq=False)
class _Front:
    """A node's rows of the factor, and the border of rows that they reach."""

    start: int
    stop: int
    border: NDArray[np.int64]
    own: Matrix
    below: Matrix


@dataclass(frozen=True, eq=False)
class Cholesky:
    """A = P L Lᵀ Pᵀ of a symmetric positive definite matrix."""

    order: NDArray[np.int64]  # (N,) rows of the matrix in the order of elimination
    fronts: tuple[_Front, ...]  # The factor by nodes

    @classmethod
    def of(
        cls,
        tree: EliminationTree,
        kept: NDArray[np.bool_],
        ends: NDArray[np.integer],
        weights: Matrix,
        diagonal: Matrix,
    ) -> Cholesky:
        """Factor the matrix of -w at (E, 2) edges between the N kept vertices of the tree's graph.

        Each pair of vertices is there once, w ≥ 0; the (N,) diagonal is larger than the sum of the
        weights at the vertex.
        """
        inside = kept[tree.order]
        place: NDArray[np.int64] = np.cumsum(inside) - inside
        row = np.cumsum(kept) - 1
        order = row[tree.order[inside]]
        position = np.empty(len(kept), dtype=np.int64)
        position[tree.order] = place
        low, high = np.sort(position[ends], axis=1).T
        by_low = np.argsort(low, kind="stable")
        low, high, entries = low[by_low], high[by_low], -weights[by_low]
        starts = np.append(place, len(order))[tree.starts]
        firsts = np.searchsorted(low, starts)
        diagonal = diagonal[order]
        left: list[list[tuple[NDArray[np.int64], Matrix]]] = [[] for _ in tree.parents]
        fronts = []
        for node, parent in enumerate(tree.parents):
            start, stop = int(starts[node]), int(starts[node + 1])
            updates, left[node] = left[node], []
            if start == stop:
                if parent >= 0:
                    left[parent] += updates
                continue
            above = tree.borders[node]
            border = place[above[inside[above]]]
            mine = slice(firsts[node], firsts[node + 1])
            edges = low[mine] - start, high[mine], entries[mine]
            front, update = _eliminated(start, stop, border, diagonal, edges, updates)
            fronts.append(front)
            if parent >= 0 and border.size:
                left[parent].append((border, update))
        return cls(order, tuple(fronts))

    def solve(self, wanted: Matrix) -> Matrix:
        """(N, K) solutions of A x = b for (N, K) right-hand sides."""
        from scipy.linalg.blas import dtrsm

        x = wanted[self.order]
        for front in self.fronts:
            own = dtrsm(1.0, front.own, x[front.start : front.stop], lower=1)
            x[front.start : front.stop] = own
            if front.border.size:
                x[front.border] -= front.below @ own
        for front in reversed(self.fronts):
            own = x[front.start : front.stop]
            if front.border.size:
                own = own - front.below.T @ x[front.border]
            x[front.start : front.stop] = dtrsm(1.0, front.own, own, lower=1, trans_a=1)
        found = np.empty_like(x)
        found[self.order] = x
        return found


def _eliminated(
    start: int,
    stop: int,
    border: NDArray[np.int64],
    diagonal: Matrix,
    edges: tuple[NDArray[np.int64], NDArray[np.int64], Matrix],
    updates: list[tuple[NDArray[np.int64], Matrix]],
) -> tuple[_Front, Matrix]:
    """Gather the dense matrix of a node, its lower half, and eliminate the node's own rows."""
    from scipy.linalg.blas import dsyrk, dtrsm

    size, reach = stop - start, len(border)
    own = np.zeros((size, size), order="F")
    below = np.zeros((reach, size), order="F")
    rest = np.zeros((reach, reach), order="F")
    own.ravel("K")[:: size + 1] = diagonal[start:stop]
    column, other, entries = edges
    within = other < stop
    own[other[within] - start, column[within]] = entries[within]
    below[np.searchsorted(border, other[~within]), column[~within]] = entries[~within]
    for places, update in updates:
        split = int(np.searchsorted(places, stop))
        here, there = places[:split] - start, np.searchsorted(border, places[split:])
        # Transposed, memory is walked in its own order.
        own.T[here[:, None], here] += update.T[:split, :split]
        below.T[here[:, None], there] += update.T[:split, split:]
        rest.T[there[:, None], there] += update.T[split:, split:]
    own = _lower(own)
    if reach:
        below = dtrsm(1.0, own, below, side=1, lower=1, trans_a=1, overwrite_b=1)
        rest = dsyrk(-1.0, below, beta=1.0, c=rest, lower=1, overwrite_c=1)
    return _Front(start, stop, border, own, below), rest


def _lower(matrix: Matrix) -> Matrix:
    """L of a dense matrix of which the lower half is given."""
    from scipy.linalg.lapack import dpotrf

    found, failed = dpotrf(matrix, lower=1)
    least = _LEAST_PIVOT * float(np.abs(matrix).max()) if failed else 0.0
    for _ in range(_ROUNDS):
        if not failed:
            return np.asarray(found)
        np.fill_diagonal(matrix, matrix.diagonal() + least)
        least *= 10.0
        found, failed = dpotrf(matrix, lower=1)
    raise MeshError("the equation of the surface has no solution: nothing holds a part of it")
