"""What a face of a data set is made of: columns of numbers, each stored in 16 bits.

A column has a range. The code q stands for low + q (high - low)/65535, so nothing outside the
range can be said; where 0 lies within the range it is a code, so that a slider at rest is at rest
exactly.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import ParameterError
from elastomorph.numbers import as_numbers

LEVELS = 65535
"""The largest code."""

TIME = "t"
"""The name of the column of times."""

Codes = NDArray[np.uint16]


@dataclass(frozen=True)
class Column:
    """A number that each face has, such as the weight of a slider.

    Attributes:
        name: What it is.
        low: The value of the code 0.
        high: The value of the code 65535.

    Raises:
        ParameterError: The range is none.
    """

    name: str
    low: float = 0.0
    high: float = 1.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.high - self.low) and self.low <= self.high):
            raise ParameterError(
                f"the range of {self.name!r} must be two finite numbers, the lower first, found "
                f"{self.low:g} and {self.high:g}"
            )

    @classmethod
    def within(cls, name: str, low: float, high: float) -> Column:
        """The column of the largest range inside this one of which 0 is a code, if it is in it.

        The longer side of 0 stays as it is; the shorter has all whole steps that fit.
        """
        column = cls(name, float(low), float(high))
        if not column.low < 0 < column.high:
            return column
        longer = max(-column.low, column.high)
        shorter = min(-column.low, column.high)
        beyond = math.floor(shorter / (column.high - column.low) * LEVELS)
        short = beyond * (longer / (LEVELS - beyond))
        ends = (-short, longer) if longer == column.high else (-longer, short)
        return cls(name, ends[0] + 0.0, ends[1])

    @property
    def varies(self) -> bool:
        """Whether it has more than one value."""
        return self.low < self.high

    @property
    def rest(self) -> int:
        """The code of 0, or of what is nearest to it."""
        extent = self.high - self.low
        return round(min(max(-self.low / extent, 0.0), 1.0) * LEVELS) if extent > 0 else 0


@dataclass(frozen=True)
class Columns(Sequence[Column]):
    """The columns of a data set, in order: the sliders of the rig, then others.

    Attributes:
        columns: Each.
        whole: Which are weights of whole targets, as of the identity, wherever `t` is.
    """

    columns: tuple[Column, ...]
    whole: frozenset[int] = frozenset()

    def listed(self) -> list[list[Any]]:
        """[[name, low, high], …], to be kept beside the data."""
        return [[column.name, column.low, column.high] for column in self.columns]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Their names."""
        return tuple(column.name for column in self.columns)

    def times(self, values: NDArray[np.float64], sliders: int) -> NDArray[np.float64] | None:
        """The times of `Rig.batch` in (n, C) values: None, one a face, or one for each slider."""
        if TIME not in self.names:
            return None
        times: NDArray[np.float64] = values[:, self.names.index(TIME)]
        if self.whole:
            times = np.repeat(times[:, None], sliders, axis=1)
            times[:, sorted(self.whole)] = 1.0
        return times

    @cached_property
    def rest(self) -> Codes:
        """(C,) the code of each column that is 0, or nearest to it."""
        return np.array([column.rest for column in self.columns], dtype=np.uint16)

    def decode(self, codes: ArrayLike) -> NDArray[np.float64]:
        """(n, C) float64 from (n, C) codes.

        Raises:
            ParameterError: Another number of columns.
        """
        table = self._table(np.asarray(codes))
        values = table * self._extent
        values /= LEVELS
        values += self._low
        # Rounding must neither leave the range nor turn rest into 1e-17.
        np.minimum(values, self._high, out=values)
        for column in self._crossing:
            values[table[:, column] == self.rest[column], column] = 0.0
        return values

    def encode(self, values: ArrayLike) -> Codes:
        """(n, C) uint16 codes nearest to (n, C) values; values out of range become its ends.

        Raises:
            ParameterError: Another number of columns, or a value that is no number.
        """
        table = self._table(as_numbers(values, "values"))
        if np.isnan(table).any():
            row, column = np.argwhere(np.isnan(table))[0]
            raise ParameterError(f"{self.names[column]!r} of face {row} is no number")
        extent = np.where(self._extent > 0, self._extent, 1.0)
        scaled = (np.clip(table, self._low, self._high) - self._low) / extent * LEVELS
        codes: Codes = np.rint(scaled).astype(np.uint16)
        return codes

    def __getitem__(self, place: Any) -> Any:
        return self.columns[place]

    def __len__(self) -> int:
        return len(self.columns)

    @cached_property
    def _low(self) -> NDArray[np.float64]:
        return np.array([column.low for column in self.columns])

    @cached_property
    def _high(self) -> NDArray[np.float64]:
        return np.array([column.high for column in self.columns])

    @cached_property
    def _extent(self) -> NDArray[np.float64]:
        return self._high - self._low

    @cached_property
    def _crossing(self) -> list[int]:
        return [i for i, column in enumerate(self.columns) if column.low < 0 < column.high]

    def _table(self, table: NDArray[Any]) -> NDArray[Any]:
        if table.ndim != 2 or table.shape[1] != len(self):
            raise ParameterError(
                f"faces are rows of {len(self)} columns ({', '.join(self.names[:4])}, …), found "
                f"the shape {table.shape}"
            )
        return table
