"""Bends through a few moments."""

from __future__ import annotations

import numpy as np
import pytest

from elastomorph.rotations import EdgeBend
from elastomorph.rotations.polynomial_bend import PolynomialBend, moments_needed


def test_a_polynomial_bend_is_reproduced() -> None:
    """Every t(1 - t)·q(t) with q of a degree below the number of nodes."""
    powers = np.random.default_rng(0).normal(size=(4, 5, 3))

    def bend(t: float) -> np.ndarray:
        return t * (1 - t) * np.tensordot(t ** np.arange(4.0), powers, axes=1)

    found = PolynomialBend.through(bend, 4)
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
    found = PolynomialBend.through(edges.at, moments_needed(np.radians(degrees)))
    for t in np.linspace(0, 1, 21):
        assert np.abs(found.at(t) - edges.at(t)).max() < 3e-8
