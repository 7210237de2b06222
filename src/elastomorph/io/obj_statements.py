"""What the statements of an OBJ file say, apart from how its text is taken apart.

Both ways of reading the text, `obj_lines` (strict, line by line) and `obj_table` (fast), end in an
`ObjStatements`, and share here the rules on keywords, names and comments.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.mesh import FaceLabels, Mesh, Source, UVMap
from elastomorph.polygons import Polygons

__all__ = [
    "IGNORED",
    "NAMING",
    "VERTEX_COLUMNS",
    "Naming",
    "ObjStatements",
    "mesh_of",
    "name_in",
    "without_comment",
]

VERTEX_COLUMNS = (3, 4, 6, 7)
"""Numbers a ``v`` statement may have: x y z, then a weight, a colour, or both (neither is kept)."""

NAMING = frozenset({b"usemtl", b"mtllib", b"g", b"o"})

IGNORED = frozenset(
    # normals go stale as soon as a vertex moves; smoothing, points and lines are not polygons
    b"vn s l p mg lod bevel c_interp d_interp usemap maplib shadow_obj trace_obj ctech stech "
    # curves and surfaces
    b"vp deg bmat step cstype curv curv2 surf parm trim hole scrv sp end con "
    # statements that version 2 of the format already called superseded
    b"bsp bzp cdc cdp res".split()
)

_COMMENT_AFTER_NAME = re.compile(rb"(?:^|(?<=[ \t]))#(?=[ \t]|$)")


@dataclass(frozen=True)
class Naming:
    """One ``usemtl``, ``g`` or ``o`` statement: the name that holds from this line on.

    Attributes:
        line: Line number, counted from 1.
        name: The name; empty for none.
    """

    line: int
    name: str


@dataclass(frozen=True, eq=False)
class ObjStatements:
    """The statements of one OBJ file that are kept.

    Attributes:
        vertices: (V, 3) float64.
        texture: (T, 2) or (T, 3) float64, the ``vt`` statements.
        corners: (C,) int, a vertex for each polygon corner, counted from 0.
        texture_corners: (C,) int, a ``vt`` for each corner, or -1 for none.
        sizes: (F,) int, corners of each polygon.
        face_lines: (F,) int, line number of each polygon.
        materials: The ``usemtl`` statements.
        groups: The ``g`` and ``o`` statements.
        libraries: What the ``mtllib`` statements name.
    """

    vertices: NDArray[np.float64]
    texture: NDArray[np.float64]
    corners: NDArray[np.int64]
    texture_corners: NDArray[np.int64]
    sizes: NDArray[np.int64]
    face_lines: NDArray[np.int64]
    materials: list[Naming]
    groups: list[Naming]
    libraries: list[str]


def without_comment(line: bytes, keyword: bytes) -> bytes:
    """The line up to its comment.

    After a name only a # that stands alone begins a comment: ``usemtl Material #25`` is a name.
    """
    if keyword in NAMING:
        comment = _COMMENT_AFTER_NAME.search(line)
        return line[: comment.start()] if comment else line
    return line.partition(b"#")[0]


def name_in(statement: bytes) -> str:
    """All that follows the keyword, blanks inside included; empty where nothing does.

    Raises:
        UnicodeDecodeError: The name is not UTF-8 text.
    """
    return b"".join(statement.split(None, 1)[1:]).strip().decode("utf-8")


def mesh_of(path: str | Path, statements: ObjStatements) -> Mesh:
    """The mesh that the statements describe.

    A polygon belongs to the group named last before it, whether by ``g`` or by ``o``.
    """
    faces = Polygons(statements.corners, np.concatenate([[0], np.cumsum(statements.sizes)]))
    uv = None
    if len(statements.texture):
        uv = UVMap(statements.texture, statements.texture_corners.astype(np.int32))
    return Mesh(
        statements.vertices,
        faces,
        uv=uv,
        materials=_labels(statements.materials, statements.face_lines),
        groups=_labels(statements.groups, statements.face_lines),
        material_library=" ".join(filter(None, dict.fromkeys(statements.libraries))) or None,
        source=Source(str(path), statements.face_lines.astype(np.int32)),
    )


def _labels(statements: list[Naming], face_lines: NDArray[np.int64]) -> FaceLabels | None:
    lines = np.array([statement.line for statement in statements], dtype=np.int64)
    holding = np.searchsorted(lines, face_lines) - 1
    used, of_face = np.unique(holding, return_inverse=True)
    names: dict[str, int] = {}
    numbers = np.full(len(used), -1, dtype=np.int32)
    for i, statement in enumerate(used):
        name = statements[statement].name if statement >= 0 else ""
        if name:
            numbers[i] = names.setdefault(name, len(names))
    return FaceLabels(tuple(names), numbers[of_face.reshape(-1)]) if names else None
