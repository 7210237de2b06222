"""Accessors: arrays in the buffers of a document, dense, sparse, or packed with Draco.

Every number that is read is checked against the bytes there are before it is believed.

With KHR_draco_mesh_compression a primitive names a stream, and by numbers its attributes in the
stream; its accessors say what they are, but have no bytes. Morph targets are no part of it: theirs
are plain, in the order of the vertices in the stream. Draco breaks or takes any amount of memory on
damaged streams, so all those of a file are unpacked in a process of its own.
"""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FileError, FormatError, MissingExtraError
from elastomorph.io.gltf.container import GltfFile
from elastomorph.io.gltf.meshopt import EXTENSIONS, packed_view
from elastomorph.io.isolated import IsolatedReader, extracted
from elastomorph.io.npz.members import NpzMembers, write_arrays
from elastomorph.rig import Rig

EXTENSION = "KHR_draco_mesh_compression"

_TRIANGLES = "triangles"
_DRACO = IsolatedReader(
    worker="elastomorph.io.gltf.draco_worker",
    library="Draco",
    advice="export it again without compression",
)


def draco_values(file: GltfFile, number: int) -> NDArray[Any] | None:
    """(count, width) what Draco holds of an accessor without bytes; None for other ones."""
    if file.draco is None:
        file.draco = _all_values(file)
    return file.draco.get(number)


def _all_values(file: GltfFile) -> dict[int, NDArray[Any]]:
    """What Draco holds, by the numbers of the accessors that stand for it."""
    places: dict[int, tuple[int, str]] = {}  # of an accessor: its stream, and its name there
    streams: dict[int, memoryview] = {}  # by the number of its view
    for primitive in _primitives(file):
        of = "a primitive packed with Draco"
        own = file.object_in(file.object_in(primitive, "extensions", of), EXTENSION, of)
        numbers = file.object_in(own, "attributes", of)
        accessors = file.object_in(primitive, "attributes", of)
        named = {
            accessors[key]: str(file.whole_in(numbers, key, of))
            for key in numbers
            if type(accessors.get(key)) is int
        }
        if type(primitive.get("indices")) is not int:
            file.refuse(f"{of} has no indices")
        named[primitive["indices"]] = _TRIANGLES
        bare = [n for n in named if "bufferView" not in file.item("accessors", n, of)]
        if not bare:
            continue  # a plain copy is there too
        stream: Any = own.get("bufferView")
        streams[stream], _ = file.view(stream, of)
        for accessor in bare:
            places.setdefault(accessor, (stream, named[accessor]))
    return _unpacked(file, streams, places) if streams else {}


def _primitives(file: GltfFile) -> list[dict[str, Any]]:
    """All primitives of the document that name the extension."""
    return [
        primitive
        for mesh in file.items("meshes")
        if isinstance(mesh, dict)
        for primitive in file.list_in(mesh, "primitives", "a mesh")
        if isinstance(primitive, dict)
        and EXTENSION in file.object_in(primitive, "extensions", "a primitive")
    ]


def _unpacked(
    file: GltfFile, streams: dict[int, memoryview], places: dict[int, tuple[int, str]]
) -> dict[int, NDArray[Any]]:
    """The values of accessors, out of all streams together."""
    if find_spec("DracoPy") is None:
        raise MissingExtraError("DracoPy", "gltf")
    with tempfile.TemporaryDirectory(prefix="elastomorph-") as folder:
        packed = Path(folder) / "streams.npz"
        write_arrays(packed, {f"{n}": np.frombuffer(own, "u1") for n, own in streams.items()})
        try:
            with extracted(_DRACO, packed) as members:
                return {
                    accessor: _member(file, members, stream, name)
                    for accessor, (stream, name) in places.items()
                }
        except FileError as error:
            if error.path != packed:
                raise
            problem = str(error).removeprefix(f"{packed}: ")
            raise type(error)(file.path, problem) from error


def _member(file: GltfFile, members: NpzMembers, stream: int, name: str) -> NDArray[Any]:
    """(N, width) an attribute of a stream, or (N, 1) the corners of its triangles."""
    key = f"{stream}.{name}"
    if key not in members.names:
        raise FormatError(
            file.path,
            f"buffer view {stream}, packed with Draco, has no attribute {name[:40]}; the file is "
            "damaged or was written wrongly",
        )
    found = members.array(key, "fiu", (None, None))
    return found.reshape(-1, 1) if name == _TRIANGLES else found


DTYPES = {5120: "|i1", 5121: "|u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
COMPONENT_TYPES = {name: number for number, name in DTYPES.items()}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
TYPES = {width: name for name, width in _WIDTHS.items()}
_KEPT, _COPIES = 8, 12  # bytes of each number that is read, and of copies made on the way


def read_floats(
    file: GltfFile, number: Any, width: int, of: str, *, count: int | None = None
) -> NDArray[np.float64]:
    """(count, width) float64 coordinates of an accessor, unpacked where they are quantised."""
    values = _values(file, number, width, of, count)
    found = values.astype(np.float64)
    if file.item("accessors", number, of).get("normalized") is True:
        if values.dtype.kind == "f":
            file.refuse(f"accessor {number} holds normalised floats, which do not exist")
        found = np.maximum(found / np.iinfo(values.dtype).max, -1.0)
    return found


def read_indices(file: GltfFile, number: Any, of: str) -> NDArray[np.int64]:
    """Vertex indices (N,)."""
    values = _values(file, number, 1, of, None)
    if values.dtype.kind != "u":
        file.refuse(f"accessor {number} of {of} does not hold vertex indices")
    return values.reshape(-1).astype(np.int64)


def _values(file: GltfFile, number: Any, width: int, of: str, count: int | None) -> NDArray[Any]:
    accessor = file.item("accessors", number, of)
    name = f"accessor {number}"
    kind = DTYPES.get(_key(accessor.get("componentType")))
    if kind is None or _WIDTHS.get(_key(accessor.get("type"))) != width:
        file.refuse(f"{name} of {of} has a type that {of} cannot have")
    own = file.whole_in(accessor, "count", name)
    if own < 1 or (count is not None and own != count):
        file.refuse(f"{name} of {of} has {own:,} elements, expected {count or 'at least 1'}")
    dtype = np.dtype(kind)
    bare = accessor.get("bufferView") is None
    elements = (
        _from_draco(file, number, (own, width), dtype)
        if bare
        else _elements(file, accessor, own, width, dtype, name)
    )
    file.budget.spend(own * width * _KEPT)
    file.budget.spend_briefly(own * width * _COPIES)
    # Zeros, or for sparse values. Others are copied, so that sparse ones can replace some.
    values = np.zeros((own, width), dtype=dtype) if elements is None else elements.copy()
    if "sparse" in accessor:
        _replace(file, values, file.object_in(accessor, "sparse", name), name)
    return values


def _from_draco(
    file: GltfFile, number: int, shape: tuple[int, int], dtype: np.dtype[Any]
) -> NDArray[Any] | None:
    """(count, width) what Draco holds of an accessor, if anything."""
    values = draco_values(file, number)
    if values is None:
        return None
    found = values.shape
    if found != shape:
        file.refuse(
            f"accessor {number} has {shape[0]:,} elements of {shape[1]} numbers, but Draco packs "
            f"{found[0]:,} of {found[1]} for it"
        )
    # Whole numbers of vertices and normals arrive as floats.
    with np.errstate(all="ignore"):
        typed = values.astype(dtype)
    if dtype.kind != "f" and not np.array_equal(typed, values):
        file.refuse(f"what Draco packs for accessor {number} does not fit into its numbers")
    return typed


def _replace(file: GltfFile, values: NDArray[Any], sparse: dict[str, Any], name: str) -> None:
    of = f"the sparse values of {name}"
    count = file.whole_in(sparse, "count", of)
    if not 1 <= count <= len(values):
        file.refuse(f"{name} has {len(values):,} elements, and {count:,} sparse ones of them")
    indices, contents = (file.object_in(sparse, key, of) for key in ("indices", "values"))
    kind = DTYPES.get(_key(indices.get("componentType")), "")
    if "u" not in kind:
        file.refuse(f"{of} have places that are no whole numbers")
    file.budget.spend(count * (8 + values.dtype.itemsize * values.shape[1]))
    at = _elements(file, indices, count, 1, np.dtype(kind), name).reshape(-1)
    rising = np.diff(at.astype(np.int64)) > 0
    if int(at.max()) >= len(values) or not rising.all():
        file.refuse(f"{of} are out of range or out of order")
    values[at] = _elements(file, contents, count, values.shape[1], values.dtype, name)


def _elements(
    file: GltfFile, place: dict[str, Any], count: int, width: int, dtype: np.dtype[Any], name: str
) -> NDArray[Any]:
    """(count, width) elements of a buffer view, not copied."""
    offset = file.whole_in(place, "byteOffset", name, default=0)
    content, apart = file.view(place.get("bufferView"), name)
    size = dtype.itemsize * width
    stride = apart or size
    if stride < size or offset + (count - 1) * stride + size > len(content):
        file.refuse(
            f"{name} has {count:,} elements of {size} bytes, {stride} apart, which do not fit "
            f"into the {len(content):,} bytes of buffer view {place.get('bufferView')}"
        )
    return np.ndarray((count, width), dtype, content, offset, (stride, dtype.itemsize))


def _key(value: Any) -> Any:
    """A value to look up; lists and objects are none."""
    return value if isinstance(value, int | str) else None


# Accessors and their values as a file gets them: each sequence of bytes once, in one buffer.
#
# A file that we compress stores positions and morph targets in whole steps of one length
# (KHR_mesh_quantization), in 16 bits that stand for -1 to 1; the node that shows the mesh
# multiplies. The step is as long as the error asked for allows, and what storing really moves is
# measured. Normals are stored in 127ths.
#
# Small moves would fit into 8 bits, but once packed take hardly fewer bytes. Other programs
# rescale targets only if they have the type of their mesh, and whole numbers only if these are
# normalized.

# A coordinate is off by at most half a step, a vertex by half the diagonal of a cube of steps.
_WORST = np.sqrt(3) / 2
_LARGEST = np.iinfo(np.int16).max
_FARTHEST, _TINY = 1e30, 1e-37


@dataclass(frozen=True, eq=False)
class Grid:
    """Steps in which positions and displacements are stored."""

    scale: float  # Length of 32767 steps, in units of the rig
    origin: NDArray[np.float64]  # (3,) where the steps of positions are counted from

    @classmethod
    def of(cls, rig: Rig, error: float) -> Grid:
        """The longest steps at which no slider is off by more than a fraction of D.

        A vertex sums the errors of the neutral, of Δ, and of each bend times its curve.
        """
        vertices = rig.neutral.vertices
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        sums = [sum(curve.height for curve in m.bend_curves) for m in rig.morphs.values()]
        step = error * (rig.neutral.diameter or 1.0) / (_WORST * (2 + max(sums, default=0.0)))
        fields = [own for m in rig.morphs.values() for own in (m.delta, m.bends)]
        farthest = max(float(np.abs(own).max(initial=0.0)) for own in [high - low, *fields])
        # In single precision, as viewers hold the scale of a node, and no number of steps too large
        # for it where targets move vertices beyond all measure.
        scale = _LARGEST * max(step, farthest / _FARTHEST, _TINY)
        return cls(float(np.float32(scale)), (low + high) / 2)

    @property
    def step(self) -> float:
        """Length of a step, in units of the rig."""
        return self.scale / _LARGEST

    def positions(self, rows: NDArray[np.float64]) -> NDArray[Any]:
        """(N, 3) positions from the origin: int16 steps, or float32 in units of the scale."""
        return self._whole(rows - self.origin)

    def displacements(self, rows: NDArray[np.float64]) -> NDArray[Any]:
        """(N, 3) displacements: int16 steps, or float32 in units of the scale."""
        return self._whole(rows)

    def stored_positions(self, rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) positions as a reader gets them."""
        return self._units(self.positions(rows)) + self.origin

    def stored_displacements(self, rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) displacements as a reader gets them."""
        return self._units(self.displacements(rows))

    def placing(self) -> dict[str, list[float]]:
        """The scale and the translation of the node of the mesh, as JSON."""
        return {"scale": [self.scale] * 3, "translation": self.origin.tolist()}

    def _units(self, stored: NDArray[Any]) -> NDArray[np.float64]:
        """What was stored, in units of the rig."""
        return stored.astype(np.float64) * (self.step if stored.dtype.kind == "i" else self.scale)

    def _whole(self, rows: NDArray[np.float64]) -> NDArray[Any]:
        """In 16 bits; as floats, unrounded, where these do not hold them."""
        whole = np.rint(rows / self.step)
        if np.abs(whole).max(initial=0.0) > _LARGEST:
            return (rows / self.scale).astype("<f4")
        return whole.astype("<i2")


def byte_normals(normals: NDArray[np.float64]) -> NDArray[np.int8]:
    """(N, 3) unit vectors, or what is added to them, in 127ths."""
    found: NDArray[np.int8] = np.rint(127 * np.clip(normals, -1, 1)).astype(np.int8)
    return found


def within_reach(turned: NDArray[np.float64], normals: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 3) what is added to unit normals, with no part of it beyond 1, which is all bytes hold.

    A normal only tells a direction: n + δ is shortened until each part of δ fits. The direction at
    the end of the slider stays what it was.
    """
    end = normals + turned
    # |s·e − n| ≤ 1 for each part: s ≤ (1 ± n) / |e| by the sign of e.
    with np.errstate(all="ignore"):
        room = np.where(end == 0, np.inf, (1 + np.sign(end) * normals) / np.abs(end))
    shorter = np.clip(room.min(axis=1, keepdims=True), 0.0, 1.0)
    return np.where(shorter < 1, shorter * end - normals, turned)


def padded(rows: NDArray[Any]) -> NDArray[np.uint8]:
    """(N, bytes) rows as bytes, each filled up with zeros to fours, as attributes must lie."""
    content = np.ascontiguousarray(rows).view(np.uint8).reshape(len(rows), -1)
    return np.pad(content, ((0, 0), (0, -content.shape[1] % 4)))


def largest_move(away: Sequence[NDArray[np.float64]]) -> float:
    """The farthest that (V, 3) errors move a vertex together, however they point."""
    total = sum(np.sqrt(np.einsum("vi,vi->v", own, own)) for own in away)
    return float(np.max(total, initial=0.0))


_ARRAY_BUFFER, _ELEMENT_ARRAY_BUFFER = 34962, 34963
_ATTRIBUTES = "attributes"
_VIEWS: dict[str, dict[str, int]] = {
    "indices": {"target": _ELEMENT_ARRAY_BUFFER},
    "times of keys": {},
    "weights of keys": {},
    "places of sparse values": {},
    "sparse values": {},
}


@dataclass(eq=False)
class _View:
    """Values of accessors that lie together."""

    fields: dict[str, int]  # of the buffer view, as JSON
    row: int  # Bytes that a row, or an index, takes
    part: str  # of the file that the first of them belong to
    mode: str = "ATTRIBUTES"  # in which meshoptimizer packs it
    content: bytearray = field(default_factory=bytearray)


class AccessorWriter:
    """Collects accessors, and their values in one buffer.

    Args:
        compress: Pack every view with meshoptimizer.
    """

    def __init__(self, compress: bool = False) -> None:
        self.accessors: list[dict[str, Any]] = []  # as JSON
        self.sizes: dict[str, int] = {}  # bytes of each part of the file, by its name, at the end
        self._views: dict[str, _View] = {}
        self._known: dict[bytes, int] = {}
        self._compress = compress

    def vertices(
        self,
        rows: NDArray[Any],
        part: str,
        *,
        bounds: bool = False,
        sparse: bool = False,
    ) -> int:
        """The number of an attribute of the vertices, or of a morph target, (N, 2) or (N, 3).

        Bounds, as positions must have, are its least and greatest value; sparse, only the rows that
        are not zero are stored, where that is smaller. Whole numbers are normalized: the largest
        stands for 1.
        """
        moved = np.flatnonzero(rows.any(axis=1)) if sparse else None
        if moved is not None:
            moved = moved.astype(np.uint16 if len(rows) <= 0xFFFF else np.uint32)
            smaller = moved.nbytes + rows[:1].nbytes * len(moved) < rows.nbytes
            # Packed, zeros take nearly nothing, and places of what is not zero more.
            if len(moved) and (self._compress or not smaller):
                moved = None
        return self._accessor(_ATTRIBUTES, rows, part, bounds, moved)

    def indices(self, triangles: NDArray[np.int32], vertices: int) -> int:
        """The corners of triangles (T, 3) of a mesh of so many vertices."""
        kind = np.uint16 if vertices <= 0xFFFF else np.uint32
        return self._accessor("indices", triangles.reshape(-1, 1).astype(kind), "surface")

    def keys(self, times: NDArray[np.float32], weights: NDArray[np.float32]) -> tuple[int, int]:
        """The key times (T,) and the keys (T, targets) of an animation."""
        at = self._accessor("times of keys", times.reshape(-1, 1), "animations", bounds=True)
        return at, self._accessor("weights of keys", weights.reshape(-1, 1), "animations")

    def rotations(self, keys: NDArray[np.float32]) -> int:
        """The quaternions (T, 4) of an animation."""
        return self._accessor("rotations of keys", keys, "animations")

    def finish(self) -> tuple[list[dict[str, Any]], list[dict[str, Any]], bytes]:
        """The buffer views, the buffers, and the bytes of the first of these."""
        blob = bytearray()
        views: list[dict[str, Any]] = []
        plain = 0  # bytes that all would take
        for name, own in self._views.items():
            content = bytes(own.content)
            place: dict[str, Any] = {
                "buffer": 0,
                "byteOffset": len(blob),
                "byteLength": len(content),
            }
            if self._compress:
                content, packing = packed_view(content, own.row, own.mode)
                packed_place = {**place, "byteLength": len(content)}
                place |= {"buffer": 1, "byteOffset": plain}
                place["extensions"] = {EXTENSIONS[0]: packed_place | packing}
                plain += len(own.content) + -len(own.content) % 4
                self.sizes[own.part] = self.sizes.get(own.part, 0) + len(content)
            views.append({**place, **own.fields, "name": name})
            blob += content + bytes(-len(content) % 4)
        buffers: list[dict[str, Any]] = [{"byteLength": len(blob)}]
        if self._compress:  # where the views would be in a plain file; it has no bytes
            said = {"extensions": {EXTENSIONS[0]: {"fallback": True}}}
            buffers.append({"byteLength": plain} | said)
        return views, buffers, bytes(blob)

    def _accessor(
        self,
        kind: str,
        rows: NDArray[Any],
        part: str,
        bounds: bool = False,
        moved: NDArray[Any] | None = None,
    ) -> int:
        # An accessor has one use: positions state their bounds, times and weights lie apart.
        width = rows.shape[1]
        use = f"{kind} of {width} {moved is None} {rows.dtype} {rows.shape} {bounds}"
        key = hashlib.blake2b(use.encode() + rows.tobytes(), digest_size=16).digest()
        if key in self._known:
            return self._known[key]
        accessor: dict[str, Any] = {} if moved is not None else self._append(kind, rows, part)
        accessor |= {
            "componentType": COMPONENT_TYPES[rows.dtype.str],
            "count": len(rows),
            "type": TYPES[width],
        }
        if kind == _ATTRIBUTES and rows.dtype.kind == "i":
            accessor["normalized"] = True
        if moved is not None and len(moved):
            number = {"componentType": COMPONENT_TYPES[moved.dtype.str]}
            places = self._append("places of sparse values", moved.reshape(-1, 1), part)
            accessor["sparse"] = {
                "count": len(moved),
                "indices": places | number,
                "values": self._append("sparse values", rows[moved], part),
            }
        if bounds:
            accessor |= {"max": rows.max(axis=0).tolist(), "min": rows.min(axis=0).tolist()}
        self._known[key] = len(self.accessors)
        self.accessors.append(accessor)
        return self._known[key]

    def _append(self, kind: str, rows: NDArray[Any], part: str) -> dict[str, Any]:
        """Where the values of an accessor are."""
        content, name, fields = rows.tobytes(), kind, _VIEWS.get(kind, {})
        row, mode = rows.itemsize * rows.shape[1], "INDICES" if kind == "indices" else "ATTRIBUTES"
        if kind == _ATTRIBUTES:
            filled = padded(rows)
            content, row = filled.tobytes(), filled.shape[1]
            name = f"attributes of {row // 4}"
            fields = {"byteStride": row, "target": _ARRAY_BUFFER}
        if self._compress:  # parts pack better apart, and can be told apart
            name = f"{part}: {name}"
        view = self._views.setdefault(name, _View(fields, row, part, mode))
        view.content += bytes(-len(view.content) % 4)
        offset = len(view.content)
        view.content += content
        if not self._compress:
            self.sizes[part] = self.sizes.get(part, 0) + len(content)
        return {"bufferView": list(self._views).index(name), "byteOffset": offset}
