"""A sheet of some faces of a data set, to look at: their pictures, with labels beside them."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.pictures import Image
from elastomorph.errors import ParameterError
from elastomorph.farm.reading.faces import FaceSet
from elastomorph.farm.reading.picture_rows import pictured

__all__ = ["sheet_of"]

_SIDE = 256  # pixels of what is drawn for the sheet alone


def sheet_of(faces: FaceSet, path: str | PathLike[str] | None = None, *, count: int = 8) -> Image:
    """Some faces from the first to the last: colour with landmarks, depth, normals, parts.

    Pictures that are stored are shown as they are. Where none are, they are drawn from the columns
    of the faces; what the recipe does not vary is as `SETTINGS` say of faces at rest.

    Args:
        faces: The data set, finished as far as its last face.
        path: Picture to write, if any; the suffix chooses the format.
        count: How many faces.

    Returns:
        (H, W, 3) uint8.

    Raises:
        ParameterError: No faces are asked for, or there are none.
        FormatError: The faces are not made yet.
        MissingExtraError: embreex, Pillow or matplotlib is not installed.
    """
    from elastomorph.farm.pictures.sheet import contact_sheet

    if count < 1 or not len(faces):
        raise ParameterError(f"a sheet needs a face or more, found {min(count, len(faces))}")
    numbers = np.unique(np.linspace(0, len(faces) - 1, min(count, len(faces))).astype(np.int64))
    images = {name: rows[numbers] for name, rows in pictured(faces).items()}
    shown = images or _drawn(faces, numbers)
    return contact_sheet(shown, numbers.tolist(), None if path is None else Path(path))


def _drawn(faces: FaceSet, numbers: NDArray[np.int64]) -> dict[str, NDArray[Any]]:
    from elastomorph.farm.pictures.painter import Painter

    marks = faces.data.plan.contents.get("landmarks", {})
    columns = dict(zip(faces.columns.names, faces.values[numbers].T, strict=True))
    return Painter(faces.rig, (_SIDE, _SIDE), marks).draw(faces[numbers], columns)
