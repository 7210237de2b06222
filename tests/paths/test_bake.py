"""The error of a bake is measured where the fit is worst: between its nodes."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial import Chebyshev
from numpy.typing import NDArray

from elastomorph.errors import BakeError
from elastomorph.model.mesh import Mesh
from elastomorph.paths.bake import bake

NEUTRAL = Mesh([[0, 0, 0], [1, 0, 0]])
# Zero at the 17 Chebyshev nodes of [0, 1], 1 in size half-way between each two.
WAVE = Chebyshev.basis(17, domain=[0, 1])


def swinging(t: float, size: float) -> NDArray[np.float64]:
    """A path that no fit at the nodes tells from one that does not move."""
    return NEUTRAL.vertices + [0, size * t * (1 - t) * WAVE(t), 0]


def test_what_no_node_sees_is_an_error() -> None:
    with pytest.raises(BakeError, match=r"leave an error of 0\.02"):
        bake(lambda t: swinging(t, 0.1), NEUTRAL, NEUTRAL, tolerance=1e-3)


def test_an_error_within_the_tolerance_is_the_one_between_the_nodes() -> None:
    path = bake(lambda t: swinging(t, 1e-3), NEUTRAL, NEUTRAL, tolerance=1e-3)
    times = np.linspace(0, 1, 2001)
    largest = np.abs(1e-3 * times * (1 - times) * WAVE(times)).max()
    assert path.bake_error == pytest.approx(largest, rel=0.02)
    assert len(path.bends) == 0
