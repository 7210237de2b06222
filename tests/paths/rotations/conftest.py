"""Small surfaces and random motions for the tests of rotations."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import elastomorph as em


def _curved_sheet(rows: int, columns: int) -> em.Mesh:
    x, y = np.meshgrid(np.arange(columns + 1.0), np.arange(rows + 1.0))
    z = 0.3 * np.sin(x) + 0.2 * np.cos(1.3 * y)
    corner = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    quads = np.stack([corner, corner + 1, corner + columns + 2, corner + columns + 1], axis=1)
    return em.Mesh(np.stack([x, y, z], axis=-1).reshape(-1, 3), quads)


@pytest.fixture(scope="session")
def sheet() -> Callable[[int, int], em.Mesh]:
    """A curved sheet of quads, (rows + 1)·(columns + 1) vertices."""
    return _curved_sheet


@pytest.fixture
def rigid() -> Callable[..., NDArray[np.float64]]:
    """Points after a turn by a rotation vector about a centre and a shift, by scipy."""

    def move(
        points: NDArray[np.float64],
        vector: NDArray[np.float64],
        centre: NDArray[np.float64],
        shift: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        return Rotation.from_rotvec(vector).apply(points - centre) + centre + shift

    return move
