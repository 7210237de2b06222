"""Reads Wavefront OBJ text: all statements of a kind at once, one by one where one is unusual.

Ordinary files convert as tables. What does not is read strictly, corner by corner, which takes
three times as long and either gives the same or says what is wrong and where.
"""

from __future__ import annotations

import math
import re
from bisect import bisect
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError, warn
from elastomorph.io.atomic import read_bytes
from elastomorph.io.obj.statements import (
    Rows,
    StatementError,
    Statements,
    encoding_of,
    plain_text,
    shown,
)
from elastomorph.io.untrusted import naming_file
from elastomorph.model.mesh import FaceLabels, Mesh, Source, UVMap
from elastomorph.model.polygons import Polygons

__all__ = ["read_obj"]

# Each piece can match in one way only: a long word that is no number is refused in one pass.
_NUMBER = re.compile(rb"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_INDEX = re.compile(rb"[+-]?[0-9]+")
_LARGEST_INDEX = int(np.iinfo(np.int32).max)

VERTEX_COLUMNS = (3, 4, 6, 7)
_VERTEX = "expected 'v x y z', optionally followed by a weight, a colour r g b or both"
_TEXTURE_COLUMNS = (1, 2, 3)
_TEXTURE = "expected 'vt u', 'vt u v' or 'vt u v w'"

Indices = NDArray[np.int64]


def read_obj(path: str | Path) -> Mesh:
    """The mesh in an OBJ file.

    Materials (``usemtl``) and groups (the last ``g`` or ``o`` above a polygon) become its labels,
    ``vt`` its texture coordinates, ``mtllib`` the name of its material library. Lines may end in
    LF, CR LF or CR, the file in NUL bytes. Names that are not UTF-8 are read as Latin-1, which has
    a letter for every byte, and `write_obj` writes those bytes again.

    What looks like part of the surface but is not is passed over with a warning: texture indices
    in a file without ``vt``, polygons of two corners, and the lines ``vw`` and ``t``.
    """
    found = Statements(plain_text(path, read_bytes(path)))
    faces = _Faces(found)
    tables: list[NDArray[np.float64]] = []
    steps: tuple[Callable[[], None], ...] = (
        lambda: tables.append(read_table(found.vertices, VERTEX_COLUMNS, _VERTEX)),
        lambda: tables.append(read_table(found.texture, _TEXTURE_COLUMNS, _TEXTURE)),
        faces.read,
    )
    for read in steps:
        try:
            read()
        except StatementError as problem:
            found.problems.append(problem)
    if found.problems:
        first = min(found.problems, key=lambda problem: problem.line)
        raise FormatError(path, str(first), line=first.line)
    vertices, texture = tables
    if not len(vertices):
        raise FormatError(path, "there are no vertices; expected lines such as 'v 0.5 1.25 -3'")
    faces.require_existing(path)
    _warn(path, found, faces)
    return _mesh(path, found, vertices, texture, faces)


def read_table(rows: Rows, columns: Sequence[int], expected: str) -> NDArray[np.float64]:
    """(rows, widest) float64, padded with zeros."""
    bodies = rows.without_comments()
    widths = {len(body.split()) for body in bodies}
    text = b" ".join(bodies)
    # float alone would take 1_0, nan and inf.
    if len(widths) == 1 and widths.issubset(columns) and b"_" not in text:
        with suppress(ValueError):
            values = np.array(list(map(float, text.split())))
            if np.isfinite(values).all():
                return values.reshape(len(bodies), -1)
    table = np.zeros((len(bodies), max(widths, default=0)))
    for row, line, body in zip(table, rows.lines, bodies, strict=True):
        own = body.split()
        if len(own) not in columns:
            raise StatementError(line, f"{expected}, found {len(own)} numbers")
        row[: len(own)] = [_number(line, word) for word in own]
    return table


def _number(line: int, word: bytes) -> float:
    if not _NUMBER.fullmatch(word):
        comma = b"," in word and _NUMBER.fullmatch(word.replace(b",", b"."))
        advice = "; write decimals with a point" if comma else ""
        raise StatementError(
            line, f"expected a finite decimal number, found '{shown(word)}'{advice}"
        )
    if math.isfinite(value := float(word)):
        return value
    raise StatementError(line, f"the number '{shown(word)}' is larger than a 64-bit float can hold")


class _Faces:
    """The polygons of a file: the line and the number of corners of each (F,).

    Each corner (C,) has a vertex, counted from 0, and a ``vt``: -1 for none, any where the file has
    no ``vt`` at all. Lines of polygons with two corners, which show no surface, are kept apart.
    """

    def __init__(self, found: Statements) -> None:
        self._rows = found.faces
        self._above = (found.vertices.lines, found.texture.lines)
        self.two_corners: list[int] = []

    def read(self) -> None:
        """Read the statements, or raise StatementError where one is not what the format allows."""
        bodies = self._rows.without_comments()
        self.lines = self._rows.lines
        self.sizes = np.array([len(body.split()) for body in bodies], dtype=np.int64)
        indices = self._alike(b" ".join(bodies))
        if indices is None:
            read = list(self._one_by_one(bodies))
            self.lines = [line for line, _ in read]
            self.sizes = np.array([len(corners) for _, corners in read], dtype=np.int64)
            every = [corner for _, corners in read for corner in corners]
            indices = np.array(every, dtype=np.int64).reshape(-1, 2)
        self.corners, self.texture_corners = indices[:, 0], indices[:, 1]

    def _alike(self, text: bytes) -> Indices | None:
        """(C, 2) vertex and vt, if all corners are written alike and name what is there."""
        if not text or self.sizes.min() < 3:
            return None
        count = int(self.sizes.sum())
        marks = text.translate(None, b"0123456789").split()  # what stands between the numbers
        between = set(marks)
        if len(between) > 1 or len(marks) != (count if between else 0):
            return None
        values = np.fromstring(text.replace(b"/", b" "), dtype=np.int64, sep=" ")
        width, left = divmod(values.size, count)
        styles = {(b"", 1): 0, (b"/", 2): 1, (b"//", 3): 1}
        if text.count(b"//") == count:  # and not v/vt/vn
            styles = {(b"//", 2): 0}
        textured = styles.get((next(iter(between), b""), width))
        if left or textured is None:
            return None
        table = values.reshape(count, width)
        indices = np.full((count, 2), -1, dtype=np.int64)
        indices[:, : 1 + textured] = table[:, : 1 + textured] - 1
        vertices, texture = map(len, self._above)
        if not texture:
            indices[:, 1] = np.minimum(indices[:, 1], 0)
        exist = (indices >= (0, 0 if textured and texture else -1)) & (
            indices < (vertices, max(texture, 1))
        )
        return indices if exist.all() else None

    def _one_by_one(self, bodies: list[bytes]) -> Iterator[tuple[int, list[tuple[int, int]]]]:
        """Line and corners of each polygon."""
        vertex_lines, texture_lines = self._above
        for line, body in zip(self._rows.lines, bodies, strict=True):
            vertices = bisect(vertex_lines, line)
            texture = bisect(texture_lines, line) if texture_lines else None
            corners = [_corner(line, word, vertices, texture) for word in body.split()]
            if len(corners) == 2:
                self.two_corners.append(line)
                continue
            if len(corners) < 3:
                problem = f"needs at least 3 vertices, found {len(corners)}; complete or delete it"
                raise StatementError(line, f"a polygon {problem}")
            yield line, corners

    def require_existing(self, path: str | Path) -> None:
        """Refuse polygons that name what is not in the file."""
        vertices, texture = map(len, self._above)
        for indices, count, one, many in (
            (self.corners, vertices, "vertex", "vertices"),
            (self.texture_corners, texture or np.inf, "vt", "vt lines"),
        ):
            beyond = indices >= count
            if beyond.any():
                corner = int(np.argmax(beyond))
                raise FormatError(
                    path,
                    f"the polygon names {one} {int(indices[corner]) + 1:,}, but the file has "
                    f"{count:,} {many}; it may have been cut off or put together from two files",
                    line=self.lines[self._face_of(corner)],
                )

    def without_texture(self) -> list[int]:
        """Lines of the polygons that name texture coordinates in a file that has none."""
        if self._above[1]:
            return []
        naming = np.flatnonzero(self.texture_corners >= 0)
        return [self.lines[face] for face in np.unique(self._face_of(naming)).tolist()]

    def _face_of(self, corner: Indices | int) -> Indices:
        return np.searchsorted(np.cumsum(self.sizes), corner, side="right")


def _corner(line: int, word: bytes, vertices: int, coordinates: int | None) -> tuple[int, int]:
    """Vertex and vt of one polygon corner, both counted from 0, -1 for no vt.

    The index of a normal must be a whole number; as normals are not kept, it may be any. So may
    that of a vt where ``coordinates`` says that the file has none.
    """
    parts = word.split(b"/")
    well_formed = 1 <= len(parts) <= 3 and _INDEX.fullmatch(parts[0])
    if not well_formed or not all(not part or _INDEX.fullmatch(part) for part in parts[1:]):
        raise StatementError(
            line,
            "expected the corners of a polygon as 'v', 'v/vt', 'v//vn' or 'v/vt/vn' with whole "
            f"numbers, found '{shown(word)}'",
        )
    vertex = _index(line, parts[0], vertices, "vertices")
    if len(parts) == 1 or not parts[1]:
        return vertex, -1
    return vertex, 0 if coordinates is None else _index(line, parts[1], coordinates, "vt lines")


def _index(line: int, word: bytes, so_far: int, what: str) -> int:
    # Python refuses to read very many digits, even zeros.
    digits = word.lstrip(b"+-").lstrip(b"0") or b"0"
    if len(digits) > 10 or int(digits) > _LARGEST_INDEX:
        raise StatementError(
            line, f"the index '{shown(word)}' is far beyond the {what} of any file"
        )
    number = -int(digits) if word.startswith(b"-") else int(digits)
    if number == 0:
        raise StatementError(line, f"the index 0 is not allowed: {what} are counted from 1")
    if number > 0:
        return number - 1
    if -number > so_far:
        raise StatementError(
            line,
            f"the relative index {number} counts back beyond the first of the {so_far:,} {what} "
            "above this line",
        )
    return so_far + number


def _warn(path: str | Path, found: Statements, faces: _Faces) -> None:
    """Say what is not kept although it looks as if it should be, in the order of first lines."""
    left_out = [
        (lines, f"'{keyword.decode()}' is no keyword of the OBJ format; the line is left out")
        for keyword, lines in found.stray.items()
    ]
    shows_nothing = "the polygon has two corners and shows no surface; it is left out"
    left_out = sorted(each for each in [*left_out, (faces.two_corners, shows_nothing)] if each[0])
    without_texture = (
        "the polygon names texture coordinates, but the file has no vt lines; it is read without "
        "them"
    )
    for lines, what in [*left_out, (faces.without_texture(), without_texture)]:
        if lines:
            warn(f"{path}, line {lines[0]}: {what} ({len(lines):,} in the file, this is the first)")


def _mesh(
    path: str | Path,
    found: Statements,
    vertices: NDArray[np.float64],
    texture: NDArray[np.float64],
    faces: _Faces,
) -> Mesh:
    uv = None
    if len(texture):
        texture = np.pad(texture, ((0, 0), (0, max(0, 2 - texture.shape[1]))))
        uv = UVMap(texture, faces.texture_corners.astype(np.int32))
    names = found.names
    groups = sorted(names[b"g"] + names[b"o"])
    libraries = [name for _, name in names[b"mtllib"]]
    encoding = encoding_of([*(name for _, name in names[b"usemtl"] + groups), *libraries])
    library = b" ".join(filter(None, dict.fromkeys(libraries)))
    with naming_file(path):
        return Mesh(
            np.ascontiguousarray(vertices[:, :3]),
            Polygons(faces.corners, np.concatenate([[0], np.cumsum(faces.sizes)])),
            uv=uv,
            materials=_labels(names[b"usemtl"], faces.lines, encoding),
            groups=_labels(groups, faces.lines, encoding),
            material_library=library.decode(encoding) or None,
            source=Source(str(path), np.array(faces.lines, dtype=np.int32), encoding),
        )


def _labels(
    names: list[tuple[int, bytes]], face_lines: list[int], encoding: str
) -> FaceLabels | None:
    """The name that holds at each polygon."""
    holding = np.searchsorted([line for line, _ in names], face_lines) - 1
    used, of_face = np.unique(holding, return_inverse=True)
    known: dict[str, int] = {}
    numbers = np.full(len(used), -1, dtype=np.int32)
    for i, statement in enumerate(used):
        name = names[statement][1].decode(encoding) if statement >= 0 else ""
        if name:
            numbers[i] = known.setdefault(name, len(known))
    return FaceLabels(tuple(known), numbers[of_face.reshape(-1)]) if known else None
