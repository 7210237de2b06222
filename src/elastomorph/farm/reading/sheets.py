"""Some faces of a data set on one sheet: colour with landmarks, depth, normals, parts."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import chain
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.pictures import Image, as_pillow, imported, written
from elastomorph.draw.sheet import picture_grid
from elastomorph.errors import ParameterError
from elastomorph.farm.pictures.subject import PARTS
from elastomorph.farm.reading.faces import FaceSet, pictured

_LEAST_SIDE = 224  # pixels that a picture has at least
_ABREAST = 2
_SEEN, _HIDDEN = (60, 230, 90), (240, 70, 60)


def contact_sheet(
    images: Mapping[str, NDArray[Any]],
    numbers: Sequence[int],
    path: str | Path | None = None,
    *,
    title: str = "",
) -> Image:
    """Put pictures and labels of faces beside each other.

    Args:
        images: (n, …) arrays as `Painter.draw` returns them; those that are missing are left out.
        numbers: n of the faces in their data set.
        path: Picture to write, if any; the suffix chooses the format.
        title: Above the sheet.

    Returns:
        (H, W, 3) uint8.

    Raises:
        ParameterError: No pictures, or as many numbers as there are not.
        MissingExtraError: Pillow or matplotlib is not installed.
    """
    shown = {name: draw for name, draw in _DRAWN.items() if name in images}
    if not shown or not len(numbers) or any(len(images[name]) != len(numbers) for name in shown):
        raise ParameterError(
            f"a contact sheet needs pictures, and a number for each face; found {len(numbers)} "
            f"numbers and the arrays {', '.join(images) or 'none'}"
        )
    marks = images.get("landmarks")
    cells, captions = [], []
    for face, number in enumerate(numbers):
        made = [_enlarged(draw(images[name][face])) for name, draw in shown.items()]
        if marks is not None:
            made[0] = _marked(made[0], marks[face], images[next(iter(shown))].shape[1])
        cells.append(made)
        captions.append([f"face {number:,}", *list(shown)[1:]])
    rows = [
        list(chain.from_iterable(cells[start : start + _ABREAST]))
        for start in range(0, len(cells), _ABREAST)
    ]
    below = [
        list(chain.from_iterable(captions[start : start + _ABREAST]))
        for start in range(0, len(cells), _ABREAST)
    ]
    return written(picture_grid(rows, captions=below, title=title), path)


def _of_depth(depth: NDArray[np.floating]) -> Image:
    """The nearest white, the farthest dark, nothing black."""
    there = depth > 0
    shade = np.zeros(depth.shape)
    if there.any():
        near, far = depth[there].min(), depth[there].max()
        shade[there] = 1 - 0.8 * (depth[there] - near) / max(far - near, 1e-30)
    return np.repeat(np.rint(255 * shade).astype(np.uint8)[..., None], 3, axis=2)


def _of_normals(normals: NDArray[np.int8]) -> Image:
    """As normal maps are shown: right red, up green, towards the camera blue."""
    turned = normals.astype(np.int16) * np.array([1, -1, -1], dtype=np.int16)
    return np.asarray((turned + 128).clip(0, 255), dtype=np.uint8)


def _of_parts(parts: NDArray[np.uint8]) -> Image:
    colours = imported("matplotlib").colormaps["tab20"](np.arange(1, len(PARTS)) % 20)[:, :3]
    table = np.concatenate([np.zeros((1, 3)), colours])
    codes: Image = np.rint(255 * table).astype(np.uint8)
    return codes[np.minimum(parts, len(table) - 1)]


_DRAWN: Mapping[str, Callable[[NDArray[Any]], Image]] = {
    "colour": np.asarray,
    "depth": _of_depth,
    "normals": _of_normals,
    "parts": _of_parts,
}


def _enlarged(image: Image) -> Image:
    times = -(-_LEAST_SIDE // max(image.shape[:2]))
    return image.repeat(times, axis=0).repeat(times, axis=1)


def _marked(image: Image, marks: NDArray[np.floating], height: int) -> Image:
    """Landmarks as points: green where they are seen, red rings where something hides them."""
    sheet = as_pillow(image)
    draw = imported("PIL.ImageDraw").Draw(sheet)
    times = image.shape[0] / height
    for x, y, seen in marks[np.isfinite(marks).all(axis=1)].tolist():
        across, down = ((place + 0.5) * times - 0.5 for place in (x, y))
        box = (across - 2, down - 2, across + 2, down + 2)
        draw.ellipse(box, fill=_SEEN if seen else None, outline=_SEEN if seen else _HIDDEN)
    return np.asarray(sheet)


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
