"""Beams of a whole face: small bends are kept, for they are the law; rounding is not."""

from __future__ import annotations

import numpy as np
import pytest

import elastomorph as em
from elastomorph.paths import Method
from elastomorph.physics import modal_response

COUNT = 24
TURN = 2 * np.pi * np.arange(COUNT) / COUNT
RING = em.Mesh(np.stack([np.cos(TURN), np.sin(TURN), 0 * TURN], axis=1))
CURVES = em.CurveNetwork([em.Curve(np.arange(COUNT), True)], COUNT)
# One wave along the ring: a single mode.
WAVE = np.stack([0 * TURN, 0 * TURN, np.cos(TURN)], axis=1)


@pytest.mark.parametrize("rigidity", [1.0, 1e3, 1e6])
def test_the_bends_of_a_stiff_beam_are_small_and_exact(rigidity: float) -> None:
    """φ₁ of the load t³ has -3c/B of t², down to 10⁻⁹ of the displacement."""
    method = Method("beam", order=3, material=em.Material(rigidity=rigidity))
    path = method.prepare(RING, CURVES)(RING.with_vertices(RING.vertices + WAVE))
    law = modal_response(16 * np.pi**4 * rigidity, method.external_load, method.material)
    assert abs(law[1]) < 2e-3
    assert path.bends == pytest.approx(np.multiply.outer(law[1:], WAVE), rel=1e-5, abs=1e-14)


def test_bends_that_are_rounding_are_left_out() -> None:
    """Of a displacement alike everywhere the mean moves, by the limit law: no t² is in it."""
    moved = RING.with_vertices(RING.vertices + [0.1, 0.7, 0.3])
    path = Method("beam", order=3).prepare(RING, CURVES)(moved)
    assert len(path.bends) == 1
    assert path.bends[0] == pytest.approx(path.delta, abs=1e-14)
