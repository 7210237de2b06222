"""Reads the text of an ordinary OBJ file quickly: equal statements are taken together, as tables.

Anything out of the ordinary, right or wrong (columns that vary, relative indices, continued lines,
comments behind numbers), is left to `obj_lines`, which is some times slower. What this reader does
accept, it reads exactly as that one does.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.obj_statements import (
    IGNORED,
    NAMING,
    VERTEX_COLUMNS,
    Naming,
    ObjStatements,
    name_in,
    without_comment,
)

__all__ = ["read_table"]

_LF, _SLASH, _BLANKS = ord("\n"), ord("/"), b" \t"
_SKIPPED, _VERTEX, _TEXTURE, _FACE, _OTHER = range(5)
_FACE_LARGEST = int(np.iinfo(np.int32).max)


def _table_of(characters: bytes) -> NDArray[np.bool_]:
    allowed = np.zeros(256, dtype=bool)
    allowed[np.frombuffer(characters, dtype=np.uint8)] = True
    return allowed


_BLANK = _table_of(_BLANKS)
_IN_NUMBERS = _table_of(b"0123456789+-.eE \t\n")
_IN_CORNERS = _table_of(b"0123456789/ \t\n")


def read_table(text: bytes) -> ObjStatements | None:
    """The statements of an ordinary OBJ file, or None where the strict reader is needed.

    Args:
        text: Its content without NUL bytes, with lines that end in LF, the last one too.
    """
    if b"\\\n" in text:
        return None
    content = np.frombuffer(text, dtype=np.uint8)
    ends = np.flatnonzero(content == _LF) + 1
    starts = np.concatenate([[0], ends[:-1]])
    kinds = _kinds(content, starts)

    vertices = _numbers(_lines_of(text, starts, ends, kinds == _VERTEX), 1)
    texture = _numbers(_lines_of(text, starts, ends, kinds == _TEXTURE), 2)
    faces = _corners(_lines_of(text, starts, ends, kinds == _FACE))
    if vertices is None or texture is None or faces is None:
        return None
    corners, texture_corners, sizes = faces
    if (
        not len(vertices)
        or vertices.shape[1] not in VERTEX_COLUMNS
        or texture.shape[1] > 3
        or not _all_exist(corners, 0, len(vertices))
        or (len(texture) and not _all_exist(texture_corners, -1, len(texture)))
    ):
        return None
    if not len(texture):
        texture_corners = np.minimum(texture_corners, 0)
    if texture.shape[1] < 2:
        texture = np.concatenate([texture, np.zeros((len(texture), 2 - texture.shape[1]))], axis=1)

    others = np.flatnonzero(kinds == _OTHER)
    namings = _namings([(i + 1, text[starts[i] : ends[i] - 1]) for i in others.tolist()])
    if namings is None:
        return None
    return ObjStatements(
        vertices=np.ascontiguousarray(vertices[:, :3]),
        texture=texture,
        corners=corners,
        texture_corners=texture_corners,
        sizes=sizes,
        face_lines=np.flatnonzero(kinds == _FACE) + 1,
        materials=[naming for keyword, naming in namings if keyword == b"usemtl"],
        groups=[naming for keyword, naming in namings if keyword in (b"g", b"o")],
        libraries=[naming.name for keyword, naming in namings if keyword == b"mtllib"],
        dropped=[],
    )


def _namings(lines: list[tuple[int, bytes]]) -> list[tuple[bytes, Naming]] | None:
    """Keyword and name where a line gives one; None if a line needs the strict reader."""
    namings = []
    for number, line in lines:
        keyword = b"".join(line.split(None, 1)[:1])
        if keyword in NAMING:
            namings.append((keyword, Naming(number, name_in(without_comment(line, keyword)))))
        elif keyword and not keyword.startswith(b"#") and keyword not in IGNORED:
            return None
    return namings


def _kinds(content: NDArray[np.uint8], starts: NDArray[np.int64]) -> NDArray[np.uint8]:
    """(lines,) what each line holds, judged by its first three characters."""
    last = len(content) - 1
    first, second, third = (content[np.minimum(starts + i, last)] for i in range(3))
    kinds = np.full(len(starts), _OTHER, dtype=np.uint8)
    is_v = first == ord("v")
    kinds[is_v & _BLANK[second]] = _VERTEX
    kinds[is_v & (second == ord("t")) & _BLANK[third]] = _TEXTURE
    kinds[is_v & (second == ord("n")) & _BLANK[third]] = _SKIPPED
    kinds[(first == ord("f")) & _BLANK[second]] = _FACE
    kinds[(first == ord("#")) | (first == _LF)] = _SKIPPED
    return kinds


def _lines_of(
    text: bytes, starts: NDArray[np.int64], ends: NDArray[np.int64], wanted: NDArray[np.bool_]
) -> bytes:
    """The wanted lines one after another; neighbours are copied together."""
    edges = np.flatnonzero(np.diff(wanted, prepend=False, append=False))
    firsts, lasts = starts[edges[::2]].tolist(), ends[edges[1::2] - 1].tolist()
    return b"".join([text[a:b] for a, b in zip(firsts, lasts, strict=True)])


def _numbers(lines: bytes, keyword_length: int) -> NDArray[np.float64] | None:
    """(lines, columns) float64, or None where lines differ in columns or hold anything else."""
    if not lines:
        return np.empty((0, 3))
    content, starts = _without_keyword(lines, keyword_length)
    if not _IN_NUMBERS[content].all():
        return None
    counts = _words_per_line(content, starts)
    if counts[0] == 0 or (counts != counts[0]).any():
        return None
    try:
        values = np.array(list(map(float, content.tobytes().split())))
    except ValueError:
        return None
    return values.reshape(len(starts), -1) if np.isfinite(values).all() else None


def _corners(
    lines: bytes,
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]] | None:
    """Vertex and vt of each corner, counted from 0, and (F,) sizes; None if corners are mixed."""
    none = np.empty(0, dtype=np.int64)
    if not lines:
        return none, none, none
    content, starts = _without_keyword(lines, 1)
    sizes = _words_per_line(content, starts)
    if sizes.min() < 3 or not _IN_CORNERS[content].all():
        return None
    slashes = _slashes_per_corner(content)
    if slashes is None:
        return None
    try:
        values = np.array(list(map(int, content.tobytes().replace(b"/", b" ").split())))
    except (ValueError, OverflowError):
        return None
    if values.dtype != np.int64:
        return None
    if slashes == b"":
        return values - 1, np.full(len(values), -1, dtype=np.int64), sizes
    table = values.reshape(-1, 3 if slashes == b"/ /" else 2)
    if slashes == b"//":
        return table[:, 0] - 1, np.full(len(table), -1, dtype=np.int64), sizes
    return (table[:, 0] - 1, table[:, 1] - 1, sizes) if table[:, 1].min() > 0 else None


def _slashes_per_corner(content: NDArray[np.uint8]) -> bytes | None:
    """How every corner is put together: b"" (v), b"/" (v/vt), b"//" (v//vn), b"/ /" (v/vt/vn)."""
    is_slash = content == _SLASH
    if not is_slash.any():
        return b""
    inside = content > ord(" ")
    begins = np.flatnonzero(inside[1:] & ~inside[:-1]) + 1
    counts = np.add.reduceat(is_slash, begins, dtype=np.int64)
    places = np.flatnonzero(is_slash)
    doubled = int((is_slash[places + 1]).sum())
    if (counts != counts[0]).any() or not (inside[places - 1] & inside[places + 1]).all():
        return None
    if counts[0] == 1 and doubled == 0:
        return b"/"
    if counts[0] == 2 and doubled in (0, len(begins)):
        return b"//" if doubled else b"/ /"
    return None


def _without_keyword(
    lines: bytes, keyword_length: int
) -> tuple[NDArray[np.uint8], NDArray[np.int64]]:
    """The characters with each line's keyword blanked, and where the lines start."""
    content = np.frombuffer(lines, dtype=np.uint8).copy()
    ends = np.flatnonzero(content == _LF)
    starts = np.concatenate([[0], ends[:-1] + 1])
    for i in range(keyword_length):
        content[starts + i] = ord(" ")
    return content, starts


def _words_per_line(content: NDArray[np.uint8], starts: NDArray[np.int64]) -> NDArray[np.int64]:
    inside = content > ord(" ")
    begins = inside.copy()
    begins[1:] &= ~inside[:-1]
    return np.add.reduceat(begins, starts, dtype=np.int64)


def _all_exist(indices: NDArray[np.int64], lowest: int, count: int) -> bool:
    return not indices.size or (
        int(indices.min()) >= lowest and int(indices.max()) < min(count, _FACE_LARGEST)
    )
