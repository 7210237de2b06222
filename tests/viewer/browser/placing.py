"""Photographs with dots where points belong, and pages on which they are placed."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from scipy import ndimage

from elastomorph.capturing.landmarks import LANDMARKS

if TYPE_CHECKING:
    from playwright.sync_api import Page

NAMES = tuple(LANDMARKS)
SIZE = (640, 480)  # width, height
ORIENTATION = 0x0112
GROUND, DOT = (96, 104, 112), (20, 220, 40)


def dots(seed: int, size: tuple[int, int] = SIZE) -> NDArray[np.float64]:
    """(15, 2) pixels far from each other, each in a row of its own, from top to bottom."""
    rng = np.random.default_rng(seed)
    rows = np.linspace(24, size[1] - 24, len(NAMES)) + rng.uniform(-2, 2, len(NAMES))
    return np.stack([rng.uniform(60, size[0] - 60, len(NAMES)), rows], axis=1)


def write_photograph(
    path: Path, at: NDArray[np.float64], size: tuple[int, int] = SIZE, held: int = 1
) -> None:
    """A JPEG or TIFF with dots, soft as a lens makes them; ``held`` is how EXIF turns it."""
    y, x = np.mgrid[: size[1], : size[0]]
    cover = np.zeros((size[1], size[0]))
    for a, b in at:
        cover = np.maximum(cover, np.clip(5.5 - np.hypot(x - a, y - b), 0, 1))
    pixels = np.array(GROUND) + cover[..., None] * (np.array(DOT) - np.array(GROUND))
    image = Image.fromarray(pixels.round().astype(np.uint8))
    turns = {1: None, 6: Image.Transpose.ROTATE_90, 3: Image.Transpose.ROTATE_180}
    stored = image if turns[held] is None else image.transpose(turns[held])
    exif = Image.Exif()
    exif[ORIENTATION] = held
    options = {} if path.suffix == ".tif" else {"quality": 97, "subsampling": 0}
    stored.save(path, exif=exif, **options)


def seen_dots(page: Page) -> NDArray[np.float64]:
    """(N, 2) where dots are in the picture of the page, CSS pixels of the page, from the top."""
    box = page.locator(".picture").bounding_box()
    assert box is not None
    # Marks, lines and the magnifier may cover some.
    shot = page.screenshot(clip=box, style="canvas:is(.over, .lens) { visibility: hidden }")
    with Image.open(io.BytesIO(shot)) as image:
        pixels = np.asarray(image.convert("RGB")).astype(float)
    ground, dot = np.array(GROUND, float), np.array(DOT, float)
    cover = np.clip(((pixels - ground) @ (dot - ground)) / ((dot - ground) ** 2).sum(), 0, 1)
    # The mat around the photograph and words on it are of other colours.
    far = np.abs(pixels - ground - cover[..., None] * (dot - ground)).max(axis=-1)
    cover[far > 40] = 0
    labels, count = ndimage.label(cover > 0.3)
    wide = ndimage.grey_dilation(labels, 3)
    centres = np.array(ndimage.center_of_mass(cover, wide, range(1, count + 1)))
    large = ndimage.sum_labels(cover, wide, range(1, count + 1)) > 12
    # The middle of the first pixel of a screenshot is half a CSS pixel from its corner.
    return centres[large][:, ::-1] + 0.5 + (box["x"], box["y"])


def click(page: Page, at: NDArray[np.float64]) -> None:
    page.mouse.click(float(at[0]), float(at[1]))


def opened(page: Page, name: str) -> None:
    """Waits until a photograph or a surface is in view."""
    page.get_by_role("application", name=f"{name}: click to place points").wait_for()


def active(page: Page) -> str | None:
    """The point that a click places, by its name."""
    found = page.locator(".point[aria-current]")
    return found.get_attribute("data-name") if found.count() else None


def saved(page: Page) -> None:
    """Waits until the page says that all is in the file."""
    page.locator(".saved", has_text="saved in").wait_for()
