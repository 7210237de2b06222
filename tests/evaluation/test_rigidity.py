"""Rigid bodies along paths."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import elastomorph as em
from elastomorph.evaluation.rigidity import rigidity

POINTS = np.random.default_rng(0).normal(size=(12, 3))
NEUTRAL = em.Mesh(POINTS)
ANGLE = 0.5
TURNED = NEUTRAL.with_vertices(Rotation.from_rotvec([0, 0, ANGLE]).apply(POINTS))
TIMES = (0.25, 0.5, 0.75)


def test_a_true_turn_stays_rigid() -> None:
    path = em.bake(
        lambda t: Rotation.from_rotvec([0, 0, t * ANGLE]).apply(POINTS),
        NEUTRAL,
        TURNED,
        tolerance=1e-10,
    )
    found = rigidity(path, np.arange(12), TIMES)
    assert found.change < 1e-9
    assert found.off_screw < 1e-7


def test_the_straight_path_shrinks_the_body_by_the_cosine() -> None:
    """Halfway every radius is cos(θ/2) of its own, and so is every distance across the axis."""
    flat = em.Mesh(POINTS * [1, 1, 0])
    turned = flat.with_vertices(Rotation.from_rotvec([0, 0, ANGLE]).apply(POINTS * [1, 1, 0]))
    found = rigidity(em.interpolate(flat, turned, "linear"), np.arange(12), [0.5])
    assert found.change == pytest.approx(1 - np.cos(ANGLE / 2), rel=1e-9)
    radius = np.linalg.norm(flat.vertices, axis=1).max()
    assert found.off_screw == pytest.approx(
        radius * (1 - np.cos(ANGLE / 2)) / flat.diameter, rel=1e-3
    )


def test_what_is_no_rigid_body_is_told_by_its_ends() -> None:
    stretched = NEUTRAL.with_vertices(POINTS * [1, 2, 1])
    path = em.interpolate(NEUTRAL, stretched, "linear")
    assert rigidity(path, np.arange(12), TIMES).ends > 0.05
    turned = em.interpolate(NEUTRAL, TURNED, "linear")
    assert rigidity(turned, np.arange(12), TIMES).ends < 1e-12


def test_bodies_must_exist() -> None:
    path = em.interpolate(NEUTRAL, TURNED, "linear")
    with pytest.raises(em.ParameterError, match="at least 4"):
        rigidity(path, [1, 2, 3], TIMES)
    with pytest.raises(em.CurveError, match="99"):
        rigidity(path, [1, 2, 3, 99], TIMES)
