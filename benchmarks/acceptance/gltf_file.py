"""glTF files as the specification describes them: the document, its buffers and its accessors."""

from __future__ import annotations

import base64
import json
import struct
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
_DTYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_JSON, _BIN = 0x4E4F534A, 0x004E4942
PACKED = ("EXT_meshopt_compression", "KHR_meshopt_compression", "KHR_draco_mesh_compression")


@dataclass(frozen=True, eq=False)
class GltfFile:
    """A document and the bytes it holds or names."""

    path: Path
    document: dict[str, Any]
    chunk: bytes | None  # the binary chunk of a .glb or .vrm file

    @classmethod
    def read(cls, path: Path) -> GltfFile:
        """Read a .glb, .gltf or .vrm file."""
        content = path.read_bytes()
        if content[:4] != b"glTF":
            return cls(path, json.loads(content), None)
        chunks: dict[int, bytes] = {}
        at = 12
        while at < len(content):
            size, kind = struct.unpack_from("<II", content, at)
            chunks.setdefault(kind, content[at + 8 : at + 8 + size])
            at += 8 + size
        return cls(path, json.loads(chunks[_JSON]), chunks.get(_BIN, b""))

    def __getattr__(self, name: str) -> list[Any]:
        """The entries of a root list: ``file.nodes``, ``file.meshes``, …; empty if it has none."""
        if name.startswith("_"):
            raise AttributeError(name)
        found = self.document.get(name, [])
        assert isinstance(found, list)
        return found

    @cached_property
    def contents(self) -> list[bytes]:
        """The bytes of every buffer; of one that is only there as a fallback, none."""
        return [self._content(number, entry) for number, entry in enumerate(self.buffers)]

    def _content(self, number: int, entry: dict[str, Any]) -> bytes:
        uri = entry.get("uri")
        if uri is None:
            return self.chunk[: entry["byteLength"]] if self.chunk and not number else b""
        if uri.startswith("data:"):
            return base64.b64decode(uri.split(",", 1)[1])[: entry["byteLength"]]
        return (self.path.parent / unquote(uri)).read_bytes()[: entry["byteLength"]]

    @property
    def packed(self) -> bool:
        """Whether its arrays cannot be read without decompression."""
        return any(name in PACKED for name in self.document.get("extensionsUsed", []))

    def array(self, number: int) -> NDArray[np.float64]:
        """(count, width) what an accessor says, as float64."""
        accessor = self.accessors[number]
        dtype = np.dtype(_DTYPES[accessor["componentType"]])
        width, count = _WIDTHS[accessor["type"]], accessor["count"]
        if "bufferView" in accessor:
            stored = self._elements(accessor, dtype, width, count)
        else:
            stored = np.zeros((count, width), dtype)
        if "sparse" in accessor:
            sparse = accessor["sparse"]
            kind = np.dtype(_DTYPES[sparse["indices"]["componentType"]])
            at = self._elements(sparse["indices"], kind, 1, sparse["count"])[:, 0]
            stored = stored.copy()
            stored[at] = self._elements(sparse["values"], dtype, width, sparse["count"])
        values = stored.astype(np.float64)
        if accessor.get("normalized"):
            values = np.maximum(values / np.iinfo(dtype).max, -1.0)
        return values

    def _elements(
        self, place: dict[str, Any], dtype: np.dtype[Any], width: int, count: int
    ) -> NDArray[Any]:
        view = self.bufferViews[place["bufferView"]]
        content = self.contents[view["buffer"]]
        start = view.get("byteOffset", 0)
        own = content[start : start + view["byteLength"]]
        size = dtype.itemsize * width
        stride = view.get("byteStride", size)
        strides = (stride, dtype.itemsize)
        return np.ndarray((count, width), dtype, own, place.get("byteOffset", 0), strides)
