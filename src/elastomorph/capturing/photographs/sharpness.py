"""How sharp a photograph is where it shows something, to compare with others of the same head.

The strength of its finest detail (of about a pixel) against that of coarser detail (of about four),
in the third of the photograph that has most of the latter. It does not depend on brightness and
little on what is shown; blur of a pixel or two halves it. Noise is fine detail too, and would make
the most blurred photograph of a dim room the sharpest: its strength is estimated and taken off.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import convolve, gaussian_filter

_FINE, _COARSE, _AROUND = 0.8, 3.2, 8.0  # px
_SHOWS_SOMETHING = 70  # percentile
# What is left of white noise of variance 1, and nothing of what is smooth (Immerkær 1996); where
# the skin has pores it holds these too, so that the plainer parts of what is shown tell the noise.
_NOISE = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], dtype=np.float32) / 6
_PLAIN = 20  # percentile


def sharpness(grey: NDArray[np.uint8]) -> float:
    """Strength of fine against coarse detail of a photograph (H, W); 0 where it is uniform."""
    picture = grey.astype(np.float32)
    fine = _strength(picture, _FINE)
    coarse = _strength(picture, _COARSE)
    shows = coarse >= np.percentile(coarse, _SHOWS_SOMETHING)
    shows &= coarse > 1e-3
    if not shows.any():
        return 0.0
    noise = np.percentile(gaussian_filter(convolve(picture, _NOISE) ** 2, _AROUND)[shows], _PLAIN)
    left = fine[shows] - noise * _of_white(_FINE)
    below = np.maximum(coarse[shows] - noise * _of_white(_COARSE), 1e-3)
    return float(np.sqrt(max(np.median(left / below), 0.0)))


def _strength(picture: NDArray[np.float32], width: float) -> NDArray[np.float32]:
    """Mean square, around each pixel, of the detail between a width and twice that, (H, W)."""
    band = gaussian_filter(picture, width) - gaussian_filter(picture, 2 * width)
    strength: NDArray[np.float32] = gaussian_filter(band * band, _AROUND)
    return strength


def _of_white(width: float) -> float:
    """Mean square of the detail of `_strength` in white noise of variance 1.

    Gaussians of widths a and b overlap by 1 / 2π (a² + b²).
    """
    return (1 + 1 / 4 - 4 / 5) / (4 * np.pi * width**2)
