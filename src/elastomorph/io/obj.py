"""Wavefront OBJ: meshes of polygons as text, the file most scans and face rigs come in.

Vertices keep their order and polygons their corners, whatever texture coordinates, normals,
groups or materials say. What is not kept: a vertex's weight and colour (columns 4 to 7 of ``v``,
as MeshLab and some scanners write them; colours are read where they are asked for), normals
(``vn``; they go stale as soon as a vertex moves), smoothing groups, points, lines, curves and
surfaces.

All statements of a kind are read at once, one by one where one is unusual: ordinary files convert
as tables. What does not is read strictly, corner by corner, which takes three times as long and
either gives the same or says what is wrong and where. Every number is written as the shortest
decimal that reads back bit for bit.
"""

from __future__ import annotations

import math
import re
from bisect import bisect
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError, warn
from elastomorph.io.atomic import read_bytes, replacing
from elastomorph.io.untrusted import naming_file
from elastomorph.model.mesh import FaceLabels, Mesh, Source, UVMap
from elastomorph.model.polygons import Polygons


def write_obj(path: str | Path, mesh: Mesh) -> None:
    """Write a mesh as OBJ: vertices, polygons, texture coordinates, materials and groups.

    Reading the file gives back the same mesh, coordinates bit for bit. Names stand in it as in the
    file that the mesh was read from, if that was OBJ, and in UTF-8 otherwise. Whose the mesh is
    stands in a comment, which is not read back.
    """
    encoding = _encoding(mesh)
    lines = [f"# {said}" for said in ownership(mesh, encoding)]
    if mesh.material_library is not None:
        lines.append(_naming(path, "mtllib", mesh.material_library, encoding))
    lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in mesh.vertices.tolist()]
    if mesh.uv is not None and not np.isfinite(mesh.uv.coordinates).all():
        raise FormatError(path, "texture coordinates that are not finite cannot be written")
    places, polygons = _statements(mesh.faces, mesh.uv)
    lines += places
    switches = _switches(path, mesh, encoding)
    for face, statement in enumerate(polygons):
        if face in switches:
            lines += switches[face]
        lines.append(statement)
    content = "\n".join([*lines, ""]).encode(encoding)
    with replacing(path) as file:
        file.write(content)


@lru_cache(maxsize=1)
def _statements(faces: Polygons, uv: UVMap | None) -> tuple[list[str], list[str]]:
    """Texture coordinates and one ``f`` a polygon, kept for the next of many poses of one mesh."""
    corners = list(map(str, (faces.indices + 1).tolist()))
    places: list[str] = []
    if uv is not None:
        places = ["vt " + " ".join(map(repr, row)) for row in uv.coordinates.tolist()]
        corners = [
            f"{corner}/{coordinate}" if coordinate else corner
            for corner, coordinate in zip(corners, (uv.corners + 1).tolist(), strict=True)
        ]
    bounds = pairwise(faces.offsets.tolist())
    return places, ["f " + " ".join(corners[start:stop]) for start, stop in bounds]


def _switches(path: str | Path, mesh: Mesh, encoding: str) -> dict[int, list[str]]:
    """The ``g`` and ``usemtl`` statements that go before a polygon, by polygon."""
    switches: dict[int, list[str]] = {}
    for keyword, labels in (("g", mesh.groups), ("usemtl", mesh.materials)):
        if labels is None:
            continue
        used: NDArray[np.int32] = np.unique(labels.of_face[labels.of_face >= 0])
        statements = {-1: keyword}
        for name in used.tolist():
            statements[name] = _naming(path, keyword, labels.names[name], encoding)
        # where the label is not that of the polygon before; none comes before the first
        for face in np.flatnonzero(np.diff(labels.of_face, prepend=np.int32(-1))).tolist():
            switches.setdefault(face, []).append(statements[int(labels.of_face[face])])
    return switches


def _encoding(mesh: Mesh) -> str:
    """That of the file the mesh came from, unless a name has been added that it cannot hold."""
    names = [name for labels in (mesh.materials, mesh.groups) if labels for name in labels.names]
    encoding = mesh.source.encoding if mesh.source else "utf-8"
    try:
        "\n".join([*names, mesh.material_library or ""]).encode(encoding)
    except UnicodeEncodeError:
        return "utf-8"
    return encoding


def ownership(mesh: Mesh, encoding: str) -> list[str]:
    """Whose the mesh is, as the one line of a comment; none where that is not known."""
    shown = "".join(sign if sign.isprintable() else " " for sign in mesh.copyright)
    line = " ".join(shown.split()).rstrip("\\ ")  # at which some programs go on with the next line
    return [line.encode(encoding, "replace").decode(encoding)] if line else []


def _naming(path: str | Path, keyword: str, name: str, encoding: str) -> str:
    """The statement, if a reader of OBJ would get back just that name."""
    try:
        statement = f"{keyword} {name}".encode(encoding)
        lines = statement.replace(b"\r", b"\n").split(b"\n")
        kept = name_in(without_comment(lines[0], keyword.encode())) == name.encode(encoding)
    except UnicodeEncodeError:
        kept = False
    if not (name and kept) or b"\0" in statement or is_continued(statement, keyword.encode()):
        raise FormatError(
            path,
            f"the name {name!r} cannot be written as '{keyword}' of an OBJ file: it must be one "
            "line of text without blanks at its ends, a lone # or a final backslash",
        )
    return f"{keyword} {name}"


NAMING = frozenset({b"usemtl", b"mtllib", b"g", b"o"})

IGNORED = frozenset(
    # normals go stale as soon as a vertex moves; smoothing, points and lines are not polygons
    b"vn s l p mg lod bevel c_interp d_interp usemap maplib shadow_obj trace_obj ctech stech "
    # curves and surfaces
    b"vp deg bmat step cstype curv curv2 surf parm trim hole scrv sp end con "
    # statements that version 2 of the format already called superseded
    b"bsp bzp cdc cdp res".split()
)

_UTF8_MARK = b"\xef\xbb\xbf"
_UTF16_MARKS = (b"\xff\xfe", b"\xfe\xff")

_STRAY = (b"t", b"vw")
_COMMENT_AFTER_NAME = re.compile(rb"(?:^|(?<=[ \t]))#(?=[ \t]|$)")


class StatementError(ValueError):
    """What is wrong with the statement on a line."""

    def __init__(self, line: int, problem: str) -> None:
        super().__init__(problem)
        self.line = line


class Rows:
    """The statements of one keyword: the line of each, from 1, and what follows the keyword."""

    def __init__(self) -> None:
        self.lines: list[int] = []
        self.bodies: list[bytes] = []

    def without_comments(self) -> list[bytes]:
        """What follows the keyword, up to the comment."""
        if not any(b"#" in body for body in self.bodies):
            return self.bodies
        return [body.partition(b"#")[0] for body in self.bodies]


class Statements:
    """The statements of an OBJ file that matter.

    Attributes:
        vertices: The ``v`` statements.
        texture: The ``vt`` statements.
        faces: The ``f`` statements.
        names: ``(line, name)`` of each ``usemtl``, ``g``, ``o`` and ``mtllib`` by keyword; the
            name holds from its line on, and is empty for none.
        stray: Lines of statements that are no part of the format but common in files.
        problems: What is wrong with the first statement whose keyword is unknown, if any is.
    """

    def __init__(self, text: bytes) -> None:
        """Take apart a text whose lines end in LF."""
        self.vertices, self.texture, self.faces = Rows(), Rows(), Rows()
        self.names: dict[bytes, list[tuple[int, bytes]]] = {keyword: [] for keyword in NAMING}
        self.stray: dict[bytes, list[int]] = {keyword: [] for keyword in _STRAY}
        self.problems: list[StatementError] = []
        rows = {b"v": self.vertices, b"vt": self.texture, b"f": self.faces, b"fo": self.faces}
        takers = {key: (own.lines.append, own.bodies.append) for key, own in rows.items()}
        lines = text.split(b"\n")
        if b"\\\n" in text or text.endswith(b"\\"):
            _join_continued(lines)
        for number, line in enumerate(lines, start=1):
            keyword, _, body = line.partition(b" ")
            take = takers.get(keyword)
            if take is None:
                if keyword in IGNORED:
                    continue
                words = line.split(None, 1)
                if not words or words[0].startswith(b"#"):
                    continue
                keyword = words[0].removesuffix(b"\\")
                body = words[1] if len(words) > 1 else b""
                take = takers.get(keyword)
            if take is not None:
                take[0](number)
                take[1](body)
            else:
                self._take_other(number, keyword, line)

    def _take_other(self, number: int, keyword: bytes, line: bytes) -> None:
        if keyword in NAMING:
            self.names[keyword].append((number, name_in(without_comment(line, keyword))))
        elif keyword in _STRAY:
            self.stray[keyword].append(number)
        elif keyword not in IGNORED and not self.problems:
            problem = (
                "unknown keyword '{}'; expected v, vt, vn, f, g, o, s, usemtl, mtllib, another "
            )
            problem += "keyword of the OBJ format, or # before a comment"
            if keyword in (b"call", b"csh"):
                problem = "'{}' draws in other files, which is not supported; merge them first"
            problem = problem.format(shown(keyword))
            self.problems.append(StatementError(number, problem))


def plain_text(path: str | Path, content: bytes) -> bytes:
    """The content with lines that end in LF."""
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
    return text


def _join_continued(lines: list[bytes]) -> None:
    """Put statements that a backslash continues on their first line; the others become empty."""
    rest = enumerate(lines)
    for number, line in rest:
        words = line.split(None, 1)
        if not words or words[0].startswith(b"#") or not line.endswith(b"\\"):
            continue
        keyword = words[0].removesuffix(b"\\")
        parts = [without_comment(line, keyword)]
        while is_continued(line, keyword) and parts[-1] == line:  # a comment is not continued
            parts[-1] = line[:-1]
            place, line = next(rest, (0, b""))
            parts.append(without_comment(line, keyword))
            if place:
                lines[place] = b""
        lines[number] = b" ".join(parts) if keyword else words[0] + b" " + b" ".join(parts)


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
    in_letter = keyword in NAMING and line[-2:-1] >= b"\x81" and encoding_of([line]) != "utf-8"
    return line.endswith(b"\\") and not in_letter


def name_in(statement: bytes) -> bytes:
    """All that follows the keyword, blanks inside included; empty where nothing does."""
    return b"".join(statement.split(None, 1)[1:]).strip()


def encoding_of(names: Sequence[bytes]) -> Literal["utf-8", "latin-1"]:
    """UTF-8, or Latin-1 where that cannot be: every byte is a letter of it, and comes back."""
    try:
        for name in names:
            name.decode("utf-8")
    except UnicodeDecodeError:
        return "latin-1"
    return "utf-8"


def shown(word: bytes) -> str:
    """A word of a file for a message: printable, and not long."""
    text = word[:80].decode("ascii", "backslashreplace")
    printable = "".join(c if c.isprintable() else f"\\x{ord(c):02x}" for c in text)
    return printable if len(printable) <= 40 else printable[:37] + "..."


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
