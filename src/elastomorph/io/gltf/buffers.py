"""The binary part of a file: accessors, dense or sparse, each sequence of bytes stored once."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import MissingExtraError

__all__ = ["BufferBuilder", "pygltflib"]

_ARRAY_BUFFER, _ELEMENT_ARRAY_BUFFER = 34962, 34963
_UNSIGNED_SHORT, _UNSIGNED_INT, _FLOAT = 5123, 5125, 5126
_ROWS = {1: "SCALAR", 2: "VEC2", 3: "VEC3"}


def pygltflib() -> Any:
    """The library that models glTF documents.

    Raises:
        MissingExtraError: It is not installed.
    """
    try:
        return import_module("pygltflib")
    except ImportError:
        raise MissingExtraError("pygltflib", "gltf") from None


@dataclass(frozen=True)
class _View:
    """A stretch of the buffer for accessors of one kind."""

    name: str
    target: int | None = None
    stride: int | None = None


_INDICES = _View("indices", _ELEMENT_ARRAY_BUFFER)
_TIMES = _View("times of keys")
_WEIGHTS = _View("weights of keys")
_PLACES = _View("places of sparse values")
_VALUES = _View("sparse values")


class BufferBuilder:
    """Collects accessors; `finish` lays them out.

    Attributes:
        sizes: Bytes written for each part of the file, by the names the caller gives them.
    """

    def __init__(self) -> None:
        self._library = pygltflib()
        self._stretches: dict[_View, bytearray] = {}
        self._accessors: list[Any] = []
        self._known: dict[bytes, int] = {}
        self.sizes: dict[str, int] = {}

    def vertices(
        self, rows: NDArray[np.float32], part: str, *, bounds: bool = False, sparse: bool = False
    ) -> int:
        """An attribute of the vertices, or of a morph target.

        Args:
            rows: (N, 2) or (N, 3) float32.
            part: What its bytes are counted as.
            bounds: Whether to state the least and greatest value, as positions must.
            sparse: Whether to store only the rows that are not zero, where that is smaller.

        Returns:
            The number of the accessor.
        """
        moved = np.flatnonzero(rows.any(axis=1)) if sparse else np.zeros(0, dtype=np.int64)
        width = 2 if len(rows) <= 0xFFFF else 4
        saves = sparse and len(moved) * (width + rows.itemsize * rows.shape[1]) < rows.nbytes
        if saves:
            return self._sparse(rows, moved, width, part, bounds)
        view = _View(f"attributes of {rows.shape[1]}", _ARRAY_BUFFER, 4 * rows.shape[1])
        return self._dense(rows, view, part, bounds)

    def indices(self, triangles: NDArray[np.int32], vertices: int) -> int:
        """The corners of triangles (T, 3) of a mesh of so many vertices."""
        kind = np.uint16 if vertices <= 0xFFFF else np.uint32
        return self._dense(triangles.reshape(-1, 1).astype(kind), _INDICES, "surface", False)

    def times(self, seconds: NDArray[np.float32]) -> int:
        """The key times (T,) of an animation."""
        return self._dense(seconds.reshape(-1, 1), _TIMES, "animations", True)

    def weights(self, weights: NDArray[np.float32]) -> int:
        """The keys (T, targets) of an animation."""
        return self._dense(weights.reshape(-1, 1), _WEIGHTS, "animations", False)

    def finish(self) -> tuple[list[Any], list[Any], bytes]:
        """The accessors, the buffer views and the buffer."""
        blob = bytearray()
        number: dict[_View, int] = {}
        views: list[Any] = []
        for view, content in self._stretches.items():
            number[view] = len(views)
            views.append(
                self._library.BufferView(
                    buffer=0,
                    byteOffset=len(blob),
                    byteLength=len(content),
                    byteStride=view.stride,
                    target=view.target,
                    name=view.name,
                )
            )
            blob += content + bytes(-len(content) % 4)
        for accessor in self._accessors:
            for holder in (
                (accessor, accessor.sparse.indices, accessor.sparse.values)
                if accessor.sparse
                else (accessor,)
            ):
                if holder.bufferView is not None:
                    holder.bufferView = number[holder.bufferView]
        return self._accessors, views, bytes(blob)

    def _dense(self, rows: NDArray[Any], view: _View, part: str, bounds: bool) -> int:
        key = self._key(view.name, rows, bounds)
        if key not in self._known:
            offset = self._append(view, rows, part)
            self._add(key, rows, bounds, bufferView=view, byteOffset=offset)
        return self._known[key]

    def _sparse(
        self,
        rows: NDArray[np.float32],
        moved: NDArray[np.int64],
        width: int,
        part: str,
        bound: bool,
    ) -> int:
        key = self._key("sparse", rows, bound)
        if key not in self._known:
            sparse = None
            if len(moved):
                places = moved.astype(np.uint16 if width == 2 else np.uint32)
                library = self._library
                sparse = library.Sparse(
                    count=len(moved),
                    indices=library.AccessorSparseIndices(
                        bufferView=_PLACES,
                        byteOffset=self._append(_PLACES, places, part),
                        componentType=_UNSIGNED_SHORT if width == 2 else _UNSIGNED_INT,
                    ),
                    values=library.AccessorSparseValues(
                        bufferView=_VALUES,
                        byteOffset=self._append(_VALUES, rows[moved], part),
                    ),
                )
            self._add(key, rows, bound, sparse=sparse, bufferView=None, byteOffset=None)
        return self._known[key]

    def _add(self, key: bytes, rows: NDArray[Any], bounds: bool, **fields: Any) -> None:
        types = {np.dtype(np.uint16): _UNSIGNED_SHORT, np.dtype(np.uint32): _UNSIGNED_INT}
        self._known[key] = len(self._accessors)
        self._accessors.append(
            self._library.Accessor(
                componentType=types.get(rows.dtype, _FLOAT),
                normalized=None,
                count=len(rows),
                type=_ROWS[rows.shape[1]],
                min=_bound(rows.min(axis=0)) if bounds else None,
                max=_bound(rows.max(axis=0)) if bounds else None,
                **fields,
            )
        )

    def _append(self, view: _View, rows: NDArray[Any], part: str) -> int:
        content = rows.tobytes()
        stretch = self._stretches.setdefault(view, bytearray())
        stretch += bytes(-len(stretch) % 4)
        offset = len(stretch)
        stretch += content
        self.sizes[part] = self.sizes.get(part, 0) + len(content)
        return offset

    @staticmethod
    def _key(kind: str, rows: NDArray[Any], bounds: bool) -> bytes:
        # An accessor has one use: positions state their bounds, times and weights lie apart.
        shape = f"{kind} {rows.dtype} {rows.shape} {bounds}".encode()
        return hashlib.blake2b(shape + rows.tobytes(), digest_size=16).digest()


def _bound(row: Sequence[Any] | NDArray[Any]) -> list[float]:
    return [float(value) for value in row]
