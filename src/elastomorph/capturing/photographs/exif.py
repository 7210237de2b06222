"""What a camera wrote into a photograph: how it was held, its lens, and what that is in pixels.

A focal length in pixels follows from its length on 35-mm film, f_px = f_35 · diagonal / 43.27, or
from the sensor's pixels per unit of length, f_px = f · resolution, reduced as the photograph was
since. Neither is more than a start: cameras are solved from the photographs themselves, and what
EXIF says is compared with the result. What cannot be true is not used, and the reason is said.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

_ORIENTATION, _MAKE, _MODEL, _EXIF_FOLDER = 274, 271, 272, 0x8769
_FOCAL_LENGTH, _FOCAL_35 = 37386, 41989
_PLANE_X, _PLANE_Y, _PLANE_UNIT = 41486, 41487, 41488
_PIXELS_X, _PIXELS_Y = 40962, 40963
_MILLIMETRES = {1: 25.4, 2: 25.4, 3: 10.0, 4: 1.0, 5: 0.001}

_DIAGONAL_35 = math.hypot(36.0, 24.0)
# Of the longer side: wider than any lens that is no fisheye, and longer than faces are taken with.
_SHORTEST, _LONGEST = 0.35, 12.0
_SMALLEST_SENSOR, _LARGEST_SENSOR = 3.0, 70.0  # mm, longer side
_SWAPS_SIDES = (5, 6, 7, 8)


@dataclass(frozen=True)
class Exif:
    """What is used of a photograph's EXIF.

    Attributes:
        orientation: How the stored rows are turned to stand upright, 1 to 8 as EXIF counts.
        camera: Make and model, empty where none is written.
        length: Focal length in mm as written, or None.
        focal: Focal length in pixels of the whole photograph, or None where it does not follow.
        doubt: Why a focal length that was written is not used; empty where there is no doubt.
    """

    orientation: int = 1
    camera: str = ""
    length: float | None = None
    focal: float | None = None
    doubt: str = ""

    @property
    def swaps_sides(self) -> bool:
        """Whether width and height change places when the photograph is turned upright."""
        return self.orientation in _SWAPS_SIDES


def read_exif(tags: Any, size: tuple[int, int]) -> Exif:
    """The EXIF of an image opened by Pillow.

    Args:
        tags: What its ``getexif`` returned.
        size: Width and height in pixels as stored.
    """
    more = tags.get_ifd(_EXIF_FOLDER)
    orientation = tags.get(_ORIENTATION, 1)
    make, model = _text(tags.get(_MAKE)), _text(tags.get(_MODEL))
    camera = model if model.lower().startswith(make.lower()) else f"{make} {model}"
    length = _number(more.get(_FOCAL_LENGTH))
    focal, doubt = _focal(more, length, size)
    return Exif(
        orientation=orientation if orientation in range(1, 9) else 1,
        camera=camera.strip(),
        length=length,
        focal=focal,
        doubt=doubt,
    )


def _focal(tags: Any, length: float | None, size: tuple[int, int]) -> tuple[float | None, str]:
    longer = max(size)
    film = _number(tags.get(_FOCAL_35))
    by_film = None if film is None else film * math.hypot(*size) / _DIAGONAL_35
    by_sensor, doubt = _by_sensor(tags, length, longer)
    for focal, source in ((by_film, "35-mm film"), (by_sensor, "its sensor")):
        if focal is None:
            continue
        if _SHORTEST * longer <= focal <= _LONGEST * longer:
            return focal, ""
        doubt = (
            f"by {source} its focal length would be {focal:,.0f} px for {longer:,} px, "
            f"as no lens has that takes a face"
        )
    return None, doubt


def _by_sensor(tags: Any, length: float | None, longer: int) -> tuple[float | None, str]:
    resolution = _number(tags.get(_PLANE_X))
    if length is None or resolution is None:
        return None, ""
    per_millimetre = resolution / _MILLIMETRES.get(tags.get(_PLANE_UNIT, 2), 25.4)
    taken = [_number(tags.get(key)) for key in (_PIXELS_X, _PIXELS_Y)]
    whole = max((side for side in taken if side is not None), default=float(longer))
    sensor = whole / per_millimetre
    if not _SMALLEST_SENSOR <= sensor <= _LARGEST_SENSOR:
        return None, f"its sensor would be {sensor:,.1f} mm wide"
    return length * per_millimetre * longer / whole, ""


def _number(value: object) -> float | None:
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, ZeroDivisionError, OverflowError):
        return None
    return number if math.isfinite(number) and number > 0 else None


def _text(value: object) -> str:
    return value.replace("\0", " ").strip() if isinstance(value, str) else ""
