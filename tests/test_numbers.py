"""Numbers as users give them: what NumPy would take for a number, and nobody means, is refused."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

import elastomorph as em
from elastomorph.numbers import as_number, as_numbers, first_few

STRAIGHT = em.interpolate(em.Mesh(np.eye(3)), em.Mesh(2 * np.eye(3)), "linear")


@pytest.mark.parametrize(
    "values", [0.5, 1, [0, 1], (), np.float32(0.5), np.arange(3), [Fraction(1, 2), 0.25]]
)
def test_numbers_of_any_kind(values: object) -> None:
    expected = np.array(values, dtype=float)
    np.testing.assert_array_equal(as_numbers(values, "times"), expected)  # type: ignore[arg-type]


NO_NUMBERS = [None, True, "0.5", [None, 0.5], [[0, 1], [0]], object(), [0.5, "1"], {"t": 1}, 1j]


@pytest.mark.parametrize("values", NO_NUMBERS, ids=lambda value: type(value).__name__)
def test_what_is_no_number_is_refused(values: object) -> None:
    with pytest.raises(em.ParameterError, match="times must be numbers, found"):
        STRAIGHT.at(values)  # type: ignore[arg-type]


def test_the_message_shows_what_was_found() -> None:
    with pytest.raises(em.ParameterError, match="times must be numbers, found None"):
        STRAIGHT.at(None)  # type: ignore[arg-type]
    with pytest.raises(em.ParameterError, match="times must be numbers, found True"):
        STRAIGHT.at(True)


@pytest.mark.parametrize("value", [0, 3, np.float64(0.5), np.array(2.0), Fraction(1, 3)])
def test_one_number(value: object) -> None:
    assert as_number(value, "size", least=0) == float(value)  # type: ignore[arg-type]


@pytest.mark.parametrize("value", [-1, float("nan"), float("inf"), None, False, "1", [1.0]])
def test_one_number_is_finite_and_within_its_bound(value: object) -> None:
    with pytest.raises(em.ParameterError, match=r"size must be a (finite )?number ≥ 0, found"):
        as_number(value, "size", least=0)
    with pytest.raises(em.ParameterError, match=r"size must be a (finite )?number above 0, found"):
        as_number(value, "size", above=0)


def test_the_first_few_names_are_listed() -> None:
    assert first_few([], 2) == ""
    assert first_few(iter("ab"), 2) == "a, b"
    assert first_few(range(1_003), 3) == "0, 1, 2 and 1,000 more"
