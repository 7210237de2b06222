"""``deformation-gradients``: rotation and stretch of every triangle interpolated, then one solve.

After Roh, Kim, Jang, Seol and Kim, *Interactive Facial Expression Editing with Non-linear
Blendshape Interpolation* (Eurographics 2022), the paper's [15], who interpolate the deformation
gradients of blendshapes; the gradients and the solve are those of Sumner and Popović, *Deformation
Transfer for Triangle Meshes* (ACM Trans. Graph. 23, 2004). The affine map of a triangle with its
normal is F = R S, a rotation and a symmetric stretch. On the way

    F(t) = exp(t log R) (I + t (S - I)),        x(t) = argmin Σ_T area_T ‖∇x - F_T(t)‖²

The normal equations are Poisson's with the cotangent Laplacian of the neutral, factored once.

Ours, where the sources leave it open: a polygon counts as all its shortest fans of triangles
(`triangulate`), one without area not at all; vertices that both ends have at the same place stay
there; where a connected part has none, its centre (mean of vertices) moves straight.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork
from elastomorph.model.cholesky import symmetric_factor
from elastomorph.model.geometry import component_of, sides_of
from elastomorph.model.sequence import MeshSequence
from elastomorph.model.surface import triangulate
from elastomorph.rivals.rival import Faces, Rival, straight

# Triangles whose area is below this part of D² have no direction that could turn.
_FLAT = 1e-14


@dataclass(frozen=True)
class DeformationGradients(Rival):
    """Rotation and stretch of every triangle interpolated, then a Poisson solve."""

    name = "deformation-gradients"
    source = "Roh and others 2022, [15]; Sumner and Popović 2004"
    on_surfaces = True

    def faces(
        self, recording: MeshSequence, curves: CurveNetwork, times: NDArray[np.float64]
    ) -> Faces:
        """The face at each time."""
        from scipy.spatial.transform import Rotation

        start, end = recording.frames
        triangles, shares = triangulate(recording.mesh)
        real = _doubled_areas(start[triangles]) > _FLAT * recording.mesh.diameter**2
        triangles, shares = triangles[real], shares[real]
        turns, stretches = polar(_frames(end[triangles]) @ np.linalg.inv(_frames(start[triangles])))
        logs = Rotation.from_matrix(turns).as_rotvec()
        poisson = _Poisson.of(recording, triangles, shares)
        for time in times:
            part = np.eye(3) + time * (stretches - np.eye(3))
            gradients = Rotation.from_rotvec(time * logs).as_matrix() @ part
            yield poisson.solved(gradients, straight(recording, float(time)))


@dataclass(frozen=True, eq=False)
class _Poisson:
    """What finds the vertices whose gradients come nearest to wanted ones."""

    triangles: NDArray[np.int32]  # (T, 3)
    slopes: NDArray[np.float64]  # (T, 3, 3) of each corner's hat function, times the area
    laplacian: Any  # (V, V) of the neutral, sparse
    held: NDArray[np.bool_]  # (V,) vertices that stay; of a part without any, one that is moved on
    part_of: NDArray[np.int32]  # (V,)
    floating: NDArray[np.bool_]  # (P,) whether nothing of a part stays
    factor: Any

    @classmethod
    def of(
        cls,
        recording: MeshSequence,
        triangles: NDArray[np.int32],
        shares: NDArray[np.float64],
    ) -> _Poisson:
        """Factor the Laplacian of the first frame."""
        from scipy.sparse import coo_array, csc_array

        start, end = recording.frames
        count = len(start)
        slopes, areas = _slopes(start[triangles])
        weights = np.einsum("t,tix,tjx->tij", shares * areas, slopes, slopes)
        rows = np.broadcast_to(triangles[:, :, None], weights.shape).ravel()
        columns = np.broadcast_to(triangles[:, None, :], weights.shape).ravel()
        laplacian = csc_array(coo_array((weights.ravel(), (rows, columns)), shape=(count, count)))
        part_of = component_of(count, sides_of(triangles))
        held = (start == end).all(axis=1)
        floating = np.bincount(part_of, held) == 0
        held[np.unique(part_of, return_index=True)[1][floating]] = True
        free = csc_array(laplacian[~held][:, ~held])
        factor = symmetric_factor(free) if free.shape[0] else None
        scaled = (shares * areas)[:, None, None] * slopes
        return cls(triangles, scaled, laplacian, held, part_of, floating, factor)

    def solved(
        self, gradients: NDArray[np.float64], placed: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """(V, 3) the vertices of (T, 3, 3) gradients; floating parts have the centres of others."""
        found = placed.copy()
        if self.factor is None:
            return found
        pulls = np.einsum("txy,tiy->tix", gradients, self.slopes)
        wanted = np.stack(
            [
                np.bincount(self.triangles.ravel(), axis.ravel(), minlength=len(placed))
                for axis in np.moveaxis(pulls, 2, 0)
            ],
            axis=1,
        )
        free = ~self.held
        known = self.laplacian[free][:, self.held] @ placed[self.held]
        found[free] = self.factor.solve(np.ascontiguousarray(wanted[free] - known))
        off = part_means(placed - found, self.part_of)
        off[~self.floating] = 0.0
        return found + off[self.part_of]


def part_means(vectors: NDArray[np.float64], part_of: NDArray[np.int32]) -> NDArray[np.float64]:
    """(P, 3) means of (V, 3) vectors over the parts of a mesh."""
    sums = [np.bincount(part_of, axis) for axis in vectors.T]
    return np.stack(sums, axis=1) / np.bincount(part_of)[:, None]


def _doubled_areas(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    sides = corners[:, 1:] - corners[:, :1]
    return np.asarray(np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1))


def _frames(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """(T, 3, 3) two sides and the normal of (T, 3, 3) triangles, as columns.

    The normal has the length of a side, so that it stretches as the triangle does.
    """
    sides = corners[:, 1:] - corners[:, :1]
    normal = np.cross(sides[:, 0], sides[:, 1])
    size = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = np.divide(normal, np.sqrt(size), out=np.zeros_like(normal), where=size > 0)
    return np.stack([sides[:, 0], sides[:, 1], normal], axis=2)


def _slopes(corners: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(T, 3, 3) gradient of the hat function of each corner, and (T,) areas."""
    opposite = np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)
    normal = np.cross(opposite[:, 0], opposite[:, 1])
    doubled = np.linalg.norm(normal, axis=1)
    slopes = np.cross(normal[:, None], opposite) / (doubled**2)[:, None, None]
    return slopes, 0.5 * doubled


def polar(
    matrices: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(N, 3, 3) F = R S: the nearest rotations R and the symmetric S that are left of them."""
    left, sizes, right = np.linalg.svd(matrices)
    mirrored = np.linalg.det(left) * np.linalg.det(right) < 0
    sizes[mirrored, -1] *= -1.0
    left[mirrored, :, -1] *= -1.0
    turns = left @ right
    return turns, np.einsum("nki,nk,nkj->nij", right, sizes, right)
