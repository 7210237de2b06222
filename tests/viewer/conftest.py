"""The smallest rig, and a page to put it in."""

from __future__ import annotations

import numpy as np
import pytest
from pages import STAND_IN

import elastomorph as em
from elastomorph.evaluation import Evaluation
from elastomorph.rig import Rig


@pytest.fixture
def stand_in(monkeypatch: pytest.MonkeyPatch) -> str:
    """A page of a few lines in place of the shipped one."""
    monkeypatch.setattr("elastomorph.viewer.page.shipped_page", lambda: STAND_IN)
    return STAND_IN


@pytest.fixture(scope="session")
def tetrahedron() -> em.Mesh:
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    return em.Mesh(vertices, [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


@pytest.fixture(scope="session")
def curved(tetrahedron: em.Mesh) -> em.Morph:
    """The tip goes up by 1 and, half way, aside by a quarter."""
    up, aside = np.zeros((4, 3)), np.zeros((1, 4, 3))
    up[3, 2], aside[0, 3, 0] = 1.0, -1.0
    target = tetrahedron.with_vertices(tetrahedron.vertices + up)
    return em.Morph(tetrahedron, target, aside, (em.BendCurve.power(2),), method="by hand")


@pytest.fixture(scope="session")
def straight(curved: em.Morph) -> em.Morph:
    return em.interpolate(curved.neutral, curved.target, "linear")


@pytest.fixture(scope="session")
def rig(tetrahedron: em.Mesh, curved: em.Morph, straight: em.Morph) -> Rig:
    return Rig(tetrahedron, {"up": curved, "plain": straight}, groups={"tip": ["up", "plain"]})


@pytest.fixture(scope="session")
def evaluation(curved: em.Morph) -> Evaluation:
    """A tip on an arc, filmed at uneven times."""
    times = np.array([0.0, 0.1, 0.4, 0.7, 1.0])
    motion = em.MeshSequence(curved.neutral, curved.at(times), times)
    return em.evaluate(motion, ["linear", "ease:2", "beam:2"])
