"""From light to the file a camera writes: focus, exposure, noise, JPEG, EXIF."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from photographs.cameras import Lens
from photographs.exif import Exif, equivalent

__all__ = ["Film", "developed"]

_GAMMA = 1 / 1.4
_SENSOR = 9.8  # mm, its diagonal: a phone's
# How a photograph is turned before it is stored, so that the camera's tag says how to turn it back.
_STORED = {1: 0, 3: 2, 6: 1, 8: 3}  # quarter turns against the clock


@dataclass(frozen=True)
class Film:
    """How a camera records light.

    Attributes:
        blur: Standard deviation of focus, in pixels of a photograph 2000 high; in proportion else.
        noise: Standard deviation of a value of 0 to 1.
        exposure: Standard deviation of the exposure from one photograph to the next, relative.
        quality: Of JPEG, 1 to 100.
        orientation: EXIF orientation: 1, 3, 6 or 8.
        exif: Whether anything about the camera is written.
    """

    blur: float = 0.7
    noise: float = 0.008
    exposure: float = 0.02
    quality: int = 94
    orientation: int = 1
    exif: bool = True


def developed(
    light: NDArray[np.float32], lens: Lens, film: Film, random: np.random.Generator
) -> bytes:
    """A JPEG of linear light (H, W, 3).

    Args:
        light: Red, green, blue.
        lens: For its focal length.
        film: How it is recorded.
        random: Source of exposure and noise.
    """
    sigma = film.blur * light.shape[0] / 2000
    if sigma > 0.2:  # less than that leaves a pixel to itself
        light = cv2.GaussianBlur(light, (0, 0), sigma)
    exposed = np.clip(light * np.float32(1 + film.exposure * random.normal()), 0, 1)
    values = cv2.pow(exposed, _GAMMA)
    if film.noise:
        values += np.float32(film.noise) * random.standard_normal(values.shape, dtype=np.float32)
    stored = (np.clip(values, 0, 1) * 255).astype(np.uint8)[:, :, ::-1]
    stored = np.ascontiguousarray(np.rot90(stored, _STORED[film.orientation]))
    good, jpeg = cv2.imencode(".jpg", stored, [cv2.IMWRITE_JPEG_QUALITY, film.quality])
    if not good:
        raise RuntimeError("OpenCV could not encode a JPEG")
    return exif(lens, film).into(jpeg.tobytes()) if film.exif else jpeg.tobytes()


def exif(lens: Lens, film: Film) -> Exif:
    """What the camera writes about a photograph by this lens."""
    width, height = lens.size
    focal = lens.focal * _SENSOR / float(np.hypot(width, height))
    same = round(equivalent(lens.focal, lens.size))
    upright = Exif("Elastomorph", "Renderer 1", focal, same, (width, height))
    turned = (height, width) if film.orientation in (6, 8) else (width, height)
    return replace(upright, size=turned, orientation=film.orientation)
