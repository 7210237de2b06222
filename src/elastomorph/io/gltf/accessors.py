"""Accessors: arrays in the buffers of a document, dense, sparse, or packed with Draco.

Every number that is read is checked against the bytes there are before it is believed.

With KHR_draco_mesh_compression a primitive names a stream, and by numbers its attributes in the
stream; its accessors say what they are, but have no bytes. Morph targets are no part of it: theirs
are plain, in the order of the vertices in the stream. Draco breaks or takes any amount of memory on
damaged streams, so all those of a file are unpacked in a process of its own.
"""

from __future__ import annotations

import tempfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FileError, FormatError, MissingExtraError
from elastomorph.io.gltf.container import GltfFile
from elastomorph.io.isolated import IsolatedReader, extracted
from elastomorph.io.npz.members import NpzMembers, write_arrays

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
