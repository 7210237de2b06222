"""Two pictures compared: what has moved between them, and how alike they are."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

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
