"""Curves and shapes that follow recorded frames, the worst place of them most of all.

What frames are off the straight path, R_t (N, 3) at time t, is to be a sum of products

    R_t ≈ α(t) F + Σ_k b_k(t) D_k

with the given shape F = Δ, or without, K shapes D_k that are free, and curves α and b_k that are
cubic splines, zero at both ends. Least squares have a closed form: on the splines, F is projected
out, and the D_k are singular vectors. From there the sum of the p-th powers of the errors, p rising
to 64, is made small by reweighted least squares (Lawson, 1961), shapes and curves in turn: first of
all vertices, then more and more of the worst. Errors are those of Eq. 35: of each vertex, and of
each curve of the face in the mean.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.blas_threads import one_blas_thread
from elastomorph.model.bend_curve import BendCurve

Floats = NDArray[np.float64]

_ROUNDS: tuple[tuple[int, int], ...] = (
    *((2, 2), (3, 3), (4, 4), (6, 6), (8, 6), (12, 8)),
    *((16, 8), (24, 8), (32, 8), (48, 8), (64, 8)),
)
_FROM_FEWER = _ROUNDS[4:]
_GOING_ON: tuple[tuple[int, int], ...] = ((32, 8), (64, 8))
_MENDING = ((4, 3), (16, 4), (64, 5))
"""Exponents p, and how many steps with each: of a path, of one that starts with fewer shapes, of
one that is close, of a vertex."""
_LEAST = 1e-2  # Errors below this part of the largest weigh like it
_RIDGE = 1e-10
_NOTHING = 1e-12
_TINY = float(np.finfo(np.float64).tiny)


@dataclass(frozen=True, eq=False)
class Splines:
    """Cubic splines that are zero at t = 0 and t = 1, on knots with equally many frames between."""

    knots: Floats  # Those of B-splines, the ends repeated
    degree: int
    values: Floats  # (T, M) of each of M splines at each time

    @classmethod
    def at(cls, times: Floats, knots: int) -> Splines:
        """Splines on as many inner knots, fewer where there are too few (T,) rising times.

        There are no more splines than times within (0, 1), if there is one.
        """
        from scipy.interpolate import BSpline

        inner = np.unique(times[(times > 0) & (times < 1)])
        degree = min(3, len(inner) + 1)
        count = min(knots, len(inner) + 1 - degree)
        every = np.concatenate([[0.0], inner, [1.0]])
        places = np.linspace(0, len(every) - 1, count + 2)[1:-1]
        middle = np.interp(places, np.arange(len(every)), every)
        ends = np.ones(degree + 1)
        own = np.concatenate([0 * ends, middle, ends])
        design = BSpline.design_matrix(np.clip(times, 0.0, 1.0), own, degree)
        return cls(own, degree, np.asarray(design.toarray()[:, 1:-1]))

    def curve(self, weights: Floats) -> BendCurve:
        """The curve of (M,) weights of the splines."""
        from scipy.interpolate import PPoly

        spline = (self.knots, np.concatenate([[0.0], weights, [0.0]]), self.degree)
        pieces = slice(self.degree, len(self.knots) - self.degree - 1)
        rows = np.asarray(PPoly.from_spline(spline).c)[::-1, pieces].T
        return BendCurve(self.knots[self.degree : len(self.knots) - self.degree], rows)


@dataclass(frozen=True, eq=False)
class Observed:
    """What the path is fitted to; lengths are fractions of D."""

    offsets: Floats  # (T, 3, N) how far each frame is off the straight path
    fixed: Floats | None  # (3, N) the shape F
    counted: Floats | None  # (T, N) 1 where a vertex counts in a frame, else 0; all by default
    means: Any  # (C, N) sparse, takes the mean over each curve of the face
    unit: Floats  # (T, 1) what errors of each frame are counted in

    @cached_property
    def straight(self) -> Floats:
        """(T, N) distances of the frames from the straight path."""
        return self._distances(np.einsum("txn,txn->tn", self.offsets, self.offsets))

    @cached_property
    def even(self) -> Floats:
        """(T, 1 or N) weights of squares at which all errors count alike."""
        return self.unit**-2 if self.counted is None else self.counted * self.unit**-2

    @cached_property
    def largest(self) -> float:
        """The largest error of the straight path."""
        return float(self.straight.max(initial=_TINY))

    @cached_property
    def average(self) -> float:
        """The largest mean error of a curve on the straight path."""
        return float(self._means(self.straight).max(initial=_TINY))

    def part(self, vertices: NDArray[np.int64]) -> Observed:
        """Some of the vertices, without the means over curves."""
        fixed = None if self.fixed is None else self.fixed[:, vertices]
        counted = None if self.counted is None else self.counted[:, vertices]
        return Observed(self.offsets[:, :, vertices], fixed, counted, None, self.unit)

    def recorded(self, frames: list[int]) -> Floats:
        """(S, 3, N) the offsets of some frames as shapes, F first."""
        offsets = self.offsets[frames]
        return offsets if self.fixed is None else np.concatenate([self.fixed[None], offsets])

    def errors(self, curves: Floats, shapes: Floats) -> Floats:
        """(T, N) distances from the path of (T, S) curves and (S, 3, N) shapes."""
        count = len(self.offsets)
        left = curves @ shapes.reshape(len(shapes), -1)
        left -= self.offsets.reshape(count, -1)
        np.square(left, out=left)
        return self._distances(left.reshape(count, 3, -1).sum(axis=1))

    def _distances(self, squares: Floats) -> Floats:
        """(T, N) errors from their squares."""
        distances: Floats = np.sqrt(squares)
        distances /= self.unit
        return distances if self.counted is None else distances * self.counted

    def score(self, errors: Floats) -> float:
        """The largest error, of a vertex or the mean of a curve, as a part of the straight one."""
        largest = errors.max(initial=0.0) / self.largest
        return float(max(largest, self._means(errors).max(initial=0.0) / self.average))

    def _means(self, errors: Floats) -> Floats:
        """(T, C) means over the curves of (T, N) errors."""
        return np.asarray((self.means @ errors.T).T)

    def weights(self, errors: Floats, power: float, score: float) -> Floats:
        """(T, N) weights of squares with which least squares go down the sum of p-th powers."""
        largest, average = score * self.largest, score * self.average
        means = self._means(errors) / average
        low = _LEAST * largest
        weights = (np.maximum(errors, low) / largest) ** (power - 2) / largest**2
        pulls = self.means.T @ (np.maximum(means, _LEAST) ** (power - 1)).T / average
        weights += pulls.T / np.maximum(errors, low)
        weights /= weights.mean()
        weights *= self.even
        return weights


@dataclass(frozen=True, eq=False)
class PathFit:
    """Curves and shapes found."""

    weights: Floats  # (M, S) of the splines in each curve; the first is α where there is an F
    shapes: Floats  # (S, 3, N), F first where there is one
    score: float  # The largest error, of a vertex or a mean, as a part of the straight path's
    largest: float  # The largest error of a vertex
    paced: bool  # Whether the first is F


# Many products of moderate size: threads of BLAS would wait for each other after every one.
@one_blas_thread()
def fitted(
    seen: Observed,
    splines: Splines,
    count: int,
    start: PathFit | None = None,
    shapes: Floats | None = None,
) -> PathFit:
    """The path with so many free shapes, or with (S, 3, N) shapes given; goes on from another.

    One with fewer shapes gets those that take the most from the squares that it leaves.
    """
    basis, free = splines.values, shapes is None
    rounds = _ROUNDS if start is None else _GOING_ON
    if start is not None:
        own, now = start.weights, start.shapes
        if (more := count + int(start.paced) - len(now)) > 0:
            rounds = _FROM_FEWER
            offsets = seen.offsets - np.tensordot(basis @ own, now, 1)
            left = replace(seen, offsets=offsets, fixed=None)
            added = _least_squares(left, basis, more)
            own = np.concatenate([own, added], axis=1)
            now = np.concatenate([now, shapes_for(left, basis @ added)])
    elif shapes is None:
        own = _least_squares(seen, basis, count)
        now = shapes_for(seen, basis @ own)
    else:
        own = _curves_for(seen, basis, shapes, seen.even * np.ones(seen.straight.shape))
        now = shapes
    best = PathFit(own, now, np.inf, np.inf, seen.fixed is not None)
    for power, steps in rounds:
        part = 1.0 / (power - 1)  # Newton's step; all of the way diverges
        for _ in range(steps):
            errors = seen.errors(basis @ own, now)
            score = seen.score(errors)
            if score < best.score:
                largest = float(errors.max(initial=0.0))
                best = PathFit(own, now, score, largest, best.paced)
            weights = seen.weights(errors, power, score)
            ahead = shapes_for(seen, basis @ own, weights) if free else now
            found = _curves_for(seen, basis, ahead, weights)
            if free:
                now = now + part * (shapes_for(seen, basis @ found, weights) - now)
            own = own + part * (found - own)
    return best


def unexplained(seen: Observed, basis: Floats | None, count: int) -> float:
    """The largest error that least squares leave: of splines (T, M), or of so many free shapes.

    Of vertices that count in every frame: what is missing would look like a shape of its own.
    """
    every = slice(None) if seen.counted is None else (seen.counted > 0).all(axis=0)
    rows = (seen.offsets[:, :, every] / seen.unit[:, None]).reshape(len(seen.offsets), -1)
    if basis is not None:
        span = np.linalg.qr(basis)[0]
    else:
        if seen.fixed is not None and seen.fixed[:, every].any():
            unit = seen.fixed[:, every].ravel() / np.linalg.norm(seen.fixed[:, every])
            rows = rows - np.outer(rows @ unit, unit)
        span = np.linalg.eigh(rows @ rows.T)[1][:, ::-1][:, :count]
    left = (rows - span @ (span.T @ rows)).reshape(len(rows), 3, -1)
    return float(np.linalg.norm(left, axis=1).max(initial=0.0))


def _least_squares(seen: Observed, basis: Floats, count: int) -> Floats:
    """(M, S) spline weights of the least sum of squares of all frames and vertices."""
    orthogonal, triangle = np.linalg.qr(basis / seen.unit)
    rows = orthogonal.T @ (seen.offsets.reshape(len(basis), -1) / seen.unit)
    own = []
    if seen.fixed is not None:
        unit = seen.fixed.ravel() / np.linalg.norm(seen.fixed)
        along = rows @ unit
        rows = rows - np.outer(along, unit)
        own.append(along / np.linalg.norm(seen.fixed))
    # The eigenvectors of a small matrix are the singular vectors of a long one.
    _, vectors = np.linalg.eigh(rows @ rows.T)
    own += list(vectors[:, ::-1].T[:count])
    return np.linalg.solve(triangle, np.stack(own, axis=1))


def shapes_for(seen: Observed, curves: Floats, weights: Floats | None = None) -> Floats:
    """(S, 3, N) the shapes that fit (T, S) curves best, F first; squares weigh (T, N)."""
    offsets, fixed = seen.offsets, seen.fixed
    count, size = len(offsets), offsets.shape[2]
    weights = seen.even if weights is None else weights
    first = int(fixed is not None)
    free = curves[:, first:]
    number = free.shape[1]
    if not number:
        return np.zeros((0, 3, size)) if fixed is None else fixed[None]
    weighted = weights[:, None] * offsets
    wanted = (free.T @ weighted.reshape(count, -1)).reshape(number, 3, size)
    squares = (free[:, :, None] * free[:, None]).reshape(count, -1)
    grams = (weights.T @ squares).reshape(-1, number, number)
    if fixed is not None:
        crossed = (free * curves[:, :1]).T @ weights
        wanted -= crossed[:, None] * fixed
    ridge = _RIDGE * np.trace(grams, axis1=1, axis2=2) + _TINY
    grams += ridge[:, None, None] * np.eye(number)
    found: Floats = np.asarray(np.linalg.solve(grams, wanted.transpose(2, 0, 1)), dtype=np.float64)
    found = found.transpose(1, 2, 0)
    return found if fixed is None else np.concatenate([fixed[None], found])


def _curves_for(seen: Observed, basis: Floats, shapes: Floats, weights: Floats) -> Floats:
    """(M, S) the spline weights that fit (S, 3, N) shapes best; squares weigh (T, N)."""
    number, count = len(shapes), len(basis)
    products = np.einsum("ixn,jxn->ijn", shapes, shapes).reshape(number * number, -1)
    grams = (weights @ products.T).reshape(count, number, number)
    weighted = (weights[:, None] * seen.offsets).reshape(count, -1)
    wanted = weighted @ shapes.reshape(number, -1).T
    system = np.einsum("ta,tij,tb->aibj", basis, grams, basis, optimize=True)
    size = basis.shape[1] * number
    system = system.reshape(size, size)
    scale = np.sqrt(np.diag(system))
    scale = np.maximum(scale, _NOTHING * scale.max()) + _TINY
    system = system / scale / scale[:, None] + _RIDGE * np.eye(size)
    found: Floats = np.linalg.solve(system, (basis.T @ wanted).ravel() / scale) / scale
    return found.reshape(-1, number)


def worst_mended(seen: Observed, curves: Floats, allowed: float) -> tuple[Floats, Floats]:
    """(S, 3, N) shapes for (T, S) curves, and (N,) the largest error each vertex is left with.

    Least squares; where that leaves more than what is allowed, the largest error is made small.
    """
    shapes = shapes_for(seen, curves)
    errors = seen.errors(curves, shapes)
    worst = errors.max(axis=0)
    bad = np.flatnonzero(worst > allowed)
    part = seen.part(bad)
    now, errors = shapes[:, :, bad], errors[:, bad]
    for power, steps in _MENDING if len(bad) else ():
        for _ in range(steps):
            high = errors.max(axis=0)
            weights = np.maximum(errors / high, _LEAST) ** (power - 2) * part.even
            now = now + (shapes_for(part, curves, weights) - now) / (power - 1)
            errors = part.errors(curves, now)
            better = errors.max(axis=0) < worst[bad]
            shapes[:, :, bad[better]] = now[:, :, better]
            worst[bad[better]] = errors.max(axis=0)[better]
    return shapes, worst
