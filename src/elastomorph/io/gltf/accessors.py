"""Accessors: arrays in the buffers of a document, dense or sparse.

Every number that is read is checked against the bytes there are before it is believed.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.gltf.container import GltfFile
from elastomorph.io.gltf.draco import draco_values

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
