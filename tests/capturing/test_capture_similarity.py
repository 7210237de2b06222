"""Similarities recover what moved the points, and doubt what did not."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from elastomorph.capturing.geometry import (
    Similarity,
    agreeing,
    fit_similarity,
    robust_rigid,
)
from elastomorph.errors import CaptureError


def any_similarity(seed: int) -> Similarity:
    random = np.random.default_rng(seed)
    turned = Rotation.random(random_state=seed).as_matrix()
    return Similarity(float(random.uniform(0.1, 10)), turned, random.normal(size=3) * 5)


@given(seed=st.integers(0, 10_000))
def test_fit_recovers_what_moved_the_points(seed):
    truth = any_similarity(seed)
    points = np.random.default_rng(seed + 1).normal(size=(7, 3))
    found = fit_similarity(points, truth(points))
    np.testing.assert_allclose(found(points), truth(points), atol=1e-9 * truth.scale)
    assert found.scale == pytest.approx(truth.scale)


@given(seed=st.integers(0, 10_000))
def test_inverse_and_composition(seed):
    first, second = any_similarity(seed), any_similarity(seed + 1)
    points = np.random.default_rng(seed).normal(size=(5, 3))
    np.testing.assert_allclose(first.inverse()(first(points)), points, atol=1e-9)
    np.testing.assert_allclose(first.then(second)(points), second(first(points)), atol=1e-8)


def test_a_mirrored_copy_is_fitted_only_when_asked():
    points = np.random.default_rng(0).normal(size=(9, 3))
    mirrored = points * [-1, 1, 1]
    assert np.linalg.det(fit_similarity(points, mirrored).rotation) == pytest.approx(1)
    for mirror in (True, None):
        found = fit_similarity(points, mirrored, mirrored=mirror)
        np.testing.assert_allclose(found(points), mirrored, atol=1e-12)


def test_a_third_of_wrong_pairs_changes_nothing():
    random = np.random.default_rng(3)
    truth = any_similarity(5)
    points = random.normal(size=(90, 3))
    goal = truth(points)
    goal[:30] = random.normal(size=(30, 3)) * 20
    found, agree = agreeing(points, goal, 1e-6)
    assert not agree[:30].any()
    assert agree[30:].all()
    np.testing.assert_allclose(found(points[30:]), goal[30:], atol=1e-9)


def test_points_on_a_line_are_refused():
    line = np.outer(np.arange(5.0), [1, 2, 3])
    with pytest.raises(CaptureError, match="one line"):
        fit_similarity(line, line)
    with pytest.raises(CaptureError, match="at least 3"):
        fit_similarity(line[:2], line[:2])


def test_a_rigid_motion_of_what_is_still_whatever_moves() -> None:
    """A third of the points go somewhere else by up to a tenth of the whole."""
    random = np.random.default_rng(3)
    source = random.normal(size=(300, 3))
    true = Similarity(1.0, np.eye(3), np.array([0.02, -0.01, 0.03]))
    goal = true(source) + 1e-4 * random.normal(size=source.shape)
    goal[:100, 1] -= random.uniform(0.1, 0.5, 100)
    found = robust_rigid(source, goal, (0.1, 0.03, 0.01))
    assert np.abs(found(source) - true(source)).max() < 1e-3
    assert np.abs(fit_similarity(source, goal, rigid=True)(source) - true(source)).max() > 0.05
