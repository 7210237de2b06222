"""Surfaces that bend as little as what is known of them allows.

The energy of positions V with a rotation R_i at each vertex is

    Σ_i (v_iᵀ A_i v_i − 2 b_iᵀ v_i) + a Σ_ij ‖v_i − v_j − (R_i + R_j)/2 (p_i − p_j)‖²
                                    + β Σ_i ‖(L V)_i − R_i (L P)_i‖²

with the rest positions P, edges ij and the mean-of-neighbours Laplacian L: as rigid as possible
(Sorkine and Alexa, SGP 2007) with bending. Rotations and positions are found in turns.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

from elastomorph.model.cholesky import Cholesky, EliminationTree
from elastomorph.model.geometry import component_of

Points = NDArray[np.float64]

# What holds vertices that nothing else holds to where they are, beside the stiffness of an edge.
_HOLD = 1e-7
# Pairs of vertices by which a part is tied to the rest.
_TIES = 12


class Deformation:
    """A surface at rest, prepared for many solutions.

    Parts that hang together with nothing are tied to the nearest vertices of the largest part, so
    that what is not seen, an eye or teeth, goes along.
    """

    def __init__(self, rest: Points, triangles: NDArray[np.integer]) -> None:
        count = len(rest)
        sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
        edges = np.unique(np.sort(sides, axis=1), axis=0)
        self.rest = rest
        self.edges = np.concatenate([edges, _ties(rest, edges)])
        first, second = self.edges.T
        ones = np.ones(len(self.edges))
        joined = sparse.coo_array((ones, (first, second)), shape=(count, count))
        self.neighbours = (joined + joined.T).tocsr()
        degrees = self.neighbours.sum(axis=1)
        laplacian = sparse.diags_array(degrees) - self.neighbours
        mean = sparse.diags_array(1 / np.maximum(degrees, 1)) @ laplacian
        self._laplacian, self._mean = laplacian.tocsr(), mean.tocsr()
        self._bending = (mean.T @ mean).tocsr()
        self._curvature = mean @ rest
        self._smoothing = sparse.diags_array(1 / (degrees + 1)) @ (
            self.neighbours + sparse.eye_array(count)
        )
        pattern = sparse.triu(abs(self._bending) + abs(self._laplacian), 1).tocoo()
        self._pairs = np.stack([pattern.row, pattern.col], axis=1)
        self._tree = EliminationTree.of(np.repeat(rest, 3, axis=0), _coupled(self._pairs, count))

    def rotations(self, vertices: Points, smoothing: int = 2) -> Points:
        """(V, 3, 3) rotations of the surroundings of each vertex from rest to (V, 3) vertices."""
        first, second = self.edges.T
        before = self.rest[first] - self.rest[second]
        after = vertices[first] - vertices[second]
        products = (after[:, :, None] * before[:, None, :]).reshape(-1, 9)
        total = np.zeros((len(vertices), 9))
        np.add.at(total, first, products)
        np.add.at(total, second, products)
        for _ in range(smoothing):
            total = self._smoothing @ total
        left, _, right = np.linalg.svd(total.reshape(-1, 3, 3))
        left[:, :, 2] *= np.sign(np.linalg.det(left @ right))[:, None]
        found: Points = left @ right
        return found

    def solve(
        self,
        vertices: Points,
        quadratic: Points,
        linear: Points,
        *,
        arap: float,
        bending: float,
        rounds: int = 3,
    ) -> Points:
        """(V, 3) positions of least energy, begun at `vertices`.

        Args:
            vertices: (V, 3) to start from.
            quadratic: (V, 3, 3) A, symmetric.
            linear: (V, 3) b.
            arap: a, how much edges are kept.
            bending: β, how much curvature is kept.
            rounds: turns of rotations and positions.
        """
        hold = _HOLD * max(arap, bending)
        factor = self._factor(quadratic + hold * np.eye(3), arap, bending)
        first, second = self.edges.T
        edges = self.rest[first] - self.rest[second]
        for _ in range(rounds):
            turned = self.rotations(vertices)
            pull = 0.5 * np.einsum("eij,ej->ei", turned[first] + turned[second], edges)
            right = linear + hold * vertices
            np.add.at(right, first, arap * pull)
            np.add.at(right, second, -arap * pull)
            right += bending * (self._mean.T @ np.einsum("nij,nj->ni", turned, self._curvature))
            vertices = factor.solve(right.reshape(-1, 1)).reshape(-1, 3)
        return vertices

    def _factor(self, quadratic: Points, arap: float, bending: float) -> Cholesky:
        """Of the matrix of 3 V unknowns, x, y and z of a vertex after each other."""
        count = len(self.rest)
        matrix: Any = (arap * self._laplacian + bending * self._bending).tocsr()
        between = np.asarray(matrix[tuple(self._pairs.T)])
        weights = np.concatenate(
            [np.repeat(-between[:, None], 3, axis=1).ravel(), -quadratic[:, *_OFF_DIAGONAL].ravel()]
        )
        own = matrix.diagonal()[:, None] + np.diagonal(quadratic, axis1=1, axis2=2)
        kept = np.ones(3 * count, dtype=bool)
        return Cholesky.of(self._tree, kept, _coupled(self._pairs, count), weights, own.ravel())


_OFF_DIAGONAL = (np.array([0, 0, 1]), np.array([1, 2, 2]))


def _coupled(pairs: NDArray[np.integer], count: int) -> NDArray[np.int64]:
    """Pairs of the 3 V unknowns: each axis of each pair of vertices, and the axes of a vertex."""
    axes = (3 * pairs[:, None, :] + np.arange(3)[:, None]).reshape(-1, 2)
    own = 3 * np.arange(count)[:, None, None] + np.stack(_OFF_DIAGONAL, axis=1)
    return np.concatenate([axes, own.reshape(-1, 2)]).astype(np.int64)


def _ties(rest: Points, edges: NDArray[np.integer]) -> NDArray[np.int64]:
    """(E, 2) pairs of near vertices that join each part to the largest one."""
    from scipy.spatial import cKDTree

    parts = component_of(len(rest), edges)
    sizes = np.bincount(parts)
    main = np.flatnonzero(parts == sizes.argmax())
    tree = cKDTree(rest[main])
    ties = [np.empty((0, 2), dtype=np.int64)]
    for part in np.flatnonzero((sizes > 1) & (np.arange(len(sizes)) != sizes.argmax())):
        mine = np.flatnonzero(parts == part)
        far, nearest = (np.asarray(found) for found in tree.query(rest[mine]))
        few = np.argsort(far, kind="stable")[:_TIES]
        ties.append(np.stack([mine[few], main[nearest[few]]], axis=1))
    return np.concatenate(ties)
