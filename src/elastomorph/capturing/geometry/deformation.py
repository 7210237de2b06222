"""Surfaces that bend as little as what is known of them allows.

The energy of positions V with a rotation R_i at each vertex is

    Σ_i (v_iᵀ A_i v_i − 2 b_iᵀ v_i) + a Σ_ij ‖v_i − v_j − (R_i + R_j)/2 (p_i − p_j)‖²
                                    + β Σ_i ‖(L V)_i − R_i (L P)_i‖²

with the rest positions P, edges ij and the mean-of-neighbours Laplacian L: as rigid as possible
(Sorkine and Alexa, SGP 2007) with bending. Rotations and positions are found in turns.
"""

from __future__ import annotations

from copy import copy
from typing import Any

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

from elastomorph.capturing.geometry.surface import Surface, edges_of
from elastomorph.model.cholesky import symmetric_factor
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
        edges = edges_of(triangles)
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
        self._order = _order(self._bending)
        self._smoothing = sparse.diags_array(1 / (degrees + 1)) @ (
            self.neighbours + sparse.eye_array(count)
        )

    def around(self, rest: Points) -> Deformation:
        """The same surface with another shape at rest, without preparing it again."""
        other = copy(self)
        other.rest, other._curvature = rest, self._mean @ rest
        return other

    def smoothed(self, values: Points, rounds: int = 1) -> Points:
        """(V, ...) values at the vertices, each made the mean of itself and its neighbours."""
        for _ in range(rounds):
            values = self._smoothing @ values
        return values

    def rotations(self, vertices: Points, smoothing: int = 2) -> Points:
        """(V, 3, 3) rotations of the surroundings of each vertex from rest to (V, 3) vertices."""
        first, second = self.edges.T
        before = self.rest[first] - self.rest[second]
        after = vertices[first] - vertices[second]
        products = (after[:, :, None] * before[:, None, :]).reshape(-1, 9)
        total = np.zeros((len(vertices), 9))
        np.add.at(total, first, products)
        np.add.at(total, second, products)
        left, _, right = np.linalg.svd(self.smoothed(total, smoothing).reshape(-1, 3, 3))
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
            found = factor.solve(right[self._order].reshape(-1, 1))
            vertices = np.empty_like(vertices)
            vertices[self._order] = found.reshape(-1, 3)
        return vertices

    def _factor(self, quadratic: Points, arap: float, bending: float) -> Any:
        """Of the matrix of 3 V unknowns in order, x, y and z of a vertex after each other."""
        stiffness = (arap * self._laplacian + bending * self._bending)[self._order][:, self._order]
        count = len(self.rest)
        blocks = sparse.bsr_array(
            (quadratic[self._order], np.arange(count), np.arange(count + 1)),
            shape=(3 * count, 3 * count),
        )
        matrix = sparse.kron(stiffness, sparse.eye_array(3)) + blocks
        return symmetric_factor(matrix.tocsc(), ordered=True)


def _order(pattern: Any) -> NDArray[np.int64]:
    """(V,) vertices in the order in which a symmetric matrix of this pattern is eliminated.

    The minimum degree order suits surfaces with many layers, a mouth within a head: its factor
    has a fraction of the entries that cuts along planes leave.
    """
    factor = symmetric_factor((pattern + sparse.eye_array(pattern.shape[0])).tocsc())
    return np.argsort(factor.perm_c)


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


# What draws a surface to points in space: robust closest points, and places that are known.


def robust(residuals: Points, width: float) -> Points:
    """Weights in (0, 1] of residuals: half of it at 0.64 widths, next to nothing beyond three.

    That of Geman and McClure: the sum of r² / (r² + width²) is what becomes least.
    """
    weights: Points = 1 / (1 + (residuals / width) ** 2) ** 2
    return weights


def along_normals(surface: Surface, weights: Points, offsets: Points) -> tuple[Points, Points]:
    """Quadratic (V, 3, 3) and linear (V, 3) terms that move (V,) vertices along their normals."""
    normals = surface.normals
    quadratic = weights[:, None, None] * (normals[:, :, None] * normals[:, None, :])
    goal = np.einsum("ij,ij->i", surface.vertices, normals) + offsets
    return quadratic, normals * (weights * goal)[:, None]


def to_places(
    count: int, vertices: NDArray[np.integer], places: Points, weight: float
) -> tuple[Points, Points]:
    """Quadratic (V, 3, 3) and linear (V, 3) terms that draw some vertices to (K, 3) places."""
    quadratic, linear = np.zeros((count, 3, 3)), np.zeros((count, 3))
    np.add.at(quadratic, vertices, weight * np.eye(3))
    np.add.at(linear, vertices, weight * places)
    return quadratic, linear


def to_points(
    surface: Surface, points: Points, chosen: NDArray[np.bool_], *, width: float, reach: float
) -> tuple[Points, Points]:
    """Quadratic (V, 3, 3) and linear (V, 3) terms that draw a surface to (N, 3) points.

    Each point draws the triangle that is nearest to it, along the normals of its corners.

    Args:
        surface: what is drawn.
        points: near it; any others do nothing.
        chosen: (V,) which vertices may be drawn; a triangle needs one.
        width: of `robust`, in the units of the surface.
        reach: farther points do nothing.
    """
    near = surface.closest(points)
    corners = surface.triangles[near.triangles]
    use = (near.distances < reach) & chosen[corners].any(axis=1)
    corners, shares = corners[use], near.weights[use]
    away = points[use] - near.points[use]
    weights = shares * robust(near.distances[use], width)[:, None]
    normals = surface.normals[corners]
    goals = np.einsum("ncj,ncj->nc", surface.vertices[corners], normals)
    goals += np.einsum("nj,ncj->nc", away, normals)
    quadratic = np.zeros((len(surface.vertices), 3, 3))
    linear = np.zeros((len(surface.vertices), 3))
    products = weights[..., None, None] * (normals[..., :, None] * normals[..., None, :])
    np.add.at(quadratic, corners, products)
    np.add.at(linear, corners, (weights * goals)[..., None] * normals)
    return quadratic, linear
