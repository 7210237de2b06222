"""Meshes and turns that the tests of turning paths share."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation


def rigid(points: NDArray[np.float64], vector: NDArray[np.float64]) -> NDArray[np.float64]:
    """Turned about an axis that does not pass through the origin."""
    centre = np.array([2.0, -1.0, 0.5])
    return np.asarray(Rotation.from_rotvec(vector).apply(points - centre) + centre)


def random_triangles(rng: np.random.Generator, count: int) -> NDArray[np.int64]:
    """(count, 3) of twelve vertices, no vertex twice in a triangle."""
    return rng.permuted(np.tile(np.arange(12), (count, 1)), axis=1)[:, :3]
