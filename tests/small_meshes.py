"""Meshes small enough to see what becomes of each vertex."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import Curve, CurveNetwork
from elastomorph.model.mesh import Mesh
from elastomorph.model.polygons import Polygons

__all__ = ["cut_open", "grid", "meeting", "small_network"]


def grid(
    columns: int,
    rows: int,
    height: Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]] | None = None,
) -> Mesh:
    """Quads between columns × rows vertices at whole x and y, numbered row by row.

    They lie at z = 0, or at a height that depends on x and y.
    """
    y, x = (axis.ravel() for axis in np.mgrid[0.0:rows, 0.0:columns])
    corner = np.arange(rows * columns).reshape(rows, columns)[:-1, :-1].reshape(-1, 1)
    z = 0.0 * x if height is None else height(x, y)
    return Mesh(np.stack([x, y, z], axis=1), corner + [0, 1, columns + 1, columns])


def cut_open(mesh: Mesh, far: np.ndarray) -> tuple[Mesh, np.ndarray]:
    """A mesh whose (F,) bool far polygons have vertices of their own where they meet the others.

    And (W,) the vertex of the whole mesh that each of its vertices is.
    """
    faces, corner_far = mesh.faces, far[mesh.faces.corner_faces]
    shared = np.intersect1d(faces.indices[corner_far], faces.indices[~corner_far])
    copies = np.arange(len(mesh.vertices))
    copies[shared] = len(copies) + np.arange(len(shared))
    indices = np.where(corner_far, copies[faces.indices], faces.indices)
    origin = np.concatenate([np.arange(len(copies)), shared])
    return Mesh(mesh.vertices[origin], Polygons(indices, faces.offsets)), origin


def meeting(neutral: Mesh) -> dict[str, Mesh]:
    """A target that turns a mesh about x, and one that takes most of it back."""
    x, y, z = neutral.vertices.T
    turned = np.stack([x, y * np.cos(1) - z * np.sin(1), y * np.sin(1) + z * np.cos(1)], axis=1)
    back = neutral.vertices - 0.9 * (turned - neutral.vertices)
    return {"jawOpen": neutral.with_vertices(turned), "mouthClose": neutral.with_vertices(back)}


def small_network() -> CurveNetwork:
    """Two closed and three open curves over 29 vertices, and one vertex on none."""
    sizes = ((8, True), (5, True), (7, False), (6, False), (3, False))
    starts = np.cumsum([0] + [size for size, _ in sizes])
    return CurveNetwork(
        [
            Curve(np.arange(start, start + size), closed, f"curve {number}")
            for number, (start, (size, closed)) in enumerate(zip(starts, sizes, strict=False))
        ],
        int(starts[-1]) + 1,
    )
