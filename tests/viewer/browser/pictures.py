"""What the picture of a page looks like, as numbers."""

from __future__ import annotations

import base64
import io
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PIL import Image

if TYPE_CHECKING:
    from playwright.sync_api import Page

Pixels = NDArray[np.int16]


def picture(page: Page) -> Pixels:
    """(H, W, 3) what the stage draws, 0 to 255, without what lies over it."""
    # A canvas keeps its pixels until the task in which it was drawn ends.
    address = page.evaluate(
        "() => { elastomorph.readout(); return document.querySelector('canvas').toDataURL(); }"
    )
    return pixels_of(address)


def pixels_of(address: str) -> Pixels:
    """(H, W, 3) of a picture in a ``data:`` address."""
    png = base64.b64decode(address.partition(",")[2])
    with Image.open(io.BytesIO(png)) as image:
        return np.asarray(image.convert("RGB")).astype(np.int16)


def rgb(colour: str) -> Pixels:
    """(3,) of ``#rrggbb``."""
    return np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)], np.int16)


def differing(one: Pixels, other: Pixels, least: int = 8) -> NDArray[np.bool_]:
    """(H, W) where two pictures differ by more than the eye would let pass."""
    return np.abs(one - other).max(axis=-1) > least


def near(pixels: Pixels, colour: Pixels, reach: int) -> NDArray[np.bool_]:
    """(H, W) where a picture has a colour, about."""
    return np.abs(pixels - colour).max(axis=-1) <= reach


def skin(pixels: Pixels) -> NDArray[np.bool_]:
    """(H, W) where a picture shows skin rather than the grey wall behind it."""
    return (pixels.max(axis=-1) - pixels.min(axis=-1)) > 24
