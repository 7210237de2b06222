"""Small surfaces whose motion is known."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import elastomorph as em


def plate_of(count: int) -> em.Mesh:
    """A curved sheet of (count - 1)² quads."""
    along = np.linspace(-1.0, 1.0, count)
    x, y = np.meshgrid(along, along, indexing="ij")
    vertices = np.stack([x, y, 0.3 * x * y + 0.2 * x**2], axis=2).reshape(-1, 3)
    corner = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).ravel()
    quads = corner[:, None] + np.array([0, count, count + 1, 1])
    return em.Mesh(vertices, quads.tolist())


def turn(axis: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    """(3, 3) the rotation about an axis."""
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)).as_matrix())


def between(neutral: em.Mesh, end: NDArray[np.float64]) -> em.MeshSequence:
    """A recording of two frames."""
    return em.MeshSequence(neutral, [neutral.vertices, end])
