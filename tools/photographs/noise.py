"""Random functions of space, the same for the same seed: values on a lattice, and spots.

A corner of the lattice gets its random number from three tables, one for each coordinate, whose
entries are joined by exclusive or: as good as random, and a gather a corner.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["Spots", "ValueNoise"]

Points = NDArray[np.float32]
Values = NDArray[np.float32]
_SIDE = 4096  # of the lattice before it repeats
_NUMBERS = 1 << 16


class _Lattice:
    """Corners of a turned lattice and the random number of each."""

    def __init__(self, seed: list[int], cell: float) -> None:
        self.random = np.random.default_rng(seed)
        self.tables = self.random.integers(_NUMBERS, size=(3, _SIDE))
        # Turned, so that no flat part of a face runs along a plane of corners.
        turn, _ = np.linalg.qr(self.random.normal(size=(3, 3)))
        self.turn = (turn / cell).astype(np.float32)

    def place(self, points: Points) -> tuple[NDArray[np.int64], Points]:
        """(3, n) the cell of each point, and (3, n) where in it."""
        turned = self.turn @ points.T
        whole = np.floor(turned)
        return whole.astype(np.int64) & (_SIDE - 1), turned - whole


class ValueNoise(_Lattice):
    """Smooth noise from -1 to 1: random values at the corners of cells, blended between.

    Args:
        seed: Entropy of the tables.
        cell: Length of a cell.
    """

    def __init__(self, seed: list[int], cell: float) -> None:
        super().__init__(seed, cell)
        self.values = self.random.uniform(-1, 1, _NUMBERS).astype(np.float32)

    def __call__(self, points: Points) -> Values:
        """(n,) values at points (n, 3)."""
        cell, inside = self.place(points)
        x, y, z = inside * inside * (3 - 2 * inside)
        near = [table.take(c) for table, c in zip(self.tables, cell, strict=True)]
        far = [
            table.take((c + 1) & (_SIDE - 1)) for table, c in zip(self.tables, cell, strict=True)
        ]
        slices = []
        for depth in (near[2], far[2]):
            rows = []
            for down in (near[1] ^ depth, far[1] ^ depth):
                left, right = self.values.take(near[0] ^ down), self.values.take(far[0] ^ down)
                rows.append(left + x * (right - left))
            slices.append(rows[0] + y * (rows[1] - rows[0]))
        found: Values = slices[0] + z * (slices[1] - slices[0])
        return found


class Spots(_Lattice):
    """Soft round spots, at most one in a cell and none across its walls; 0 to 1.

    Args:
        seed: Entropy of the tables.
        cell: Length of a cell; a spot reaches out to 0.2 to 0.4 of it.
        share: Of the cells that have one.
    """

    def __init__(self, seed: list[int], cell: float, share: float = 0.45) -> None:
        super().__init__(seed, cell)
        reach = self.random.uniform(0.2, 0.4, _NUMBERS)
        free = (0.5 - reach)[:, None] * self.random.uniform(-1, 1, (_NUMBERS, 3))
        self.middle = np.ascontiguousarray((0.5 + free).T).astype(np.float32)
        self.tightness = (6 / reach**2).astype(np.float32)  # e⁻⁶ where it ends
        depth = self.random.uniform(0.4, 1.0, _NUMBERS)
        self.depth = np.where(self.random.random(_NUMBERS) < share, depth, 0).astype(np.float32)

    def __call__(self, points: Points) -> Values:
        """(n,) darkness at points (n, 3)."""
        cell, inside = self.place(points)
        number = self.tables[0].take(cell[0])
        for table, c in zip(self.tables[1:], cell[1:], strict=True):
            number = number ^ table.take(c)
        squared = np.zeros(len(points), dtype=np.float32)
        for axis in range(3):
            squared += (inside[axis] - self.middle[axis].take(number)) ** 2
        found: Values = np.exp(-squared * self.tightness.take(number)) * self.depth.take(number)
        return found
