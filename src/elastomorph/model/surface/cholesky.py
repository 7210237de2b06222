"""A sparse Cholesky factorisation of a graph's matrix, piece by piece with dense algebra.

The multifrontal method (Duff and Reid, ACM TOMS 9(3), 1983): each node of the elimination tree
gathers its rows and what its children left in one dense matrix, eliminates its own vertices and
leaves the rest to its parent.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import MeshError
from elastomorph.model.surface.dissection import EliminationTree

__all__ = ["Cholesky"]

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
    """A = P L Lᵀ Pᵀ of a symmetric positive definite matrix.

    Attributes:
        order: (N,) rows of the matrix in the order of elimination.
        fronts: The factor by nodes.
    """

    order: NDArray[np.int64]
    fronts: tuple[_Front, ...]

    @classmethod
    def of(
        cls,
        tree: EliminationTree,
        kept: NDArray[np.bool_],
        ends: NDArray[np.integer],
        weights: Matrix,
        diagonal: Matrix,
    ) -> Cholesky:
        """Factor the matrix that has -w at the edges of some vertices of a graph.

        Args:
            tree: Of the whole graph.
            kept: (V,) the N vertices that have a row.
            ends: (E, 2) vertices joined, all kept, each pair once.
            weights: (E,) w ≥ 0.
            diagonal: (N,) larger than the sum of the weights at the vertex.
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
