"""A take of markers: named points in motion, as they were recorded."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.numbers import first_few

_SHOWN = 12


@dataclass(frozen=True, eq=False, repr=False)
class Markers:
    """Named points in motion, where the head was and with gaps.

    Attributes:
        names: M names; several markers may have one.
        frames: (T, M, 3) float64 positions, NaN where a marker is missing.
        times: (T,) float64 seconds that rise, where the file says them.
        vertices: M vertices of a rig on which they are, where the file says them.
        unit: Of the positions, where the file says it, such as ``mm``.
    """

    names: tuple[str, ...]
    frames: NDArray[np.float64]
    times: NDArray[np.float64] | None = None
    vertices: tuple[int, ...] | None = None
    unit: str | None = None

    def of(self, names: Iterable[str]) -> NDArray[np.float64]:
        """(T, N, 3) positions of the markers with these names, in their order.

        Raises:
            ParameterError: No marker, or more than one, has a name.
        """
        return self.frames[:, self.columns(names)]

    def columns(self, names: Iterable[str]) -> list[int]:
        """Which markers have these names, as `of` finds them."""
        if isinstance(names, str) or not isinstance(names, Iterable):
            raise ParameterError(f"names of markers are a list of texts, found {names!r:.60}")
        often, known = Counter(self.names), {name: i for i, name in enumerate(self.names)}
        columns = []
        for name in names:
            if often[name] != 1:
                problem = "no marker is" if name not in known else f"{often[name]} markers are"
                raise ParameterError(f"{problem} called {name!r}; there are {self.listed()}")
            columns.append(known[name])
        return columns

    def listed(self) -> str:
        """Names of the markers, the first of many."""
        return first_few((f"{name:.40}" for name in self.names), _SHOWN)

    def __len__(self) -> int:
        return len(self.frames)

    def __repr__(self) -> str:
        missing = np.isnan(self.frames).any(axis=2).mean() if self.frames.size else 0.0
        return f"Markers({len(self):,} frames of {len(self.names)}, {missing:.1%} missing)"
