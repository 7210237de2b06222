"""A sphere to draw, and a small evaluation."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import ball

from elastomorph.curves import Curve, CurveNetwork
from elastomorph.evaluation import Evaluation, evaluate
from elastomorph.mesh import Mesh
from elastomorph.sequence import MeshSequence


@pytest.fixture(scope="session")
def sphere() -> Mesh:
    """The unit sphere."""
    return ball(rings=24, meridians=48)


@pytest.fixture(scope="session")
def rings() -> CurveNetwork:
    """The parallels of a small ball as closed curves, its poles as curves of one vertex."""
    curves = [Curve(np.arange(24) + 24 * ring, True) for ring in range(11)]
    return CurveNetwork([*curves, Curve([264]), Curve([265])], 266)


@pytest.fixture(scope="session")
def evaluation(rings: CurveNetwork) -> Evaluation:
    """A ball that grows and moves aside, compared with a few methods."""
    mesh = ball()
    times = np.linspace(0.0, 1.0, 5)
    push = np.array([0.6, 0.0, 0.2]) + 0.3 * mesh.vertices * (1 + mesh.vertices[:, :1])
    frames = [mesh.vertices + time**1.5 * push for time in times]
    methods = ["linear", "ease:2", "beam:1", "beam:2", "beam:2:unforced"]
    return evaluate(MeshSequence(mesh, np.stack(frames), times), methods, rings)
