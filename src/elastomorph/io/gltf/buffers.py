"""The binary part of a file: accessors, dense or sparse, each sequence of bytes stored once."""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["BufferWriter"]

_ARRAY_BUFFER, _ELEMENT_ARRAY_BUFFER = 34962, 34963
_COMPONENT_TYPES = {"uint16": 5123, "uint32": 5125, "float32": 5126}
_TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3"}
_VIEWS: dict[str, dict[str, int]] = {
    "attributes of 2": {"byteStride": 8, "target": _ARRAY_BUFFER},
    "attributes of 3": {"byteStride": 12, "target": _ARRAY_BUFFER},
    "indices": {"target": _ELEMENT_ARRAY_BUFFER},
    "times of keys": {},
    "weights of keys": {},
    "places of sparse values": {},
    "sparse values": {},
}


class BufferWriter:
    """Collects accessors, and their values in one buffer.

    Attributes:
        accessors: The accessors, as JSON.
        sizes: Bytes written for each part of the file, by the names the caller gives them.
    """

    def __init__(self) -> None:
        self.accessors: list[dict[str, Any]] = []
        self.sizes: dict[str, int] = {}
        self._views: dict[str, bytearray] = {}
        self._known: dict[bytes, int] = {}

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
        moved = np.flatnonzero(rows.any(axis=1)) if sparse else None
        if moved is not None:
            moved = moved.astype(np.uint16 if len(rows) <= 0xFFFF else np.uint32)
            if moved.nbytes + rows[:1].nbytes * len(moved) >= rows.nbytes:
                moved = None
        return self._accessor(f"attributes of {rows.shape[1]}", rows, part, bounds, moved)

    def indices(self, triangles: NDArray[np.int32], vertices: int) -> int:
        """The corners of triangles (T, 3) of a mesh of so many vertices."""
        kind = np.uint16 if vertices <= 0xFFFF else np.uint32
        return self._accessor("indices", triangles.reshape(-1, 1).astype(kind), "surface")

    def times(self, seconds: NDArray[np.float32]) -> int:
        """The key times (T,) of an animation."""
        return self._accessor("times of keys", seconds.reshape(-1, 1), "animations", bounds=True)

    def weights(self, weights: NDArray[np.float32]) -> int:
        """The keys (T, targets) of an animation."""
        return self._accessor("weights of keys", weights.reshape(-1, 1), "animations")

    def finish(self) -> tuple[list[dict[str, Any]], bytes]:
        """The buffer views and the buffer."""
        blob = bytearray()
        views: list[dict[str, Any]] = []
        for name, content in self._views.items():
            place = {"buffer": 0, "byteOffset": len(blob), "byteLength": len(content)}
            views.append({**place, **_VIEWS[name], "name": name})
            blob += content + bytes(-len(content) % 4)
        return views, bytes(blob)

    def _accessor(
        self,
        view: str,
        rows: NDArray[Any],
        part: str,
        bounds: bool = False,
        moved: NDArray[Any] | None = None,
    ) -> int:
        # An accessor has one use: positions state their bounds, times and weights lie apart.
        use = f"{view} {moved is None} {rows.dtype} {rows.shape} {bounds}".encode()
        key = hashlib.blake2b(use + rows.tobytes(), digest_size=16).digest()
        if key in self._known:
            return self._known[key]
        accessor: dict[str, Any] = {} if moved is not None else self._append(view, rows, part)
        accessor |= {
            "componentType": _COMPONENT_TYPES[rows.dtype.name],
            "count": len(rows),
            "type": _TYPES[rows.shape[1]],
        }
        if moved is not None and len(moved):
            kind = {"componentType": _COMPONENT_TYPES[moved.dtype.name]}
            accessor["sparse"] = {
                "count": len(moved),
                "indices": self._append("places of sparse values", moved, part) | kind,
                "values": self._append("sparse values", rows[moved], part),
            }
        if bounds:
            accessor |= {"max": rows.max(axis=0).tolist(), "min": rows.min(axis=0).tolist()}
        self._known[key] = len(self.accessors)
        self.accessors.append(accessor)
        return self._known[key]

    def _append(self, view: str, rows: NDArray[Any], part: str) -> dict[str, Any]:
        """Where the values of an accessor are."""
        content = self._views.setdefault(view, bytearray())
        content += bytes(-len(content) % 4)
        offset = len(content)
        content += rows.tobytes()
        self.sizes[part] = self.sizes.get(part, 0) + rows.nbytes
        return {"bufferView": list(self._views).index(view), "byteOffset": offset}
