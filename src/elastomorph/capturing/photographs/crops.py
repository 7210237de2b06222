"""The part of a photograph that shows the head, as fine as is asked for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.camera import View

Points = NDArray[np.float64]

# Pixels around the head that are kept, and the least that the head itself has to have.
_BORDER, _LEAST = 24, 32


def cropped(view: View, points: Points) -> View | None:
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
    return View(camera, view.grey[part].copy(), mask)


def no_finer(view: View, density: float, middle: Points) -> View:
    """A photograph with no more than `density` pixels to a unit of length at (3,) the middle."""
    away = float(np.linalg.norm(middle - view.camera.position))
    factor = density * away / view.camera.focal
    return view if factor > 0.95 else view.scaled(factor)
