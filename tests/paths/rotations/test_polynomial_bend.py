"""Bends through a few moments."""

from __future__ import annotations

import numpy as np
import pytest

import elastomorph as em
from elastomorph.paths.rotations import EdgeBend
from elastomorph.paths.rotations.bends import PolynomialBend, moments_needed


def test_a_polynomial_bend_is_reproduced() -> None:
    """Every t(1 - t)·q(t) with q of a degree below the number of nodes."""
    powers = np.random.default_rng(0).normal(size=(4, 5, 3))

    def bend(t: float) -> np.ndarray:
        return t * (1 - t) * np.tensordot(t ** np.arange(4.0), powers, axes=1)

    found = PolynomialBend.through(bend, 4, np.ones(5, bool))
    for t in np.linspace(0, 1, 11):
        np.testing.assert_allclose(found.at(t), bend(t), atol=1e-13)


@pytest.mark.parametrize("degrees", [1, 25, 90, 170, 240])
def test_enough_moments_for_every_turn(degrees: float) -> None:
    """Turning and stretching edges, to 1e-8 of their length."""
    rng = np.random.default_rng(degrees)
    first, second = rng.normal(size=(2, 50, 3))
    axes = rng.normal(size=(50, 3))
    angles = np.radians(degrees) / np.linalg.norm(axes, axis=1)
    edges = EdgeBend.of(first, second, angles[:, None] * axes)
    found = PolynomialBend.through(edges.at, moments_needed(np.radians(degrees)), np.ones(50, bool))
    for t in np.linspace(0, 1, 21):
        assert np.abs(found.at(t) - edges.at(t)).max() < 3e-8


def test_only_vertices_that_bend_are_kept_and_baking_agrees_with_a_bake_of_the_path() -> None:
    """The same bends as `bake`, which looks at the path at 50 moments."""
    rng = np.random.default_rng(3)
    bent = np.array([True, False, True, True, False])
    arms = rng.normal(size=(3, 3))

    def bend(t: float) -> np.ndarray:
        return np.sin(np.pi * t) * arms

    neutral = em.Mesh(rng.normal(size=(5, 3)))
    target = neutral.with_vertices(neutral.vertices + 0.1)
    found = PolynomialBend.through(bend, 14, bent)

    def path(t: float) -> np.ndarray:
        offsets = np.zeros((5, 3))
        offsets[bent] = bend(t)
        return neutral.vertices + 0.1 * t + offsets

    for tolerance in (1e-2, 1e-6):
        slow = em.bake(path, neutral, target, tolerance=tolerance)
        fast = found.baked(neutral, target, tolerance=tolerance, method="baked")
        assert len(fast.bends) == len(slow.bends) > 0
        np.testing.assert_allclose(fast.bends, slow.bends, atol=1e-8)
        assert fast.bake_error == pytest.approx(slow.bake_error, rel=1e-3)
        assert not fast.bends[:, ~bent].any()


def test_the_stated_error_is_the_largest_of_all_vertices() -> None:
    """Few vertices are tried for it, so the worst one is put where bounds alone would not look."""
    rng = np.random.default_rng(8)
    coefficients = rng.normal(size=(6, 500, 3)) / 4.0 ** np.arange(6)[:, None, None]
    neutral = em.Mesh(rng.normal(size=(500, 3)))
    bend = PolynomialBend(coefficients, np.ones(500, bool))
    for tolerance in (1e-1, 1e-2, 1e-3):
        morph = bend.baked(neutral, neutral, tolerance=tolerance, method="baked")
        checks = (1 - np.cos(np.pi * np.arange(1, 34) / 34)) / 2
        off = [np.linalg.norm(morph.at(t) - neutral.vertices - bend.at(t), axis=1) for t in checks]
        assert np.max(off) / neutral.diameter == pytest.approx(morph.bake_error, rel=1e-9)
        assert morph.bake_error <= tolerance
