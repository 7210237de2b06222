"""Pictures of pixels as files, and the packages that only drawing needs."""

from __future__ import annotations

from importlib import import_module
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import MissingExtraError, ParameterError
from elastomorph.io.atomic import replacing

Image = NDArray[np.uint8]
SUFFIXES = {".png": "PNG", ".jpg": "JPEG", ".jpeg": "JPEG", ".webp": "WEBP"}
_NAME_TO_INSTALL = {"vtkmodules": "vtk", "PIL": "pillow", "imageio_ffmpeg": "imageio-ffmpeg"}


def imported(module: str) -> Any:
    """A module of vtk, matplotlib, Pillow or imageio-ffmpeg, imported when it is first needed."""
    package = module.partition(".")[0]
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] != package:
            raise
        raise MissingExtraError(_NAME_TO_INSTALL.get(package, package), "demo") from None


def write_picture(image: Image, path: str | Path) -> None:
    """Write an (H, W, 3) uint8 picture, whole or not at all, in a format of `SUFFIXES`."""
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES:
        raise ParameterError(
            f"{path}: a picture is written as {', '.join(SUFFIXES)}, found {suffix or 'no suffix'}"
        )
    picture = as_pillow(image)
    settings = {} if suffix == ".png" else {"quality": 92}
    with replacing(path) as file:
        picture.save(file, format=SUFFIXES[suffix], **settings)


def written(image: Image, path: str | Path | None) -> Image:
    """The picture, written first where a path is given."""
    if path is not None:
        write_picture(image, path)
    return image


def as_png(image: Image) -> bytes:
    """The picture as the content of a PNG file, to embed in a page."""
    file = BytesIO()
    as_pillow(image).save(file, format="PNG")
    return file.getvalue()


def as_pillow(image: Image) -> Any:
    """The picture as an ``Image`` of Pillow."""
    return imported("PIL.Image").fromarray(np.ascontiguousarray(image))
