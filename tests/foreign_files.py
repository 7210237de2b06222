"""GLB files read and written without any library, as other programs write them."""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import elastomorph as em
from elastomorph.io.gltf import write_glb

__all__ = ["chunks_of", "glb", "write_foreign_glb"]


def glb(document: dict[str, Any], blob: bytes = b"") -> bytes:
    """A GLB container, written without any library."""
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    blob += bytes(-len(blob) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
    if blob:
        chunks += struct.pack("<II", len(blob), 0x004E4942) + blob
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


def chunks_of(path: Path) -> tuple[dict[str, Any], bytes]:
    """The document and the binary chunk of a GLB file, read without any library."""
    content = path.read_bytes()
    magic, version, length, size, kind = struct.unpack_from("<4sIIII", content)
    assert (magic, version, length, kind) == (b"glTF", 2, len(content), 0x4E4F534A)
    rest, bin_kind = struct.unpack_from("<II", content, 20 + size)
    assert bin_kind == 0x004E4942
    assert rest % 4 == 0
    assert size % 4 == 0
    return json.loads(content[20 : 20 + size]), content[28 + size : 28 + size + rest]


def write_foreign_glb(
    path: Path, rig: em.Rig, *, nodes: Sequence[str] = ("face",), clips: bool = False
) -> Path:
    """A GLB of the straight targets of a rig.

    Args:
        path: The file.
        rig: Its targets are written, its bends are not.
        nodes: Names of the nodes, one after another to the right, that each show the face.
        clips: Keep an animation of the weights.
    """
    to = em.prepare(rig.neutral, "linear")
    straight = em.Rig(rig.neutral, {name: to(own.target) for name, own in rig.morphs.items()})
    whole = path.with_name(f"{path.stem}-whole.glb")
    write_glb(whole, straight, normals="none", clips=clips)
    document, blob = chunks_of(whole)
    whole.unlink()
    for holder in (document["asset"], *document["meshes"]):
        (holder.get("extras") or {}).pop("elastomorph", None)
    if not clips:
        document.pop("animations", None)
    shown = next(number for number, node in enumerate(document["nodes"]) if "mesh" in node)
    node = document["nodes"][shown]
    document["nodes"][shown] = {**node, "name": nodes[0]}
    roots = document["scenes"][document.get("scene", 0)]["nodes"]
    for place, name in enumerate(nodes[1:], start=1):
        roots.append(len(document["nodes"]))
        document["nodes"].append({**node, "name": name, "translation": [100.0 * place, 0, 0]})
    path.write_bytes(glb(document, blob))
    return path
