"""A small rig of curved paths."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import elastomorph as em
from elastomorph.rig import Rig
from small_head import expressions, head


@pytest.fixture(scope="session")
def rig() -> Rig:
    """The small head with the paper's five expressions as quadratic beams."""
    to = em.prepare(head(), "beam:2", closure="rest")
    return Rig(head(), {name: to(mesh) for name, mesh in expressions().items()})


@pytest.fixture(scope="session")
def small() -> Rig:
    """Ten vertices, three morphs of which one moves two vertices only, random bends."""
    random = np.random.default_rng(5)
    neutral = em.Mesh(random.normal(size=(10, 3)))
    morphs = {}
    for name, moved in (("a", np.arange(10)), ("b", np.array([2, 7])), ("c", np.arange(4, 9))):
        delta, bends = np.zeros((10, 3)), np.zeros((2, 10, 3))
        delta[moved] = random.normal(size=(len(moved), 3))
        bends[:, moved] = random.normal(size=(2, len(moved), 3))
        target = neutral.with_vertices(neutral.vertices + delta)
        curves = (em.BendCurve.power(2), em.BendCurve.power(3))
        morphs[name] = em.Morph(neutral, target, bends, curves)
    return Rig(neutral, morphs)


@pytest.fixture(scope="session")
def many() -> Callable[[int, float, float], Rig]:
    """Makes rigs of thirty vertices: how many morphs, how far they go, how far they bend."""

    def made(count: int, far: float, bent: float) -> Rig:
        random = np.random.default_rng(11)
        neutral = em.Mesh(random.normal(size=(30, 3)))
        morphs = {}
        for number in range(count):
            delta, bend = far * random.normal(size=(30, 3)), bent * random.normal(size=(1, 30, 3))
            target = neutral.with_vertices(neutral.vertices + delta)
            morphs[f"m{number}"] = em.Morph(neutral, target, bend, (em.BendCurve.power(2),))
        return Rig(neutral, morphs)

    return made
