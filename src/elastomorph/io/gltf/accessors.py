"""Accessors as arrays: every number checked against the bytes there are before it is believed."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.gltf.container import GltfFile

__all__ = ["AccessorReader"]

_TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "MAT4": 16}
_COPIES = 20  # bytes of each number that is read, with the copies made of it
_MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression")


class AccessorReader:
    """Reads the accessors of a file, and counts the memory they take.

    Sparse targets are far smaller in the file than in memory, but not arbitrarily so.
    """

    def __init__(self, file: GltfFile) -> None:
        self._file = file

    def floats(self, number: Any, width: int, of: str, *, count: int | None = None) -> Any:
        """Coordinates, unpacked from whole numbers where the file has them quantised.

        Args:
            number: The accessor, as the file names it.
            width: Components of an element.
            of: What names it, for messages.
            count: How many elements it must have, if that is known.

        Returns:
            (count, width) float64.

        Raises:
            FormatError: It does not exist, has another shape, or reaches beyond its buffer.
        """
        values = self._values(number, width, of, count)
        found = values.astype(np.float64)
        if self._file.item("accessors", number, of).get("normalized") is True:
            if values.dtype.kind == "f":
                self._file.refuse(f"accessor {number} holds normalised floats, which do not exist")
            found = np.maximum(found / np.iinfo(values.dtype).max, -1.0)
        return found

    def indices(self, number: Any, of: str) -> NDArray[np.int64]:
        """Vertex indices.

        Raises:
            FormatError: As `floats`, or they are not whole numbers from 0.
        """
        values = self._values(number, 1, of, None)
        if values.dtype.kind != "u":
            self._file.refuse(f"accessor {number} of {of} does not hold vertex indices")
        return values.reshape(-1).astype(np.int64)

    def _values(self, number: Any, width: int, of: str, count: int | None) -> NDArray[Any]:
        file = self._file
        accessor = file.item("accessors", number, of)
        name = f"accessor {number}"
        kind = _TYPES.get(_key(accessor.get("componentType")))
        if kind is None or _WIDTHS.get(_key(accessor.get("type"))) != width:
            file.refuse(f"{name} of {of} has a type that {of} cannot have")
        own = file.whole_in(accessor, "count", name)
        if own < 1 or (count is not None and own != count):
            file.refuse(f"{name} of {of} has {own:,} elements, expected {count or 'at least 1'}")
        dtype = np.dtype(kind)
        if accessor.get("bufferView") is not None:
            offset = file.whole_in(accessor, "byteOffset", name, default=0)
            # The step is the view's; the values are copied, so that sparse ones can replace some.
            view = self._elements(accessor["bufferView"], offset, own, width, dtype, name)
            file.budget.spend(own * width * _COPIES)
            values = view.copy()
        else:  # zeros, or for sparse values
            file.budget.spend(own * width * _COPIES)
            values = np.zeros((own, width), dtype=dtype)
        if "sparse" in accessor:
            self._replace(values, file.object_in(accessor, "sparse", name), name)
        return values

    def _replace(self, values: NDArray[Any], sparse: dict[str, Any], name: str) -> None:
        file = self._file
        count = file.whole_in(sparse, "count", f"the sparse values of {name}")
        if not 1 <= count <= len(values):
            file.refuse(f"{name} has {len(values):,} elements, and {count:,} sparse ones of them")
        places, contents = (
            file.object_in(sparse, key, f"the sparse values of {name}")
            for key in ("indices", "values")
        )
        kind = _TYPES.get(_key(places.get("componentType")), "")
        if "u" not in kind:
            file.refuse(f"the sparse values of {name} have places that are no whole numbers")
        offsets = [
            file.whole_in(part, "byteOffset", f"the sparse values of {name}", default=0)
            for part in (places, contents)
        ]
        file.budget.spend(count * (8 + values.dtype.itemsize * values.shape[1]))
        at = self._elements(
            places.get("bufferView"), offsets[0], count, 1, np.dtype(kind), name
        ).reshape(-1)
        rising = np.diff(at.astype(np.int64)) > 0
        if int(at.max()) >= len(values) or not rising.all():
            file.refuse(f"the sparse values of {name} are out of range or out of order")
        values[at] = self._elements(
            contents.get("bufferView"), offsets[1], count, values.shape[1], values.dtype, name
        )

    def _elements(
        self, view: Any, offset: int, count: int, width: int, dtype: np.dtype[Any], name: str
    ) -> NDArray[Any]:
        """(count, width) elements of a buffer view, not copied."""
        file = self._file
        entry = file.item("bufferViews", view, name)
        of = f"buffer view {view}"
        if any(key in file.object_in(entry, "extensions", of) for key in _MESHOPT):
            file.refuse(
                "it is compressed with meshopt, which is not read. Export it again without "
                "compression"
            )
        start = file.whole_in(entry, "byteOffset", of, default=0)
        length = file.whole_in(entry, "byteLength", of)
        size = dtype.itemsize * width
        # Some programs write 0 for elements without gaps, as glTF 1.0 had it.
        step = file.whole_in(entry, "byteStride", of, default=size) or size
        content = file.buffer(file.whole_in(entry, "buffer", of))
        if start + length > len(content):
            file.refuse(f"{of} reaches beyond its buffer of {len(content):,} bytes")
        if step < size or offset + (count - 1) * step + size > length:
            file.refuse(
                f"{name} has {count:,} elements of {size} bytes, {step} apart, which do not fit "
                f"into the {length:,} bytes of {of}"
            )
        return np.ndarray(
            (count, width),
            dtype=dtype,
            buffer=content,
            offset=start + offset,
            strides=(step, dtype.itemsize),
        )


def _key(value: Any) -> Any:
    """A value to look up; lists and objects are none."""
    return value if isinstance(value, int | str) else None
