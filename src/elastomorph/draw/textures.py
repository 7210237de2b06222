"""Images of materials as pixels, and where each corner of a surface lies in them.

Pillow reads the head of a file first: an image of more pixels than `MOST_PIXELS` is not decoded,
and one larger than a picture can show is made smaller at once.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from io import BytesIO

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.pictures import imported
from elastomorph.errors import warn
from elastomorph.model.appearance import Material, Texture

MOST_PIXELS = 8192**2
"""Of an image that is decoded: 256 MB for a moment."""
LARGEST = 2048
"""Pixels on a side of what is kept of it."""
_FORMATS = ("PNG", "JPEG", "WEBP")


def pixels_of(material: Material) -> tuple[NDArray[np.uint8] | None, str]:
    """(H, W, 4) sRGB and opacity of a material, its colour and its image; and why there are none.

    Light is multiplied where it is linear, so the colour of a material tints its image as in any
    other renderer.
    """
    image, problem = _decoded(material.texture) if material.texture is not None else (None, "")
    if image is None:
        return None, problem
    for channel, factor in enumerate(material.colour):
        if factor != 1.0:
            levels = np.arange(256) / 255
            shown = levels * factor if channel == 3 else encoded(linear(levels) * factor)
            image[..., channel] = np.rint(255 * shown).astype(np.uint8)[image[..., channel]]
    return image, ""


def warn_of(problems: Iterable[tuple[str, str]], where: str) -> None:
    """One warning for all (material, problem) pairs of a mesh whose images cannot be shown."""
    found = list(problems)
    if not found:
        return
    name, problem = found[0]
    others = f" and {len(found) - 1} more" if len(found) > 1 else ""
    warn(
        f"{where}: the texture of {name[:60]!r}{others} cannot be shown ({problem}); only the "
        "colour of the material is"
    )


def places_in(texture: Texture, coordinates: NDArray[np.float64]) -> NDArray[np.float64]:
    """(C, 2) where corners lie in an image, counted from its left and bottom, as the texture says.

    The (C, 2) coordinates are those of the mesh.
    """
    u, v = (coordinates * [1, -1] + [0, 1]).T
    across, down = u * texture.scale[0], v * texture.scale[1]
    cosine, sine = np.cos(texture.rotation), np.sin(texture.rotation)
    x = texture.offset[0] + cosine * across + sine * down
    y = texture.offset[1] - sine * across + cosine * down
    return np.stack([x, 1.0 - y], axis=1)


def linear(shown: NDArray[np.float64]) -> NDArray[np.float64]:
    """Light of sRGB from 0 to 1."""
    return np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)


def encoded(light: NDArray[np.float64]) -> NDArray[np.float64]:
    """The sRGB from 0 to 1 of light."""
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)


def _decoded(texture: Texture) -> tuple[NDArray[np.uint8] | None, str]:
    if not texture.image:
        return None, texture.problem or "it is empty"
    pillow = imported("PIL.Image")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of its size and of odd headers: both are handled here
            with pillow.open(BytesIO(texture.image), formats=_FORMATS) as image:
                width, height = image.size
                if width * height > MOST_PIXELS:
                    return None, f"it has {width:,} × {height:,} pixels"
                image.draft("RGB", (LARGEST, LARGEST))  # a large JPEG is decoded smaller
                whole = image.convert("RGBA")
                whole.thumbnail((LARGEST, LARGEST))
                return np.array(whole), ""
    except pillow.DecompressionBombError:
        return None, "it has too many pixels"
    except Exception as error:  # Pillow raises many kinds, some of them for the same damage
        if isinstance(error, pillow.UnidentifiedImageError):  # its words name an object in memory
            return None, "it is no PNG, JPEG or WebP image"
        return None, f"it is damaged: {error}"
