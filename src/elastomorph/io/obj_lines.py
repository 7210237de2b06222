"""Reads the text of an OBJ file one line at a time, and says what is wrong with it and where.

This is the reader that decides what an OBJ file may hold; `obj_table` is quicker and must agree.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError
from elastomorph.io.obj_statements import (
    IGNORED,
    NAMING,
    VERTEX_COLUMNS,
    Dropped,
    Naming,
    ObjStatements,
    is_continued,
    name_in,
    without_comment,
)

__all__ = ["read_lines"]

# Each piece can match in one way only: a long word that is no number is refused in one pass.
_NUMBER = re.compile(rb"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_INDEX = re.compile(rb"[+-]?[0-9]+")
_TEXTURE = re.compile(rb"^[ \t\v\f]*vt(?:\s|\\)", re.MULTILINE)
_TWO_CORNERS = "the polygon has two corners and shows no surface; it is left out"
_STRAY = {
    b"t": "'t' is no keyword of the OBJ format; the line is left out",
    b"vw": "'vw' is no keyword of the OBJ format; the line is left out",
}
_LARGEST_INDEX = int(np.iinfo(np.int32).max)


def read_lines(path: str | Path, text: bytes) -> ObjStatements:
    """The statements of an OBJ file.

    Args:
        path: The file as the user named it, for messages.
        text: Its content, with lines that end in LF.

    Raises:
        FormatError: A statement is not what the format allows; the message names its line.
    """
    reader = _LineReader(has_texture=_TEXTURE.search(text) is not None)
    for line, keyword, statement in _statements(text):
        try:
            reader.take(line, keyword, statement)
        except _StatementError as problem:
            raise FormatError(path, str(problem), line=line) from None
    found = reader.found()
    vertices, texture = len(found.vertices), len(found.texture)
    if not vertices:
        raise FormatError(path, "there are no vertices; expected lines such as 'v 0.5 1.25 -3'")
    _require_existing(path, found, found.corners, vertices, "vertex", "vertices")
    if texture:
        _require_existing(path, found, found.texture_corners, texture, "vt", "vt lines")
    return found


class _LineReader:
    """Collects statements one after another."""

    def __init__(self, *, has_texture: bool) -> None:
        self._has_texture = has_texture
        self._vertices: list[list[float]] = []
        self._texture: list[list[float]] = []
        self._corners: list[tuple[int, int]] = []
        self._sizes: list[int] = []
        self._face_lines: list[int] = []
        self._namings: dict[bytes, list[Naming]] = {keyword: [] for keyword in NAMING}
        self._dropped: dict[str, list[int]] = {}

    def take(self, line: int, keyword: bytes, statement: bytes) -> None:
        """Take one statement.

        Raises:
            _StatementError: It is not what the format allows.
        """
        if keyword == b"v":
            self._vertices.append(_vertex(statement.split()[1:]))
        elif keyword == b"vt":
            self._texture.append(_texture(statement.split()[1:]))
        elif keyword in (b"f", b"fo"):
            self._take_face(line, statement.split()[1:])
        elif keyword in NAMING:
            self._namings[keyword].append(Naming(line, name_in(statement)))
        elif keyword in _STRAY:
            self._dropped.setdefault(_STRAY[keyword], []).append(line)
        elif keyword not in IGNORED:
            raise _StatementError(_unknown(keyword))

    def _take_face(self, line: int, words: list[bytes]) -> None:
        texture = len(self._texture) if self._has_texture else None
        corners = [_corner(word, len(self._vertices), texture) for word in words]
        if len(corners) == 2:
            self._dropped.setdefault(_TWO_CORNERS, []).append(line)
            return
        if len(corners) < 3:
            raise _StatementError(
                f"a polygon needs at least 3 vertices, found {len(corners)}; complete or delete it"
            )
        self._corners += corners
        self._sizes.append(len(corners))
        self._face_lines.append(line)

    def found(self) -> ObjStatements:
        """What was taken."""
        corners = np.array(self._corners, dtype=np.int64).reshape(-1, 2)
        groups = self._namings[b"g"] + self._namings[b"o"]
        return ObjStatements(
            vertices=np.array(self._vertices, dtype=np.float64),
            texture=_padded(self._texture),
            corners=corners[:, 0],
            texture_corners=corners[:, 1],
            sizes=np.array(self._sizes, dtype=np.int64),
            face_lines=np.array(self._face_lines, dtype=np.int64),
            materials=self._namings[b"usemtl"],
            groups=sorted(groups, key=lambda naming: naming.line),
            libraries=[naming.name for naming in self._namings[b"mtllib"]],
            dropped=[Dropped(lines[0], len(lines), what) for what, lines in self._dropped.items()],
        )


class _StatementError(ValueError):
    """What is wrong with a statement; a FormatError as soon as its line is known."""


def _statements(text: bytes) -> Iterator[tuple[int, bytes, bytes]]:
    """Line number, keyword and text of each statement, without comments and continuations."""
    lines = enumerate(text.split(b"\n"), start=1)
    for number, line in lines:
        words = line.split(None, 1)
        if not words or words[0].startswith(b"#"):
            continue
        keyword = words[0].removesuffix(b"\\")
        last = line
        parts = [without_comment(last, keyword)]
        while is_continued(last, keyword) and parts[-1] == last:  # a comment is not continued
            parts[-1] = last[:-1]
            last = next(lines, (0, b""))[1]
            parts.append(without_comment(last, keyword))
        yield number, keyword, b" ".join(parts)


def _vertex(words: list[bytes]) -> list[float]:
    if len(words) not in VERTEX_COLUMNS:
        raise _StatementError(
            "expected 'v x y z', optionally followed by a weight, a colour r g b or both, found "
            f"{len(words)} numbers"
        )
    return [_number(word) for word in words][:3]


def _texture(words: list[bytes]) -> list[float]:
    if not 1 <= len(words) <= 3:
        raise _StatementError(
            f"expected 'vt u', 'vt u v' or 'vt u v w', found {len(words)} numbers"
        )
    return [_number(word) for word in words]


def _number(word: bytes) -> float:
    if not _NUMBER.fullmatch(word):
        advice = ""
        if b"," in word and _NUMBER.fullmatch(word.replace(b",", b".")):
            advice = "; write decimals with a point"
        raise _StatementError(f"expected a finite decimal number, found '{_shown(word)}'{advice}")
    value = float(word)
    if not math.isfinite(value):
        raise _StatementError(f"the number '{_shown(word)}' is larger than a 64-bit float can hold")
    return value


def _corner(word: bytes, vertices: int, coordinates: int | None) -> tuple[int, int]:
    """Vertex and vt of one polygon corner, both counted from 0, -1 for no vt.

    The index of a normal must be a whole number; as normals are not kept, it may be any. So may
    that of a vt where ``coordinates`` says that the file has none.
    """
    parts = word.split(b"/")
    well_formed = 1 <= len(parts) <= 3 and _INDEX.fullmatch(parts[0])
    if not well_formed or not all(not part or _INDEX.fullmatch(part) for part in parts[1:]):
        raise _StatementError(
            "expected the corners of a polygon as 'v', 'v/vt', 'v//vn' or 'v/vt/vn' with whole "
            f"numbers, found '{_shown(word)}'"
        )
    vertex = _index(parts[0], vertices, "vertices")
    if len(parts) == 1 or not parts[1]:
        return vertex, -1
    return vertex, 0 if coordinates is None else _index(parts[1], coordinates, "vt lines")


def _index(word: bytes, so_far: int, what: str) -> int:
    # Python refuses to read very many digits, even zeros.
    digits = word.lstrip(b"+-").lstrip(b"0") or b"0"
    if len(digits) > 10 or int(digits) > _LARGEST_INDEX:
        raise _StatementError(f"the index '{_shown(word)}' is far beyond the {what} of any file")
    number = -int(digits) if word.startswith(b"-") else int(digits)
    if number == 0:
        raise _StatementError(f"the index 0 is not allowed: {what} are counted from 1")
    if number > 0:
        return number - 1
    if -number > so_far:
        raise _StatementError(
            f"the relative index {number} counts back beyond the first of the {so_far:,} {what} "
            "above this line"
        )
    return so_far + number


def _padded(texture: list[list[float]]) -> NDArray[np.float64]:
    columns = 3 if any(len(row) == 3 for row in texture) else 2
    padded = [row + [0.0] * (columns - len(row)) for row in texture]
    return np.array(padded, dtype=np.float64).reshape(-1, columns)


def _require_existing(
    path: str | Path,
    found: ObjStatements,
    indices: NDArray[np.int64],
    count: int,
    one: str,
    many: str,
) -> None:
    beyond = indices >= count
    if beyond.any():
        corner = int(np.argmax(beyond))
        face = int(np.searchsorted(np.cumsum(found.sizes), corner, side="right"))
        raise FormatError(
            path,
            f"the polygon names {one} {int(indices[corner]) + 1:,}, but the file has {count:,} "
            f"{many}; it may have been cut off or put together from two files",
            line=int(found.face_lines[face]),
        )


def _unknown(keyword: bytes) -> str:
    if keyword in (b"call", b"csh"):
        return f"'{_shown(keyword)}' draws in other files, which is not supported; merge them first"
    return (
        f"unknown keyword '{_shown(keyword)}'; expected v, vt, vn, f, g, o, s, usemtl, mtllib, "
        "another keyword of the OBJ format, or # before a comment"
    )


def _shown(word: bytes) -> str:
    shown = word[:80].decode("ascii", "backslashreplace")
    printable = "".join(c if c.isprintable() else f"\\x{ord(c):02x}" for c in shown)
    return printable if len(printable) <= 40 else printable[:37] + "..."
