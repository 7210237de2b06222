"""What the statements of an OBJ file say, apart from how its text is taken apart.

Both ways of reading the text, `obj_lines` (strict, line by line) and `obj_table` (fast), end in an
`ObjStatements`, and share here the rules on keywords, names and comments.
"""

from __future__ import annotations

import re
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ElastomorphWarning
from elastomorph.model.mesh import FaceLabels, Mesh, Source, UVMap
from elastomorph.model.polygons import Polygons

__all__ = [
    "IGNORED",
    "NAMING",
    "VERTEX_COLUMNS",
    "Dropped",
    "Naming",
    "ObjStatements",
    "is_continued",
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
        name: The name as the file has it; empty for none.
    """

    line: int
    name: bytes


@dataclass(frozen=True)
class Dropped:
    """Statements, or parts of them, that are not kept although they look as if they should be.

    Attributes:
        line: Line number of the first.
        count: How many there are.
        what: A sentence on what they are and what becomes of them.
    """

    line: int
    count: int
    what: str


@dataclass(frozen=True, eq=False)
class ObjStatements:
    """The statements of one OBJ file that are kept.

    Attributes:
        vertices: (V, 3) float64.
        texture: (T, 2) or (T, 3) float64, the ``vt`` statements.
        corners: (C,) int, a vertex for each polygon corner, counted from 0.
        texture_corners: (C,) int, a ``vt`` for each corner, or -1 for none; any where there is no
            ``vt`` at all.
        sizes: (F,) int, corners of each polygon.
        face_lines: (F,) int, line number of each polygon.
        materials: The ``usemtl`` statements.
        groups: The ``g`` and ``o`` statements.
        libraries: What the ``mtllib`` statements name.
        dropped: What is not kept and worth a warning, but for texture indices without ``vt``.
    """

    vertices: NDArray[np.float64]
    texture: NDArray[np.float64]
    corners: NDArray[np.int64]
    texture_corners: NDArray[np.int64]
    sizes: NDArray[np.int64]
    face_lines: NDArray[np.int64]
    materials: list[Naming]
    groups: list[Naming]
    libraries: list[bytes]
    dropped: list[Dropped]


def without_comment(line: bytes, keyword: bytes) -> bytes:
    """The line up to its comment.

    After a name only a # that stands alone begins a comment: ``usemtl Material #25`` is a name.
    """
    if keyword in NAMING:
        comment = _COMMENT_AFTER_NAME.search(line)
        return line[: comment.start()] if comment else line
    return line.partition(b"#")[0]


def is_continued(line: bytes, keyword: bytes) -> bool:
    """Whether a backslash at the end of a line joins it with the next.

    In Shift-JIS, a backslash is also the second byte of letters: ``usemtl ソ`` ends in one.
    """
    if not line.endswith(b"\\"):
        return False
    in_letter = keyword in NAMING and line[-2:-1] >= b"\x81" and _encoding([line]) != "utf-8"
    return not in_letter


def name_in(statement: bytes) -> bytes:
    """All that follows the keyword, blanks inside included; empty where nothing does."""
    return b"".join(statement.split(None, 1)[1:]).strip()


def mesh_of(path: str | Path, statements: ObjStatements) -> Mesh:
    """The mesh that the statements describe.

    A polygon belongs to the group named last before it, whether by ``g`` or by ``o``.
    """
    for dropped in (*statements.dropped, *_without_texture(statements)):
        warnings.warn(
            f"{path}, line {dropped.line}: {dropped.what} ({dropped.count:,} in the file, this is "
            "the first)",
            ElastomorphWarning,
            stacklevel=3,
        )
    faces = Polygons(statements.corners, np.concatenate([[0], np.cumsum(statements.sizes)]))
    uv = None
    if len(statements.texture):
        uv = UVMap(statements.texture, statements.texture_corners.astype(np.int32))
    named = [naming.name for naming in (*statements.materials, *statements.groups)]
    encoding = _encoding([*named, *statements.libraries])
    library = b" ".join(filter(None, dict.fromkeys(statements.libraries)))
    return Mesh(
        statements.vertices,
        faces,
        uv=uv,
        materials=_labels(statements.materials, statements.face_lines, encoding),
        groups=_labels(statements.groups, statements.face_lines, encoding),
        material_library=library.decode(encoding) or None,
        source=Source(str(path), statements.face_lines.astype(np.int32), encoding),
    )


def _without_texture(statements: ObjStatements) -> list[Dropped]:
    """The polygons that name texture coordinates in a file that has none."""
    naming = np.flatnonzero(statements.texture_corners >= 0)
    if len(statements.texture) or not naming.size:
        return []
    faces = np.unique(np.searchsorted(np.cumsum(statements.sizes), naming, side="right"))
    return [
        Dropped(
            int(statements.face_lines[faces[0]]),
            len(faces),
            "the polygon names texture coordinates, but the file has no vt lines; it is read "
            "without them",
        )
    ]


def _encoding(names: list[bytes]) -> Literal["utf-8", "latin-1"]:
    """UTF-8, or Latin-1 where that cannot be: every byte is a letter of it, and comes back."""
    try:
        for name in names:
            name.decode("utf-8")
    except UnicodeDecodeError:
        return "latin-1"
    return "utf-8"


def _labels(
    statements: list[Naming], face_lines: NDArray[np.int64], encoding: str
) -> FaceLabels | None:
    lines = np.array([statement.line for statement in statements], dtype=np.int64)
    holding = np.searchsorted(lines, face_lines) - 1
    used, of_face = np.unique(holding, return_inverse=True)
    names: dict[str, int] = {}
    numbers = np.full(len(used), -1, dtype=np.int32)
    for i, statement in enumerate(used):
        name = statements[statement].name.decode(encoding) if statement >= 0 else ""
        if name:
            numbers[i] = names.setdefault(name, len(names))
    return FaceLabels(tuple(names), numbers[of_face.reshape(-1)]) if names else None
