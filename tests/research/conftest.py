"""Small faces whose curves move by a known material and load."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import elastomorph as em
from elastomorph.curves import CurveNetwork
from small_meshes import small_network

Synthesis = Callable[..., list[em.MeshSequence]]


@pytest.fixture(scope="session")
def network() -> CurveNetwork:
    """Curves that are open and closed, over 29 vertices of 30."""
    return small_network()


@pytest.fixture(scope="session")
def synthesis(network: CurveNetwork) -> Synthesis:
    """Motions that obey one method, with other shapes and times each, and noise between ends."""

    def motions(
        method: em.Method, *, count: int = 3, frames: int = 12, noise: float = 0.0, seed: int = 1
    ) -> list[em.MeshSequence]:
        random = np.random.default_rng(seed)
        found = []
        for _ in range(count):
            neutral = em.Mesh(random.normal(size=(network.vertex_count, 3)))
            target = neutral.with_vertices(
                neutral.vertices + 0.5 * random.normal(size=neutral.vertices.shape)
            )
            times = np.sort(np.concatenate([[0.0, 1.0], random.uniform(0.02, 0.98, frames - 2)]))
            path = em.interpolate(neutral, target, method, curves=network).at(times)
            path[1:-1] += noise * random.normal(size=path[1:-1].shape)
            found.append(em.MeshSequence(neutral, path, times))
        return found

    return motions
