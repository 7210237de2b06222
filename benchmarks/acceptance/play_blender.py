"""Poses a plain GLB file as Blender does; run by a Python that has ``bpy``, and by itself.

Run:  PYTHON-WITH-BPY benchmarks/acceptance/play_blender.py FILE REQUESTS OUT

As ``web/checks/play.mjs``, whose header says what REQUESTS and OUT are; primitives of one mesh are
one part, of the vertices that its triangles use: all of the first primitive, then of the next.
"""

from __future__ import annotations

import json
import struct
import sys
from pathlib import Path
from typing import Any

import bpy
import numpy as np


def play(path: Path, requests: list[dict[str, Any]], out: Path) -> list[list[int]]:
    """Pose a file, and say which nodes were found and how many vertices each has."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=str(path), merge_vertices=False)
    shown = sorted(_shown(path).items())
    counts = []
    with out.open("wb") as written:
        for request in requests:
            _stop()
            for node, own in shown:
                keys = own.data.shape_keys.key_blocks[1:]
                for key, weight in zip(keys, request["weights"][str(node)], strict=True):
                    key.value = weight
            if request["clip"] is not None:
                _play(f"clip{request['clip']}", request["time"])
            bpy.context.view_layer.update()
            found = [_positions(own) for _, own in shown]
            counts = [[node, 0, len(rows)] for (node, _), rows in zip(shown, found, strict=True)]
            for rows in found:
                written.write(rows.tobytes())
    return counts


def _shown(path: Path) -> dict[int, Any]:
    """The object of each node that shows a mesh with targets.

    A skinned mesh becomes an object of its own, named after the mesh.
    """
    objects = [own for own in bpy.data.objects if own.type == "MESH" and own.data.shape_keys]
    named = {own.name: own for own in objects}
    content = path.read_bytes()
    (size,) = struct.unpack_from("<I", content, 12)
    found = {}
    for number, node in enumerate(json.loads(content[20 : 20 + size])["nodes"]):
        own = named.pop(f"node{number}", None)
        if own is None and "mesh" in node:
            mesh = f"mesh{node['mesh']}"
            own = next((named.pop(n) for n in sorted(named) if n.split(".")[0] == mesh), None)
        if own is not None:
            found[number] = own
    return found


def _animated() -> list[Any]:
    return [own for kind in (bpy.data.objects, bpy.data.shape_keys) for own in kind]


def _stop() -> None:
    for own in _animated():
        if own.animation_data:
            own.animation_data.action = None
            for track in own.animation_data.nla_tracks:
                track.mute = True


def _play(name: str, seconds: float) -> None:
    render = bpy.context.scene.render
    frame = seconds * render.fps / render.fps_base
    for own in _animated():
        for track in own.animation_data.nla_tracks if own.animation_data else ():
            track.mute = track.name != name
            if not track.mute:  # the strip has been laid at frame 1, its keys count from 0
                strip = track.strips[0]
                start = strip.frame_start - strip.action_frame_start
    whole = int((start + frame) // 1)
    bpy.context.scene.frame_set(whole, subframe=start + frame - whole)


def _positions(own: Any) -> np.ndarray[Any, np.dtype[np.float64]]:
    """(V, 3) world positions, y up as in glTF."""
    posed = own.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = posed.to_mesh()
    flat = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", flat)
    posed.to_mesh_clear()
    world = np.array(posed.matrix_world)
    rows = flat.reshape(-1, 3) @ world[:3, :3].T + world[:3, 3]
    return np.ascontiguousarray(rows[:, [0, 2, 1]] * [1.0, 1.0, -1.0])


if __name__ == "__main__":
    source, asked, result = map(Path, sys.argv[1:4])
    # What Blender itself prints goes before it.
    print(json.dumps(play(source, json.loads(asked.read_text("utf-8")), result)))
