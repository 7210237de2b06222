"""Wavefront OBJ: meshes of polygons as text, the file most scans and face rigs come in.

Vertices keep their order and polygons their corners, whatever texture coordinates, normals,
groups or materials say. What is not kept: a vertex's weight and colour (columns 4 to 7 of ``v``),
normals (``vn``; they go stale as soon as a vertex moves), smoothing groups, points, lines, curves
and surfaces.
"""

from __future__ import annotations

from pathlib import Path

from elastomorph.errors import FormatError
from elastomorph.io.atomic import read_bytes
from elastomorph.io.obj_lines import read_lines
from elastomorph.io.obj_statements import mesh_of
from elastomorph.io.obj_table import read_table
from elastomorph.io.obj_writer import write_obj
from elastomorph.model.mesh import Mesh

__all__ = ["read_obj", "write_obj"]

_UTF8_MARK = b"\xef\xbb\xbf"
_UTF16_MARKS = (b"\xff\xfe", b"\xfe\xff")


def read_obj(path: str | Path) -> Mesh:
    """The mesh in an OBJ file.

    Materials (``usemtl``) and groups (the last ``g`` or ``o`` above a polygon) become its labels,
    ``vt`` its texture coordinates, ``mtllib`` the name of its material library. Lines may end in
    LF, CR LF or CR, the file in NUL bytes. Names that are not UTF-8 are read as Latin-1, which has
    a letter for every byte, and `write_obj` writes those bytes again.

    What looks like part of the surface but is not is passed over with a warning: texture indices
    in a file without ``vt``, polygons of two corners, and the lines ``vw`` and ``t``.

    Args:
        path: The file.

    Returns:
        The mesh; ``source.face_lines`` has the line number of each polygon.

    Raises:
        FileError: The file is missing or cannot be read.
        FormatError: The content is not OBJ text; the message names the line.
    """
    text = _plain_text(path, read_bytes(path))
    statements = read_table(text) or read_lines(path, text)
    return mesh_of(path, statements)


def _plain_text(path: str | Path, content: bytes) -> bytes:
    """The content with lines that end in LF, the last one too."""
    if content.startswith(_UTF16_MARKS):
        raise FormatError(path, "this is UTF-16 text; save the file as UTF-8")
    text = content.removeprefix(_UTF8_MARK)
    if text.endswith(b"\0"):
        text = text.rstrip(b"\0")  # padding, as ZBrush writes it
    if b"\r" in text:
        text = text.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    nul = text.find(b"\0")
    if nul >= 0:
        raise FormatError(
            path,
            "a NUL byte: this is not text, or the file is damaged; export it again as OBJ in UTF-8",
            line=text.count(b"\n", 0, nul) + 1,
        )
    return text if text.endswith(b"\n") else text + b"\n"
