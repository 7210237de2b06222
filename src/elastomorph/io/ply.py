"""Stanford PLY: vertices and polygons, as ASCII or binary of either byte order.

Only positions, bit for bit, and polygons are read and written, and colours of vertices and images
read where they are asked for. Normals and whatever else a file holds are passed over; groups have
no place in PLY. Nothing is allocated for rows that the rest of the file could not hold.

PLY itself knows of no images. By common use, as programs of photogrammetry write them, the header
names them in lines ``comment TextureFile``, the polygons have a list ``texcoord`` of u and v for
each corner and ``texnumber``, which image they show; or the vertices have ``s`` and ``t``, also
called ``u`` and ``v``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError, ParameterError
from elastomorph.io.atomic import is_file, read_bytes, replacing
from elastomorph.io.mtl import image_beside
from elastomorph.io.obj import ownership
from elastomorph.io.untrusted import naming_file
from elastomorph.model.mesh import FaceLabels, Material, Mesh, Source, UVMap
from elastomorph.model.polygons import Polygons

ENCODINGS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
"""Name of each encoding, and the byte order NumPy knows it by."""

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1",
    "short": "i2", "int16": "i2", "ushort": "u2", "uint16": "u2",
    "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
_LONGEST_HEADER = 1 << 20
_MOST_PROPERTIES = 1000
_LONGEST_NAME = 100


class Property(NamedTuple):
    """A number, or where it has the type of a length, a list of numbers with its length before it.

    The types have the byte order of the file.
    """

    name: str
    kind: np.dtype[np.generic]
    length: np.dtype[np.generic] | None = None


@dataclass(frozen=True)
class Element:
    """A table of the file: ``length`` rows, each with the same properties."""

    name: str
    length: int
    properties: list[Property] = field(default_factory=list)

    def place(self, *names: str) -> int | None:
        """The place of the first property of the first of the names that there is."""
        own = [p.name for p in self.properties]
        return next((own.index(name) for name in names if name in own), None)


class PlyHeader(NamedTuple):
    """The header: byte order (a value of `ENCODINGS`), elements, its bytes and lines, images."""

    order: str
    elements: list[Element]
    size: int
    lines: int
    images: tuple[str, ...]


def read_header(path: str | Path, content: bytes) -> PlyHeader:
    """The header of a PLY file."""
    newline = next((n for n in (b"\r\n", b"\n", b"\r") if content.startswith(b"ply" + n)), None)
    if newline is None:
        raise FormatError(path, "this is not a PLY file: it does not begin with the line 'ply'")
    order: str | None = None
    elements: list[Element] = []
    images: list[str] = []
    line, position = 1, len(b"ply" + newline)
    while True:
        line += 1
        end = content.find(newline, position, _LONGEST_HEADER)
        if end < 0:
            raise FormatError(path, "the header has no line 'end_header'; the file was cut off")
        row = content[position:end]
        words = row.decode("ascii", "backslashreplace").split()
        position = end + len(newline)
        if words == ["end_header"]:
            break
        try:
            if not words or words[0] in ("comment", "obj_info"):
                if words[:2] == ["comment", "TextureFile"]:
                    images.append(row.decode("utf-8", "replace").split(None, 2)[-1].strip())
                continue
            if words[0] == "format":
                order = _order(words)
            elif words[0] == "element":
                elements.append(_element(words))
            elif words[0] == "property" and elements and order is not None:
                elements[-1].properties.append(_property(words, order))
                if len(elements[-1].properties) > _MOST_PROPERTIES:
                    raise ValueError(f"expected at most {_MOST_PROPERTIES:,} properties")
            else:
                raise ValueError("expected format, then element and property, then end_header")
        except ValueError as expected:
            shown = " ".join(words)[:80]
            raise FormatError(path, f"{expected}, found '{shown}'", line=line) from None
    if order is None:
        raise FormatError(path, "the header has no line 'format'")
    return PlyHeader(order, elements, position, line, tuple(images))


def _order(words: list[str]) -> str:
    if len(words) != 3 or words[1] not in ENCODINGS or words[2] != "1.0":
        raise ValueError(f"expected 'format', one of {', '.join(ENCODINGS)}, and version 1.0")
    return ENCODINGS[words[1]]


def _element(words: list[str]) -> Element:
    if (
        len(words) != 3
        or not words[2].isdecimal()
        or len(words[2]) > 18
        or len(words[1]) > _LONGEST_NAME
    ):
        raise ValueError("expected 'element', a name and how many there are")
    return Element(words[1], int(words[2]))


def _property(words: list[str], order: str) -> Property:
    if len(words[-1]) > _LONGEST_NAME:
        raise ValueError(f"expected a name of at most {_LONGEST_NAME} characters")
    if len(words) == 3 and words[1] in _TYPES:
        return Property(words[2], np.dtype(order + _TYPES[words[1]]))
    if len(words) == 5 and words[1] == "list" and words[2] in _TYPES and words[3] in _TYPES:
        count, kind = (np.dtype(order + _TYPES[word]) for word in words[2:4])
        if count.kind in "iu":
            return Property(words[4], kind, count)
    raise ValueError(
        "expected 'property TYPE NAME' or 'property list INTEGER-TYPE TYPE NAME' with types out "
        f"of {', '.join(_TYPES)}"
    )


_OF_VERTICES = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"))


def with_ply_looks(mesh: Mesh) -> Mesh:
    """A mesh with the images that its PLY names; any other is returned as it is.

    An image that cannot be had is a `Texture` without content, which says why.

    Raises:
        FileError: The file cannot be read.
        FormatError: It is damaged, or its coordinates are not two for each corner.
    """
    if mesh.source is None or not is_file(mesh.source.path):
        return mesh
    path = Path(mesh.source.path)
    content = read_bytes(path)
    header = read_header(path, content)
    require_surface(path, header)
    uv = _coordinates(path, content, header, mesh) if header.images else None
    if uv is None:
        return mesh
    used = _used(path, content, header, mesh)
    textures = {name: image_beside(path.parent, name) for name in header.images}
    names = tuple(textures)
    of_image = np.array([names.index(name) for name in header.images], dtype=np.int32)
    within = (used >= 0) & (used < len(of_image))
    labels = np.where(within, of_image[np.where(within, used, 0)], -1).astype(np.int32)
    looks = {name: Material(texture=texture) for name, texture in textures.items()}
    return Mesh(
        mesh.vertices,
        mesh.faces,
        uv,
        FaceLabels(names, labels),
        source=mesh.source,
        appearance=looks,
    )


def _coordinates(path: Path, content: bytes, header: PlyHeader, mesh: Mesh) -> UVMap | None:
    """Those of corners, or of vertices; None where there are neither."""
    faces = next((own for own in header.elements if own.name == "face"), None)
    if faces is not None and faces.place("texcoord") is not None:
        column = columns_of(path, content, header, {"face": ("texcoord",)})["texcoord"]
        if not np.array_equal(column.sizes, 2 * mesh.faces.sizes):
            raise FormatError(path, "'texcoord' needs two numbers for each corner of a polygon")
        return UVMap(
            column.values.reshape(-1, 2).astype(np.float64),
            np.arange(len(mesh.faces.indices), dtype=np.int32),
        )
    vertices = next(own for own in header.elements if own.name == "vertex")
    for pair in _OF_VERTICES:
        if all(vertices.place(name) is not None for name in pair):
            found = columns_of(path, content, header, {"vertex": pair})
            values = np.stack([_one(path, found[name]) for name in pair], axis=1)
            return UVMap(values.astype(np.float64), mesh.faces.indices.astype(np.int32))
    return None


def _used(path: Path, content: bytes, header: PlyHeader, mesh: Mesh) -> NDArray[np.int64]:
    """(F,) which image each polygon shows."""
    faces = next((own for own in header.elements if own.name == "face"), None)
    if faces is None or faces.place("texnumber") is None:
        return np.zeros(len(mesh.faces), dtype=np.int64)
    column = columns_of(path, content, header, {"face": ("texnumber",)})["texnumber"]
    return _one(path, column).astype(np.int64)


def _one(path: Path, column: Column) -> NDArray[Any]:
    """The numbers of a property that is no list."""
    if not (column.sizes == 1).all():
        raise FormatError(path, "texture coordinates of vertices are numbers, found lists")
    return column.values


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


_AXES = ("x", "y", "z")
_CORNERS = ("vertex_indices", "vertex_index")
Wanted = Mapping[str, tuple[str, ...]]
"""Names of properties, by their element."""
_SURFACE: Wanted = {"vertex": _AXES, "face": _CORNERS}
Encoding = Literal["ascii", "binary_little_endian", "binary_big_endian"]
ByteOrder = Literal["big", "little"]
_LARGEST_INDEX = int(np.iinfo(np.int32).max)


def read_ply(path: str | Path) -> Mesh:
    """The mesh in a PLY file."""
    content = read_bytes(path)
    header = read_header(path, content)
    require_surface(path, header)
    columns = columns_of(path, content, header, _SURFACE)
    nothing = Column(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64))
    faces = next((columns[name] for name in _CORNERS if name in columns), nothing)
    indices = faces.values
    if indices.size and (int(indices.min()) < 0 or int(indices.max()) > _LARGEST_INDEX):
        raise FormatError(path, "a polygon names a vertex below 0 or far beyond the last one")
    with naming_file(path):
        return Mesh(
            np.stack([columns[axis].values for axis in _AXES], axis=1).astype(np.float64),
            Polygons(indices, np.concatenate([[0], np.cumsum(faces.sizes)])),
            source=Source(str(path)),
        )


class Column(NamedTuple):
    """A property of all rows: the numbers of all lists, and the (rows,) length of each; or ones."""

    values: NDArray[Any]
    sizes: NDArray[np.int64]


Columns = Iterator[tuple[str, Column]]


def columns_of(
    path: str | Path, content: bytes, header: PlyHeader, wanted: Wanted
) -> dict[str, Column]:
    """The wanted properties by name, the first of each."""
    read = _binary_columns if header.order else _ascii_columns
    columns: dict[str, Column] = {}
    for name, column in read(path, content, header, wanted):
        columns.setdefault(name, column)
    return columns


def require_surface(path: str | Path, header: PlyHeader) -> None:
    """Refuse a header without vertices, or with polygons that are none."""
    elements = {own.name: own for own in reversed(header.elements) if own.length}
    first = next((own for own in header.elements if own.name == "vertex"), None)
    if first is None or not first.length:
        says = "has no 'element vertex'" if first is None else "says 'element vertex 0'"
        raise FormatError(path, f"there are no vertices: the header {says}; export it again")
    for axis in _AXES:
        place = first.place(axis)
        if place is None or first.properties[place].length is not None:
            raise FormatError(path, f"the vertices have no property '{axis}' that is a number")
    if "tristrips" in elements:
        raise FormatError(
            path, "its polygons are triangle strips, which is not supported; export polygons"
        )
    if "face" in elements:
        face = elements["face"]
        place = face.place(*_CORNERS)
        corners = None if place is None else face.properties[place]
        if corners is None or corners.length is None or corners.kind.kind not in "iu":
            raise FormatError(
                path, "the faces have no list of whole numbers called 'vertex_indices'"
            )


def _places(element: Element, wanted: Wanted) -> dict[int, str]:
    """The name of each property that is wanted, by its place."""
    places = {element.place(name): name for name in wanted.get(element.name, ())}
    return {place: name for place, name in places.items() if place is not None}


def _ascii_columns(path: str | Path, content: bytes, header: PlyHeader, wanted: Wanted) -> Columns:
    text = content[header.size :].replace(b"\r\n", b"\n").replace(b"\r", b"\n")
    lines = enumerate(map(bytes.split, text.split(b"\n")), start=header.lines + 1)
    rows = [(line, words) for line, words in lines if words]
    first = 0
    for element in header.elements:
        if not element.properties:
            continue
        own = rows[first : first + element.length]
        if len(own) < element.length:
            raise FormatError(
                path,
                f"the header announces {element.length:,} rows of '{element.name}', but only "
                f"{len(own):,} lines are left; the file was cut off or its header is wrong",
            )
        first += element.length
        yield from _columns_of_lines(path, element, own, _places(element, wanted))
    if first < len(rows):
        raise FormatError(
            path, "there are more lines than the header announces", line=rows[first][0]
        )


def _columns_of_lines(
    path: str | Path,
    element: Element,
    rows: list[tuple[int, list[bytes]]],
    wanted: dict[int, str],
) -> Columns:
    values: dict[int, list[float]] = {j: [] for j in wanted}
    sizes: dict[int, list[int]] = {j: [] for j in wanted}
    parse = [float if p.kind.kind == "f" else int for p in element.properties]
    for line, words in rows:
        try:
            start = 0
            for j, p in enumerate(element.properties):
                size = 1
                if p.length is not None:
                    size = int(words[start])
                    start += 1
                if size < 0 or start + size > len(words):
                    raise IndexError
                if j in wanted:
                    values[j].extend(map(parse[j], words[start : start + size]))
                    sizes[j].append(size)
                start += size
            if start != len(words) or b"_" in b"".join(words):
                raise IndexError
        except (IndexError, ValueError):
            each = [p.name if p.length is None else f"N N×{p.name}" for p in element.properties]
            raise FormatError(
                path,
                f"expected the numbers of one '{element.name}' ({' '.join(each)[:200]}), found "
                f"'{b' '.join(words)[:60].decode('ascii', 'backslashreplace')}'",
                line=line,
            ) from None
    try:
        for j, name in wanted.items():
            kind = "f8" if parse[j] is float else "i8"
            yield name, Column(np.array(values[j], kind), np.array(sizes[j], np.int64))
    except OverflowError:
        raise FormatError(path, f"a number of '{element.name}' is too large") from None


def _binary_columns(path: str | Path, content: bytes, header: PlyHeader, wanted: Wanted) -> Columns:
    position = header.size
    order: ByteOrder = "big" if header.order == ">" else "little"
    for element in header.elements:
        smallest = sum(
            (p.kind if p.length is None else p.length).itemsize for p in element.properties
        )
        left = len(content) - position
        if element.length * smallest > left:
            raise FormatError(
                path,
                f"the header announces {element.length:,} rows of '{element.name}', at least "
                f"{element.length * smallest:,} bytes, but only {left:,} are left; "
                "the file was cut off or its header is wrong",
            )
        if not element.properties or not element.length:
            continue
        places = _places(element, wanted)
        table = _alike_rows(path, content, position, element, order)
        if table is not None:
            position += table.nbytes
            for j, name in places.items():
                values = table[f"f{j}"].reshape(element.length, -1)
                yield name, Column(values.reshape(-1), np.full(len(values), values.shape[1]))
            continue
        starts, sizes, position = _walk(path, content, position, element, element.length, order)
        for j, name in places.items():
            kind = element.properties[j].kind
            yield name, Column(_gathered(content, starts[:, j], sizes[:, j], kind), sizes[:, j])
    rest = len(content[position:].strip())
    if rest:
        raise FormatError(path, f"{rest:,} bytes follow the last row; the header is wrong")


def _alike_rows(
    path: str | Path, content: bytes, position: int, element: Element, order: ByteOrder
) -> NDArray[Any] | None:
    """The rows as one table, if all their lists are as long as those of the first row."""
    sizes = _walk(path, content, position, element, 1, order)[1][0].tolist()
    fields: list[tuple[Any, ...]] = []
    for j, (p, size) in enumerate(zip(element.properties, sizes, strict=True)):
        if p.length is not None:
            fields.append((f"n{j}", p.length))
        fields.append((f"f{j}", p.kind) if p.length is None else (f"f{j}", p.kind, (size,)))
    row = np.dtype(fields)
    if 0 in sizes or element.length * row.itemsize > len(content) - position:
        return None
    table = np.frombuffer(content, dtype=row, count=element.length, offset=position)
    for j, p in enumerate(element.properties):
        if p.length is not None and (table[f"n{j}"] != sizes[j]).any():
            return None
    return table


def _walk(
    path: str | Path, content: bytes, position: int, element: Element, length: int, order: ByteOrder
) -> tuple[NDArray[np.int64], NDArray[np.int64], int]:
    """(rows, properties) first byte and number of values of each entry, and where the rows end."""
    steps = [
        (p.kind.itemsize, 0, False)
        if p.length is None
        else (p.kind.itemsize, p.length.itemsize, p.length.kind == "i")
        for p in element.properties
    ]
    places: list[tuple[int, int]] = []
    for row in range(length):
        for item, counter, signed in steps:
            size = 1
            if counter:
                count = content[position : position + counter]
                size = int.from_bytes(count, order, signed=signed)
                position += counter
            if size < 0 or position + size * item > len(content):
                raise FormatError(
                    path,
                    f"row {row:,} of '{element.name}' has a list of {size:,} values, but only "
                    f"{max(len(content) - position, 0):,} bytes are left; the file was cut off or "
                    "is damaged",
                )
            places.append((position, size))
            position += size * item
    table = np.array(places).reshape(length, len(steps), 2)
    return table[..., 0], table[..., 1], position


def _gathered(
    content: bytes, starts: NDArray[np.int64], sizes: NDArray[np.int64], kind: np.dtype[Any]
) -> NDArray[Any]:
    """The values of all lists one after another."""
    before = np.cumsum(sizes) - sizes
    within = np.arange(int(sizes.sum())) - np.repeat(before, sizes)
    first = np.repeat(starts, sizes) + within * kind.itemsize
    everything = np.frombuffer(content, dtype=np.uint8)
    values: NDArray[Any] = everything[first[:, None] + np.arange(kind.itemsize)].reshape(-1)
    return values.view(kind)


def write_ply(path: str | Path, mesh: Mesh, encoding: Encoding = "binary_little_endian") -> None:
    """Write the vertices and polygons of a mesh as PLY, coordinates bit for bit.

    Args:
        path: The file; its folder must exist. A file that is there is replaced at once.
        mesh: The mesh. Its texture coordinates, materials and groups are not written; whose it is
            stands in a comment.
        encoding: ``ascii``, ``binary_little_endian`` or ``binary_big_endian``. Positions are
            float64 (``double``), indices int32.

    Raises:
        FileError: The file cannot be written.
        ParameterError: Another encoding.
    """
    if encoding not in ENCODINGS:
        raise ParameterError(f"expected one of {', '.join(ENCODINGS)}, found {encoding!r}")
    sizes = mesh.faces.sizes
    count = "uchar" if sizes.max(initial=0) <= 255 else "int"
    header = [
        "ply",
        f"format {encoding} 1.0",
        *(f"comment {said}" for said in ownership(mesh, "ascii")),
        f"element vertex {len(mesh.vertices)}",
        *(f"property double {axis}" for axis in "xyz"),
        f"element face {len(mesh.faces)}",
        f"property list {count} int vertex_indices",
        "end_header\n",
    ]
    order = ENCODINGS[encoding]
    if order:
        counts = sizes.astype(np.dtype(order + ("u1" if count == "uchar" else "i4")))
        indices = mesh.faces.indices.astype(np.dtype(order + "i4"))
        positions = mesh.vertices.astype(np.dtype(order + "f8")).tobytes()
        body = positions + _interleaved(counts, indices, mesh.faces.offsets)
    else:
        rows = [f"{x!r} {y!r} {z!r}\n" for x, y, z in mesh.vertices.tolist()]
        rows += [f"{len(face)} {' '.join(map(str, face.tolist()))}\n" for face in mesh.faces]
        body = "".join(rows).encode("ascii")
    with replacing(path) as file:
        file.write("\n".join(header).encode("ascii") + body)


def _interleaved(
    counts: NDArray[np.integer], indices: NDArray[np.integer], offsets: NDArray[np.int64]
) -> bytes:
    """Each polygon's count, then its indices, as they stand in the file."""
    raw = indices.view(np.uint8).reshape(-1, indices.itemsize)
    before = np.repeat(offsets[:-1] * indices.itemsize, counts.itemsize)
    return np.insert(raw.ravel(), before, counts.view(np.uint8)).tobytes()
