"""Keys of weight animations, extended by the weights of bends so that clips play bent.

A bend follows its slider, or several by a law: its weight is b(s(t)), which between two keys is
neither the straight line of LINEAR nor the cubic of CUBICSPLINE. Keys are added where that makes a
difference: every source key stays as it is, and what the sliders do between the keys stays the same
curve. Steps need none.

The error of a stretch between two keys is measured at points so close together that the second
derivative leaves little between them: a function that vanishes at two points h apart stays within
h²/8 of its largest second derivative in between. That rest is counted, so the tolerance holds at
every moment.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, combinations, product
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import ParameterError
from elastomorph.model.bend_curve import BendCurve, unit_roots
from elastomorph.numbers import as_number, as_numbers
from elastomorph.rig.laws import Corrective

Floats = NDArray[np.float64]

# A slider this close to where a curve has a corner is at the corner: keys of in-betweens were
# rounded to single precision.
_AT_CORNER = 1e-6
_MOST_CELLS = 1 << 14
# How far beside a moment laws are asked for the slope on one side: farther than a key at a kink was
# rounded to single precision, as part of the time since 0, and at least this in units of u or s.
_ROUNDED, _BESIDE = 1e-7, 1e-9
# Cells of a piece in which what a law makes of its sliders is looked at.
_FINE = 64
# Points that are computed at once.
_BLOCK = 1 << 13


@dataclass(frozen=True)
class Driven:
    """Several sliders that together say what one would: by the law of a corrective."""

    columns: tuple[int, ...]  # Columns of its drivers
    law: Corrective

    def weight(self, sliders: Floats) -> Floats:
        """(…,) from (…, J) sliders."""
        return self.law.weight(sliders[..., list(self.columns)])

    def rate(self, sliders: Floats, rates: Floats, near: Floats, *, before: bool) -> Floats:
        """(N,) its rate from (N, J) sliders and their rates, ``near`` before or after a moment."""
        some = list(self.columns)
        # Where a law has a kink, what counts is on that side of it; the rate is a complex step.
        beside = sliders[:, some] + (-near if before else near)[:, None] * rates[:, some]
        return self.law.weight(beside + 1e-100j * rates[:, some]).imag / 1e-100

    def turns(self, row: Floats) -> Floats:
        """Each u within (0, 1) at which its law has a kink; row (2 or 4, J) of a piece."""
        own = row[:, list(self.columns)]
        if self.law.law == "hinge":
            lines = [own @ np.array(self.law.numbers) - np.eye(len(own))[0]]
        else:  # where drivers pass 0, 1 or each other
            ones = np.eye(len(own))[0][:, None]
            differences = [a - b for a, b in combinations(own.T, 2)]
            lines = [*own.T, *(own - ones).T, *differences]
        return np.concatenate([unit_roots(_without_dust(line)) for line in lines])

    def bounds(self, pieces: Pieces) -> tuple[Floats, Floats]:
        """(M,) bounds of |dm/du| and |d²m/du²| between kinks, in each piece."""
        some = list(self.columns)
        fast, hard = pieces.fastest[:, some], pieces.hardest[:, some]
        if self.law.law == "hinge":
            gains = np.abs(self.law.numbers)
            return fast @ gains, hard @ gains
        if self.law.law == "min":
            return fast.max(axis=1), hard.max(axis=1)
        # No law in closed form is rougher than twice what a fine grid of it shows.
        u = np.arange(_FINE + 1) / _FINE
        count = len(pieces.starts)
        which, part = np.repeat(np.arange(count), len(u)), np.tile(u, count)
        values = self.weight(pieces.at(which, part, slice(None))[0]).reshape(count, len(u))
        first, second = np.abs(np.diff(values)) * _FINE, np.abs(np.diff(values, 2)) * _FINE**2
        return 2 * first.max(axis=1), 2 * second.max(axis=1)


def _without_dust(row: Floats) -> Floats:
    return np.where(np.abs(row) <= 1e-14 * np.abs(row).max(), 0.0, row)


@dataclass(frozen=True, eq=False)
class Follower:
    """A weight that follows a slider, or several; without a curve, it is what they say."""

    driver: int | Driven  # Column of its slider
    place: int  # Column of the weights that it is added to
    curve: BendCurve | None
    size: float  # How far what it drives moves a vertex at a weight of 1, fraction of D

    def weight(self, sliders: Floats) -> Floats:
        """(…,) from (…, J) sliders."""
        driver = self.driver
        said = sliders[..., driver] if isinstance(driver, int) else driver.weight(sliders)
        return said if self.curve is None else self.curve(said)

    def rate(self, sliders: Floats, rates: Floats, near: Floats, *, before: bool) -> Floats:
        """(N,) its rate from (N, J) sliders and their rates, just before or after a moment.

        Kinks are looked for as far from it as (N,) ``near`` says, in the unit of time of the rates.
        """
        driver = self.driver
        if isinstance(driver, int):
            said, speed = sliders[:, driver], rates[:, driver]
        else:
            said, speed = driver.weight(sliders), driver.rate(sliders, rates, near, before=before)
        return speed if self.curve is None else self._rates(said, speed, before=before)

    def turns(self, pieces: Pieces, number: int) -> Floats:
        """Each u within a piece at which its slope may jump."""
        driver = self.driver
        if isinstance(driver, int):
            levels = [pieces.crossings(number, driver, float(level)) for level in self.corners]
            return np.concatenate([np.zeros(0), *levels])
        kinks = driver.turns(pieces.rows[number])
        if not len(self.corners):
            return kinks
        u = np.unique(np.concatenate([kinks, np.arange(_FINE + 1) / _FINE]))

        def said(at: Floats) -> Floats:
            here = np.full(len(at), number)
            return driver.weight(pieces.at(here, at, slice(None))[0])

        found = [kinks]
        for level in self.corners.tolist():
            above = said(u) > level
            cells = np.flatnonzero(above[1:] != above[:-1])
            low, high = u[cells], u[cells + 1]
            for _ in range(50):
                middle = (low + high) / 2
                passed = (said(middle) > level) == above[cells + 1]
                low, high = np.where(passed, low, middle), np.where(passed, middle, high)
            found.append(high)
        return np.concatenate(found)

    def bounds(self, pieces: Pieces) -> tuple[Floats, Floats]:
        """(M,) bounds of |ds/du| and |d²s/du²| of what it follows, in each piece."""
        driver = self.driver
        if isinstance(driver, int):
            return pieces.fastest[:, driver], pieces.hardest[:, driver]
        return driver.bounds(pieces)

    @cached_property
    def corners(self) -> Floats:
        """Where the slope of its curve jumps."""
        if self.curve is None:
            return np.zeros(0)
        inner = self.curve.breaks[1:-1]
        jumps = np.abs(self.curve.slope(inner) - self.curve.slope(inner, before=True))
        return inner[jumps > 1e-9 * self.steepest]

    @cached_property
    def steepest(self) -> float:
        """A bound of |b'(t)|."""
        return 1.0 if self.curve is None else _largest_derivative(self.curve, 1)

    @cached_property
    def roundest(self) -> float:
        """A bound of |b″(t)| between corners."""
        return 0.0 if self.curve is None else _largest_derivative(self.curve, 2)

    def _rates(self, sliders: Floats, rates: Floats, *, before: bool) -> Floats:
        """d b(s)/dt from (N,) values and rates of what it follows, just before or after a moment.

        At a corner the curve has two slopes: which one counts depends on where the slider comes
        from, or goes.
        """
        assert self.curve is not None
        found = sliders
        if len(self.corners):
            near = np.abs(sliders[:, None] - self.corners).argmin(axis=1)
            corner = self.corners[near]
            found = np.where(np.abs(sliders - corner) <= _AT_CORNER, corner, sliders)
        above = self.curve.slope(found)
        if not len(self.corners):
            return above * rates
        below = self.curve.slope(found, before=True)
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
class Pieces:
    """The sliders between source keys: polynomials of u, the part of the time that has gone."""

    starts: Floats  # (M,) seconds
    stops: Floats  # (M,)
    rows: Floats  # (M, 2 or 4, J) coefficients of 1, u, u² and u³

    @property
    def cubic(self) -> bool:
        """Whether keys have tangents."""
        return bool(self.rows.shape[1] == 4)

    def at(self, which: NDArray[np.int64], u: Floats, column: int | slice) -> tuple[Floats, Floats]:
        """(P,) or (P, J) values and rates d/du of a slider, or of some, at P points of pieces."""
        rows = self.rows[:, :, column][which]
        part = u.reshape(-1, *(1,) * (rows.ndim - 2))
        value, rate = rows[:, -1], np.zeros_like(rows[:, 0])
        for degree in range(rows.shape[1] - 2, -1, -1):
            rate = rate * part + value
            value = value * part + rows[:, degree]
        return value, rate

    @cached_property
    def fastest(self) -> Floats:
        """(M, J) bounds of |ds/du|."""
        degrees = np.arange(1.0, self.rows.shape[1])
        return np.asarray(np.einsum("n,mnj->mj", degrees, np.abs(self.rows[:, 1:])))

    @cached_property
    def hardest(self) -> Floats:
        """(M, J) bounds of |d²s/du²|."""
        if not self.cubic:
            return np.zeros_like(self.rows[:, 0])
        second = 2 * self.rows[:, 2]
        return np.asarray(np.maximum(np.abs(second), np.abs(second + 6 * self.rows[:, 3])))

    def crossings(self, number: int, column: int, level: float) -> Floats:
        """Each u within (0, 1) at which a slider passes a level in a piece."""
        row = self.rows[number, :, column].copy()
        row[0] -= level
        return unit_roots(_without_dust(row))


@dataclass(frozen=True, eq=False)
class Added:
    """Keys to be put between two others."""

    times: Floats  # (N,) seconds, rising, numbers in single precision
    error: float  # What is left between all of them, as a fraction of D


def added_keys(pieces: Pieces, followers: Sequence[Follower], tolerance: float) -> list[Added]:
    """The keys that each piece needs, as few as a greedy search finds."""
    found = [Added(np.zeros(0), 0.0)] * len(pieces.starts)
    sizes, steepest, roundest = (
        np.array([getattr(own, name) for own in followers])
        for name in ("size", "steepest", "roundest")
    )
    bounds = [own.bounds(pieces) for own in followers]
    fast, hard = np.reshape(bounds, (len(followers), 2, len(found))).transpose(1, 2, 0)
    bends = (roundest * fast**2 + steepest * hard) @ sizes
    moving = (fast > 0) & (sizes > 0)
    grids = []
    for number in np.flatnonzero(moving.any(axis=1)).tolist():
        own = np.flatnonzero(moving[number])
        some = [followers[k] for k in own.tolist()]
        grid = _grid(pieces, number, some, float(bends[number]), tolerance)
        if grid is not None:
            grids.append((grid, own))
        else:
            found[number] = Added(np.zeros(0), float(bends[number]) / 8)
    for block in _blocks(grids):
        for grid, stretch in _stretches(pieces, block, followers):
            stops, error = _fewest(stretch, np.searchsorted(grid.u, grid.places), tolerance)
            at = np.searchsorted(grid.places, grid.u[stops[1:-1]]) - 1
            found[grid.number] = Added(grid.times[at], error)
    return found


@dataclass(frozen=True, eq=False)
class _Grid:
    """Where keys may be put in a piece, and where the error is measured."""

    number: int  # of the piece
    times: Floats  # (N,) seconds of possible keys
    places: Floats  # (N + 2,) those moments, the start and the end
    u: Floats  # (P,) the places, and the moments at which curves have corners
    bend: float  # Σ_k bound of |d²/du²|


def _grid(
    pieces: Pieces, number: int, moving: Sequence[Follower], bend: float, tolerance: float
) -> _Grid | None:
    """The grid of a piece; None where straight lines need no more keys."""
    corners = np.unique(np.concatenate([own.turns(pieces, number) for own in moving]))
    if not len(corners) and (bend == 0 or (not pieces.cubic and bend / 8 <= tolerance)):
        return None
    # Straight pieces are many and short, cubics few and long: choosing where they end from cells
    # this small keeps a straight piece within a twentieth of as long as it can be.
    fine = 2 if pieces.cubic else 8
    cells = int(np.clip(np.ceil(fine * np.sqrt(bend / tolerance)), 1, _MOST_CELLS))
    start, stop = pieces.starts[number], pieces.stops[number]
    even = np.arange(1, cells) / cells
    single = (start + np.union1d(even, corners) * (stop - start)).astype(np.float32)
    times = np.unique(single).astype(np.float64)
    times = times[(times > start) & (times < stop)]
    places = np.concatenate([[0.0], (times - start) / (stop - start), [1.0]])
    return _Grid(number, times, places, np.union1d(places, corners), bend)


_Moved = tuple[_Grid, NDArray[np.int64]]  # A grid, and which followers move in its piece


def _blocks(grids: list[_Moved]) -> Iterator[list[_Moved]]:
    """The grids in runs of not too many points."""
    block: list[_Moved] = []
    for own in grids:
        block.append(own)
        if sum(len(grid.u) for grid, _ in block) >= _BLOCK:
            yield block
            block = []
    if block:
        yield block


@dataclass(frozen=True, eq=False)
class _Stretch:
    """What the followers of a piece do at rising points of it."""

    u: Floats  # (P,)
    values: Floats  # (K, P) how far each moves a vertex, fraction of D
    # (2, K, P) d/du just before and just after each point; None where keys have no tangents
    rates: Floats | None
    bend: float  # Σ_k bound of |d²/du²|

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


def _stretches(
    pieces: Pieces, block: list[_Moved], followers: Sequence[Follower]
) -> Iterator[tuple[_Grid, _Stretch]]:
    """What moves on some grids, each curve computed at all of their points at once."""
    u = np.concatenate([grid.u for grid, _ in block])
    which = np.repeat([grid.number for grid, _ in block], [len(grid.u) for grid, _ in block])
    some = np.unique(np.concatenate([own for _, own in block]))
    values = np.empty((len(some), len(u)))
    rates = np.empty((2, *values.shape)) if pieces.cubic else None
    sliders, speeds = pieces.at(which, u, slice(None))
    near = _near(pieces.stops)[which] / (pieces.stops - pieces.starts)[which]
    for row, own in enumerate(followers[k] for k in some.tolist()):
        values[row] = own.size * own.weight(sliders)
        if rates is not None:
            rates[0, row] = own.size * own.rate(sliders, speeds, near, before=True)
            rates[1, row] = own.size * own.rate(sliders, speeds, near, before=False)
    start = 0
    for grid, own_rows in block:
        rows, points = np.searchsorted(some, own_rows), slice(start, start + len(grid.u))
        start = points.stop
        both = None if rates is None else rates[:, rows, points]
        yield grid, _Stretch(grid.u, values[rows, points], both, grid.bend)


def _fewest(
    stretch: _Stretch, places: NDArray[np.int64], tolerance: float
) -> tuple[NDArray[np.int64], float]:
    """Greedily, the longest stretch from each key on."""
    last = len(places) - 1
    keys, largest = [0], 0.0
    while keys[-1] < last:
        before = keys[-1] - keys[-2] if len(keys) > 1 else last
        reached, error = _longest(stretch, places, keys[-1], before, tolerance)
        keys.append(reached)
        largest = max(largest, error)
    return places[keys], largest


def _longest(
    stretch: _Stretch, places: NDArray[np.int64], start: int, guess: int, tolerance: float
) -> tuple[int, float]:
    """Where the longest stretch from one key ends, and its error: the next place at least.

    It is looked for from as long as the last one was, in steps that double and then halve.
    """
    last = len(places) - 1
    good, bad, error = start + 1, last + 1, np.nan
    tried, step = min(start + guess, last), 1
    while bad - good > 1 or np.isnan(error):
        longer = stretch.error(places[start], places[tried])
        if longer <= tolerance or tried == start + 1:
            good, error = tried, longer
            ahead = tried + step
        else:
            bad = tried
            ahead = tried - step
        inside = bad <= last and not np.isnan(error)
        tried = (good + bad) // 2 if inside else min(max(ahead, start + 1), last)
        step *= 2
        if good == last:
            break
    return good, float(error)


@dataclass(frozen=True, eq=False)
class Columns:
    """How the weights of one mesh are extended.

    Attributes:
        count: Number J of weights that the source has.
        bends: For each of the K targets that are added, in their order: the column of the slider
            it follows, or several with their law; its curve; and how far it moves a vertex at a
            weight of 1, at most and as a fraction of D. Without a curve its weight is what the
            slider, or the law, says.
        folds: By column of the slider: the curve that is added to the weight of Δ itself, and how
            far Δ moves a vertex at most, as a fraction of D.
        sizes: (J,) how far each Δ moves a vertex, likewise; for weights in whole numbers alone.
    """

    count: int
    bends: tuple[tuple[int | Driven, BendCurve | None, float], ...]
    folds: Mapping[int, tuple[BendCurve, float]]
    sizes: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        drivers = (*(own[0] for own in self.bends), *self.folds)
        columns = [(own,) if isinstance(own, int) else own.columns for own in drivers]
        for column in chain.from_iterable(columns):
            if not 0 <= column < self.count:
                raise ParameterError(
                    f"a bend follows slider column {column} of a mesh of {self.count} weights"
                )

    def weights(self, sliders: ArrayLike) -> NDArray[np.float64]:
        """(…, J + K) weights of all targets from (…, J) weights of the source."""
        given = as_numbers(sliders, "slider weights")
        if given.ndim < 1 or given.shape[-1] != self.count:
            raise ParameterError(
                f"slider weights must have shape (…, {self.count}), found {given.shape}"
            )
        found = np.concatenate([given, np.zeros((*given.shape[:-1], len(self.bends)))], axis=-1)
        for own in self.followers:
            found[..., own.place] += own.weight(given)
        return found

    @cached_property
    def followers(self) -> tuple[Follower, ...]:
        """All curves, those of bends and those added to a Δ, with the column each adds to."""
        bends = [
            Follower(driver, self.count + k, curve, size)
            for k, (driver, curve, size) in enumerate(self.bends)
        ]
        folds = [Follower(column, column, *own) for column, own in self.folds.items()]
        return (*bends, *folds)


@dataclass(frozen=True, eq=False)
class Keys:
    """The keys of a weight animation.

    Attributes:
        times: (T',) seconds, each of them a number in single precision.
        values: (T', J + K), or (T', 3, J + K) for CUBICSPLINE: in-tangent, value and out-tangent,
            tangents a second as glTF has them. All are numbers that the type holds.
        interpolation: STEP, LINEAR or CUBICSPLINE, as in the source.
        error: How far a vertex may be from where the sliders put it, between keys and by the
            rounding of the bends' weights, as a fraction of D.
        dtype: The type of the values: ``<f4``, or whole numbers of which the largest stands for 1.
    """

    times: NDArray[np.float64]
    values: NDArray[np.float64]
    interpolation: str
    error: float
    dtype: str = "<f4"

    def stored(self, values: Floats) -> NDArray[Any]:
        """Some of the values as the numbers of the type."""
        kind = np.dtype(self.dtype)
        return (values if kind.kind == "f" else np.rint(values * np.iinfo(kind).max)).astype(kind)


# Types of weights, each with those that hold them more closely; only the last holds all weights.
_KINDS = {
    "|u1": ("|u1", "<u2", "<i2"),
    "|i1": ("|i1", "<i2"),
    "<u2": ("<u2", "<i2"),
    "<i2": ("<i2",),
}


def bent_keys(
    times: ArrayLike,
    values: ArrayLike,
    interpolation: str,
    columns: Columns,
    tolerance: float,
    dtype: str = "<f4",
) -> Keys:
    """The keys of all targets of a mesh from those of its sliders.

    Source keys keep their times and slider weights. Between two of them keys are added, as few as
    a greedy search finds, until Σ_k |error of weight k|·|D_k| is within the tolerance at every
    moment; the bound is kept between samples too, from the derivatives of the curves. Where
    single precision has no room for another time, the error that is left is returned.

    Args:
        times: (T,) seconds, rising.
        values: (T, J) weights; (T, 3, J) in-tangents, weights and out-tangents for CUBICSPLINE.
        interpolation: STEP, LINEAR or CUBICSPLINE.
        columns: How the weights are extended.
        tolerance: Largest error, as a fraction of D.
        dtype: The type of the values in the file. Whole numbers stay whole, in as many bits as hold
            a fifth or else a half of the tolerance: the rest is for what is between the keys.

    Raises:
        ParameterError: Shapes do not fit, numbers are not finite, times do not rise, or the
            interpolation is none of glTF.
    """
    tolerance = as_number(tolerance, "the tolerance of keys", above=0)
    moments, given = _checked(times, values, interpolation, columns.count)
    for kind, part in product(_KINDS.get(dtype, ()), (0.8, 0.5)):
        keys = _bent(moments, given, interpolation, columns, part * tolerance, kind)
        if keys.error <= tolerance:
            return keys
    return _bent(moments, given, interpolation, columns, tolerance, "<f4")


def _bent(
    moments: Floats, given: Floats, kind: str, columns: Columns, tolerance: float, dtype: str
) -> Keys:
    if kind == "STEP":
        found, rounding = _rounded(columns.weights(given), columns, dtype)
        return Keys(moments, found, kind, rounding, dtype)
    pieces = _pieces(moments, given)
    added = added_keys(pieces, columns.followers, tolerance)
    seconds, sliders = _with_added(moments, given, pieces, added)
    spans = np.diff(seconds) if pieces.cubic else None
    every = columns.weights(sliders) if spans is None else _with_tangents(seconds, sliders, columns)
    found, rounding = _rounded(every, columns, dtype, spans)
    error = max((own.error for own in added), default=0.0)
    return Keys(seconds, found, kind, error + rounding, dtype)


def _checked(
    times: ArrayLike, values: ArrayLike, interpolation: str, count: int
) -> tuple[Floats, Floats]:
    """Times and values in single precision, which is what a file holds."""
    if interpolation not in ("STEP", "LINEAR", "CUBICSPLINE"):
        raise ParameterError(
            f"an interpolation is STEP, LINEAR or CUBICSPLINE, found {interpolation!r}"
        )
    moments = as_numbers(times, "the times of keys")
    given = as_numbers(values, "the values of keys")
    inner = (3, count) if interpolation == "CUBICSPLINE" else (count,)
    if moments.ndim != 1 or not len(moments) or given.shape != (len(moments), *inner):
        raise ParameterError(
            f"{interpolation} keys of {count} weights must have values of shape "
            f"{('T', *inner)} at (T,) times, found {given.shape} at {moments.shape}"
        )
    moments, given = _single(moments), _single(given)
    if (np.diff(moments) <= 0).any():
        raise ParameterError("the times of keys must rise in single precision")
    return moments, given


def _single(numbers: Floats) -> Floats:
    """The nearest numbers in single precision."""
    with np.errstate(over="ignore"):
        found = numbers.astype(np.float32).astype(np.float64)
    if not np.isfinite(found).all():
        raise ParameterError("the times and values of keys must be finite in single precision")
    return found


def _pieces(times: Floats, values: Floats) -> Pieces:
    """What the sliders do between each two keys."""
    if values.ndim == 2:
        rows = np.stack([values[:-1], np.diff(values, axis=0)], axis=1)
    else:
        spans = np.diff(times)[:, None]
        first, last = spans * values[:-1, 2], spans * values[1:, 0]
        rise = np.diff(values[:, 1], axis=0)
        rows = np.stack(
            [values[:-1, 1], first, 3 * rise - 2 * first - last, first + last - 2 * rise], axis=1
        )
    return Pieces(times[:-1], times[1:], rows)


def _with_added(
    times: Floats, values: Floats, pieces: Pieces, added: list[Added]
) -> tuple[Floats, Floats]:
    """Times and sliders of all keys; between its keys each slider stays the same curve."""
    counts = np.array([len(own.times) for own in added], dtype=np.int64)
    which = np.repeat(np.arange(len(added)), counts)
    more = np.concatenate([np.zeros(0), *(own.times for own in added)])
    spans = pieces.stops - pieces.starts
    found, rates = pieces.at(which, (more - pieces.starts[which]) / spans[which], slice(None))
    if pieces.cubic:
        rates = rates / spans[which, None]
        found = np.stack([rates, found, rates], axis=1)
    after = np.repeat(np.arange(1, len(times)), counts)
    return np.insert(times, after, more), np.insert(values, after, found, axis=0)


def _near(seconds: Floats) -> Floats:
    return np.maximum(_ROUNDED * np.abs(seconds), _BESIDE)


def _with_tangents(seconds: Floats, sliders: Floats, columns: Columns) -> Floats:
    """(T, 3, J + K) in-tangents, weights and out-tangents from (T, 3, J) of the sliders."""
    near = _near(seconds)
    more = np.zeros((*sliders.shape[:2], len(columns.bends)))
    found = np.concatenate([sliders, more], axis=2)
    for own in columns.followers:
        at = sliders[:, 1]
        found[:, 0, own.place] += own.rate(at, sliders[:, 0], near, before=True)
        found[:, 1, own.place] += own.weight(at)
        found[:, 2, own.place] += own.rate(at, sliders[:, 2], near, before=False)
    return found


def _rounded(
    values: Floats, columns: Columns, dtype: str, spans: Floats | None = None
) -> tuple[Floats, float]:
    """Values as a type holds them, and how far that moves a vertex by the weights that follow.

    Whole numbers round the weights of sliders too. A wrong tangent moves a cubic by at most 4/27 of
    it times the span.
    """
    found = _single(values)
    sizes = np.zeros(values.shape[-1])
    if dtype != "<f4":
        limits = np.iinfo(dtype)
        found = np.rint(np.clip(found, max(limits.min, -limits.max) / limits.max, 1) * limits.max)
        found /= limits.max
        sizes[: len(columns.sizes)] = columns.sizes
    for own in columns.followers:
        sizes[own.place] = own.size
    off = np.abs(found - values) @ sizes
    if spans is None:
        return found, float(off.max(initial=0.0))
    between = 4 / 27 * spans * (off[:-1, 2] + off[1:, 0])
    return found, float(off[:, 1].max(initial=0.0) + between.max(initial=0.0))
