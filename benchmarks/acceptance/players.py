"""What three.js, Babylon.js and Blender show of a file, beside what the specification says."""

from __future__ import annotations

import copy
import json
import os
import shutil
import struct
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from acceptance.gltf_file import GltfFile
from acceptance.posing import Floats, Pose, Scene

CHECKS = Path(__file__).parents[2] / "web" / "checks"
BLENDER = "ELASTOMORPH_BLENDER_PYTHON"
PLAYERS = ("three.js", "Babylon.js", "Blender")
_SCRIPTS = {"three.js": "three", "Babylon.js": "babylon"}


@dataclass(frozen=True, eq=False)
class Request:
    """A pose to be shown: the weights of all targets by node, and a clip that plays over them."""

    weights: dict[int, Floats]
    clip: int | None = None
    time: float = 0.0
    bend: bool = False  # by the package for engines, which Blender has not

    def as_json(self) -> dict[str, Any]:
        """As the scripts take it."""
        weights = {str(node): own.tolist() for node, own in self.weights.items()}
        own = {"clip": self.clip, "time": float(self.time), "bend": self.bend}
        return {"weights": weights, **own}


def command(player: str) -> list[str] | None:
    """What runs a player, None where it is not installed.

    Blender is the Python with ``bpy`` that the variable ``ELASTOMORPH_BLENDER_PYTHON`` names, or
    the one that ``make test-blender`` has made.
    """
    if player == "Blender":
        python = os.environ.get(BLENDER, str(CHECKS.parents[1] / ".venv-blender/bin/python"))
        script = Path(__file__).with_name("play_blender.py")
        return [python, str(script)] if Path(python).is_file() else None
    node = shutil.which("node")
    package = {"three.js": "three", "Babylon.js": "@babylonjs/core"}[player]
    if node is None or not (CHECKS.parent / "node_modules" / package).is_dir():
        return None
    return [node, str(CHECKS / "play.mjs"), _SCRIPTS[player]]


def plain(file: GltfFile, path: Path, *, pointers: bool = True) -> Path:
    """Write a copy for players: one buffer, no materials, all named by their numbers.

    Shapes, skins and clips are those of the file, byte for byte; it must not be packed. Clips with
    pointers are left out where a program cannot open a file that has them.
    """
    document = copy.deepcopy(file.document)
    starts, content = [], b""
    for own in file.contents:
        starts.append(len(content))
        content += own + bytes(-len(own) % 4)
    for view in document.get("bufferViews", []):
        view["byteOffset"] = view.get("byteOffset", 0) + starts[view["buffer"]]
        view["buffer"] = 0
    document["buffers"] = [{"byteLength": len(content)}]
    for name in ("materials", "textures", "images", "samplers", "extensions", "extras"):
        document.pop(name, None)
    for mesh in document.get("meshes", []):
        for primitive in mesh["primitives"]:
            primitive.pop("material", None)
            primitive.pop("extensions", None)
            for target in primitive.get("targets", []):  # names, at which Blender stops
                target.pop("extras", None)
    for kind, word in (("nodes", "node"), ("meshes", "mesh"), ("animations", "clip")):
        for number, own in enumerate(document.get(kind, [])):
            own["name"] = f"{word}{number}"
            own.pop("extensions", None)
    clips = document.get("animations", [])
    clips = [own for own in clips if pointers or not has_pointers(own)]
    document["animations"] = clips
    if not clips:
        del document["animations"]
    kept = {"KHR_mesh_quantization", "KHR_animation_pointer"}
    for name in ("extensionsUsed", "extensionsRequired"):
        document[name] = [own for own in document.get(name, []) if own in kept]
        if not document[name]:
            del document[name]
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(content))
    chunks = [struct.pack("<I4s", len(text), b"JSON"), text]
    chunks += [struct.pack("<I4s", len(content), b"BIN\0"), content]
    path.write_bytes(head + b"".join(chunks))
    return path


def has_pointers(clip: Mapping[str, Any]) -> bool:
    """Whether an animation moves something that only KHR_animation_pointer can name."""
    return any(own["target"]["path"] == "pointer" for own in clip["channels"])


def shown(
    player: str, file: Path, requests: Sequence[Request], folder: Path
) -> list[dict[int, Floats]]:
    """(V, 3) world positions by node, of each request, as a player shows a plain file."""
    start = command(player)
    assert start is not None
    asked, out = folder / f"{file.stem}.requests.json", folder / f"{file.stem}.posed"
    asked.write_text(json.dumps([own.as_json() for own in requests]))
    words = [*start, str(file), str(asked), str(out)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=600)
    if done.returncode:
        raise RuntimeError(f"{player} {file.name}: {(done.stderr or done.stdout)[-800:]}")
    parts = json.loads(done.stdout.splitlines()[-1])
    rows = np.fromfile(out, "<f8").reshape(len(requests), -1, 3)
    found = []
    for own in rows:
        pose: dict[int, list[Floats]] = {}
        start_at = 0
        for node, _, count in parts:
            pose.setdefault(node, []).append(own[start_at : start_at + count])
            start_at += count
        found.append({node: np.concatenate(each) for node, each in pose.items()})
    return found


def seen(scene: Scene, player: str, node: int, primitive: int, rows: Floats) -> Floats:
    """Those of the (V, 3) positions of a primitive for which a player has vertices."""
    entry = scene.file.meshes[scene.file.nodes[node]["mesh"]]["primitives"][primitive]
    if player != "Blender" or "indices" not in entry:
        return rows
    return rows[np.unique(scene.file.array(entry["indices"]).astype(int))]


def as_shown(scene: Scene, player: str, pose: Pose) -> dict[int, Floats]:
    """(V, 3) world positions by node that a player should show."""
    found: dict[int, list[Floats]] = {}
    for (node, primitive), rows in scene.posed(pose).items():
        found.setdefault(node, []).append(seen(scene, player, node, primitive, rows))
    return {node: np.concatenate(own) for node, own in sorted(found.items())}
