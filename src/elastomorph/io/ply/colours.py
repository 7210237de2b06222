"""Colours of vertices in PLY files, as scanners give them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.atomic import read_bytes
from elastomorph.io.ply.header import read_header
from elastomorph.io.ply.mesh import columns_of, require_surface

__all__ = ["read_ply_colours"]

_COLOURS = ("red", "green", "blue")


def read_ply_colours(path: str | Path) -> NDArray[np.uint8] | None:
    """The colours of the vertices of a PLY file, or None where it has none.

    Returns:
        (V, 3) uint8, red first. Whole numbers in the file are from 0 to 255, others from 0 to 1.

    Raises:
        FileError: It cannot be read.
        FormatError: It is damaged.
    """
    content = read_bytes(path)
    header = read_header(path, content)
    require_surface(path, header)
    vertices = next(own for own in header.elements if own.name == "vertex")
    places = [vertices.place(name) for name in _COLOURS]
    found = [vertices.properties[place] for place in places if place is not None]
    if len(found) < len(_COLOURS) or any(each.length is not None for each in found):
        return None
    columns = columns_of(path, content, header, {"vertex": _COLOURS})
    values = np.stack([columns[name].values for name in _COLOURS], axis=1).astype(np.float64)
    if found[0].kind.kind == "f":
        values = np.nan_to_num(values) * 255
    return np.clip(np.round(values), 0, 255).astype(np.uint8)
