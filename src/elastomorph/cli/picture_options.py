"""What a user says about a picture: its size, view, times, background."""

from __future__ import annotations

import math
import re

from elastomorph.errors import ParameterError

__all__ = ["background_of", "numbers", "picture_size", "view_of"]

_SMALLEST, _LARGEST = 16, 4096


def picture_size(text: str | None, otherwise: tuple[int, int]) -> tuple[int, int]:
    """Width and height from ``720x900``.

    Raises:
        ParameterError: The text is not understood, or a side is out of range.
    """
    if text is None:
        return otherwise
    found = re.fullmatch(r"(\d{1,9})\s*[x×*,]\s*(\d{1,9})", text.strip().lower())
    if found is None:
        raise ParameterError(f"--size {text!r}: expected width and height in pixels, as in 720x900")
    width, height = int(found[1]), int(found[2])
    if not all(_SMALLEST <= side <= _LARGEST for side in (width, height)):
        raise ParameterError(
            f"--size {text!r}: width and height must be from {_SMALLEST} to {_LARGEST} pixels"
        )
    return width, height


def view_of(text: str) -> str | tuple[float, float]:
    """A view by name, or degrees to the face's left and up from ``30,10``.

    Raises:
        ParameterError: Neither.
    """
    from elastomorph.draw.camera import VIEWS

    name = text.strip().lower()
    if name in VIEWS:
        return name
    try:
        left, up = (float(word) for word in name.split(","))
    except ValueError:
        left = up = math.nan
    if not (math.isfinite(left) and abs(up) < 90):
        raise ParameterError(
            f"--view {text!r}: expected one of {', '.join(VIEWS)}, or degrees to the face's left "
            "and up (above -90 and below 90), as in 30,10"
        )
    return left, up


def numbers(text: str, option: str) -> list[float]:
    """Finite numbers from ``0,0.5,1``.

    Raises:
        ParameterError: The text is not understood.
    """
    try:
        found = [float(word) for word in text.split(",")]
    except ValueError:
        found = [math.nan]
    if not all(map(math.isfinite, found)):
        raise ParameterError(f"{option} {text!r}: expected numbers separated by commas, as 0,0.5,1")
    return found


def background_of(text: str | None) -> tuple[float, float, float] | None:
    """Red, green, blue from 0 to 1 of a colour's name or #rrggbb; None is transparent.

    Raises:
        ParameterError: No such colour.
    """
    from elastomorph.draw.colours import colour_named
    from elastomorph.draw.stage import BACKGROUND

    if text is None:
        return BACKGROUND
    return None if text.strip().lower() == "transparent" else colour_named(text)
