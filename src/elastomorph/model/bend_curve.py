"""Bend curves: the scalar weights over time that drive the bends of a morph."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import ParameterError
from elastomorph.numbers import as_numbers, is_whole


@dataclass(frozen=True, eq=False)
class BendCurve:
    """A piecewise polynomial b(t) on [0, 1] with b(0) = b(1) = 0.

    Plain numbers, so that it can be stored in a file and turned into weight keys. Outside [0, 1]
    it continues straight along its end tangents.

    Attributes:
        breaks: (S + 1,) rising times from 0 to 1 where the S pieces meet.
        coefficients: (S, N) of 1, s, s², … with s = t - breaks[piece].

    Raises:
        ParameterError: Breaks do not rise from 0 to 1, shapes do not fit, or an end is not zero.
    """

    breaks: NDArray[np.float64]
    coefficients: NDArray[np.float64]

    def __post_init__(self) -> None:
        breaks = np.array(as_numbers(self.breaks, "the breaks of a bend curve"))
        coefficients = np.array(as_numbers(self.coefficients, "the coefficients of a bend curve"))
        ends = breaks.ndim == 1 and breaks.size > 1 and breaks[0] == 0 and breaks[-1] == 1
        if not ends or (np.diff(breaks) <= 0).any():
            raise ParameterError("the breaks of a bend curve must rise from 0 to 1")
        if coefficients.ndim != 2 or len(coefficients) != breaks.size - 1:
            raise ParameterError("a bend curve needs one row of coefficients for each piece")
        if coefficients.shape[1] == 0 or not np.isfinite(coefficients).all():
            raise ParameterError("the coefficients of a bend curve must be finite numbers")
        last = np.polynomial.polynomial.polyval(breaks[-1] - breaks[-2], coefficients[-1])
        if max(abs(coefficients[0, 0]), abs(last)) > 1e-9 * max(1.0, np.abs(coefficients).max()):
            raise ParameterError("a bend curve must be 0 at t = 0 and at t = 1")
        for name, array in (("breaks", breaks), ("coefficients", coefficients)):
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    @classmethod
    def polynomial(cls, coefficients: ArrayLike) -> BendCurve:
        """The polynomial with the given coefficients of 1, t, t² and so on."""
        row = as_numbers(coefficients, "the coefficients of a bend curve")
        return cls(np.array([0.0, 1.0]), np.atleast_2d(row))

    @classmethod
    def power(cls, exponent: int) -> BendCurve:
        """The curve t^exponent - t.

        Raises:
            ParameterError: The exponent is not a whole number from 1.
        """
        if not is_whole(exponent) or exponent < 1:
            raise ParameterError(f"the exponent must be a whole number from 1, found {exponent!r}")
        coefficients = np.zeros(exponent + 1)
        coefficients[exponent] = 1.0
        coefficients[1] -= 1.0
        return cls.polynomial(coefficients)

    def __call__(self, times: ArrayLike) -> NDArray[np.float64]:
        """The value at each time, in the shape of ``times``."""
        t = as_numbers(times, "times")
        inside = np.clip(t, 0.0, 1.0)
        value = np.where((inside > 0) & (inside < 1), self._horner(self.coefficients, inside), 0.0)
        first, last = self.end_slopes
        return value + first * np.minimum(t, 0.0) + last * np.maximum(t - 1.0, 0.0)

    def at(self, time: float) -> float:
        """The value at one time, without the cost of an array: for posing a rig."""
        if 0.0 < time < 1.0:
            breaks, descending = self._pieces
            piece = bisect_right(breaks, time) - 1
            local, value = time - breaks[piece], 0.0
            for coefficient in descending[piece]:
                value = value * local + coefficient
            return value
        first, last = self.end_slopes
        return first * min(time, 0.0) + last * max(time - 1.0, 0.0)

    def slope(self, times: ArrayLike, *, before: bool = False) -> NDArray[np.float64]:
        """The derivative db/dt at each time, in the shape of ``times``.

        Where two pieces meet, it is that of the piece after, or of the one before.
        """
        t = np.clip(np.asarray(times, dtype=np.float64), 0.0, 1.0)
        rows = np.polynomial.polynomial.polyder(self.coefficients, axis=1)
        side: Literal["left", "right"] = "left" if before else "right"
        return self._horner(np.asarray(rows, dtype=np.float64), t, side)

    def derivatives_at(self, time: float) -> tuple[float, float, float]:
        """Value, first and second derivative at one time, without the cost of an array."""
        if not 0.0 <= time <= 1.0:
            return self.at(time), self.end_slopes[time > 0.0], 0.0
        breaks, descending = self._pieces
        piece = min(bisect_right(breaks, time), len(descending)) - 1
        local, value, slope, half = time - breaks[piece], 0.0, 0.0, 0.0
        for coefficient in descending[piece]:
            half = half * local + slope
            slope = slope * local + value
            value = value * local + coefficient
        return value, slope, 2.0 * half

    def times_within(self, count: int) -> NDArray[np.float64]:
        """(count, S) times spread evenly over each piece, its ends among them."""
        return self.breaks[:-1] + np.linspace(0, 1, count)[:, None] * np.diff(self.breaks)

    @cached_property
    def end_slopes(self) -> tuple[float, float]:
        """The derivatives at t = 0 and t = 1."""
        return float(self.slope(0.0)), float(self.slope(1.0))

    @cached_property
    def peak(self) -> tuple[float, float]:
        """The time within [0, 1] at which the curve is farthest from 0, and its value there."""
        spans = np.diff(self.breaks)[:, None]
        # In u = s / span from 0 to 1, so that coefficients are as large as what they add.
        rows = np.polynomial.polynomial.polyder(
            self.coefficients * spans ** np.arange(self.coefficients.shape[1]), axis=1
        )
        turns = [
            start + unit_roots(row) * span
            for start, span, row in zip(self.breaks[:-1], spans, rows, strict=True)
        ]
        times = np.concatenate([self.breaks, *turns])
        values = self(times)
        highest = int(np.abs(values).argmax())
        return float(times[highest]), float(values[highest])

    @property
    def height(self) -> float:
        """The largest absolute value of b(t) within [0, 1]."""
        return abs(self.peak[1])

    @cached_property
    def _pieces(self) -> tuple[list[float], list[list[float]]]:
        return self.breaks.tolist(), self.coefficients[:, ::-1].tolist()

    def _horner(
        self,
        rows: NDArray[np.float64],
        t: NDArray[np.float64],
        side: Literal["left", "right"] = "right",
    ) -> NDArray[np.float64]:
        pieces = np.clip(np.searchsorted(self.breaks, t, side=side) - 1, 0, len(self.breaks) - 2)
        local = t - self.breaks[pieces]
        value = np.zeros_like(t)
        for column in range(rows.shape[1] - 1, -1, -1):
            value = value * local + rows[pieces, column]
        return value


def unit_roots(coefficients: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the real u within (0, 1) at which a polynomial of 1, u, u² … is zero.

    They are eigenvalues of a pencil, C - uE with the last coefficient in E: dividing by it, as a
    companion matrix is made, loses every root where it is rounding noise. They are the exact roots
    of coefficients that differ by rounding of the largest; a polynomial of zeros has none.
    """
    from scipy.linalg import eigvals

    row = np.asarray(coefficients, dtype=np.float64)
    if len(row) < 2 or not row.any():
        return np.zeros(0)
    row = row / np.abs(row).max()
    companion, last = np.diag(np.ones(len(row) - 2), -1), np.eye(len(row) - 1)
    companion[:, -1], last[-1, -1] = -row[:-1], row[-1]
    roots = np.asarray(eigvals(companion, last), dtype=np.complex128)
    real = np.asarray(roots[np.abs(roots.imag) <= 1e-9].real, dtype=np.float64)
    return real[(real > 0) & (real < 1)]


def as_times(times: ArrayLike) -> NDArray[np.float64]:
    """One time or (T,) times as float64, all finite."""
    t = as_numbers(times, "times")
    if t.ndim > 1:
        raise ParameterError(f"times must be one number or a list of them, found shape {t.shape}")
    if not np.isfinite(t).all():
        bad = np.atleast_1d(t)[~np.isfinite(np.atleast_1d(t))][0]
        raise ParameterError(f"times must be finite numbers, found {bad}")
    return t
