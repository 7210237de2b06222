"""The ways to store one path: with no bend, one, two and so on, each with the error it leaves.

A path V₀ + tΔ + Σ_k b_k(t) D_k can often do with fewer bends than it came with. Its bent part is
a matrix, times by coordinates; of its singular vectors the first r are the r bends that leave the
least (in least squares), with curves that are sums of the b_k. They are what is stored where they
are fewer; otherwise the bends stay what they were.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.morph import Morph
from elastomorph.paths.bake import largest_sum

__all__ = ["Way", "farthest", "ways"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Way:
    """A path as it may be stored, less its straight part."""

    bends: Floats  # (K, V, 3)
    curves: tuple[BendCurve, ...]
    fold: BendCurve | None  # Added to the weight of Δ
    error: float  # Distance from the path at most, in the unit of the vertices

    def within(self, tolerance: float) -> Way:
        """The same, zero where that moves no vertex farther from the path than the tolerance.

        At each vertex the bends that move it least are left out, as many as there is room for.
        """
        if not len(self.bends):
            return self
        peaks = np.array([curve.height for curve in self.curves])
        moves = peaks[:, None] * np.linalg.norm(self.bends, axis=2)
        order = np.argsort(moves, axis=0)
        lost = self.error + np.cumsum(np.take_along_axis(moves, order, axis=0), axis=0)
        small = np.empty(moves.shape, dtype=bool)
        np.put_along_axis(small, order, lost <= tolerance, axis=0)
        small |= moves == 0
        error = self.error + float(np.where(small, moves, 0.0).sum(axis=0).max())
        left: NDArray[np.bool_] = np.asarray(~small.all(axis=1))
        curves = tuple(curve for curve, some in zip(self.curves, left, strict=True) if some)
        bends = np.where(small[left, :, None], 0.0, self.bends[left])
        return Way(bends, curves, self.fold, error)


def farthest(curves: tuple[BendCurve, ...], bends: Floats) -> float:
    """The largest |Σ_k b_k(t) D_k| of (K, V, 3) bends, over all vertices and all t in [0, 1].

    Every piece of degree n is sampled at 32n + 1 Chebyshev points, which no polynomial exceeds
    between them by more than 1/cos(π/64) - 1 = 0.12 %: so much too small it may be.
    """
    moved = bends.any(axis=(0, 2)) if len(bends) else np.zeros(0, dtype=bool)
    if not moved.any():
        return 0.0
    bends = bends[:, moved]
    breaks = np.unique(np.concatenate([curve.breaks for curve in curves]))
    points = 32 * max(1, *(curve.coefficients.shape[1] - 1 for curve in curves))
    part = (1 - np.cos(np.pi * np.arange(points + 1) / points)) / 2
    times = np.unique(breaks[:-1] + part[:, None] * np.diff(breaks))
    rows = np.stack([curve(times) for curve in curves], axis=1)
    return largest_sum(rows, bends, np.linalg.norm(bends, axis=2))


def ways(morph: Morph, tolerance: float, *, fold: bool) -> list[Way]:
    """The ways to store a path by the number of their bends, up to what is within a tolerance.

    The tolerance is in the unit of the vertices. With `fold` what the bends have in common with Δ
    goes into the weight of Δ itself where that saves a bend.
    """
    plain = _fewest(morph.bend_curves, morph.bends, None, tolerance)
    size = float(np.einsum("vi,vi->", morph.delta, morph.delta))
    if not fold or len(plain) == 1 or not size:
        return plain
    share = np.einsum("kvi,vi->k", morph.bends, morph.delta) / size
    rest = morph.bends - share[:, None, None] * morph.delta
    folded = _fewest(morph.bend_curves, rest, combined(morph.bend_curves, share), tolerance)
    return folded if len(folded) < len(plain) else plain


def _fewest(
    curves: tuple[BendCurve, ...], bends: Floats, fold: BendCurve | None, tolerance: float
) -> list[Way]:
    found = [Way(bends[:0], (), fold, farthest(curves, bends))]
    if found[0].error <= tolerance:
        return found
    whole = Way(bends, curves, fold, 0.0)
    count = len(whole.within(tolerance).bends)
    parts = _Parts.of(curves, bends)
    for number in range(1, min(count, len(parts.curves) + 1)):
        way = parts.first(number, fold)
        found.append(way)
        # The other half is for what moves next to nothing, without which files are smaller.
        if way.error <= tolerance / 2 and (parts.positive or not _positive(curves)):
            return found
    return [*found, whole]


@dataclass(frozen=True, eq=False)
class _Parts:
    """The bent part of a path as a sum of products, curve by bend, the most of it first."""

    curves: tuple[BendCurve, ...]
    bends: Floats  # (R, V, 3)
    positive: bool  # Whether sums of the curves can be made positive, see `first`

    @classmethod
    def of(cls, curves: tuple[BendCurve, ...], bends: Floats) -> _Parts:
        moved = bends.any(axis=(0, 2))
        flat = bends[:, moved].reshape(len(bends), -1)
        breaks = np.unique(np.concatenate([curve.breaks for curve in curves]))
        nodes, weights = np.polynomial.legendre.leggauss(
            max(curve.coefficients.shape[1] for curve in curves)
        )
        spans = np.diff(breaks)
        times = (breaks[:-1] + (nodes[:, None] + 1) / 2 * spans).ravel()
        roots = np.sqrt(weights[:, None] / 2 * spans).ravel()
        rows = roots[:, None] * np.stack([curve(times) for curve in curves], axis=1)
        _, sizes, fields = np.linalg.svd(np.linalg.qr(rows, mode="r") @ flat, full_matrices=False)
        some = sizes > 1e-12 * sizes[0]
        sizes, fields = sizes[some], fields[some]
        shares = flat @ fields.T / sizes  # of each new curve in each bend curve
        scaled, found = [], np.zeros((len(sizes), *bends.shape[1:]))
        for share, size, field, bend in zip(shares.T, sizes, fields, found, strict=True):
            curve = combined(curves, share)
            peak = curve.peak[1]
            scaled.append(combined((curve,), np.array([1 / peak])))
            bend[moved] = (peak * size * field).reshape(-1, 3)
        first = _over_arch(scaled[0])
        return cls(tuple(scaled), found, bool(first.min() > _LEAST * first.max()))

    def first(self, number: int, fold: BendCurve | None) -> Way:
        """The way with that many bends.

        All curves but the first swing to both sides. So much of the first is added to them, and
        of their bends taken from its own, that none is negative.
        """
        error = farthest(self.curves[number:], self.bends[number:])
        curves, bends = list(self.curves[:number]), self.bends[:number].copy()
        for k in range(1, number if self.positive else 0):
            ratio = _over_arch(curves[k]) / _over_arch(curves[0])
            more = 1.01 * max(0.0, float(-ratio.min()))
            curve = combined((curves[k], curves[0]), np.array([1.0, more]))
            bends[0] -= more * bends[k]
            peak = curve.peak[1]
            curves[k] = combined((curve,), np.array([1 / peak]))
            bends[k] *= peak
        return Way(bends, tuple(curves), fold, error)


# How much of its largest value a curve over t(1 - t) must have everywhere to be called positive.
_LEAST = 0.02


def _over_arch(curve: BendCurve) -> Floats:
    """(N,) values of b(t) over t(1 - t): 0 and negative where b is."""
    times = curve.times_within(101)[1:-1].ravel()
    times = times[(times > 0) & (times < 1)]
    return np.asarray(curve(times) / (times * (1 - times)))


def _positive(curves: tuple[BendCurve, ...]) -> bool:
    return all(float(curve(curve.times_within(65)).min()) >= -1e-9 for curve in curves)


def combined(curves: tuple[BendCurve, ...], weights: Floats) -> BendCurve:
    """The curve Σ_k w_k b_k."""
    breaks = np.unique(np.concatenate([curve.breaks for curve in curves]))
    terms = max(curve.coefficients.shape[1] for curve in curves)
    rows = np.zeros((len(breaks) - 1, terms))
    for curve, weight in zip(curves, weights, strict=True):
        rows += weight * _over(curve, breaks, terms)
    return BendCurve(breaks, rows)


def _over(curve: BendCurve, breaks: Floats, terms: int) -> Floats:
    """(S, terms) coefficients of a curve in the pieces of finer breaks."""
    pieces = np.searchsorted(curve.breaks, breaks[:-1], side="right") - 1
    steps = breaks[:-1] - curve.breaks[pieces]
    rows = np.zeros((len(pieces), terms))
    rows[:, : curve.coefficients.shape[1]] = curve.coefficients[pieces]
    # Horner's scheme, once for each derivative: a Taylor shift.
    for first in range(terms - 1):
        for column in range(terms - 2, first - 1, -1):
            rows[:, column] += steps * rows[:, column + 1]
    return rows
