"""Accessors and their values as a file gets them: each sequence of bytes once, in one buffer."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.gltf.accessors import COMPONENT_TYPES, TYPES
from elastomorph.io.gltf.meshopt import EXTENSIONS, packed_view
from elastomorph.io.gltf.quantize import padded

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
