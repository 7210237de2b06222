"""Polygons split into triangles for operators, in a way that no numbering can change."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.mesh import Mesh

__all__ = ["Triangulation", "triangulate"]

# Splits this close in length are equally good; rounding must not choose between them.
_TIE = 1e-6


@dataclass(frozen=True, eq=False)
class Triangulation:
    """Triangles that stand for the polygons of a mesh.

    Attributes:
        triangles: (T, 3) int32 vertex indices, wound as the polygons are.
        shares: (T,) float64 in (0, 1], how much of each triangle counts: below 1 where several
            splits of a polygon are equally good and each stands for its part.
    """

    triangles: NDArray[np.int32]
    shares: NDArray[np.float64]


def triangulate(mesh: Mesh) -> Triangulation:
    """Split every polygon into the fan with the shortest diagonals.

    A quad is split along its shorter diagonal. Where several fans are equally short (a rectangle),
    all of them count in equal shares, so the result does not depend on the order or rotation of
    the corners. Polygons of the same vertices count once, and triangles that name a vertex twice
    are left out.

    Args:
        mesh: Polygons of any size.
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
    return Triangulation(all_triangles[real], all_shares[real])


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
