"""Colours of vertices in glTF files (COLOR_0), as scanners give them that write no image."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.gltf.accessors import read_floats
from elastomorph.io.gltf.container import GltfFile, open_gltf
from elastomorph.io.gltf.nodes import PlacedMesh, placed_meshes
from elastomorph.io.gltf.primitives import Primitives, read_primitives
from elastomorph.io.untrusted import naming_file

_WIDTHS = {"VEC3": 3, "VEC4": 4}


def read_gltf_colours(path: str | Path) -> NDArray[np.uint8] | None:
    """The colours of the vertices of a .glb or .gltf file, or None where it has none.

    Returns:
        (V, 3) uint8, red first, as screens show them: a file has them as light is. The vertices
        are those of the meshes of its scene in their order; what has no colour is white.

    Raises:
        FileError: It cannot be read.
        FormatError: It is damaged.
    """
    file = open_gltf(path)
    if not any(_coloured(primitive) for mesh in file.items("meshes") for primitive in _in(mesh)):
        return None
    with naming_file(path), np.errstate(all="ignore"):
        placed = placed_meshes(file)
        read = zip(placed, read_primitives(file, placed), strict=True)
        light = np.concatenate([_light(file, *own) for own in read])
        light = np.clip(np.nan_to_num(light), 0, 1)
        low = light <= 0.0031308
        shown = np.where(low, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
        return np.asarray(np.round(255 * shown), dtype=np.uint8)


def _light(
    file: GltfFile, placed: PlacedMesh, primitives: Primitives | None
) -> NDArray[np.float64]:
    """(V, 3) linear colours of a mesh, from 0 to 1."""
    if primitives is None:
        return np.ones((0, 3))
    found = np.ones((primitives.count, 3))
    of = f"the colours of mesh {placed.number}"
    every = _in(file.item("meshes", placed.number, "a node"))
    for number, block in primitives.block_of.items():
        if _coloured(every[number]):
            own = primitives.attributes[block]
            accessor = every[number]["attributes"]["COLOR_0"]
            kind = file.item("accessors", accessor, of).get("type")
            width = _WIDTHS.get(kind if isinstance(kind, str) else "", 4)
            values = read_floats(file, accessor, width, of, count=len(own.vertices))
            found[own.start : own.start + len(own.vertices)] = values[:, :3]
    return found


def _in(mesh: object) -> list[dict[str, dict[str, object]]]:
    """The primitives of a mesh; what is none stands as an empty one."""
    every = mesh.get("primitives") if isinstance(mesh, dict) else None
    every = every if isinstance(every, list) else []
    return [own if isinstance(own, dict) else {} for own in every]


def _coloured(primitive: dict[str, dict[str, object]]) -> bool:
    attributes = primitive.get("attributes")
    return isinstance(attributes, dict) and "COLOR_0" in attributes
