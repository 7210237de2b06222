"""Images on surfaces in linear light, at the size at which a picture shows them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.dressed import Dress
from elastomorph.draw.textures import encoded, linear

__all__ = ["Texels"]

Colours = NDArray[np.float32]
Bytes = NDArray[np.uint8]

_LINEAR = linear(np.arange(256) / 255).astype(np.float32)
_COARSEST = 4
_FINEST = 4
"""Texels of an image for one pixel of a picture, a side; what is finer is not kept."""


@dataclass(frozen=True, eq=False)
class Texels:
    """An image and its halves, quarters …: (H, W, 4) sRGB, opacity last.

    A texel shown by many pixels is mixed with those beside it; many shown by one are averaged
    first, in the level whose texels are about as large as pixels.
    """

    levels: tuple[Bytes, ...]
    wrap: str
    smooth: bool

    @classmethod
    def of(cls, dress: Dress, pixels: int) -> Texels | None:
        """Those of the image of a dress, if it has one, for pictures with such sides."""
        if dress.image is None:
            return None
        rows, columns = dress.image.shape[:2]
        image = np.full((rows, columns, 4), 255, dtype=np.uint8)
        image[..., : dress.image.shape[2]] = dress.image
        levels = [image]
        while dress.smooth and min(levels[-1].shape[:2]) >= 2 * _COARSEST:
            levels.append(_halved(levels[-1]))
        fit = [own for own in levels if max(own.shape) <= _FINEST * pixels]
        return cls(tuple(fit or levels[-1:]), dress.wrap, dress.smooth)

    def level(self, texels_a_pixel: float) -> int:
        """Which level to show, from how many texels of the whole image a pixel covers."""
        halvings = np.log2(max(texels_a_pixel, 1e-9)) / 2
        return int(np.clip(np.rint(halvings), 0, len(self.levels) - 1))

    def at(self, places: NDArray[np.floating], level: int = 0) -> Colours:
        """(N, 4) linear colours and opacity at (N, 2) places, the first row of the image at 0."""
        image = self.levels[level]
        rows, columns = image.shape[:2]
        x = places[:, 0].astype(np.float64) * columns - 0.5
        y = places[:, 1].astype(np.float64) * rows - 0.5
        if not self.smooth:
            x, y = np.rint(x), np.rint(y)
        total = np.zeros((len(places), 4), dtype=np.float32)
        for column, across in _beside(x):
            for row, up in _beside(y):
                share = (across * up).astype(np.float32)
                taken = image[self._wrapped(row, rows), self._wrapped(column, columns)]
                total[:, :3] += share[:, None] * _LINEAR[taken[:, :3]]
                total[:, 3] += share * (taken[:, 3] / np.float32(255))
        return total

    def _wrapped(self, index: NDArray[np.int64], count: int) -> NDArray[np.int64]:
        if self.wrap == "clamp":
            return np.clip(index, 0, count - 1)
        if self.wrap == "repeat":
            return index % count
        there = index % (2 * count)
        return np.minimum(there, 2 * count - 1 - there)


def _beside(
    along: NDArray[np.float64],
) -> list[tuple[NDArray[np.int64], NDArray[np.float64]]]:
    """The texels before and after places, and their shares."""
    before = np.floor(along)
    part = along - before
    texel = before.astype(np.int64)
    return [(texel, 1 - part), (texel + 1, part)]


def _halved(image: Bytes) -> Bytes:
    """Means of four, of light; colours count as much as they are seen."""
    even = image[: image.shape[0] // 2 * 2, : image.shape[1] // 2 * 2]
    quarters = [even[row::2, column::2] for row in (0, 1) for column in (0, 1)]
    weights = [np.maximum(own[..., 3:], np.float32(0.1)) for own in quarters]
    light = sum(_LINEAR[own[..., :3]] * w for own, w in zip(quarters, weights, strict=True))
    opacity = sum(own[..., 3:].astype(np.float32) for own in quarters) / 4
    shown = encoded(np.asarray(light / sum(weights))) * 255
    codes = np.rint(np.concatenate([shown, opacity], axis=2)).astype(np.uint8)
    return np.asarray(codes)
