"""A small patch of skin with its curves, and motions made of it."""

from __future__ import annotations

import numpy as np
import pytest

from elastomorph.curves import Curve, CurveNetwork
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from small_meshes import small_network

ROWS, COLUMNS = 4, 5


@pytest.fixture(scope="session")
def network() -> CurveNetwork:
    """Curves that are open and closed, over 29 vertices of 30."""
    return small_network()


@pytest.fixture(scope="session")
def neutral() -> Mesh:
    """A vaulted patch of 3 by 4 quads."""
    y, x = np.mgrid[0.0:ROWS, 0.0:COLUMNS]
    z = 0.3 * np.sin(x) + 0.2 * np.cos(y)
    vertices = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    corners = [
        [r * COLUMNS + c, r * COLUMNS + c + 1, (r + 1) * COLUMNS + c + 1, (r + 1) * COLUMNS + c]
        for r in range(ROWS - 1)
        for c in range(COLUMNS - 1)
    ]
    return Mesh(vertices, corners)


@pytest.fixture(scope="session")
def target(neutral: Mesh) -> Mesh:
    """The patch pulled and shaken."""
    x, y, _ = neutral.vertices.T
    pull = np.stack([0.3 * np.sin(y), 0.2 * x, 0.5 * np.cos(x * y)], axis=1)
    return neutral.with_vertices(neutral.vertices + pull)


@pytest.fixture(scope="session")
def rows(neutral: Mesh) -> CurveNetwork:
    """One open curve along each row of vertices."""
    count = len(neutral.vertices)
    indices = np.arange(count).reshape(ROWS, COLUMNS)
    return CurveNetwork([Curve(row, name=f"row {i}") for i, row in enumerate(indices)], count)


@pytest.fixture(scope="session")
def curved(neutral: Mesh, target: Mesh) -> Morph:
    """A path with two bends of its own."""
    bends = np.random.default_rng(0).normal(size=(2, *neutral.vertices.shape))
    laws = (BendCurve.power(2), BendCurve.power(3))
    return Morph(neutral, target, bends, laws, method="curved")
