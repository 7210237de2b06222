"""Seams of closures on two curves whose means move apart."""

from __future__ import annotations

import numpy as np
import pytest

import elastomorph as em
from elastomorph.evaluation.closure_seams import closure_seams
from elastomorph.physics import mean_response


def test_seam_is_the_difference_of_the_means() -> None:
    """One row of a strip rises, the other stays: the seam is |φ₀(½) - ¼|·height / D."""
    count = 6
    x = np.arange(count, dtype=float)
    points = np.concatenate([np.stack([x, 0 * x + row, 0 * x], axis=1) for row in (0, 1)])
    faces = [[i, i + 1, count + i + 1, count + i] for i in range(count - 1)]
    neutral = em.Mesh(points, faces)
    target = neutral.with_vertices(points + np.repeat([[0, 0, 0], [0, 0, 2.0]], count, axis=0))
    rows = em.CurveNetwork(
        [em.Curve(np.arange(count), False), em.Curve(np.arange(count, 2 * count), False)],
        2 * count,
    )
    for found in closure_seams(neutral, target, rows):
        law = mean_response(found.closure, em.Load.power(2), em.Material())
        value = sum(c * 0.5 ** (r + 1) for r, c in enumerate(law))
        assert found.shape.seam == pytest.approx(abs(value - 0.25) * 2 / neutral.diameter)
