"""The part of a photograph that shows the head, as fine as is asked for."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.camera import Camera, View

Points = NDArray[np.float64]

# Pixels around the head that are kept, and the least that the head itself has to have.
_BORDER, _LEAST = 24, 32


@dataclass(frozen=True, eq=False)
class Crop:
    """Part of a photograph without distortion.

    Attributes:
        camera: that would have taken this part alone.
        grey: (H, W) uint8.
        mask: (H, W) what may be used; None: all of it.
    """

    camera: Camera
    grey: NDArray[np.uint8]
    mask: NDArray[np.bool_] | None

    @classmethod
    def of(cls, view: View, points: Points) -> Crop | None:
        """What a photograph shows of (N, 3) points and a little around; None: next to nothing."""
        pixels, depths = view.camera.project(points)
        pixels = pixels[depths > 0]
        if not len(pixels):
            return None
        start, stop = np.floor(pixels.min(axis=0)), np.ceil(pixels.max(axis=0)) + 1
        if (np.minimum(stop, view.camera.size) - np.maximum(start, 0) < _LEAST).any():
            return None
        low = np.maximum(start - _BORDER, 0).astype(int)
        high = np.minimum(stop + _BORDER, view.camera.size).astype(int)
        width, height = (int(side) for side in high - low)
        part = np.s_[low[1] : high[1], low[0] : high[0]]
        camera = replace(view.camera, size=(width, height), centre=view.camera.centre - low)
        # Copies, so that the photograph itself need not stay in memory.
        mask = None if view.mask is None else view.mask[part].copy()
        return cls(camera, view.grey[part].copy(), mask)

    def finest(self, density: float, middle: Points) -> Crop:
        """It with no more than `density` pixels to a unit of length at (3,) the middle."""
        import cv2

        factor = density * float(np.linalg.norm(middle - self.camera.position)) / self.camera.focal
        if factor > 0.95:
            return self
        camera = self.camera.scaled(factor)
        grey: Any = cv2.resize(self.grey, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
        mask = self.mask
        if mask is not None:
            size = camera.size
            mask = cv2.resize(mask.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0
        return Crop(camera, np.asarray(grey), mask)
