"""Rigid motion, fitted and played."""

from __future__ import annotations

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from elastomorph.model.geometry import fit_rigid

POINTS = np.random.default_rng(3).normal(size=(20, 3))
components = st.floats(-3, 3)


@given(st.tuples(components, components, components), st.tuples(components, components, components))
@example((0.0, 0.0, 1e-9), (0.0, 0.0, 2.0))
def test_a_rigid_motion_is_found_and_ends_where_it_should(
    turn: tuple[float, ...], shift: tuple[float, ...]
) -> None:
    end = Rotation.from_rotvec(turn).apply(POINTS) + shift
    screw, residual = fit_rigid(POINTS, end)
    assert residual.max() < 1e-7
    np.testing.assert_allclose(screw.at(0.0, POINTS), POINTS, atol=1e-9)
    halfway = screw.at(0.5, POINTS)
    distances = np.linalg.norm(halfway[:, None] - halfway[None], axis=2)
    np.testing.assert_allclose(
        distances, np.linalg.norm(POINTS[:, None] - POINTS[None], axis=2), atol=1e-9
    )
    np.testing.assert_allclose(screw.at(0.5, halfway), end, atol=1e-6)


def test_a_quarter_turn_about_a_known_axis() -> None:
    """About (1, 2, ·) along +z with a slide of 3: (2, 2, 0) goes through 45° to (1, 3, 3)."""
    points = np.array([[2.0, 2, 0], [1, 2, 0], [0, 0, 0], [1, 2, 5]])
    turn = Rotation.from_rotvec([0, 0, np.pi / 2])
    screw, _ = fit_rigid(points, turn.apply(points - [1, 2, 0]) + [1, 2, 3])
    np.testing.assert_allclose(screw.axis, [0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(screw.centre[:2], [1, 2], atol=1e-12)
    np.testing.assert_allclose(screw.slide, 3)
    root = np.sqrt(0.5)
    np.testing.assert_allclose(screw.at(0.5, points[:1]), [[1 + root, 2 + root, 1.5]])


def test_half_a_turn_and_no_turn() -> None:
    for turn in ([0, np.pi, 0], [0, 0, 0]):
        end = Rotation.from_rotvec(turn).apply(POINTS) + [1.0, 0, 0]
        screw, residual = fit_rigid(POINTS, end)
        assert residual.max() < 1e-9
        assert np.isfinite(screw.at(0.3, POINTS)).all()


def test_a_mirror_image_is_no_rigid_motion() -> None:
    _, residual = fit_rigid(POINTS, POINTS * [-1.0, 1, 1])
    assert residual.max() > 0.5
