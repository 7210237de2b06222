"""Values of pictures between their pixels, and pictures made ready for that."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]
Single = NDArray[np.float32]

# Blur of photographs before they are compared, in pixels.
_BLUR = 0.8


def pixel_grid(width: int, height: int) -> tuple[Single, Single]:
    """(H, W) the columns and (H, W) the rows of all pixels."""
    columns, rows = np.meshgrid(
        np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32)
    )
    return columns, rows


def sampled(picture: NDArray[Any], pixels: Points) -> NDArray[Any]:
    """(N,) or (N, C) values of a picture at (N, 2) pixels."""
    import cv2

    # A row of a picture made by `remap` has to be shorter than 2¹⁵.
    width = 1 << 12
    short = -len(pixels) % width
    where = np.pad(pixels.astype(np.float32), ((0, short), (0, 0)), constant_values=-9)
    grid = where.reshape(-1, width, 2)
    rows: Any = [
        cv2.remap(picture, part[..., 0], part[..., 1], cv2.INTER_LINEAR)
        for part in np.array_split(grid, len(grid) // 8192 + 1)
    ]
    found = np.concatenate(rows)
    return np.asarray(found.reshape(-1, *picture.shape[2:])[: len(pixels)])


def blurred(grey: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """A picture with less noise."""
    import cv2

    found: Any = cv2.GaussianBlur(grey, (0, 0), _BLUR)
    return np.asarray(found)


def prepared(grey: NDArray[np.uint8]) -> Single:
    """(H, W, 3) a photograph with less noise, and its changes along x and y."""
    import cv2

    smooth = blurred(grey).astype(np.float32)
    across: Any = cv2.Scharr(smooth, cv2.CV_32F, 1, 0, scale=1 / 32)
    down: Any = cv2.Scharr(smooth, cv2.CV_32F, 0, 1, scale=1 / 32)
    return np.dstack([smooth, across, down])
