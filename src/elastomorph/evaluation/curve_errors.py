"""The error of the paper: how far the vertices of every curve are from where they were captured.

At the captured times by `curve_errors`, or with `free_timing`: there every captured frame picks its
own moment of a path, in order. The moments make the largest error as small as any order of moments
can, the very error that tables show. What is left of it is the fault of the path; what vanishes was
timing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import CurveError, MeshError, ParameterError
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence


class HasVertices(Protocol):
    """Anything with the vertex indices of a curve, in order."""

    @property
    def vertices(self) -> NDArray[np.integer]:
        """(M,) vertex indices."""


@dataclass(frozen=True, eq=False)
class CurveVertices:
    """The vertices of all curves one after another, so that all curves are measured at once."""

    indices: NDArray[np.int64]  # (N,) int64 vertex indices
    starts: NDArray[np.int64]  # (C,) int64, where each curve starts in ``indices``
    counts: NDArray[np.int64]  # (C,) int64 vertices of each curve

    @classmethod
    def of(cls, curves: Iterable[HasVertices], vertex_count: int) -> CurveVertices:
        """Flatten curves of a mesh with ``vertex_count`` vertices."""
        parts = [np.asarray(curve.vertices, dtype=np.int64) for curve in curves]
        counts = np.array([part.size for part in parts], dtype=np.int64)
        if counts.size == 0 or counts.min() == 0:
            raise CurveError(
                "errors are measured along curves, but there is none: give curves=… "
                "(a mesh without polygons has no edges to trace them along)"
                if counts.size == 0
                else f"curve {int(counts.argmin())} has no vertices"
            )
        indices = np.concatenate(parts)
        if indices.min() < 0 or indices.max() >= vertex_count:
            raise CurveError(
                f"the curves name vertices {indices.min()} to {indices.max()}, but the mesh has "
                f"{vertex_count:,} vertices (0 to {vertex_count - 1:,})"
            )
        return cls(indices, np.cumsum(counts) - counts, counts)


def curve_errors(
    positions: NDArray[np.float64],
    captured: NDArray[np.float64],
    curves: CurveVertices,
    diameter: float,
    counted: NDArray[np.bool_] | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """E_A and E_M, (C,) fractions of D, of curves at one time (Eq. 35, with the norm it lacks).

        E_A = 1/M Σ_m ‖w̄_m - w_m‖ / D        E_M = max_m ‖w̄_m - w_m‖ / D

    w̄ are (V, 3) vertices as interpolated, w as captured, in the unit of D. M are those vertices
    of the curve that are (V,) `counted`, all by default; of none both errors are 0.
    """
    if not diameter > 0:
        raise MeshError(
            "all vertices of the neutral are at one place, so its diameter D is 0 and errors "
            "cannot be given as a fraction of it"
        )
    offsets = positions[curves.indices] - captured[curves.indices]
    distances = np.sqrt(np.einsum("ni,ni->n", offsets, offsets)) / diameter
    counts = curves.counts
    if counted is not None:
        distances *= counted[curves.indices]
        counts = counts_of(counted[curves.indices], curves.starts)
    average = np.add.reduceat(distances, curves.starts) / counts
    return average, np.maximum.reduceat(distances, curves.starts)


def counts_of(counted: NDArray[np.bool_], starts: NDArray[np.integer]) -> NDArray[np.int64]:
    """(…, C) how many of (…, N) vertices of curves count, at least 1, to divide by."""
    found: NDArray[np.int64] = np.add.reduceat(counted.astype(np.int64), starts, axis=-1)
    return np.maximum(found, 1)


def frame_errors(
    path: Morph,
    truth: MeshSequence,
    moments: NDArray[np.float64],
    curves: CurveVertices,
    counted: NDArray[np.bool_] | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(T,) largest E_A and E_M over the curves in each frame, as fractions of D.

    Args:
        path: The in-betweens, of which one at a time is held.
        truth: T frames.
        moments: (T,) of the path that the frames are compared with.
        curves: The curves.
        counted: (T, V) which vertices count; all by default.
    """
    average, maximum = np.empty((2, len(truth)))
    for i, moment in enumerate(moments.tolist()):
        own = None if counted is None else counted[i]
        errors = curve_errors(path.at(moment), truth.frames[i], curves, truth.mesh.diameter, own)
        average[i], maximum[i] = (error.max() for error in errors)
    return average, maximum


class CurveErrors:
    """What tables show of errors along curves in T frames, as fractions of D."""

    average: NDArray[np.float64]  # (…, T) E_A
    maximum: NDArray[np.float64]  # (…, T) E_M

    @property
    def lme(self) -> float:
        """Largest maximum error over curves and times (Table 1)."""
        return float(self.maximum.max())

    @property
    def lae(self) -> float:
        """Largest average error over curves and times (Table 1)."""
        return float(self.average.max())

    @property
    def mean_lme(self) -> float:
        """Mean over the inner times of the largest maximum error over curves."""
        return inner_mean(self.maximum)

    @property
    def mean_lae(self) -> float:
        """Mean over the inner times of the largest average error over curves."""
        return inner_mean(self.average)


def inner_mean(errors: NDArray[np.float64]) -> float:
    """Mean over the inner times of the largest of all curves; 0 where there is no inner time."""
    inner = np.atleast_2d(errors)[:, 1:-1]
    return float(inner.max(axis=0).mean()) if inner.size else 0.0


_MEASURES = ("lme", "lae")
_GRID = 257
# Each round looks two spacings to either side in steps of an eighth: in a chain of ordered convex
# problems the exact optimum lies within one spacing of the best on the grid.
_ZOOM = 2.0 * np.linspace(-1.0, 1.0, 33)
_ZOOM_STEP = 1 / 8
_ROUNDS = 11
# As many vertices are looked at all at once; of more, those that turn out to be the worst.
_FEW = 256
_CHUNK = 2_000_000
# Sums of the same numbers in another order differ by less than this part.
_ROUNDING = 1e-12

_Costs = Callable[[NDArray[np.float64]], NDArray[np.float64]]


def free_timing(
    morph: Morph,
    truth: MeshSequence,
    along: CurveVertices,
    measure: str = "lme",
    counted: NDArray[np.bool_] | None = None,
) -> NDArray[np.float64]:
    """The non-decreasing times t′ at which a path comes closest to captured frames.

    Minimises the largest error over the frames, with 0 = t′_0 ≤ t′_1 ≤ … ≤ t′_{T-1} = 1; among the
    times that reach its minimum, those of the smallest mean over the frames. The first frame is
    the neutral and the last the target, so they stay. The recorded times are such times, so this
    error is never larger than at them; its mean over the frames may be.

    A dynamic program finds the best on a grid, globally; the same program on ever finer grids
    around it then moves the times to rounding accuracy. Of many vertices or curves only some
    *witnesses* are looked at. If others turn out to be worse at the times found, they become
    witnesses too, and the times are found again; when none is, the times are the best for all.

    Args:
        morph: The path.
        truth: The captured frames.
        along: The curves the error is measured along.
        measure: The error. ``lme``: the largest distance of a vertex. ``lae``: the largest mean
            distance of the vertices of a curve.
        counted: (T, V) which vertices count in which frames; all by default.

    Returns:
        (T,) float64 from 0 to 1. Where the path stands still any t′ is as good as another.

    Raises:
        ParameterError: The measure is unknown.
    """
    if measure not in _MEASURES:
        raise ParameterError(f"measure must be one of {', '.join(_MEASURES)}, found {measure!r}")
    times = np.array(truth.times)
    if len(times) == 2:
        return times
    gaps = _Gaps(morph, truth.frames, along, counted, averaged=measure == "lae")
    error, worst = gaps.largest(times[1:-1])
    best = (float(error.max()), float(error.sum()))
    witnesses = np.arange(gaps.groups) if len(along.indices) <= _FEW else np.unique(worst)
    while True:
        inner = _in_finer_steps(partial(gaps.costs, groups=witnesses), len(error))
        seen = gaps.costs(inner[:, None], witnesses)[:, 0]
        error, worst = gaps.largest(inner)
        found = (float(error.max()), float(error.sum()))
        if found < best:
            best, times[1:-1] = found, inner
        unseen = np.setdiff1d(worst[error > seen * (1 + _ROUNDING)], witnesses)
        if not len(unseen):
            return times
        witnesses = np.union1d(witnesses, unseen)


class _Gaps:
    """How far captured frames are from a path, by groups of vertices."""

    def __init__(
        self,
        morph: Morph,
        frames: NDArray[np.float64],
        along: CurveVertices,
        counted: NDArray[np.bool_] | None,
        *,
        averaged: bool,
    ) -> None:
        """Groups are curves if errors are averaged over them, else every vertex of a curve."""
        indices = along.indices if averaged else np.unique(along.indices)
        self._starts = along.starts if averaged else np.arange(len(indices))
        self._counts = along.counts if averaged else np.ones(len(indices), dtype=np.int64)
        self._curves = morph.bend_curves
        self._fields = np.concatenate([morph.delta[None, indices], morph.bends[:, indices]])
        self._wanted = frames[1:-1, indices] - morph.neutral.vertices[indices]
        # (T - 2, N) which vertices count, and (T - 2, G) how many of each group do.
        self._counted = None if counted is None else counted[1:-1, indices]
        self._divisors = np.broadcast_to(self._counts, (len(self._wanted), self.groups))
        if self._counted is not None:
            self._divisors = counts_of(self._counted, self._starts)

    @property
    def groups(self) -> int:
        """How many groups there are."""
        return len(self._starts)

    def costs(self, moments: NDArray[np.float64], groups: NDArray[np.int64]) -> NDArray[np.float64]:
        """(T - 2, G) largest error over some groups of each inner frame at (1 or T - 2, G)."""
        counts = self._counts[groups]
        bounds = np.cumsum(counts) - counts
        columns = np.arange(counts.sum()) + np.repeat(self._starts[groups] - bounds, counts)
        # Axis by axis, so that squares are summed over long rows.
        fields, wanted = (
            whole[:, columns].transpose(0, 2, 1).reshape(len(whole), -1)
            for whole in (self._fields, self._wanted)
        )
        weights = self._weights(moments)
        costs = np.empty((len(wanted), moments.shape[1]))
        step = max(1, _CHUNK // (costs.shape[1] * wanted.shape[1]))
        for first in range(0, len(wanted), step):
            rows = slice(first, first + step)
            away = weights[rows if len(weights) > 1 else slice(1)] @ fields - wanted[rows, None]
            np.square(away, out=away)
            distances = np.sqrt(away.reshape(*away.shape[:2], 3, -1).sum(axis=2))
            if self._counted is not None:
                distances *= self._counted[rows, None, columns]
            if len(columns) > len(groups):
                distances = np.add.reduceat(distances, bounds, axis=2)
                distances /= self._divisors[rows, None, groups]
            costs[rows] = distances.max(axis=2)
        return costs

    def largest(
        self, moments: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """(T - 2,) largest error of each inner frame at its moment, and the group that has it."""
        fields = self._fields.reshape(len(self._fields), -1)
        error, worst = np.empty(len(moments)), np.empty(len(moments), dtype=np.int64)
        for i, row in enumerate(self._weights(moments)):
            away = (row @ fields).reshape(-1, 3) - self._wanted[i]
            distances = np.sqrt(np.einsum("ni,ni->n", away, away))
            if self._counted is not None:
                distances *= self._counted[i]
            means = np.add.reduceat(distances, self._starts) / self._divisors[i]
            worst[i] = means.argmax()
            error[i] = means[worst[i]]
        return error, worst

    def _weights(self, moments: NDArray[np.float64]) -> NDArray[np.float64]:
        """(…, 1 + K) the weights t, b_1(t), …, b_K(t) of Δ and the bends."""
        return np.stack([moments, *(curve(moments) for curve in self._curves)], axis=-1)


def _in_finer_steps(costs: _Costs, count: int) -> NDArray[np.float64]:
    """(count,) moments in order of least largest cost, to rounding accuracy."""
    spacing = 1.0 / (_GRID - 1)
    grid = np.linspace(0.0, 1.0, _GRID)[None]
    inner = least_in_order(np.broadcast_to(grid, (count, _GRID)), costs(grid))
    for _ in range(_ROUNDS):
        moments = np.clip(inner[:, None] + spacing * _ZOOM, 0.0, 1.0)
        inner = least_in_order(moments, costs(moments))
        spacing *= _ZOOM_STEP
    return inner


def least_in_order(moments: NDArray[np.float64], costs: NDArray[np.float64]) -> NDArray[np.float64]:
    """(T,) one of (T, G) rising moments a frame, never falling, of least largest (T, G) cost.

    Of several such choices that of least total cost.
    """
    before = [
        np.searchsorted(earlier, later, side="right") - 1 for earlier, later in pairwise(moments)
    ]
    reached = costs[0]
    for here, cost in zip(before, costs[1:], strict=True):
        least = np.minimum.accumulate(reached)[here]
        reached = np.where(here >= 0, np.maximum(least, cost), np.inf)
    allowed = np.where(costs <= reached.min(), costs, np.inf)
    columns = np.arange(costs.shape[1])
    came_from = []
    total = allowed[0]
    for here, cost in zip(before, allowed[1:], strict=True):
        cheapest = np.minimum.accumulate(total)
        came_from.append(np.maximum.accumulate(np.where(total == cheapest, columns, 0))[here])
        total = np.where(here >= 0, cost + cheapest[here], np.inf)
    chosen = [int(total.argmin())]
    for origins in reversed(came_from):
        chosen.append(int(origins[chosen[-1]]))
    return moments[np.arange(len(moments)), chosen[::-1]]
