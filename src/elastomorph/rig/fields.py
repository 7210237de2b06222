"""The displacement fields of a rig: Δ and bends of each morph, only where they move anything."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import DTypeLike, NDArray

from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.morph import Morph

__all__ = ["MorphFields", "RigFields", "Span"]


# Vertices that stay still between two moved ones are cheaper to add as zeros than to skip, up to
# about this many.
_GAP = 512


@dataclass(frozen=True, eq=False)
class Span:
    """Fields on a run of consecutive vertices.

    Attributes:
        start: The first vertex.
        fields: (1 + K, N, 3) float64, C-contiguous, Δ first.
    """

    start: int
    fields: NDArray[np.float64]

    @property
    def vertices(self) -> slice:
        """The run."""
        return slice(self.start, self.start + self.fields.shape[1])


@dataclass(frozen=True, eq=False)
class MorphFields:
    """Δ and bends of one morph on the vertices they move.

    Attributes:
        count: 1 + K, number of fields.
        spans: The fields, on runs of vertices that hold all moved ones.
        bend_curves: K scalar curves.
    """

    count: int
    spans: tuple[Span, ...]
    bend_curves: tuple[BendCurve, ...]

    @classmethod
    def of(cls, morph: Morph) -> MorphFields:
        """The fields of a morph."""
        moves = morph.delta.any(axis=1)
        for bend in morph.bends:
            moves |= bend.any(axis=1)
        moved = np.flatnonzero(moves)
        cuts = np.flatnonzero(np.diff(moved) > _GAP) + 1
        spans = [
            Span(int(run[0]), np.concatenate([morph.delta[None, part], morph.bends[:, part]]))
            for run in np.split(moved, cuts)
            if run.size
            for part in [slice(int(run[0]), int(run[-1]) + 1)]
        ]
        return cls(1 + len(morph.bends), tuple(spans), morph.bend_curves)

    @property
    def moved(self) -> NDArray[np.int32]:
        """(N,) vertices on the spans, rising."""
        runs = [np.arange(s.vertices.start, s.vertices.stop, dtype=np.int32) for s in self.spans]
        return np.concatenate([np.zeros(0, dtype=np.int32), *runs])

    @property
    def fields(self) -> NDArray[np.float64]:
        """(1 + K, N, 3) the fields on these vertices."""
        return np.concatenate(
            [np.zeros((self.count, 0, 3)), *(s.fields for s in self.spans)], axis=1
        )

    def factors_at(self, time: float) -> list[float]:
        """1 + K numbers that the fields are multiplied with at one time."""
        return [time, *(curve.at(time) for curve in self.bend_curves)]

    def factors(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """(T, 1 + K) what each field is multiplied with at each time: t, b_1(t), …, b_K(t)."""
        return np.stack([times, *(curve(times) for curve in self.bend_curves)], axis=-1)

    def slopes(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """(T, 1 + K) the derivatives of the factors with respect to time."""
        ones = np.ones_like(times)
        return np.stack([ones, *(curve.slope(times) for curve in self.bend_curves)], axis=-1)

    def add_to(self, positions: NDArray[np.float64], factors: Iterable[float]) -> None:
        """Add the fields, each times its factor; zero factors cost nothing.

        Args:
            positions: (V, 3) float64, C-contiguous, changed in place.
            factors: 1 + K numbers.
        """
        from scipy.linalg.blas import daxpy

        flat, numbers = positions.reshape(-1), list(factors)
        for offset, rows in self._rows:
            for row, factor in zip(rows, numbers, strict=True):
                if factor:
                    # In place and without a temporary: several times faster than NumPy's +=.
                    daxpy(row, flat, row.size, factor, 0, 1, offset)

    @cached_property
    def _rows(self) -> list[tuple[int, list[NDArray[np.float64]]]]:
        """Of each span, its first coordinate and its fields flat."""
        return [(3 * s.start, [field.reshape(-1) for field in s.fields]) for s in self.spans]


@dataclass(frozen=True, eq=False)
class RigFields:
    """The fields of all morphs of a rig, as one matrix for products.

    Attributes:
        neutral: (V, 3) float64.
        morphs: The fields of each morph, in the order of the rig.
    """

    neutral: NDArray[np.float64]
    morphs: tuple[MorphFields, ...]

    @cached_property
    def starts(self) -> NDArray[np.int64]:
        """(J + 1,) row of the matrix where the fields of each morph start; row 0 is the neutral."""
        counts = [morph.count for morph in self.morphs]
        return np.concatenate([[1], 1 + np.cumsum(counts, dtype=np.int64)])

    def matrix(self, dtype: DTypeLike) -> NDArray[np.floating]:
        """(1 + F, 3V) the neutral and all fields, one a row."""
        rows = np.zeros((int(self.starts[-1]), *self.neutral.shape), dtype=dtype)
        rows[0] = self.neutral
        for start, morph in zip(self.starts, self.morphs, strict=False):
            for span in morph.spans:
                rows[start : start + morph.count, span.vertices] = span.fields
        return rows.reshape(len(rows), -1)
