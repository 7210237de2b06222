"""Small characters whose paths can be worked out: a flap that turns on its hinge, with teeth."""

from __future__ import annotations

import base64
import json
import struct
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

CODES = {"|i1": 5120, "|u1": 5121, "<i2": 5122, "<u2": 5123, "<u4": 5125, "<f4": 5126}
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}

ROWS, COLUMNS = 9, 3
ANGLE = np.radians(80)


class SmallFile:
    """A document built accessor by accessor."""

    def __init__(self) -> None:
        self.blob = bytearray()
        self.json: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": "a test"},
            "scene": 0,
            "scenes": [{"nodes": []}],
            "nodes": [],
            "meshes": [],
            "accessors": [],
            "bufferViews": [],
            "extras": {"kept": [1, 2.5, "ä"]},
        }

    def array(self, values: ArrayLike, kind: str = "<f4", **fields: Any) -> int:
        rows = np.asarray(values)
        rows = rows.reshape(len(rows), -1).astype(kind)
        self.blob += bytes(-len(self.blob) % 4)
        size = rows.shape[1] * rows.itemsize
        stride = {} if size % 4 == 0 else {"byteStride": size + -size % 4}
        padded = np.zeros((len(rows), size + -size % 4), np.uint8)
        padded[:, :size] = np.ascontiguousarray(rows).view(np.uint8).reshape(len(rows), size)
        content = padded.tobytes() if rows.shape[1] > 1 else rows.tobytes()
        stride = stride if rows.shape[1] > 1 else {}
        view = {"buffer": 0, "byteOffset": len(self.blob), "byteLength": len(content), **stride}
        self.json["bufferViews"].append(view)
        self.blob += content
        accessor = {"bufferView": len(self.json["bufferViews"]) - 1, **fields}
        accessor |= {"componentType": CODES[rows.dtype.str], "count": len(rows)}
        self.json["accessors"].append(accessor | {"type": TYPES[rows.shape[1]]})
        return len(self.json["accessors"]) - 1

    def mesh(self, primitives: list[dict[str, Any]], **fields: Any) -> int:
        self.json["meshes"].append({"primitives": primitives, **fields})
        return len(self.json["meshes"]) - 1

    def node(self, **fields: Any) -> int:
        self.json["nodes"].append(fields)
        self.json["scenes"][0]["nodes"].append(len(self.json["nodes"]) - 1)
        return len(self.json["nodes"]) - 1

    def write(self, path: Path) -> Path:
        """As .glb or .vrm; a .gltf with a file beside it, or with a data URI if it is called so."""
        buffer: dict[str, Any] = {"byteLength": len(self.blob)}
        document = self.json | {"buffers": [buffer]}
        if path.suffix == ".gltf":
            if "embedded" in path.stem:
                text = base64.b64encode(self.blob).decode()
                buffer["uri"] = f"data:application/octet-stream;base64,{text}"
            else:
                buffer["uri"] = "some%20bytes.bin"
                path.with_name("some bytes.bin").write_bytes(self.blob)
            path.write_text(json.dumps(document, indent=1), encoding="utf-8")
            return path
        text = json.dumps(document).encode()
        text += b" " * (-len(text) % 4)
        blob = bytes(self.blob) + bytes(-len(self.blob) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
        chunks += struct.pack("<II", len(blob), 0x004E4942) + blob
        path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
        return path


def flap() -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
    """A strip along y, the same with its end turned about x, and its triangles."""
    along = np.linspace(0, 1, ROWS)
    grid = np.stack(np.meshgrid(np.linspace(0, 0.4, COLUMNS), along), axis=-1).reshape(-1, 2)
    shape = np.column_stack([grid, np.zeros(len(grid))])
    place = np.arange(len(grid)).reshape(ROWS, COLUMNS)
    corners = [place[:-1, :-1], place[:-1, 1:], place[1:, 1:], place[1:, :-1]]
    a, b, c, d = (own.reshape(-1) for own in corners)
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    turned = shape.copy()
    beyond = shape[:, 1] > 0.5
    arm = shape[beyond, 1] - 0.5
    turned[beyond, 1] = 0.5 + arm * np.cos(ANGLE)
    turned[beyond, 2] = arm * np.sin(ANGLE)
    return shape, turned, triangles


def flap_character(
    *,
    normals: bool = False,
    tangents: bool = False,
    quantized: bool = False,
    kind: str = "<i2",
    names: str = "mesh",
    teeth: bool = True,
    **node: Any,
) -> SmallFile:
    """A flap in two primitives that share a seam, teeth that hang on its end, and a still mesh.

    Targets are ``open``, which turns, and ``slide``, which moves all straight.
    """
    file = SmallFile()
    shape, turned, triangles = flap()
    slid = shape + [0, 0.1, 0]
    stored: dict[str, Any] = {"kind": kind, "normalized": True} if quantized else {}
    scale = np.iinfo(kind).max / 2 if quantized else 1.0
    half = len(triangles) // 2
    primitives = []
    for own in (triangles[:half], triangles[half:]):
        used, corners = np.unique(own, return_inverse=True)
        at_rest = np.round(shape[used] * scale) if quantized else shape[used]
        shown: dict[str, Any] = {"POSITION": file.array(at_rest, **stored)}
        shown["NORMAL"] = file.array(np.tile([0, 0, 1.0], (len(used), 1)))
        targets = []
        for moved in (turned, slid):
            delta = np.round((moved - shape)[used] * scale) if quantized else (moved - shape)[used]
            target: dict[str, Any] = {"POSITION": file.array(delta, **stored)}
            if normals:
                end = np.where((moved is turned) & (shape[used, 1:2] > 0.5), _TURNED, [0, 0, 1.0])
                target["NORMAL"] = file.array(end - [0, 0, 1.0])
            if tangents:
                shown.setdefault("TANGENT", file.array(np.tile([0, 1.0, 0, 1], (len(used), 1))))
                target["TANGENT"] = file.array(np.zeros((len(used), 3)))
            if names == "target":
                target["extras"] = {"name": "open" if moved is turned else "slide"}
            targets.append(target)
        primitive = {"attributes": shown, "targets": targets}
        primitive["indices"] = file.array(corners.reshape(-1), "<u2")
        if names == "primitive":
            primitive["extras"] = {"targetNames": ["open", "slide"]}
        primitives.append(primitive)
    extras = {"extras": {"targetNames": ["open", "slide"]}} if names == "mesh" else {}
    size = {"scale": [2.0, 2.0, 2.0]} if quantized else {}
    file.node(mesh=file.mesh(primitives, name="flap", **extras), name="flap", **size, **node)
    if quantized:
        file.json["extensionsUsed"] = file.json["extensionsRequired"] = ["KHR_mesh_quantization"]
    if teeth:
        _add_teeth(file)
    still = {"POSITION": file.array(shape + [5, 0, 0])}
    file.node(mesh=file.mesh([{"attributes": still}], name="still"), name="still")
    return file


_TURNED = np.array([0, -np.sin(ANGLE), np.cos(ANGLE)])


def _add_teeth(file: SmallFile) -> None:
    """A triangle that ``open`` turns with the end of the flap, in a mesh of its own."""
    shape = np.array([[0.1, 0.8, 0.1], [0.3, 0.8, 0.1], [0.2, 0.9, 0.1]])
    turn = np.array(
        [[1, 0, 0], [0, np.cos(ANGLE), -np.sin(ANGLE)], [0, np.sin(ANGLE), np.cos(ANGLE)]]
    )
    centre = np.array([0, 0.5, 0])
    turned = (shape - centre) @ turn.T + centre
    target = {"POSITION": file.array(turned - shape)}
    primitive = {"attributes": {"POSITION": file.array(shape)}, "targets": [target]}
    extras = {"targetNames": ["open"], "other": True}
    file.node(mesh=file.mesh([primitive], name="teeth", extras=extras), name="teeth")
