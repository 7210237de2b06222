"""Frames of a performance on a rig, side by side."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.face_strip import face_strip
from elastomorph.draw.stage import Image
from elastomorph.rig import Rig
from elastomorph.rig.performance import Performance

__all__ = ["take_strip", "telling_frames"]


def take_strip(
    rig: Rig,
    performance: Performance,
    weights: NDArray[np.float64],
    path: str | Path | None = None,
    *,
    count: int = 5,
    face: tuple[int, int] = (300, 375),
) -> Image:
    """Draw frames that show what a take holds, in the order of time.

    Args:
        rig: The rig.
        performance: For the times, in seconds.
        weights: (T, J) of the rig's sliders in each frame.
        path: Picture to write, if any; the suffix chooses the format.
        count: How many frames.
        face: Width and height of one face in pixels.

    Returns:
        (H, W, 3) uint8.

    Raises:
        MissingExtraError: vtk, matplotlib or Pillow is not installed.
    """
    frames = telling_frames(weights, count)
    poses = rig.batch(weights[frames], dtype=np.float64).astype(np.float64)
    return face_strip({"": (rig.neutral, poses)}, performance.times[frames], path, face=face)


def telling_frames(weights: NDArray[np.float64], count: int) -> NDArray[np.int64]:
    """Frames that show what a take holds: the most active one, then always the least alike.

    Args:
        weights: (T, J) weights of the sliders.
        count: How many frames.

    Returns:
        (min(count, T),) frames in the order of time.
    """
    chosen = [int(np.abs(weights).sum(axis=1).argmax())]
    nearest = np.full(len(weights), np.inf)
    while len(chosen) < min(count, len(weights)):
        nearest = np.minimum(nearest, np.linalg.norm(weights - weights[chosen[-1]], axis=1))
        nearest[chosen] = -1.0
        chosen.append(int(nearest.argmax()))
    return np.sort(np.array(chosen, dtype=np.int64))
