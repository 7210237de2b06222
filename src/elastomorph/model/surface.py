"""A polygon mesh as a surface: its triangles, cotangent Laplacian and lumped mass.

Polygons are split in a way that no numbering can change.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import MeshError
from elastomorph.model.geometry import component_of
from elastomorph.model.mesh import Mesh

if TYPE_CHECKING:
    from scipy.sparse import csc_array

# Splits this close in length are equally good; rounding must not choose between them.
_TIE = 1e-6


def triangulate(mesh: Mesh) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """Split every polygon into the fan with the shortest diagonals: (T, 3) corners, (T,) shares.

    A quad is split along its shorter diagonal. Where several fans are equally short (a rectangle),
    all of them count in equal shares, below 1, so the result does not depend on the order or
    rotation of the corners. Polygons of the same vertices count once, and triangles that name a
    vertex twice are left out.
    """
    triangles = [np.zeros((0, 3), np.int32)]
    shares = [np.zeros(0)]
    sizes = mesh.faces.sizes
    for size in np.unique(sizes):
        starts = mesh.faces.offsets[:-1][sizes == size]
        polygons = _without_duplicates(mesh.faces.indices[starts[:, None] + np.arange(size)])
        cost = _fan_costs(mesh.vertices[polygons])
        best = cost <= cost.min(axis=1, keepdims=True) * (1 + _TIE)
        polygon, apex = np.nonzero(best)
        corners = (apex[:, None] + np.arange(size)) % size
        turned = np.take_along_axis(polygons[polygon], corners, axis=1)
        fans = np.stack(
            [np.repeat(turned[:, :1], size - 2, axis=1), turned[:, 1:-1], turned[:, 2:]], axis=2
        )
        triangles.append(fans.reshape(-1, 3))
        shares.append(np.repeat(1.0 / best.sum(axis=1)[polygon], size - 2))
    all_triangles, all_shares = np.concatenate(triangles), np.concatenate(shares)
    a, b, c = all_triangles.T
    real = (a != b) & (b != c) & (c != a)
    return all_triangles[real], all_shares[real]


def winding_number(point: NDArray[np.float64], triangles: NDArray[np.float64]) -> float:
    """How often (T, 3, 3) triangles wind around a (3,) point: 0 outside, 1 inside, or -1.

    Between them where the surface is open: the part of all directions in which it lies (Jacobson,
    Kavan and Sorkine-Hornung, SIGGRAPH 2013), a sum of solid angles (Van Oosterom and Strackee,
    IEEE Trans. Biomed. Eng. 30(2), 1983).
    """
    a, b, c = (triangles - point).transpose(1, 0, 2)
    x, y, z = (np.sqrt(np.einsum("ti,ti->t", side, side)) for side in (a, b, c))
    volume = np.einsum("ti,ti->t", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("ti,ti->t", one, two) for one, two in ((a, b), (b, c), (c, a)))
    return float(np.arctan2(volume, x * y * z + ab * z + bc * x + ca * y).sum() / (2.0 * np.pi))


def closest_weights(
    points: NDArray[np.float64], corners: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(N, 3) weights of the corners (N, 3, 3) of triangles at the points closest to (N, 3) points.

    The nearest point of the plane where that is inside, else of the edge or corner whose region
    the point is in (Ericson, Real-Time Collision Detection, 5.1.5).
    """
    a, b, c = np.moveaxis(corners, 1, 0)
    weights = np.full((len(points), 3), np.nan)
    far = np.full(len(points), np.inf)
    for start, stop, first, second in ((a, b, 0, 1), (b, c, 1, 2), (c, a, 2, 0)):
        edge = stop - start
        length = np.einsum("ij,ij->i", edge, edge)
        along = np.einsum("ij,ij->i", points - start, edge) / np.maximum(length, 1e-300)
        along = np.clip(along, 0, 1)
        off = start + along[:, None] * edge - points
        distance = np.einsum("ij,ij->i", off, off)
        nearer = distance < far
        far[nearer] = distance[nearer]
        weights[nearer] = 0
        weights[nearer, first] = 1 - along[nearer]
        weights[nearer, second] = along[nearer]
    normal = np.cross(b - a, c - a)
    area = np.einsum("ij,ij->i", normal, normal)
    area = np.where(area > 0, area, np.inf)
    v = np.einsum("ij,ij->i", np.cross(points - a, c - a), normal) / area
    w = np.einsum("ij,ij->i", np.cross(b - a, points - a), normal) / area
    inside = (v > 0) & (w > 0) & (v + w < 1)
    weights[inside] = np.stack([1 - v - w, v, w], axis=-1)[inside]
    return weights


def _without_duplicates(polygons: NDArray[np.int32]) -> NDArray[np.int32]:
    """The rows of (F, n) vertex indices, each set of vertices once, the first of them kept."""
    ordered = np.sort(polygons, axis=1)
    order = np.lexsort(ordered.T)
    repeated = (ordered[order[1:]] == ordered[order[:-1]]).all(axis=1)
    keep = np.ones(len(polygons), dtype=bool)
    keep[order[1:][repeated]] = False
    return polygons[keep]


def _fan_costs(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """(F, A) summed squared length of the diagonals from each apex of (F, n, 3) polygons.

    Opposite corners of a quad give the same split, so only two are apexes; of a triangle, one.
    """
    size = int(corners.shape[1])
    apexes: int = {3: 1, 4: 2}.get(size, size)
    costs = np.zeros((len(corners), apexes))
    for apex in range(apexes):
        others = (apex + np.arange(2, size - 1)) % size
        diagonals = corners[:, others] - corners[:, apex, None]
        costs[:, apex] = np.einsum("fdi,fdi->f", diagonals, diagonals)
    return costs


# A triangle is taken at least this far, in parts of its longest side, from being flat: no
# cotangent is larger than about the inverse.
_SLACK = 1e-3
# A vertex without area weighs this part of an average vertex.
_LEAST_MASS = 1e-6
# Weights below this are right angles up to rounding; without them the matrices are sparser.
_NO_WEIGHT = 1e-12


@dataclass(frozen=True, eq=False)
class SurfaceOperators:
    """The discrete Laplacian of a surface: -Δv ≈ M⁻¹ L v, in units in which the area is 1."""

    triangles: NDArray[np.int32]  # (T, 3) int32, the polygons split for the operator only
    # (T,) float64 in (0, 1], how much of each triangle counts, see `triangulate`.
    shares: NDArray[np.float64]
    # (V, V) L, symmetric, positive semi-definite, its rows sum to 0; its kernel are the functions
    # that are constant on each component. Free of scale.
    laplacian: csc_array
    # (V,) the diagonal of M, a third of the area around each vertex over the whole area: above 0,
    # sums to 1 but for vertices without area.
    mass: NDArray[np.float64]
    # (V,) int32 connected piece of each vertex, joined by triangles; a vertex on no triangle is a
    # piece of its own.
    component_of: NDArray[np.int32]
    area: float  # Of the surface, in the unit of the vertices squared


def surface_operators(mesh: Mesh) -> SurfaceOperators:
    """The cotangent Laplacian of a mesh, robust to whatever artists leave behind.

    L_ij = -½ Σ cot α over the triangles at edge ij (α opposite the edge). Cotangents may be
    negative; each triangle's part is that of a real triangle, so L stays positive semi-definite.
    Triangles flatter than 0.1 % of their longest side have all three sides lengthened by what is
    missing (as in intrinsic mollification, Sharp and Crane 2020), so that degenerate triangles tie
    their corners together with a cotangent of at most about 1000 instead of infinity. Edges with
    more than two polygons add up; polygons of the same vertices count once. A vertex without area
    has the mass of a millionth of an average vertex.
    """
    triangles, shares = triangulate(mesh)
    count = len(mesh.vertices)
    corners = mesh.vertices[triangles]
    # Over the diameter, so that squares of tiny or huge lengths neither vanish nor overflow.
    scale = mesh.diameter or 1.0
    sides = (np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)) / scale
    doubled = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    areas = 0.5 * doubled * shares
    area = float(areas.sum())
    if not area > 0:
        raise MeshError(
            f"{mesh.name} has no surface: none of its {len(mesh.faces):,} polygons has an area"
        )
    mass = np.bincount(triangles.ravel(), np.repeat(areas / 3, 3), minlength=count) / area
    mass = np.maximum(mass, _LEAST_MASS / count)

    start = np.roll(triangles, -1, axis=1).ravel()
    end = np.roll(triangles, -2, axis=1).ravel()
    cotangents = _cotangents(np.linalg.norm(sides, axis=2))
    weights = (0.5 * shares[:, None] * cotangents).ravel()
    piece_of = component_of(count, np.stack([start, end], axis=1))
    for array in (mass, piece_of):
        array.flags.writeable = False
    laplacian = _laplacian(start, end, weights, count)
    return SurfaceOperators(triangles, shares, laplacian, mass, piece_of, area * scale**2)


def _laplacian(
    start: NDArray[np.int32], end: NDArray[np.int32], weights: NDArray[np.float64], count: int
) -> csc_array:
    """(V, V) with minus the weights, where vertices are joined, and rows that sum to 0."""
    from scipy.sparse import coo_array, csc_array

    joined = csc_array(coo_array((weights, (start, end)), shape=(count, count)))
    joined = csc_array(joined + joined.T)
    joined.data[np.abs(joined.data) < _NO_WEIGHT] = 0.0
    joined.eliminate_zeros()
    diagonal: NDArray[np.float64] = np.asarray(joined.sum(axis=0)).ravel()
    here = np.arange(count, dtype=np.int32)
    return csc_array(csc_array((diagonal, (here, here)), shape=joined.shape) - joined)


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
