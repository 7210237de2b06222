"""E_A and E_M of Eq. 35 along curves."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from elastomorph.curves import Curve, CurveNetwork
from elastomorph.errors import CurveError, MeshError
from elastomorph.evaluation import CurveVertices, curve_errors


def test_two_curves_computed_by_hand() -> None:
    """One curve is off by 3, 4 and 5, the other by 0 and 1, on a face of D = 10."""
    captured = np.zeros((6, 3))
    positions = np.zeros((6, 3))
    positions[4] = [3, 0, 0]
    positions[0] = [0, 0, -4]
    positions[2] = [0, 3, 4]
    positions[5] = [0.6, 0.8, 0]
    positions[3] = [99, 99, 99]  # on no curve
    network = CurveNetwork([Curve([4, 0, 2]), Curve([1, 5])], 6)
    average, maximum = curve_errors(positions, captured, CurveVertices.of(network, 6), 10.0)
    np.testing.assert_allclose(average, [0.4, 0.05])
    np.testing.assert_allclose(maximum, [0.5, 0.1])


@given(st.integers(0, 2**32 - 1), st.integers(1, 8))
def test_flat_sums_equal_a_loop_over_the_curves(seed: int, count: int) -> None:
    """The fast path equals the obvious one, and the average is never above the maximum."""
    rng = np.random.default_rng(seed)
    cuts = np.sort(rng.choice(np.arange(1, 30), count - 1, replace=False))
    order = rng.permutation(40)[:30]
    network = CurveNetwork([Curve(part) for part in np.split(order, cuts)], 40)
    positions, captured = rng.normal(size=(2, 40, 3))
    average, maximum = curve_errors(positions, captured, CurveVertices.of(network, 40), 7.0)
    for number, curve in enumerate(network):
        far = [np.linalg.norm(positions[v] - captured[v]) / 7.0 for v in curve.vertices]
        assert average[number] == pytest.approx(sum(far) / len(far), rel=1e-12)
        assert maximum[number] == pytest.approx(max(far), rel=1e-12)
    assert (average <= maximum * (1 + 1e-12)).all()


def test_no_curve_is_refused() -> None:
    """An error along no curve is not zero: it does not exist."""
    with pytest.raises(CurveError, match="there is none"):
        CurveVertices.of(CurveNetwork([], 4), 4)


def test_curves_of_another_mesh_are_refused() -> None:
    """A vertex that the mesh lacks is named."""
    with pytest.raises(CurveError, match="vertices 2 to 9, but the mesh has 5"):
        CurveVertices.of([Curve([2, 9])], 5)


def test_a_face_without_extent_is_refused() -> None:
    """D = 0 gives no fraction."""
    flat = CurveVertices.of([Curve([0, 1])], 2)
    with pytest.raises(MeshError, match="diameter D is 0"):
        curve_errors(np.zeros((2, 3)), np.zeros((2, 3)), flat, 0.0)
