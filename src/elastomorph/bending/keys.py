"""Keys of weight animations, extended by the weights of bends so that clips play bent.

A bend follows its slider: its weight is b(s(t)), which between two keys is neither the straight
line of LINEAR nor the cubic of CUBICSPLINE. Keys are added where that makes a difference: every
source key stays as it is, and what the sliders do between the keys stays the same curve. Steps
need none.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.bending.followers import Added, Floats, Follower, Pieces, added_keys
from elastomorph.errors import ParameterError
from elastomorph.model.bend_curve import BendCurve
from elastomorph.numbers import as_number, as_numbers

__all__ = ["Columns", "Keys", "bent_keys"]


@dataclass(frozen=True, eq=False)
class Columns:
    """How the weights of one mesh are extended.

    Attributes:
        count: Number J of weights that the source has.
        bends: For each of the K targets that are added, in their order: the column of the slider
            it follows, its curve, and how far its bend moves a vertex at a weight of 1, at most
            and as a fraction of D.
        folds: By column of the slider: the curve that is added to the weight of Δ itself, and how
            far Δ moves a vertex at most, as a fraction of D.
    """

    count: int
    bends: tuple[tuple[int, BendCurve, float], ...]
    folds: Mapping[int, tuple[BendCurve, float]]

    def __post_init__(self) -> None:
        for column in (*(own[0] for own in self.bends), *self.folds):
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
            found[..., own.place] += own.curve(given[..., own.column])
        return found

    @cached_property
    def followers(self) -> tuple[Follower, ...]:
        """All curves, those of bends and those added to a Δ, with the column each adds to."""
        bends = [
            Follower(column, self.count + k, curve, size)
            for k, (column, curve, size) in enumerate(self.bends)
        ]
        folds = [Follower(column, column, *own) for column, own in self.folds.items()]
        return (*bends, *folds)


@dataclass(frozen=True, eq=False)
class Keys:
    """The keys of a weight animation.

    Attributes:
        times: (T',) seconds, each of them a number in single precision.
        values: (T', J + K), or (T', 3, J + K) for CUBICSPLINE: in-tangent, value and out-tangent,
            tangents a second as glTF has them. All are numbers in single precision.
        interpolation: STEP, LINEAR or CUBICSPLINE, as in the source.
        error: How far a vertex may be from where the sliders put it, between keys and by the
            rounding of the bends' weights, as a fraction of D.
    """

    times: NDArray[np.float64]
    values: NDArray[np.float64]
    interpolation: str
    error: float


def bent_keys(
    times: ArrayLike,
    values: ArrayLike,
    interpolation: str,
    columns: Columns,
    tolerance: float,
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

    Raises:
        ParameterError: Shapes do not fit, numbers are not finite, times do not rise, or the
            interpolation is none of glTF.
    """
    tolerance = as_number(tolerance, "the tolerance of keys", above=0)
    moments, given = _checked(times, values, interpolation, columns.count)
    if interpolation == "STEP":
        found, error = _rounded(columns.weights(given), columns)
        return Keys(moments, found, interpolation, error)
    pieces = _pieces(moments, given)
    added = added_keys(pieces, columns.followers, tolerance)
    seconds, sliders = _with_added(moments, given, pieces, added)
    error = max((own.error for own in added), default=0.0)
    if interpolation == "LINEAR":
        found, rounding = _rounded(columns.weights(sliders), columns)
    else:
        found, rounding = _rounded(_with_tangents(sliders, columns), columns, np.diff(seconds))
    return Keys(seconds, found, interpolation, error + rounding)


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


def _with_tangents(sliders: Floats, columns: Columns) -> Floats:
    """(T, 3, J + K) in-tangents, weights and out-tangents from (T, 3, J) of the sliders."""
    more = np.zeros((*sliders.shape[:2], len(columns.bends)))
    found = np.concatenate([sliders, more], axis=2)
    for own in columns.followers:
        at = sliders[:, 1, own.column]
        found[:, 0, own.place] += own.rates(at, sliders[:, 0, own.column], before=True)
        found[:, 1, own.place] += own.curve(at)
        found[:, 2, own.place] += own.rates(at, sliders[:, 2, own.column], before=False)
    return found


def _rounded(values: Floats, columns: Columns, spans: Floats | None = None) -> tuple[Floats, float]:
    """Values in single precision, and how far that moves a vertex by the weights that follow.

    A wrong tangent moves a cubic by at most 4/27 of it times the span.
    """
    found = _single(values)
    sizes = np.zeros(values.shape[-1])
    for own in columns.followers:
        sizes[own.place] = own.size
    off = np.abs(found - values) @ sizes
    if spans is None:
        return found, float(off.max(initial=0.0))
    between = 4 / 27 * spans * (off[:-1, 2] + off[1:, 0])
    return found, float(off[:, 1].max(initial=0.0) + between.max(initial=0.0))
