"""What follows a slider between two keys, and the keys it needs there to stay within a tolerance.

The error of a stretch between two keys is measured at points so close together that the second
derivative leaves little between them: a function that vanishes at two points h apart stays within
h²/8 of its largest second derivative in between. That rest is counted, so the tolerance holds at
every moment.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.bend_curve import BendCurve

Floats = NDArray[np.float64]

# A slider this close to where a curve has a corner is at the corner: keys of in-betweens were
# rounded to single precision.
_AT_CORNER = 1e-6
_MOST_CELLS = 1 << 14


@dataclass(frozen=True, eq=False)
class Follower:
    """A weight that follows a slider."""

    column: int  # Column of its slider
    place: int  # Column of the weights that it is added to
    curve: BendCurve
    size: float  # How far what it drives moves a vertex at a weight of 1, fraction of D

    @cached_property
    def corners(self) -> Floats:
        """Where its slope jumps."""
        inner = self.curve.breaks[1:-1]
        jumps = np.abs(self.curve.slope(inner) - self.curve.slope(inner, before=True))
        return inner[jumps > 1e-9 * self.steepest]

    @cached_property
    def steepest(self) -> float:
        """A bound of |b'(t)|."""
        return _largest_derivative(self.curve, 1)

    @cached_property
    def roundest(self) -> float:
        """A bound of |b″(t)| between corners."""
        return _largest_derivative(self.curve, 2)

    def rates(self, sliders: Floats, rates: Floats, *, before: bool) -> Floats:
        """d b(s)/dt from (N,) values and rates of its slider, just before or after a moment.

        At a corner the curve has two slopes: which one counts depends on where the slider comes
        from, or goes.
        """
        found = sliders
        if len(self.corners):
            near = np.abs(sliders[:, None] - self.corners).argmin(axis=1)
            corner = self.corners[near]
            found = np.where(np.abs(sliders - corner) <= _AT_CORNER, corner, sliders)
        below = self.curve.slope(found, before=True)
        above = self.curve.slope(found)
        return np.asarray(np.where((rates > 0) == before, below, above) * rates)


def _largest_derivative(curve: BendCurve, order: int) -> float:
    rows = np.polynomial.polynomial.polyder(curve.coefficients, order, axis=1)
    # A polynomial of degree n is nowhere 1/cos(π/8) times larger than at 4n + 1 Chebyshev points.
    points = 4 * max(1, rows.shape[1] - 1)
    part = (1 - np.cos(np.pi * np.arange(points + 1) / points)) / 2
    local = part[:, None] * np.diff(curve.breaks)
    values = np.polynomial.polynomial.polyval(local, rows.T[:, None, :], tensor=False)
    return float(np.abs(values).max() / np.cos(np.pi / 8))


@dataclass(frozen=True, eq=False)
class Piece:
    """The sliders between two source keys: polynomials of u, the part of the time that has gone."""

    start: float  # Seconds
    stop: float
    rows: Floats  # (2 or 4, J) coefficients of 1, u, u² and u³

    @property
    def cubic(self) -> bool:
        """Whether keys have tangents."""
        return len(self.rows) == 4

    def sliders(self, u: Floats) -> Floats:
        """(N, J) values of the sliders."""
        return np.asarray(np.polynomial.polynomial.polyval(u, self.rows).T)

    def rates(self, u: Floats) -> Floats:
        """(N, J) ds/du."""
        rows = np.polynomial.polynomial.polyder(self.rows)
        return np.asarray(np.polynomial.polynomial.polyval(u, rows).T)

    @cached_property
    def fastest(self) -> Floats:
        """(J,) bounds of |ds/du|."""
        bound: Floats = np.arange(1.0, len(self.rows)) @ np.abs(self.rows[1:])
        return bound

    @cached_property
    def hardest(self) -> Floats:
        """(J,) bounds of |d²s/du²|."""
        if not self.cubic:
            return np.zeros(self.rows.shape[1])
        second = 2 * self.rows[2]
        return np.asarray(np.maximum(np.abs(second), np.abs(second + 6 * self.rows[3])))

    def crossings(self, column: int, level: float) -> Floats:
        """Each u within (0, 1) at which a slider passes a level."""
        row = self.rows[:, column].copy()
        row[0] -= level
        size = np.abs(row).max()
        row[np.abs(row) <= 1e-14 * size] = 0.0
        roots = np.polynomial.polynomial.polyroots(np.trim_zeros(row, "b"))
        real = roots.real[np.abs(roots.imag) <= 1e-9]
        return np.asarray(real[(real > 0) & (real < 1)])


@dataclass(frozen=True, eq=False)
class Added:
    """Keys to be put between two others."""

    times: Floats  # (N,) seconds, rising, numbers in single precision
    error: float  # What is left between all of them, as a fraction of D


def added_keys(piece: Piece, followers: Sequence[Follower], tolerance: float) -> Added:
    """The keys that a piece needs, as few as a greedy search finds."""
    none = np.zeros(0)
    moving = [own for own in followers if own.size and piece.rows[1:, own.column].any()]
    bend = sum(
        own.size
        * (own.roundest * piece.fastest[own.column] ** 2 + own.steepest * piece.hardest[own.column])
        for own in moving
    )
    crossings = np.unique(
        [
            u
            for own in moving
            for corner in own.corners
            for u in piece.crossings(own.column, float(corner))
        ]
    )
    if not moving or (bend == 0 and not len(crossings)):
        return Added(none, 0.0)
    if not piece.cubic and not len(crossings) and bend / 8 <= tolerance:
        return Added(none, bend / 8)
    # Straight pieces are many and short, cubics few and long: choosing where they end from cells
    # this small keeps a straight piece within a twentieth of as long as it can be.
    fine = 2 if piece.cubic else 8
    cells = int(np.clip(np.ceil(fine * np.sqrt(bend / tolerance)), 1, _MOST_CELLS))
    even = np.arange(1, cells) / cells
    span = piece.stop - piece.start
    times = np.unique((piece.start + np.union1d(even, crossings) * span).astype(np.float32))
    seconds = times.astype(np.float64)
    seconds = seconds[(seconds > piece.start) & (seconds < piece.stop)]
    places = np.concatenate([[0.0], (seconds - piece.start) / span, [1.0]])
    stretch = _Stretch.of(piece, moving, np.union1d(places, crossings), float(bend))
    stops, error = _fewest(stretch, np.searchsorted(stretch.u, places), tolerance)
    return Added(seconds[np.searchsorted(places, stretch.u[stops[1:-1]]) - 1], error)


@dataclass(frozen=True, eq=False)
class _Stretch:
    """What the followers of a piece do at rising points of it."""

    u: Floats  # (P,)
    values: Floats  # (K, P) how far each moves a vertex, fraction of D
    # (2, K, P) d/du just before and just after each point; None where keys have no tangents
    rates: Floats | None
    bend: float  # Σ_k bound of |d²/du²|

    @classmethod
    def of(cls, piece: Piece, moving: Sequence[Follower], u: Floats, bend: float) -> _Stretch:
        sliders, rates = piece.sliders(u), piece.rates(u)
        sizes = np.array([own.size for own in moving])[:, None]
        values = sizes * np.stack([own.curve(sliders[:, own.column]) for own in moving])
        if not piece.cubic:
            return cls(u, values, None, bend)
        both = [
            [
                own.rates(sliders[:, own.column], rates[:, own.column], before=before)
                for own in moving
            ]
            for before in (True, False)
        ]
        return cls(u, values, sizes * np.array(both), bend)

    def error(self, start: int, stop: int) -> float:
        """The largest Σ_k |error| between keys at two points and nowhere between."""
        u, values = self.u[start : stop + 1], self.values[:, start : stop + 1]
        step = u[-1] - u[0]
        part = (u - u[0]) / step
        rise = values[:, -1:] - values[:, :1]
        between = values[:, :1] + part * rise
        bend = self.bend
        if self.rates is not None:
            first = step * self.rates[1, :, start, None] - rise
            last = step * self.rates[0, :, stop, None] - rise
            between += part * (1 - part) * ((1 - part) * first - part * last)
            ends = np.maximum(np.abs(4 * first + 2 * last), np.abs(2 * first + 4 * last))
            bend += float(ends.sum()) / step**2
        left = float(np.abs(between - values).sum(axis=0).max())
        return left + bend * float(np.diff(u).max()) ** 2 / 8


def _fewest(
    stretch: _Stretch, places: NDArray[np.int64], tolerance: float
) -> tuple[NDArray[np.int64], float]:
    """Greedily, the longest stretch from each key on."""
    last = len(places) - 1
    keys, largest = [0], 0.0
    while keys[-1] < last:
        reached, error = _longest(stretch, places, keys[-1], tolerance)
        keys.append(reached)
        largest = max(largest, error)
    return places[keys], largest


def _longest(
    stretch: _Stretch, places: NDArray[np.int64], start: int, tolerance: float
) -> tuple[int, float]:
    """Where the longest stretch from one key ends, and its error: the next place at least."""
    last = len(places) - 1
    whole = stretch.error(places[start], places[last])
    if whole <= tolerance or last == start + 1:
        return last, whole
    good, bad = start + 1, last
    error = stretch.error(places[start], places[good])
    step = 1
    while bad - good > 1:
        tried = min(good + step, (good + bad) // 2)
        longer = stretch.error(places[start], places[tried])
        if longer > tolerance:
            bad, step = tried, bad  # from here on only halves
        else:
            good, error, step = tried, longer, 2 * step
    return good, error
