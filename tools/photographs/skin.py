"""What a point of the head looks like: its colour, fixed to the surface, and how it shines.

Everything is a function of where the point is in the neutral, so that it moves with the surface.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from photographs.noise import Spots, ValueNoise

__all__ = ["EYE", "GUMS", "IRIS", "PUPIL", "SKIN", "TEETH", "Skin"]

SKIN, EYE, IRIS, PUPIL, TEETH, GUMS = range(6)
# Colour in linear light and how much each shines; teeth and eyes have hardly any texture.
_PLAIN = {
    EYE: ((0.84, 0.82, 0.80), 0.40),
    IRIS: ((0.30, 0.20, 0.12), 0.45),
    PUPIL: ((0.03, 0.03, 0.03), 0.50),
    TEETH: ((0.85, 0.82, 0.74), 0.30),
    GUMS: ((0.55, 0.25, 0.25), 0.25),
}
_SKIN = np.array([0.78, 0.58, 0.49], dtype=np.float32)
_SKIN_SHINE = 0.10
_LIPS = np.array([0.80, 0.58, 0.60], dtype=np.float32)  # what they leave of the skin's colour
_BROWS = np.array([0.42, 0.36, 0.33], dtype=np.float32)
# Length of a cell in cm and strength: blotches whatever the texture; then what matching lives on,
# from patches of red down to pores.
_BLOTCHES = (2.5, 0.10)
_GRAIN = ((0.8, 0.07), (0.28, 0.07), (0.11, 0.08), (0.06, 0.05))
_FRECKLES = (0.62, 0.55, 0.47)  # cells in cm
_FRECKLE = 0.35


@dataclass(frozen=True)
class Skin:
    """Skin of a person.

    Attributes:
        seed: Another seed is another person's skin.
        strength: Of grain and freckles; 1 is skin in good light, 0 none: only blotches.
    """

    seed: int = 0
    strength: float = 1.0

    def colours(
        self,
        rest: NDArray[np.float32],
        material: NDArray[np.int8],
        tints: NDArray[np.float32],
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """(n, 3) colour in linear light and (n,) shine of points.

        Args:
            rest: (n, 3) where each point is in the neutral, in cm.
            material: (n,) SKIN, EYE, …
            tints: (n, 2) how much it is lip and brow, from 0 to 1.
        """
        colour = np.empty((len(rest), 3), dtype=np.float32)
        shine = np.empty(len(rest), dtype=np.float32)
        for kind in np.flatnonzero(np.bincount(material)):
            own = np.flatnonzero(material == kind)
            if kind == SKIN:
                colour[own], shine[own] = self._skin(rest[own], tints[own])
            else:
                colour[own] = self._plain(rest[own], int(kind))
                shine[own] = _PLAIN[int(kind)][1]
        return colour, shine

    def _skin(
        self, rest: NDArray[np.float32], tints: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        grain, freckles = _textures(self.seed)
        tone = _BLOTCHES[1] * grain[0](rest)
        dark = np.zeros(len(rest), dtype=np.float32)
        if self.strength:
            for noise, (_, strength) in zip(grain[1:], _GRAIN, strict=True):
                tone += np.float32(self.strength * strength) * noise(rest)
            for spots in freckles:
                dark += spots(rest)
            dark = np.float32(self.strength * _FRECKLE) * np.minimum(dark, 1)
        tone = tone[:, None] * np.array([0.7, 1.0, 1.1], dtype=np.float32)
        dark = dark[:, None] * np.array([0.7, 1.0, 1.1], dtype=np.float32)
        lip, brow = tints[:, :1], tints[:, 1:]
        base = _SKIN * (1 - lip * (1 - _LIPS)) * (1 - brow * (1 - _BROWS))
        return base * (1 + tone) * (1 - dark), _SKIN_SHINE + 0.1 * lip[:, 0]

    def _plain(self, rest: NDArray[np.float32], kind: int) -> NDArray[np.float32]:
        colour = np.array(_PLAIN[kind][0], dtype=np.float32)
        if kind not in (IRIS, GUMS):
            return np.broadcast_to(colour, rest.shape)
        veins = _veins(self.seed, 0.1 if kind == IRIS else 0.3)
        return colour + np.float32(0.09) * veins(rest)[:, None]


@cache
def _textures(seed: int) -> tuple[tuple[ValueNoise, ...], tuple[Spots, ...]]:
    cells = [_BLOTCHES[0], *(cell for cell, _ in _GRAIN)]
    grain = tuple(ValueNoise([seed, 1, number], cell) for number, cell in enumerate(cells))
    return grain, tuple(Spots([seed, 2, number], cell) for number, cell in enumerate(_FRECKLES))


@cache
def _veins(seed: int, cell: float) -> ValueNoise:
    return ValueNoise([seed, 3], cell)
