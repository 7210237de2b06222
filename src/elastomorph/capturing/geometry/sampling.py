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


# Two pictures compared: what has moved between them, and how alike they are.

Picture = NDArray[np.uint8]

# Pixels of the Gaussian in which pictures are correlated.
_WINDOW = 3.0


def flow_engine() -> Any:
    """OpenCV's dense inverse search (Kroeger et al., ECCV 2016), to the pixel and refined."""
    import cv2

    library: Any = cv2
    engine = library.DISOpticalFlow_create(library.DISOPTICAL_FLOW_PRESET_MEDIUM)
    engine.setFinestScale(0)
    engine.setVariationalRefinementIterations(3)
    return engine


def correlation(one: Picture, other: Picture) -> NDArray[np.float32]:
    """(H, W) how two pictures correlate around each pixel; noise alone is 0."""
    import cv2

    def mean(values: Any) -> Any:
        return cv2.GaussianBlur(values, (0, 0), _WINDOW)

    a, b = one.astype(np.float32), other.astype(np.float32)
    mean_a, mean_b = mean(a), mean(b)
    own_a, own_b = mean(a * a) - mean_a**2, mean(b * b) - mean_b**2
    product = mean(a * b) - mean_a * mean_b
    found = product / np.sqrt(np.maximum(own_a, 2) * np.maximum(own_b, 2))
    return np.asarray(found, dtype=np.float32)
