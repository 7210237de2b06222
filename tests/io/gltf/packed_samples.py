"""Documents whose buffer views are packed by meshoptimizer, made from plain ones."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
from glb_samples import HandMade

import needs

meshopt = needs.extra("meshopt", "gltf")

EXT, KHR = "EXT_meshopt_compression", "KHR_meshopt_compression"


def packed(file: HandMade, *, name: str = EXT, version: int = 0, fallback: bool = True) -> HandMade:
    """The same document with every view of an accessor packed: indices as such, others as rows.

    Rows are made wide in fours, as the extension asks. The buffer of what is unpacked is announced,
    and not there.
    """
    made = HandMade()
    made.document = copy.deepcopy(file.document)
    made.document["bufferViews"] = []
    indices = {p["indices"] for m in file.document["meshes"] for p in m["primitives"]}
    length = 0
    for number, view in enumerate(file.document["bufferViews"]):
        users = [
            (place, accessor)
            for place, accessor in enumerate(made.document["accessors"])
            if accessor.get("bufferView") == number
        ]
        if not users:
            made.view(_content(file, view))
            continue
        content = np.frombuffer(_content(file, view), dtype=np.uint8)
        rows = content.reshape(users[0][1]["count"], -1)
        shown: dict[str, Any]
        if users[0][0] in indices:
            numbers = rows.view(f"<u{rows.shape[1]}").reshape(-1)
            mode = "TRIANGLES" if len(numbers) % 3 == 0 else "INDICES"
            stream = meshopt.encode_gltf_buffer(numbers, mode)
            shown = {"byteStride": rows.shape[1], "mode": mode}
        else:
            rows = np.pad(rows, ((0, 0), (0, -rows.shape[1] % 4)))
            stream = meshopt.encode_gltf_buffer(rows, "ATTRIBUTES", version)
            shown = {"byteStride": rows.shape[1], "mode": "ATTRIBUTES"}
        made.view(stream)
        place = made.document["bufferViews"].pop()
        made.document["bufferViews"].append(
            {
                "buffer": 1,
                "byteOffset": length,
                "byteLength": rows.nbytes,
                "extensions": {name: place | shown | {"count": len(rows)}},
            }
        )
        length += rows.nbytes
    said = {"extensions": {name: {"fallback": True}}} if fallback else {}
    made.more_buffers = [{"byteLength": length, **said}]
    made.document["extensionsUsed"] = made.document["extensionsRequired"] = [name]
    return made


def _content(file: HandMade, view: dict[str, Any]) -> bytes:
    return file.blob[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
