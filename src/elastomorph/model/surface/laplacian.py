"""The Laplace-Beltrami operator of a polygon mesh: cotangent stiffness and lumped mass."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import MeshError
from elastomorph.model.mesh import Mesh
from elastomorph.model.surface.triangulation import triangulate

if TYPE_CHECKING:
    from scipy.sparse import csc_array

__all__ = ["SurfaceOperators", "surface_operators"]

# A triangle is taken at least this far, in parts of its longest side, from being flat: no
# cotangent is larger than about the inverse.
_SLACK = 1e-3
# A vertex without area weighs this part of an average vertex.
_LEAST_MASS = 1e-6
# Weights below this are right angles up to rounding; without them the matrices are sparser.
_NO_WEIGHT = 1e-12


@dataclass(frozen=True, eq=False)
class SurfaceOperators:
    """The discrete Laplacian of a surface: -Δv ≈ M⁻¹ L v, in units in which the area is 1.

    Attributes:
        triangles: (T, 3) int32, the polygons split for the operator only.
        shares: (T,) float64 in (0, 1], how much of each triangle counts, see `Triangulation`.
        stiffness: (V, V) L, symmetric, positive semi-definite, its rows sum to 0; its kernel are
            the functions that are constant on each component. Free of scale.
        mass: (V,) the diagonal of M, a third of the area around each vertex over the whole area:
            above 0, sums to 1 but for vertices without area.
        component_of: (V,) int32 connected piece of each vertex, joined by triangles; a vertex on
            no triangle is a piece of its own.
        component_count: Number of pieces.
        area: Of the surface, in the unit of the vertices squared.
    """

    triangles: NDArray[np.int32]
    shares: NDArray[np.float64]
    stiffness: csc_array
    mass: NDArray[np.float64]
    component_of: NDArray[np.int32]
    component_count: int
    area: float


def surface_operators(mesh: Mesh) -> SurfaceOperators:
    """The cotangent Laplacian of a mesh, robust to whatever artists leave behind.

    L_ij = -½ Σ cot α over the triangles at edge ij (α opposite the edge). Cotangents may be
    negative; each triangle's part is that of a real triangle, so L stays positive semi-definite.
    Triangles flatter than 0.1 % of their longest side have all three sides lengthened by what is
    missing (as in intrinsic mollification, Sharp and Crane 2020), so that degenerate triangles tie
    their corners together with a cotangent of at most about 1000 instead of infinity. Edges with
    more than two polygons add up; polygons of the same vertices count once. A vertex without area
    has the mass of a millionth of an average vertex.

    Args:
        mesh: Polygons of any size; see `triangulate` for how they are split.

    Raises:
        MeshError: The mesh has no polygon with an area.
    """
    from scipy.sparse import coo_array, csc_array
    from scipy.sparse.csgraph import connected_components

    split = triangulate(mesh)
    count = len(mesh.vertices)
    corners = mesh.vertices[split.triangles]
    # Over the diameter, so that squares of tiny or huge lengths neither vanish nor overflow.
    scale = mesh.diameter or 1.0
    sides = (np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)) / scale
    doubled = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    areas = 0.5 * doubled * split.shares
    area = float(areas.sum())
    if not area > 0:
        raise MeshError(
            f"{mesh.name} has no surface: none of its {len(mesh.faces):,} polygons has an area"
        )
    mass = np.bincount(split.triangles.ravel(), np.repeat(areas / 3, 3), minlength=count) / area
    mass = np.maximum(mass, _LEAST_MASS / count)

    cotangents = _cotangents(np.linalg.norm(sides, axis=2))
    start = np.roll(split.triangles, -1, axis=1).ravel()
    end = np.roll(split.triangles, -2, axis=1).ravel()
    weights = (0.5 * split.shares[:, None] * cotangents).ravel()
    joined = csc_array(coo_array((weights, (start, end)), shape=(count, count)))
    joined = csc_array(joined + joined.T)
    pieces, piece_of = connected_components(
        csc_array((np.ones_like(joined.data), joined.indices, joined.indptr), shape=joined.shape),
        directed=False,
    )
    joined.data[np.abs(joined.data) < _NO_WEIGHT] = 0.0
    joined.eliminate_zeros()
    diagonal: NDArray[np.float64] = np.asarray(joined.sum(axis=0)).ravel()
    here = np.arange(count, dtype=np.int32)
    stiffness = csc_array(csc_array((diagonal, (here, here)), shape=joined.shape) - joined)
    for array in (mass, piece_of):
        array.flags.writeable = False
    return SurfaceOperators(
        triangles=split.triangles,
        shares=split.shares,
        stiffness=stiffness,
        mass=mass,
        component_of=piece_of,
        component_count=int(pieces),
        area=area * scale**2,
    )


def _cotangents(lengths: NDArray[np.float64]) -> NDArray[np.float64]:
    """(T, 3) cotangents of the angles opposite the sides of (T, 3) lengths."""
    longest = lengths.max(axis=1)
    slack = lengths.sum(axis=1) - 2 * longest
    # A triangle that is one point has no longest side; as an equilateral one it does no harm.
    wanted = np.where(longest > 0, _SLACK * longest, 1.0)
    lengths = lengths + np.maximum(wanted - slack, 0.0)[:, None]
    half = 0.5 * lengths.sum(axis=1)
    area = np.sqrt(half * (half[:, None] - lengths).prod(axis=1))
    squares = lengths**2
    doubled = squares.sum(axis=1, keepdims=True) - 2 * squares
    return np.asarray(doubled / (4 * area[:, None]), dtype=np.float64)
