"""One path laid over part of another: exact ends, means between, bends of one curve joined."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

import elastomorph as em
from elastomorph.errors import ParameterError
from elastomorph.paths.region import laid_over

TRIANGLES = em.Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
TARGET = TRIANGLES.with_vertices(np.array([[0, 0, 1], [1, 2, 0], [3, 1, 0], [0, 1, -1.0]]))
SHARES = st.lists(st.floats(0, 1), min_size=4, max_size=4).map(np.array)


def path(method: str) -> em.Morph:
    return em.interpolate(TRIANGLES, TARGET, method)


@given(SHARES, st.floats(-0.5, 1.5))
def test_every_vertex_is_where_its_share_of_both_paths_is(
    weights: NDArray[np.float64], t: float
) -> None:
    below, above = path("ease:3"), path("cosine")
    found = laid_over(below, above, weights, "both")
    share = weights[:, None]
    expected = (1 - share) * below.at(t) + share * above.at(t)
    np.testing.assert_allclose(found.at(t), expected, atol=1e-12)
    assert found.method == "both"


@given(SHARES)
def test_both_ends_are_exact(weights: NDArray[np.float64]) -> None:
    found = laid_over(path("ease:3"), path("beam:2"), weights, "both")
    assert (found.at(0.0) == TRIANGLES.vertices).all()
    assert (found.at(1.0) == TARGET.vertices).all()


def test_bends_of_one_curve_become_one() -> None:
    """An ease t³ has the curve t³ - t, a beam of order 3 that and t² - t."""
    half = np.full(4, 0.5)
    below, above = path("ease:3"), path("beam:3")
    assert len(laid_over(below, below, half, "").bends) == 1
    assert len(laid_over(below, path("ease:2"), half, "").bends) == 2
    assert len(laid_over(below, above, half, "").bends) == 1 + len(above.bends) - any(
        np.array_equal(curve.coefficients, below.bend_curves[0].coefficients)
        for curve in above.bend_curves
    )
    assert len(laid_over(path("linear"), path("linear"), half, "").bends) == 0


def test_neither_path_is_changed() -> None:
    below, above = path("ease:3"), path("ease:3")
    before = below.bends.copy(), above.bends.copy()
    laid_over(below, above, np.full(4, 0.5), "")
    np.testing.assert_array_equal(below.bends, before[0])
    np.testing.assert_array_equal(above.bends, before[1])


def test_the_larger_bake_error_stays() -> None:
    below, above = path("rotation"), path("linear")
    assert below.bake_error > 0
    for one, other in ((below, above), (above, below)):
        assert laid_over(one, other, np.ones(4), "").bake_error == below.bake_error


def test_paths_between_other_shapes_are_refused() -> None:
    elsewhere = em.interpolate(TRIANGLES, TRIANGLES.with_vertices(2 * TARGET.vertices), "cosine")
    with pytest.raises(ParameterError, match="same two shapes"):
        laid_over(path("linear"), elsewhere, np.ones(4), "")
