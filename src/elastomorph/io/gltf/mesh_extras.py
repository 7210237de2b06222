"""The polygons, texture coordinates and labels of a mesh, kept beside its triangles.

What the triangles of the file say already is not repeated. On reading, everything is checked
against the triangles: a file that another program has rewritten (welded, reordered, simplified)
no longer fits, and is then read as the triangles it has.

Lists of whole numbers are kept as short texts: the differences of neighbours, as little-endian
32-bit integers modulo 2³², compressed with zlib and written in base64. A list that rises by one
costs next to nothing.
"""

from __future__ import annotations

import base64
import binascii
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.model.mesh import FaceLabels, Mesh, UVMap
from elastomorph.model.polygons import Polygons

# From polygons with texture seams to the triangles of glTF, reversibly.
#
# glTF has one texture coordinate a vertex, so a vertex whose corners have several is repeated.
# The first V vertices of the file are those of the mesh in their order; the copies follow. Each
# polygon becomes a fan of triangles from its first corner, in the order of the polygons within a
# material, so the polygons can be read back from the triangles and their sizes.
#
# Where there are several materials, the triangles of each are a mesh with vertices of its own:
# players keep the morph targets of all vertices that a primitive names, once a primitive.


@dataclass(frozen=True, eq=False)
class MaterialTriangles:
    """The triangles of one material, a mesh of the file."""

    label: int  # Index into the names of the materials, or -1 for none
    triangles: NDArray[np.int32]  # (T, 3) int32 vertices of the layout
    rows: NDArray[np.int32]  # (N,) the vertices of the layout that it has, rising

    @property
    def local(self) -> NDArray[np.int32]:
        """(T, 3) its triangles, by the numbers of vertices that it has."""
        return np.searchsorted(self.rows, self.triangles).astype(np.int32)


@dataclass(frozen=True, eq=False)
class Layout:
    """The vertices and triangles of a file."""

    vertex_of: NDArray[np.int32]  # (N,) mesh vertex of each of the file; 0 … V - 1 first
    uv_of: NDArray[np.int32]  # (N,) texture coordinate of each vertex of the file, or -1
    corners: NDArray[np.int32]  # (C,) int32 vertex of the file at each polygon corner
    primitives: tuple[MaterialTriangles, ...]  # One a material, by label; unlabelled ones last
    texture: NDArray[np.float32] | None  # (N, 2) u and 1 - v, as glTF counts from the top

    def rows(self, vectors: NDArray[np.float64]) -> NDArray[np.float32]:
        """(N, 3) vectors of the vertices of the file, from (V, 3) of those of the mesh."""
        return vectors.astype(np.float32)[self.vertex_of]

    def copies(self, rows: NDArray[Any]) -> NDArray[Any]:
        """(N, …) rows of the vertices of the file, from (V, …) of those of the mesh."""
        return rows[self.vertex_of]


def lay_out(mesh: Mesh) -> Layout:
    """Split the vertices along texture seams and cut the polygons into triangles.

    A vertex is split only where texture coordinates really differ in single precision; two
    entries of the UV map with the same coordinates do not split it.
    """
    count = len(mesh.vertices)
    vertex_of = np.arange(count, dtype=np.int32)
    uv_of = np.full(count, -1, dtype=np.int32)
    corners, texture = mesh.faces.indices, None
    if mesh.uv is not None and len(mesh.faces):
        flipped = _flipped(mesh.uv)
        vertex_of, uv_of, corners = _split(mesh.faces, mesh.uv, flipped, count)
        texture = np.where(uv_of[:, None] >= 0, flipped[uv_of], np.float32(0))
    triangles = Polygons(corners, mesh.faces.offsets).triangles()
    primitives = _primitives(mesh, triangles, np.arange(len(vertex_of), dtype=np.int32))
    return Layout(vertex_of, uv_of, corners, primitives, texture)


def _flipped(uv: UVMap) -> NDArray[np.float32]:
    """(max(T, 1), 2) float32, with v counted from the top."""
    flipped = np.zeros((max(len(uv.coordinates), 1), 2), dtype=np.float32)
    flipped[: len(uv.coordinates), 0] = uv.coordinates[:, 0]
    flipped[: len(uv.coordinates), 1] = 1.0 - uv.coordinates[:, 1]
    return flipped + np.float32(0)  # -0 and 0 are the same place


def _split(
    faces: Polygons, uv: UVMap, flipped: NDArray[np.float32], count: int
) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]:
    """Vertex and texture coordinate of each vertex of the file, and its place at each corner."""
    place = np.unique(flipped, axis=0, return_inverse=True)[1].reshape(-1).astype(np.int64) + 1
    kind = np.where(uv.corners >= 0, place[uv.corners], 0)
    keys = faces.indices.astype(np.int64) * (place.max() + 1) + kind
    pairs, first, of_corner = np.unique(keys, return_index=True, return_inverse=True)
    vertex = faces.indices[first]
    # Of the pairs of a vertex, the one met first in the file keeps its number.
    by_vertex = np.lexsort((first, vertex))
    leads = np.append(True, np.diff(vertex[by_vertex]) != 0)[: len(pairs)]
    kept, copies = by_vertex[leads], np.sort(by_vertex[~leads])
    number = np.empty(len(pairs), dtype=np.int32)
    number[kept] = vertex[kept]
    number[copies] = count + np.arange(len(copies))
    vertex_of = np.concatenate([np.arange(count, dtype=np.int32), vertex[copies]])
    uv_of = np.full(len(vertex_of), -1, dtype=np.int32)
    uv_of[number] = uv.corners[first]
    return vertex_of, uv_of, number[of_corner.reshape(-1)]


def _primitives(
    mesh: Mesh, triangles: NDArray[np.int32], every: NDArray[np.int32]
) -> tuple[MaterialTriangles, ...]:
    if mesh.materials is None or not len(mesh.faces):
        return (MaterialTriangles(-1, triangles, every),)
    labels = np.repeat(mesh.materials.of_face, mesh.faces.sizes - 2)
    found = np.unique(labels)
    order = [*found[found >= 0].tolist(), *found[found < 0].tolist()]
    if len(order) == 1:
        return (MaterialTriangles(order[0], triangles, every),)
    parts = [triangles[labels == label] for label in order]
    rows = [np.unique(own) for own in parts]
    # Vertices without polygons go with the first.
    rows[0] = np.union1d(rows[0], np.setdiff1d(every, triangles))
    return tuple(map(MaterialTriangles, order, parts, rows))


_DECIMALS = range(8)
_FREE_ENTRIES = 1 << 20


def surface_extras(mesh: Mesh, layout: Layout) -> dict[str, Any]:
    """What the triangles of a layout do not tell of a mesh, as JSON."""
    count = len(mesh.vertices)
    found: dict[str, Any] = {
        "vertices": count,
        "copies": packed(layout.vertex_of[count:]),
        "polygons": len(mesh.faces),
        "sizes": packed(mesh.faces.sizes),
        "parts": [own.label for own in layout.primitives if len(own.triangles)],
        "corners": _checksums([own.triangles for own in layout.primitives]),
    }
    for kind, labels in (("materials", mesh.materials), ("groups", mesh.groups)):
        if labels is not None:
            found[kind] = {"names": list(labels.names), "of_polygon": packed(labels.of_face)}
    if mesh.material_library is not None:
        found["material_library"] = mesh.material_library
    if mesh.uv is not None:
        found["uv"] = _uv_extras(mesh.uv, layout)
    return found


def is_part(stored: Any) -> bool:
    """Whether a mesh says that it is one of several that show one surface."""
    return isinstance(stored, dict) and isinstance(stored.get("part"), dict)


def rows_of_parts(
    stored: Sequence[Mapping[str, Any]], counts: Sequence[int]
) -> tuple[list[NDArray[np.int32]], int]:
    """The vertices of a surface that each of its meshes, of so many vertices, has; how many it has.

    ``stored`` is what `elastomorph.io.gltf.write_glb` says of each. A ValueError where they are not
    the meshes of one surface, in order.
    """
    whole = stored[0].get("whole")
    if not isinstance(whole, dict):
        raise ValueError("the first of its meshes is missing")
    parts = [own["part"] for own in stored]
    numbers = [part.get("number") for part in parts]
    in_order = numbers == list(range(len(parts))) and whole.get("parts") == len(parts)
    _require(in_order, "meshes are missing")
    total = _whole(whole, "vertices", 1, sum(counts))
    pairs = zip(parts, counts, strict=True)
    rows = [unpacked(own.get("vertices"), n) for own, n in pairs]
    _require(_within(np.concatenate(rows), 0, total - 1), "a vertex that does not exist")
    return rows, total


def restored_surface(
    stored: Mapping[str, Any],
    parts: Sequence[NDArray[np.int32]],
    vertices: NDArray[np.float64],
    texture: NDArray[np.float64] | None,
) -> dict[str, Any]:
    """The arguments of `Mesh` but its vertices, from what `surface_extras` wrote.

    The parts are the triangles (T, 3) of each primitive of the file, the vertices (N, 3) and the
    texture (N, 2), v from the top, those of the file. A ValueError where they do not fit, or are
    damaged.
    """
    count = _whole(stored, "vertices", 1, len(vertices))
    copies = unpacked(stored.get("copies"), len(vertices) - count)
    _require(_within(copies, 0, count - 1), "a copy of a vertex that does not exist")
    turned = _turned(stored, parts)
    vertex_of = np.concatenate([np.arange(count, dtype=np.int32), copies])
    _require(np.array_equal(vertices[count:], vertices[copies]), "copies lie elsewhere")
    polygons = _whole(stored, "polygons", 0, sum(map(len, parts)))
    sizes = unpacked(stored.get("sizes"), polygons).astype(np.int64)
    _require(_within(sizes, 3, np.iinfo(np.int32).max), "a polygon of fewer than 3 vertices")
    materials, groups = (_labels(stored.get(kind), polygons) for kind in ("materials", "groups"))
    corners = _corners(parts, stored.get("parts", []), sizes, materials, turned)
    offsets = np.concatenate([[0], np.cumsum(sizes)])
    library = stored.get("material_library")
    _require(library is None or isinstance(library, str), "the material library is no text")
    uv = stored.get("uv")
    return {
        "faces": Polygons(vertex_of[corners], offsets),
        "uv": None if uv is None else _restored_uv(uv, corners, texture, len(vertices)),
        "materials": materials,
        "groups": groups,
        "material_library": library,
    }


def _checksums(parts: Sequence[NDArray[np.int32]]) -> list[int]:
    """Two numbers that another order of vertices or triangles changes.

    The second stays where only the corner changes that a triangle begins with.
    """
    found = [0, 0]
    for triangles in parts:
        least = _rolled(triangles, triangles.argmin(axis=1)) if len(triangles) else triangles
        for number, own in enumerate((triangles, least)):
            content = np.ascontiguousarray(own, dtype="<i4").tobytes()
            found[number] = zlib.crc32(content, found[number])
    return found


def _turned(stored: Mapping[str, Any], parts: Sequence[NDArray[np.int32]]) -> bool:
    """Whether triangles begin with another corner; a ValueError where more of them has changed."""
    known = stored.get("corners")  # older files have none
    found = _checksums(parts)
    if known is None or known == found:
        return False
    uv = stored.get("uv")
    by_corner = isinstance(uv, dict) and "other_corners" in uv
    same = isinstance(known, list) and known[1:] == found[1:]
    _require(same and not by_corner, "vertices or triangles in another order")
    return True


def _turned_back(triangles: NDArray[np.int32], inner: NDArray[np.int64]) -> NDArray[np.int32]:
    """Triangles (T, 3) of fans that begin with the corner all of a fan share.

    ``inner`` are those that another of their fan comes before. Those alone stay as they are.
    """
    found = triangles.copy()
    first = np.setdiff1d(inner - 1, inner, assume_unique=True)
    shared = (found[first][:, :, None] == found[first + 1][:, None, :]).any(axis=2)
    # The corner that the next triangle lacks is the second of a fan.
    found[first] = _rolled(found[first], shared.argmin(axis=1) - 1)
    begins = np.arange(len(found))
    begins[inner] = 0
    apex = found[np.maximum.accumulate(begins)[inner], 0]
    found[inner] = _rolled(found[inner], (found[inner] == apex[:, None]).argmax(axis=1))
    return found


def _rolled(triangles: NDArray[np.int32], places: NDArray[np.int64]) -> NDArray[np.int32]:
    """Triangles (T, 3) that begin with the corner at one of their places."""
    order = (places[:, None] + np.arange(3)) % 3
    return np.take_along_axis(triangles, order, axis=1)


def _corners(
    parts: Sequence[NDArray[np.int32]],
    labels: Any,
    sizes: NDArray[np.int64],
    materials: FaceLabels | None,
    turned: bool,
) -> NDArray[np.int32]:
    """(C,) vertex of the file at each polygon corner, from the fans of the parts."""
    of_polygon = np.full(len(sizes), -1) if materials is None else materials.of_face
    _require(isinstance(labels, list) and len(labels) == len(parts), "other parts")
    _require(int((sizes - 2).sum()) == sum(map(len, parts)), "another number of triangles")
    offsets = np.concatenate([[0], np.cumsum(sizes)])
    corners = np.full(int(offsets[-1]), -1, dtype=np.int32)
    by_label = np.argsort(of_polygon, kind="stable")
    in_order = of_polygon[by_label]
    for label, triangles in zip(labels, parts, strict=True):
        _require(isinstance(label, int) and abs(label) < 1 << 31, "a part without a label")
        mine = by_label[slice(*np.searchsorted(in_order, [label, label + 1]))]
        _require(int((sizes[mine] - 2).sum()) == len(triangles), "another number of triangles")
        ends = np.cumsum(sizes[mine] - 2)
        starts = ends - (sizes[mine] - 2)
        inner = np.setdiff1d(np.arange(len(triangles)), starts, assume_unique=True)
        if turned:
            triangles = _turned_back(triangles, inner)
        fans = triangles[inner, :2] == triangles[inner - 1][:, [0, 2]]
        _require(bool(fans.all()), "triangles that are no fans of the polygons")
        corners[offsets[mine]] = triangles[starts, 0]
        corners[offsets[mine] + 1] = triangles[starts, 1]
        step = np.arange(len(triangles)) - np.repeat(starts, sizes[mine] - 2)
        corners[np.repeat(offsets[mine], sizes[mine] - 2) + 2 + step] = triangles[:, 2]
    _require(bool((corners >= 0).all()), "polygons without triangles")
    return corners


def _labels(stored: Any, polygons: int) -> FaceLabels | None:
    if stored is None:
        return None
    _require(isinstance(stored, dict), "labels that are no object")
    names = stored.get("names", [])
    are_texts = isinstance(names, list) and all(isinstance(name, str) for name in names)
    _require(are_texts, "names of labels that are no texts")
    of_polygon = unpacked(stored.get("of_polygon"), polygons)
    _require(_within(of_polygon, -1, len(names) - 1), "a label that does not exist")
    return FaceLabels(tuple(names), of_polygon)


def _uv_extras(uv: UVMap, layout: Layout) -> dict[str, Any]:
    """The table of texture coordinates, as far as the vertices of the file do not show it."""
    found: dict[str, Any] = {
        "count": len(uv.coordinates),
        "width": uv.coordinates.shape[1],
        "of_vertex": packed(layout.uv_of),
    }
    others = uv.corners.astype(np.int64) - layout.uv_of[layout.corners]
    if others.any():  # two entries of the table with the same coordinates
        found["other_corners"] = packed(others)
    coordinates = np.ascontiguousarray(uv.coordinates, dtype=np.float64)
    if layout.texture is not None:
        shown = layout.texture[layout.corners].astype(np.float64)
        for decimals in _DECIMALS:
            table = _table(shown, uv.corners, len(coordinates), decimals)
            if table.tobytes() == coordinates.tobytes():
                return found | {"decimals": decimals}
    return found | {"coordinates": packed_bytes(coordinates.astype("<f8").tobytes())}


def _restored_uv(
    stored: Any, corners: NDArray[np.int32], texture: NDArray[np.float64] | None, vertices: int
) -> UVMap:
    _require(isinstance(stored, dict), "texture coordinates that are no object")
    used = unpacked(stored.get("of_vertex"), vertices)[corners]
    if "other_corners" in stored:
        used = used + unpacked(stored["other_corners"], len(corners))
    width = _whole(stored, "width", 2, 3)
    # Entries that no corner uses may be there too; a small text must not unpack to gigabytes.
    text = stored.get("coordinates")
    written = len(text) if isinstance(text, str) else 0
    count = _whole(stored, "count", 0, max(_FREE_ENTRIES, len(corners), written))
    _require(_within(used, -1, count - 1), "a texture coordinate that does not exist")
    if text is not None:
        content = unpacked_bytes(text, 8 * width * count)
        table = np.frombuffer(content, dtype="<f8").reshape(count, width).astype(np.float64)
        return UVMap(table, used)
    decimals = _whole(stored, "decimals", min(_DECIMALS), max(_DECIMALS))
    if texture is None:
        raise ValueError("no texture coordinates in the file")
    return UVMap(_table(texture[corners], used, count, decimals), used)


def _table(
    shown: NDArray[np.float64], corners: NDArray[np.int32], count: int, decimals: int
) -> NDArray[np.float64]:
    """(T, 2) table of decimal fractions from their single-precision values (C, 2) at corners."""
    table = np.zeros((count, 2))
    has = corners >= 0
    table[corners[has], 0] = shown[has, 0]
    table[corners[has], 1] = 1.0 - shown[has, 1]
    return np.asarray(np.round(table, decimals) + 0.0)


def _whole(stored: Mapping[str, Any], key: str, least: int, most: int) -> int:
    value = stored.get(key)
    if type(value) is not int or not least <= value <= most:
        raise ValueError(f"'{key}' is no whole number from {least} to {most}")
    return value


def _within(values: NDArray[Any], least: int, most: int) -> bool:
    return not values.size or bool(values.min() >= least and values.max() <= most)


def _require(holds: bool, otherwise: str) -> None:
    if not holds:
        raise ValueError(otherwise)


def packed(integers: ArrayLike) -> str:
    """A list (N,) of whole numbers between -2³¹ and 2³¹ - 1 as text."""
    values = np.asarray(integers, dtype=np.int64)
    return packed_bytes(np.diff(values, prepend=0).astype("<u4").tobytes())


def unpacked(text: Any, count: int) -> NDArray[np.int32]:
    """The list (count,) of int32 in a text of `packed`; a ValueError where it is none."""
    differences = np.frombuffer(unpacked_bytes(text, 4 * count), dtype="<u4")
    return np.cumsum(differences, dtype=np.uint32).view(np.int32)


def packed_bytes(content: bytes) -> str:
    """Bytes, compressed, as text."""
    return base64.b64encode(zlib.compress(content, 9)).decode("ascii")


def unpacked_bytes(text: Any, length: int) -> bytes:
    """The bytes in a text, as `unpacked`; no more than ``length`` are ever unpacked."""
    if not isinstance(text, str):
        raise ValueError("expected a packed text")
    try:
        unpacker = zlib.decompressobj()
        content = unpacker.decompress(base64.b64decode(text, validate=True), length + 1)
    except (binascii.Error, zlib.error, ValueError) as error:
        raise ValueError(f"a packed text is damaged: {error}") from None
    if len(content) != length:
        raise ValueError(f"a packed text holds more or fewer than {length:,} bytes")
    return content
