"""Volumes melt and are found by rays as their formulas say."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from elastomorph.samples.implicit import capsule, cast, ellipsoid, melt, melt_away, settle

coordinates = arrays(np.float64, (7, 3), elements=st.floats(-9.0, 9.0))


@given(coordinates)
def test_an_ellipsoid_with_equal_axes_is_a_sphere(points):
    distance = np.linalg.norm(points - [1.0, 2.0, 3.0], axis=1)
    away = distance > 1e-3
    found = ellipsoid(points, (1.0, 2.0, 3.0), (2.0, 2.0, 2.0))
    np.testing.assert_allclose(found[away], distance[away] - 2.0, atol=1e-6)


@given(coordinates)
def test_an_ellipsoid_is_negative_exactly_inside(points):
    level = (((points - [0.5, 0, 0]) / [1.0, 2.0, 3.0]) ** 2).sum(axis=1)
    clear = np.abs(level - 1.0) > 1e-6
    found = ellipsoid(points, (0.5, 0.0, 0.0), (1.0, 2.0, 3.0))
    np.testing.assert_array_equal(found[clear] < 0.0, level[clear] < 1.0)


def test_a_capsule_is_its_distance_to_the_segment():
    points = np.array([[0.0, 3.0, 0.0], [5.0, 0.0, 4.0], [-2.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    found = capsule(points, (0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.5, 0.5))
    np.testing.assert_allclose(found, [2.5, 4.5, 1.5, -0.5])


@given(st.floats(-5, 5), st.floats(-5, 5), st.floats(0.1, 3))
def test_melting_only_adds_and_only_near_the_seam(a, b, width):
    first, second = np.array([a]), np.array([b])
    joined = melt(first, second, width)
    assert joined[0] <= min(a, b) + 1e-12
    assert joined[0] >= min(a, b) - width / 4 - 1e-12
    if abs(a - b) >= width:
        assert joined[0] == pytest.approx(min(a, b))
    np.testing.assert_allclose(melt(second, first, width), joined, atol=1e-12)


def test_melting_away_leaves_what_is_in_the_body_and_not_in_the_tool():
    body, tool = np.array([-3.0, -3.0, 2.0]), np.array([4.0, -4.0, 4.0])
    np.testing.assert_allclose(melt_away(body, tool, 0.5), [-3.0, 4.0, 2.0])


def test_rays_stop_at_the_first_surface_and_settling_reaches_it():
    def field(points):
        return melt(
            ellipsoid(points, (0, 0, 0), (2, 2, 2)), ellipsoid(points, (0, 0, 5), (1, 1, 1)), 0.1
        )

    start = np.array([[0.0, 0.0, 9.0], [9.0, 0.0, 0.0], [1.0, 9.0, 1.0], [9.0, 9.0, 9.0]])
    end = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [9.0, 9.0, 8.0]])
    met = cast(field, start, end)
    expected = [[0, 0, 6], [2, 0, 0], [1, np.sqrt(2), 1], [9, 9, 8]]  # the last ray misses
    np.testing.assert_allclose(met, expected, atol=1e-6)
    near = met[:3] + 0.05
    assert np.abs(field(settle(field, near, steps=4))).max() < 1e-9
