"""Pictures as files: whole or not at all."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.extras import imported
from elastomorph.errors import ParameterError
from elastomorph.io.atomic import replacing

__all__ = ["SUFFIXES", "as_png", "write_picture"]

SUFFIXES = {".png": "PNG", ".jpg": "JPEG", ".jpeg": "JPEG", ".webp": "WEBP"}


def write_picture(image: NDArray[np.uint8], path: str | Path) -> None:
    """Write a picture of pixels.

    Args:
        image: (H, W, 3) uint8.
        path: Its suffix chooses the format, one of `SUFFIXES`.

    Raises:
        ParameterError: Another suffix.
        FileError: The file cannot be written.
        MissingExtraError: Pillow is not installed.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES:
        raise ParameterError(
            f"{path}: a picture is written as {', '.join(SUFFIXES)}, found {suffix or 'no suffix'}"
        )
    picture = imported("PIL.Image").fromarray(np.ascontiguousarray(image))
    settings: dict[str, Any] = {} if suffix == ".png" else {"quality": 92}
    with replacing(path) as file:
        picture.save(file, format=SUFFIXES[suffix], **settings)


def as_png(image: NDArray[np.uint8]) -> bytes:
    """The picture as the content of a PNG file, to embed in a page."""
    from io import BytesIO

    file = BytesIO()
    imported("PIL.Image").fromarray(np.ascontiguousarray(image)).save(file, format="PNG")
    return file.getvalue()
