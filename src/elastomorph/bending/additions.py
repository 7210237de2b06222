"""What is added to a document: accessors, the views they are in, and the bytes of these.

Everything goes behind what there is, so that every number in the document still holds; only where
keys of a clip are of no more use, `fill_gaps` puts some of it in their place.
"""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.gltf import meshopt
from elastomorph.io.gltf.accessor_writer import padded
from elastomorph.io.gltf.accessors import COMPONENT_TYPES, TYPES
from elastomorph.io.gltf.container import GltfFile

_ARRAY_BUFFER = 34962


@dataclass(frozen=True)
class Packing:
    """How the views of a file that meshoptimizer packed are packed.

    Attributes:
        extension: The name of the extension.
        fallback: Number of the buffer, without bytes, that views have their decoded place in.
        length: Its length.
        asked: Whether it is only what is added that is packed, as the user asks.
    """

    extension: str
    fallback: int
    length: int
    asked: bool = False

    @classmethod
    def of(cls, file: GltfFile, accessors: Iterable[Any]) -> Packing | None:
        """That of the first of some accessors that is packed, None where none is."""
        for number in accessors:
            view = file.item("accessors", number, "a morph target").get("bufferView")
            if view is None:
                continue
            entry = file.item("bufferViews", view, "a morph target")
            extensions = file.object_in(entry, "extensions", "a buffer view")
            for name in meshopt.EXTENSIONS:
                buffer = file.item("buffers", entry.get("buffer"), "a buffer view")
                own = file.object_in(buffer, "extensions", "a buffer").get(name)
                bare = isinstance(own, dict) and own.get("fallback") is True and "uri" not in buffer
                if name in extensions and bare:
                    length = file.whole_in(buffer, "byteLength", "a buffer")
                    return cls(name, entry["buffer"], length)
        return None


class Additions:
    """Collects what bends add to a document.

    Args:
        accessors: How many accessors the document has.
        views: How many buffer views.
        packing: How its targets are packed, if they are.
    """

    def __init__(self, accessors: int, views: int, packing: Packing | None = None) -> None:
        self._first_accessor, self._first_view = accessors, views
        self._packing = packing
        self.fallback_length = 0 if packing is None else packing.length
        self.accessors: list[dict[str, Any]] = []
        self._views: list[dict[str, Any]] = []
        self._contents: list[bytearray] = []
        self._shared: dict[tuple[Any, ...], int] = {}
        self._known: dict[bytes, int] = {}

    @property
    def packs(self) -> bool:
        """Whether what is added is packed because the user asks, so that it may be rounded."""
        return self._packing is not None and self._packing.asked

    @property
    def size(self) -> int:
        """Bytes of all that was added so far."""
        return sum(map(len, self._contents))

    def displacements(
        self, rows: NDArray[Any], *, normalized: bool = False, bounds: bool = False
    ) -> int:
        """The number of an accessor of (N, 3) displacements, sparse where that is smaller.

        Sparse fractions are stored in single precision: glTF-Transform, through which many files
        go, empties sparse arrays of normalized whole numbers.
        """
        moved = np.flatnonzero(rows.any(axis=1))
        moved = moved.astype(np.uint16 if len(rows) <= 0x10000 else np.uint32)
        dense = (rows.itemsize * 3 + -(rows.itemsize * 3) % 4) * len(rows)
        fractions = normalized and len(moved) > 0
        sparse = (moved.itemsize + (4 if fractions else rows.itemsize) * 3) * len(moved)
        use = f"{rows.dtype.str} {rows.shape} {normalized} {bounds}".encode()
        key = hashlib.blake2b(use + rows.tobytes(), digest_size=16).digest()
        if key not in self._known:
            # A packed file gets whole views, as its own are: zeros take next to nothing.
            like_others = self._packing is not None and not self.packs
            whole = sparse >= dense or (like_others and len(moved) > 0)
            if fractions and not whole:
                rows = (rows / np.iinfo(rows.dtype).max).astype(np.float32)
                normalized = False
            accessor = self._dense(rows) if whole else self._sparse(rows, moved)
            accessor |= {"normalized": True} if normalized else {}
            if bounds:
                low, high = rows.min(axis=0).tolist(), rows.max(axis=0).tolist()
                accessor |= {"min": low, "max": high}
            self._known[key] = self._add(accessor)
        return self._known[key]

    def keys(self, values: NDArray[Any], beside: Any, *, bounds: bool = False) -> int:
        """The number of an accessor of (N,) numbers: key times, which have bounds, or weights.

        The largest of whole numbers stands for 1.

        They share a view with others in whose place keys of the same view were.
        """
        place = self._append(("keys", values.itemsize, bounds, beside), values.tobytes())
        accessor = place | self._kind(values.reshape(-1, 1))
        accessor |= {"normalized": True} if values.dtype.kind != "f" else {}
        if bounds:
            accessor |= {"min": [float(values.min())], "max": [float(values.max())]}
        return self._add(accessor)

    def _dense(self, rows: NDArray[Any]) -> dict[str, Any]:
        content = padded(rows)
        stride = content.shape[1]
        view = {"byteStride": stride, "target": _ARRAY_BUFFER}
        return self._append(("dense", stride), content.tobytes(), view) | self._kind(rows)

    def _sparse(self, rows: NDArray[Any], moved: NDArray[Any]) -> dict[str, Any]:
        if not len(moved):
            return self._kind(rows)
        places = self._append(("places", moved.itemsize), moved.tobytes())
        values = self._append(("values", rows.itemsize), rows[moved].tobytes())
        component = {"componentType": COMPONENT_TYPES[moved.dtype.str]}
        sparse = {"count": len(moved), "indices": places | component, "values": values}
        return self._kind(rows) | {"sparse": sparse}

    def _kind(self, rows: NDArray[Any]) -> dict[str, Any]:
        kind = {"componentType": COMPONENT_TYPES[rows.dtype.str], "count": len(rows)}
        return kind | {"type": TYPES[rows.shape[1]]}

    def _append(
        self, use: tuple[Any, ...], content: bytes, view: dict[str, Any] | None = None
    ) -> dict[str, Any]:
        """Where bytes are, in a view that others of the same use share."""
        if use not in self._shared:
            self._shared[use] = len(self._views)
            self._views.append(view or {})
            self._contents.append(bytearray())
        number = self._shared[use]
        held = self._contents[number]
        held += bytes(-len(held) % 4)
        offset = len(held)
        held += content
        return {"bufferView": self._first_view + number, "byteOffset": offset}

    def _add(self, accessor: dict[str, Any]) -> int:
        self.accessors.append(accessor)
        return self._first_accessor + len(self.accessors) - 1

    def placed(self, buffer: int, start: int) -> tuple[list[dict[str, Any]], bytes]:
        """The buffer views, and their bytes, which follow ``start`` others in a buffer."""
        views, blob = [], bytearray(-start % 4)
        for use, own, content in zip(self._shared, self._views, self._contents, strict=True):
            stored = bytes(content)
            offset = start + len(blob)
            place: dict[str, Any] = {"buffer": buffer, "byteOffset": offset}
            place["byteLength"] = len(stored)
            # Rows are packed as they are read: whole elements, of which meshoptimizer takes fours.
            stride = own.get("byteStride", use[1] * (3 if use[0] == "values" else 1))
            mode = "INDICES" if use[0] == "places" else "ATTRIBUTES"
            if self._packing is not None and (mode == "INDICES" or stride % 4 == 0):
                stored += bytes(-len(stored) % stride)
                place = self._unpacked(len(stored))
                stored, packing = meshopt.packed_view(stored, stride, mode)
                packed = {"buffer": buffer, "byteOffset": offset, "byteLength": len(stored)}
                place["extensions"] = {self._packing.extension: packed | packing}
            views.append(place | own)
            blob += stored + bytes(-len(stored) % 4)
        return views, bytes(blob)

    def _unpacked(self, length: int) -> dict[str, Any]:
        """The place of decoded bytes in the buffer that has none."""
        packing = self._packing
        assert packing is not None
        offset = self.fallback_length + -self.fallback_length % 4
        self.fallback_length = offset + length
        return {"buffer": packing.fallback, "byteOffset": offset, "byteLength": length}


def data_uri(content: bytes) -> str:
    """Bytes as a text that stands for a file."""
    return "data:application/octet-stream;base64," + base64.b64encode(content).decode()
