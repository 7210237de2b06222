"""Errors of many paths at once are those of the paths one by one."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from elastomorph.evaluation.spline_errors import (
    Choice,
    LargestError,
    MeanSquare,
    cardinal_weights,
)
from elastomorph.paths.through import LAWS, cardinal_curves


@pytest.mark.parametrize("law", LAWS)
@given(
    st.lists(
        st.lists(st.integers(1, 99), min_size=3, max_size=3, unique=True), min_size=1, max_size=5
    )
)
@settings(max_examples=40, deadline=None)
def test_many_choices_at_once_are_the_curves_one_by_one(law: str, choices: list[list[int]]) -> None:
    keys = np.sort(np.array(choices), axis=1) / 100
    grid = np.linspace(0, 1, 101)
    for row, values in zip(keys, cardinal_weights(keys, grid, law), strict=True):
        for curve, column in zip(cardinal_curves(row.tolist(), law), values.T, strict=True):
            np.testing.assert_allclose(column, curve(grid), atol=1e-9 * np.abs(column).max())


def hump(height: float) -> np.ndarray:
    """(5, 2, 3): two vertices that rest, but for the second in the middle frame."""
    offsets = np.zeros((5, 2, 3))
    offsets[2, 1] = [0, 0.6 * height, 0.8 * height]
    return offsets


@pytest.mark.parametrize("frame", [1, 3])
def test_a_frame_that_rests_leaves_the_hump(frame: int) -> None:
    """By hand: the spline through a shape of no offset is straight, so all of the hump is left."""
    times, choices = np.linspace(0, 1, 5), np.array([[frame]])
    nothing = Choice((), np.inf)
    each, pair = np.array([0, 1]), np.array([0])
    found = LargestError(hump(2.0), times, each, np.ones(2, int)).best(choices, nothing)
    assert found == Choice((frame,), pytest.approx(2.0))
    found = LargestError(hump(2.0), times, pair, np.array([2])).best(choices, nothing)
    assert found == Choice((frame,), pytest.approx(1.0))
    found = MeanSquare(hump(2.0), times).best(choices, nothing)
    assert found == Choice((frame,), pytest.approx((2.0**2 / 10) ** 0.5))


def test_the_frame_of_the_hump_swings_beside_it() -> None:
    """By hand: b(1/4) = 3/4 - 4/64 of the cardinal spline at ½ is all error at frames 1 and 3."""
    times, choices = np.linspace(0, 1, 5), np.array([[2]])
    judge = LargestError(hump(2.0), times, np.array([0, 1]), np.ones(2, int))
    assert judge.best(choices, Choice((), np.inf)).error == pytest.approx(2.0 * 11 / 16)
    square = MeanSquare(hump(2.0), times).best(choices, Choice((), np.inf)).error ** 2
    assert square == pytest.approx(2 * (2.0 * 11 / 16) ** 2 / 10)
