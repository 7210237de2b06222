"""Expected errors: what photographs leave open, what was filled in, what was stretched."""

from dataclasses import replace

import numpy as np
import pytest
from painted import grid, ring

from elastomorph.capturing.geometry import Deformation, Surface
from elastomorph.capturing.tracking import (
    Observations,
    beside,
    confidences,
    contradictions,
    expected_errors,
    filled,
    normal_equations,
    photographs,
    residuals,
    spreads,
    stretched,
    supported,
)

REST, TRIANGLES = grid(11)
CAMERAS = ring((400, 400), 6)
PIXEL = 1 / (0.36 * 400)


def seen(vertices: np.ndarray, which: np.ndarray, cameras: int, noise: float, seed: int):
    random = np.random.default_rng(seed)
    views = np.repeat(np.arange(cameras), len(which))
    every = np.tile(which, cameras)
    pixels = np.concatenate([CAMERAS[k].project(vertices[which])[0] for k in range(cameras)])
    return Observations(
        views,
        every,
        pixels + random.normal(0, noise, pixels.shape),
        np.tile(np.eye(2) / noise**2, (len(every), 1, 1)),
        np.ones(len(every)),
    )


def test_spreads_are_the_errors_of_many_trials():
    which = np.arange(0, len(REST), 7)
    errors = []
    for seed in range(60):
        found = REST
        for _ in range(3):
            observations = seen(REST, which, 6, 0.4, seed)
            quadratic, linear = normal_equations(
                CAMERAS, found, observations, unit=PIXEL, robust=1e6
            )
            moved = np.linalg.solve(quadratic[which], linear[which][..., None])[..., 0]
            found = REST.copy()
            found[which] = moved
        errors.append(((found - REST)[which] ** 2).sum(axis=1))
    expected = spreads(CAMERAS, REST, seen(REST, which, 6, 0.4, 99))[which]
    measured = np.sqrt(np.mean(errors, axis=0))
    # More is expected where one trial's photographs happen to disagree.
    assert np.median(expected / measured) == pytest.approx(1.05, abs=0.15)


def test_photographs_that_contradict_each_other_and_single_ones_are_told():
    which = np.array([5, 60])
    observations = seen(REST, which, 4, 0.3, 1)
    pixels = observations.pixels.copy()
    pixels[observations.vertices == 5] += np.array([[8, 0], [-8, 0], [0, 8], [0, -8]])
    wrong = Observations(
        observations.views, observations.vertices, pixels, observations.information, np.ones(8)
    )
    spread = spreads(CAMERAS, REST, wrong)
    assert spread[5] > 10 * spread[60]
    alone = seen(REST, which, 1, 0.3, 1)
    assert np.isinf(spreads(CAMERAS, REST, alone)).all()
    assert (photographs(observations, len(REST))[which] == 4).all()
    assert len(supported(alone, len(REST), 2).views) == 0
    assert len(supported(observations, len(REST), 4).views) == 8


def test_what_photographs_contradict_each_other_by_is_no_noise():
    """Twice as many photographs that are as far apart are expected to be as wrong."""
    which = np.array([5, 60])
    for cameras in (3, 6):
        observations = seen(REST, which, cameras, 1e-9, 1)
        pixels = observations.pixels.copy()
        pixels[observations.vertices == 5] += np.resize([[3, 0], [-3, 0], [0, 3]], (cameras, 2))
        apart = replace(observations, pixels=pixels)
        found = contradictions(CAMERAS, REST, apart, PIXEL)
        assert found[5] == pytest.approx(6 * 3 * PIXEL, rel=0.01)
        assert np.delete(found, 5).max() < 1e-6


def test_filling_in_costs_nothing_where_the_surface_is_rigid():
    """A pose that is turned as a whole; one that is stretched to the right of the middle."""
    deformation = Deformation(REST, TRIANGLES)
    turned = REST @ np.array([[0, 0, 1.0], [1, 0, 0], [0, 1, 0]]).T
    assert filled(deformation, turned).max() < 1e-9
    stretched_there = REST * np.where(REST[:, :1] > 0, [1.5, 1, 1], 1)
    rates = filled(deformation, stretched_there)
    assert rates[REST[:, 0] > 0.5].min() > 0.03
    assert rates[REST[:, 0] < -0.5].max() < 0.2 * rates[REST[:, 0] > 0.5].min()


def test_a_rigid_part_that_no_photograph_shows_is_trusted():
    surface = Surface(REST, TRIANGLES)
    spread = np.where(REST[:, 0] < -0.5, 0.001, np.inf)
    errors = expected_errors(surface, spread, 3.0, np.zeros(len(REST)))
    np.testing.assert_allclose(errors, 0.001, atol=1e-6)


def test_what_is_filled_in_is_trusted_less_the_farther_it_is():
    surface = Surface(REST, TRIANGLES)
    spread = np.full(len(REST), np.inf)
    left = REST[:, 0] < -0.5
    spread[left] = 0.001
    errors = expected_errors(surface, spread, 3.0)
    np.testing.assert_allclose(errors[left], 0.001)
    far = REST[~left, 0]
    assert (np.diff(errors[~left][np.argsort(far, kind="stable")]) > -0.05).all()
    assert np.corrcoef(errors[~left], far)[0, 1] > 0.95
    trusted = confidences(errors, 3.0)
    assert trusted[left].min() > 0.99
    assert trusted[REST[:, 0] > 0.5].max() < 0.1
    assert confidences(np.array([0.015, np.inf]), 3.0) == pytest.approx([0.5, 0], abs=1e-9)


def test_only_strain_is_expected_to_mislead():
    deformation = Deformation(REST, TRIANGLES)
    turned = REST @ np.array([[0, 0, 1.0], [1, 0, 0], [0, 1, 0]]).T
    assert stretched(deformation, turned, 0.1).max() == 0
    assert stretched(deformation, REST * [2, 1, 1], 0.1).min() > 0.02


def test_patches_where_skin_touches_skin_are_trusted_less():
    deformation = Deformation(REST, TRIANGLES)
    lips = np.abs(REST[:, 1]) < 0.1
    found = beside(deformation, lips, 0.2)
    assert found[lips].min() > 0.05
    assert found.max() <= 0.1
    assert found[np.abs(REST[:, 1]) > 0.7].max() == 0


def test_residuals_are_what_was_seen_less_where_it_would_be():
    which = np.arange(10)
    observations = seen(REST, which, 3, 1e-9, 0)
    moved = REST + [0.01, 0, 0]
    off = residuals(CAMERAS, moved, observations)
    expected = np.concatenate(
        [camera.project(REST[which])[0] - camera.project(moved[which])[0] for camera in CAMERAS[:3]]
    )
    np.testing.assert_allclose(off, expected, atol=1e-6)
