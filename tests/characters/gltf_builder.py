"""glTF documents made by hand: any number of buffers, views and accessors of every kind.

Nothing of the package is used, so that what is made here is made as others make it.
"""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
COMPONENTS = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
ARRAY, ELEMENT = 34962, 34963


class GltfBuilder:
    """A document that grows, and the buffers beside it."""

    def __init__(self, buffers: int = 1) -> None:
        self.json: dict[str, Any] = {"asset": {"version": "2.0", "generator": "made by hand"}}
        self.blobs = [bytearray() for _ in range(buffers)]

    def add(self, kind: str, entry: dict[str, Any]) -> int:
        """The number of a new entry of a root list such as "nodes"."""
        entries: list[Any] = self.json.setdefault(kind, [])
        entries.append(entry)
        return len(entries) - 1

    def use(self, *extensions: str) -> None:
        """State that extensions are used."""
        used = self.json.setdefault("extensionsUsed", [])
        used.extend(name for name in extensions if name not in used)

    def view(self, content: bytes, buffer: int = 0, **more: Any) -> int:
        """A buffer view of some bytes, from a place that suits every type."""
        blob = self.blobs[buffer]
        blob += bytes(-len(blob) % 4)
        place = {"buffer": buffer, "byteOffset": len(blob), "byteLength": len(content)}
        blob += content
        return self.add("bufferViews", place | more)

    def accessor(
        self,
        values: NDArray[Any],
        *,
        buffer: int = 0,
        target: int | None = None,
        bounds: bool = False,
        normalized: bool = False,
        **more: Any,
    ) -> int:
        """An accessor with a view of its own: (N,) or (N, width), little-endian, tightly packed."""
        rows = _rows(values)
        aim = {} if target is None else {"target": target}
        number = self.view(rows.tobytes(), buffer, **aim)
        shape = _shape(rows, bounds, normalized)
        return self.add("accessors", {"bufferView": number} | shape | more)

    def attributes(
        self, columns: dict[str, NDArray[Any]], *, interleaved: bool, buffer: int = 0
    ) -> dict[str, int]:
        """Vertex attributes by name, each with a view or all in one, vertex after vertex."""
        if not interleaved:
            return {
                name: self.accessor(
                    _padded(values),
                    buffer=buffer,
                    target=ARRAY,
                    bounds=name == "POSITION",
                    normalized=name.startswith("COLOR") and values.dtype.kind == "u",
                )
                for name, values in columns.items()
            }
        rows = [_padded(values) for values in columns.values()]
        whole = np.concatenate([own.view("u1").reshape(len(own), -1) for own in rows], axis=1)
        number = self.view(whole.tobytes(), buffer, byteStride=whole.shape[1], target=ARRAY)
        found, offset = {}, 0
        for (name, _), own in zip(columns.items(), rows, strict=True):
            place = {"bufferView": number, "byteOffset": offset}
            normal = name.startswith("COLOR") and own.dtype.kind == "u"
            found[name] = self.add("accessors", place | _shape(own, name == "POSITION", normal))
            offset += own.dtype.itemsize * own.shape[1]
        return found

    def target(self, moved: NDArray[np.float32], kind: str, *, buffer: int = 0) -> int:
        """A morph target's (N, 3) vectors: "dense", "sparse" or, where all are zero, "bare"."""
        places = np.flatnonzero(moved.any(axis=1))
        if kind == "dense" or (kind == "sparse" and not len(places)):
            return self.accessor(moved, buffer=buffer, target=ARRAY, bounds=True)
        shape = _shape(moved, True, False)
        if kind == "bare":
            assert not len(places)
            return self.add("accessors", shape)
        indices = places.astype("<u2" if len(moved) < 0x10000 else "<u4")
        sparse = {
            "count": len(places),
            "indices": {
                "bufferView": self.view(indices.tobytes(), buffer),
                "componentType": COMPONENTS[indices.dtype.str[1:]],
            },
            "values": {"bufferView": self.view(moved[places].tobytes(), buffer)},
        }
        return self.add("accessors", shape | {"sparse": sparse})

    def write(self, path: Path, *, embedded: bool = False) -> Path:
        """The document as .glb (its first buffer within), or .gltf with files or data URIs."""
        self.json["buffers"] = []
        for number, blob in enumerate(self.blobs):
            blob += bytes(-len(blob) % 4)
            entry: dict[str, Any] = {"byteLength": len(blob)}
            if path.suffix == ".gltf" and not embedded:
                name = f"{path.stem} {number}.bin"
                path.with_name(name).write_bytes(blob)
                entry["uri"] = name.replace(" ", "%20")
            elif path.suffix == ".gltf" or number:
                text = base64.b64encode(blob).decode()
                entry["uri"] = f"data:application/octet-stream;base64,{text}"
            entry["extras"] = {"buffer": number}
            self.json["buffers"].append(entry)
        if path.suffix == ".gltf":
            path.write_text(json.dumps(self.json, indent=1))
        else:
            path.write_bytes(glb_of(self.json, bytes(self.blobs[0])))
        return path


def glb_of(document: dict[str, Any], blob: bytes) -> bytes:
    """A GLB container."""
    text = json.dumps(document, ensure_ascii=False, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    chunks += struct.pack("<II", len(blob), 0x004E4942) + blob
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


def _rows(values: NDArray[Any]) -> NDArray[Any]:
    rows = np.ascontiguousarray(values)
    rows = rows.astype(rows.dtype.newbyteorder("<"))
    return rows.reshape(len(rows), -1)


def _padded(values: NDArray[Any]) -> NDArray[Any]:
    """Rows whose size is a multiple of four bytes, as vertex attributes must have."""
    rows = _rows(values)
    assert rows.dtype.itemsize * rows.shape[1] % 4 == 0
    return rows


def _shape(rows: NDArray[Any], bounds: bool, normalized: bool) -> dict[str, Any]:
    found: dict[str, Any] = {
        "componentType": COMPONENTS[rows.dtype.str[1:]],
        "count": len(rows),
        "type": TYPES[rows.shape[1]],
    }
    if normalized:
        found["normalized"] = True
    if bounds:
        found |= {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
    return found


def png(pixels: NDArray[np.uint8]) -> bytes:
    """A PNG of (H, W, 3) colours."""
    import zlib

    height, width, _ = pixels.shape
    lines = np.concatenate([np.zeros((height, 1), np.uint8), pixels.reshape(height, -1)], axis=1)

    def chunk(name: bytes, content: bytes) -> bytes:
        check = struct.pack(">I", zlib.crc32(name + content))
        return struct.pack(">I", len(content)) + name + content + check

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    body = zlib.compress(lines.tobytes(), 9)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", body) + chunk(b"IEND", b"")


def chained(parents: Sequence[int | None]) -> list[list[int]]:
    """The children of each node, from its parent."""
    children: list[list[int]] = [[] for _ in parents]
    for number, parent in enumerate(parents):
        if parent is not None:
            children[parent].append(number)
    return children
