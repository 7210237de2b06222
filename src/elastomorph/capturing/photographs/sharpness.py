"""How sharp a photograph is where it shows something, to compare with others of the same head.

The strength of its finest detail (of about a pixel) against that of coarser detail (of about four),
in the third of the photograph that has most of the latter. It does not depend on brightness and
little on what is shown; blur of a pixel or two halves it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

__all__ = ["sharpness"]

_FINE, _COARSE, _AROUND = 0.8, 3.2, 8.0  # px
_SHOWS_SOMETHING = 70  # percentile


def sharpness(grey: NDArray[np.uint8]) -> float:
    """Strength of fine against coarse detail of a photograph (H, W); 0 where it is uniform."""
    picture = grey.astype(np.float32)
    fine = _strength(picture, _FINE)
    coarse = _strength(picture, _COARSE)
    shows = coarse >= np.percentile(coarse, _SHOWS_SOMETHING)
    shows &= coarse > 1e-3
    if not shows.any():
        return 0.0
    return float(np.sqrt(np.median(fine[shows] / coarse[shows])))


def _strength(picture: NDArray[np.float32], width: float) -> NDArray[np.float32]:
    """Mean square, around each pixel, of the detail between a width and twice that, (H, W)."""
    band = gaussian_filter(picture, width) - gaussian_filter(picture, 2 * width)
    strength: NDArray[np.float32] = gaussian_filter(band * band, _AROUND)
    return strength
