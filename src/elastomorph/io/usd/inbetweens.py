"""Where in-betweens belong: the piecewise linear path nearest to a curved one.

UsdSkel moves a vertex in straight pieces from one in-between to the next. The straight part tΔ of
a path V(t) = V₀ + tΔ + Σ_k b_k(t) D_k is straight between any in-betweens, so the deviation is

    e(t) = Σ_k (b_k - Πb_k)(t) · D_k        Π: linear between the weights of the in-betweens

and its largest length over all times and vertices is what a placement makes small.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.morph import Morph

_CELLS = 64
_CHECKS = 512
_MOST_BREAKS = 96
_CLOSEST = 1e-4
_BLOCK = 256


@dataclass(frozen=True, eq=False)
class Placement:
    """The in-betweens of one morph."""

    weights: NDArray[np.float64]  # (n,) float64 rising between 0 and 1, each a float32 value
    # Largest distance between the piecewise linear path and the curved one, as a fraction of
    # ``neutral.diameter``
    error: float
    straight_error: float  # The same without any in-between


def place_inbetweens(morph: Morph, *, tolerance: float, most: int) -> Placement:
    """The fewest in-betweens, and no more than ``most``, within a tolerance, a fraction of D.

    For each number of in-betweens the best weights on a grid are found: 1/64 apart, with the
    breaks of the bend curves added. The error is then measured at 512 times and those breaks.
    """
    fields = _moving(morph)
    if fields.size == 0:
        return Placement(np.zeros(0), 0.0, 0.0)
    scale = morph.neutral.diameter or 1.0
    breaks = _breaks(morph)
    grid = _grid(_CELLS, breaks)
    checks = np.union1d(_grid(_CHECKS, breaks), grid)
    weights = np.zeros(0)
    straight = error = deviation(morph, weights, checks) / scale
    search = _Search(grid, _bend_values(morph, grid), fields)
    for count in range(1, min(most, len(grid) - 2) + 1):
        if error <= tolerance:
            break
        tried = grid[search.best(count)]
        reached = deviation(morph, tried, checks) / scale
        if reached < error:
            weights, error = tried, reached
    return Placement(weights, error, straight)


def deviation(morph: Morph, weights: NDArray[np.float64], times: NDArray[np.float64]) -> float:
    """Largest distance, at some times, from a path to the straight pieces between in-betweens."""
    fields = _moving(morph)
    if fields.size == 0:
        return 0.0
    residual = _bend_values(morph, times) - _linear(times, weights, _bend_values(morph, weights))
    largest = 0.0
    for reach, part in _farthest_first(residual, fields):
        if reach <= largest:
            break
        largest = max(largest, float(_lengths(residual, fields[:, part]).max()))
    return largest


def _moving(morph: Morph) -> NDArray[np.float64]:
    """(K, N, 3) the bends of the vertices that they move."""
    return morph.bends[:, morph.bends.any(axis=(0, 2))]


class _Search:
    """Best placements on a grid, by dynamic programming over the few vertices that decide.

    A placement that is best for some vertices is a lower bound for all; the vertex that then
    deviates most joins them, until none outside deviates more.
    """

    def __init__(
        self, grid: NDArray[np.float64], values: NDArray[np.float64], fields: NDArray[np.float64]
    ) -> None:
        self._grid = grid
        self._values = values
        self._fields = fields
        self._decisive: set[int] = set()
        self._chords = np.zeros((len(grid), len(grid)))

    def best(self, count: int) -> NDArray[np.intp]:
        """(count,) grid points of the in-betweens, rising."""
        while True:
            chosen = _cheapest(self._chords, count)
            lengths, vertices = self._worst(chosen)
            joining = set(vertices[lengths > 0].tolist()) - self._decisive
            if not joining or int(vertices[lengths.argmax()]) in self._decisive:
                return chosen
            for vertex in joining:
                path = self._values @ self._fields[:, vertex]
                np.maximum(self._chords, _chord_errors(self._grid, path), out=self._chords)
            self._decisive |= joining

    def _worst(self, chosen: NDArray[np.intp]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Length and vertex of the largest deviation in each straight piece.

        Exact for the largest of all; of other pieces, the largest that was met on the way.
        """
        knots = self._grid[chosen]
        residual = self._values - _linear(self._grid, knots, self._values[chosen])
        piece = np.searchsorted(knots, self._grid, side="right")
        largest = np.zeros(len(chosen) + 1)
        where = np.zeros(len(chosen) + 1, dtype=np.int64)
        for reach, part in _farthest_first(residual, self._fields):
            if reach <= largest.max():
                break
            lengths = _lengths(residual, self._fields[:, part])
            vertex = lengths.argmax(axis=1)
            for i, j in enumerate(piece):
                if lengths[i, vertex[i]] > largest[j]:
                    largest[j], where[j] = lengths[i, vertex[i]], part[vertex[i]]
        return largest, where


def _cheapest(chords: NDArray[np.float64], count: int) -> NDArray[np.intp]:
    """The ``count`` inner grid points whose largest chord error is smallest."""
    reach = chords[0]
    origins = []
    for _ in range(count):
        through = np.maximum(reach[:, None], chords)
        # a chord must lead forward, and the first and last grid point are no in-betweens
        through[np.tril_indices(len(chords))] = np.inf
        through[0] = np.inf
        origins.append(through.argmin(axis=0))
        reach = through.min(axis=0)
    chosen = [len(chords) - 1]
    for origin in reversed(origins):
        chosen.append(int(origin[chosen[-1]]))
    return np.array(chosen[:0:-1], dtype=np.intp)


def _chord_errors(grid: NDArray[np.float64], path: NDArray[np.float64]) -> NDArray[np.float64]:
    """(G, G) largest distance of a (G, 3) path from its chord between two grid points."""
    errors = np.zeros((len(grid), len(grid)))
    for i in range(len(grid) - 2):
        ahead = grid[i + 1 :] - grid[i]
        slopes = (path[i + 1 :] - path[i]) / ahead[:, None]
        away = (path[i + 1 :] - path[i])[None] - ahead[None, :, None] * slopes[:, None]
        squares = np.tril(np.einsum("jmx,jmx->jm", away, away))
        errors[i, i + 1 :] = np.sqrt(squares.max(axis=1))
    return errors


def _breaks(morph: Morph) -> NDArray[np.float64]:
    inner = [curve.breaks[1:-1] for curve in morph.bend_curves]
    breaks = np.unique(np.concatenate(inner).astype(np.float32)).astype(np.float64)
    breaks = breaks[(breaks > _CLOSEST) & (breaks < 1 - _CLOSEST)]
    if len(breaks) > _MOST_BREAKS:
        breaks = breaks[np.linspace(0, len(breaks) - 1, _MOST_BREAKS).astype(np.intp)]
    return breaks


def _grid(cells: int, breaks: NDArray[np.float64]) -> NDArray[np.float64]:
    even = np.linspace(0.0, 1.0, cells + 1)
    if len(breaks):
        apart = np.abs(even[:, None] - breaks).min(axis=1) > _CLOSEST
        even = even[apart]
    return np.union1d(even, breaks)


def _bend_values(morph: Morph, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """(T, K) value of each bend curve."""
    columns = [curve(times) for curve in morph.bend_curves]
    return np.stack(columns, axis=1) if columns else np.zeros((len(times), 0))


def _linear(
    times: NDArray[np.float64], knots: NDArray[np.float64], values: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(T, K) straight from 0 at 0 through the (n, K) values at the knots to 0 at 1."""
    places = np.concatenate([[0.0], knots, [1.0]])
    columns = [
        np.interp(times, places, np.concatenate([[0.0], column, [0.0]])) for column in values.T
    ]
    return np.stack(columns, axis=1) if columns else np.zeros((len(times), 0))


def _lengths(residual: NDArray[np.float64], fields: NDArray[np.float64]) -> NDArray[np.float64]:
    """(T, N) lengths of residual (T, K) times fields (K, N, 3)."""
    away = (residual @ fields.reshape(len(fields), -1)).reshape(len(residual), -1, 3)
    return np.asarray(np.sqrt(np.einsum("tni,tni->tn", away, away)))


def _farthest_first(
    residual: NDArray[np.float64], fields: NDArray[np.float64]
) -> Iterator[tuple[float, NDArray[np.intp]]]:
    """Blocks of vertices, those that can deviate most first, and a bound of how much they can."""
    reach = np.abs(residual).max(axis=0) @ np.linalg.norm(fields, axis=2)
    order = np.argsort(-reach)
    for start in range(0, len(order), _BLOCK):
        part = order[start : start + _BLOCK]
        yield float(reach[part[0]]), part
