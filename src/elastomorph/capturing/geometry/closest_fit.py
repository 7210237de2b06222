"""What draws a surface to points in space: robust closest points, and places that are known."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.surface import Surface

Points = NDArray[np.float64]


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
