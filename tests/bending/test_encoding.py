"""Displacements as the numbers that targets of a file have."""

from __future__ import annotations

import numpy as np
import pytest

from elastomorph.bending.meshes import Encoding


@pytest.mark.parametrize(
    ("rows", "dtype", "normalized", "expected"),
    [
        ([[0.5, -1.0, 1.0]], "<i2", True, [[16384, -32767, 32767]]),
        ([[0.5, -1.0, 1.0]], "|i1", True, [[64, -127, 127]]),
        ([[2.4, -127.0, 127.4]], "|i1", False, [[2, -127, 127]]),
        ([[0.1, -1e30, 1.0]], "<f4", False, np.float32([[0.1, -1e30, 1.0]])),
    ],
)
def test_numbers_and_how_far_they_are_off(
    rows: list[list[float]], dtype: str, normalized: bool, expected: object
) -> None:
    values = np.array(rows)
    stored, found, away = Encoding(dtype, normalized).encoded(values)
    np.testing.assert_array_equal(stored, expected)
    assert (stored.dtype.str, found) == (dtype, normalized)
    unit = np.iinfo(dtype).max if normalized else 1
    np.testing.assert_allclose(values + away, stored.astype(float) / unit, rtol=1e-15)


@pytest.mark.parametrize(
    ("value", "dtype", "normalized"),
    [(1.01, "|i1", True), (128.0, "|i1", False), (40000.0, "<i2", False)],
)
def test_what_does_not_fit_is_stored_in_single_precision(
    value: float, dtype: str, normalized: bool
) -> None:
    stored, found, away = Encoding(dtype, normalized).encoded(np.array([[value, 0, 0]]))
    assert (stored.dtype.str, found) == ("<f4", False)
    np.testing.assert_array_equal(stored, np.float32([[value, 0, 0]]))
    np.testing.assert_allclose(away, stored - np.array([[value, 0, 0]]), atol=1e-12)


def test_directions_that_are_too_long_are_shortened() -> None:
    rows = np.array([[2.0, -1.0, 0.0], [0.5, 0.0, 0.25]])
    stored, normalized, _ = Encoding("|i1", True).encoded(rows, directions=True)
    np.testing.assert_array_equal(stored, [[127, -64, 0], [64, 0, 32]])
    assert normalized
