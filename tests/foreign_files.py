"""Files as other programs write them: the shapes, and nothing of ours beside them."""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from pathlib import Path

import elastomorph as em
from elastomorph.io.gltf import write_glb

__all__ = ["write_foreign_glb"]


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
    write_glb(whole, straight, normals="none")
    content = whole.read_bytes()
    whole.unlink()
    length = struct.unpack_from("<I", content, 12)[0]
    document, rest = json.loads(content[20 : 20 + length]), content[20 + length :]
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
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sIIII", b"glTF", 2, 20 + len(text) + len(rest), len(text), 0x4E4F534A)
    path.write_bytes(head + text + rest)
    return path
