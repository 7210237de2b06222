"""What is behind the head: a plain studio, or a room with things on its walls."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from photographs.lengths import lengths
from photographs.noise import ValueNoise

__all__ = ["BACKDROPS", "Backdrop"]

BACKDROPS = ("studio", "room")
_GREY = np.array([0.30, 0.32, 0.33], dtype=np.float32)
_WALL = 160.0  # cm from the middle of the room
_CELLS = ((40.0, 0.25), (9.0, 0.2), (2.5, 0.15))  # cm and strength


@dataclass(frozen=True)
class Backdrop:
    """A round room about the y axis.

    Attributes:
        kind: ``studio`` is grey, lighter at the top: nothing to match. ``room`` has a pattern that
            stays where it is when the head moves.
        seed: Of the pattern.
    """

    kind: str = "studio"
    seed: int = 0

    def colours(
        self, position: NDArray[np.float64], ways: NDArray[np.float32]
    ) -> NDArray[np.float32]:
        """(n, 3) linear light along ways (n, 3) from a position (3,) within the room."""
        flat = lengths(ways[:, ::2])
        rise = ways[:, 1] / np.maximum(lengths(ways), 1e-9)
        level = (0.95 + 0.35 * rise)[:, None]
        if self.kind == "studio":
            return level * _GREY
        start = position.astype(np.float32)
        along = ways[:, [0, 2]] @ start[[0, 2]]
        reach = (flat * _WALL) ** 2 - (ways[:, 0] * start[2] - ways[:, 2] * start[0]) ** 2
        length = (np.sqrt(np.maximum(reach, 0)) - along) / np.maximum(flat**2, 1e-6)
        points = start + length[:, None] * ways
        pattern = sum(
            s * noise(points) for (_, s), noise in zip(_CELLS, _walls(self.seed), strict=True)
        )
        return level * _GREY * (1 + np.asarray(pattern)[:, None])


@cache
def _walls(seed: int) -> tuple[ValueNoise, ...]:
    return tuple(ValueNoise([seed, 4, number], cell) for number, (cell, _) in enumerate(_CELLS))
