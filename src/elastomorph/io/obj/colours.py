"""Colours of vertices in OBJ files, as MeshLab and some scanners write them behind positions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError
from elastomorph.io.atomic import read_bytes
from elastomorph.io.obj.reader import VERTEX_COLUMNS, read_table
from elastomorph.io.obj.statements import StatementError, Statements, plain_text

__all__ = ["read_obj_colours"]

_COLOURED = 6  # numbers of a vertex with a colour, at least


def read_obj_colours(path: str | Path) -> NDArray[np.uint8] | None:
    """The colours of the vertices of an OBJ file, or None where not every vertex has one.

    Returns:
        (V, 3) uint8, red first. In the file they are from 0 to 1, or to 255 if any is above 1.

    Raises:
        FileError: It cannot be read.
        FormatError: Its vertices are damaged.
    """
    rows = Statements(plain_text(path, read_bytes(path))).vertices
    if not rows.bodies or min(len(own.split()) for own in rows.without_comments()) < _COLOURED:
        return None
    try:
        values = read_table(rows, VERTEX_COLUMNS, "expected 'v x y z r g b'")
    except StatementError as problem:
        raise FormatError(path, str(problem), line=problem.line) from None
    colours = values[:, -3:]  # a weight would stand before them
    if colours.max() <= 1:
        colours = colours * 255
    return np.clip(np.round(colours), 0, 255).astype(np.uint8)
