"""Which meshes a document shows, and where: nodes, their order and their transforms."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.gltf.container import GltfFile
from elastomorph.io.gltf.lenient import object_of
from elastomorph.io.gltf.skins import Placement, Skin


@dataclass(frozen=True, eq=False)
class PlacedMesh:
    """A mesh as a node shows it."""

    number: int  # Number of the mesh
    names: tuple[str, ...]  # Of the node and of the mesh, as far as they have any; at least one
    whole: Placement  # Where all of its vertices are, unless a skin says it of each
    skin: Skin | None = None  # The joints that hold its vertices, where they differ
    node: int | None = None  # Number of the node; None for a mesh that no node shows

    def placement(
        self, file: GltfFile, attributes: dict[str, Any], count: int, of: str
    ) -> Placement:
        """Where the vertices of a primitive with these attributes are."""
        if self.skin is None:
            return self.whole
        return self.skin.placement(file, attributes, count, of)


def placed_meshes(file: GltfFile) -> list[PlacedMesh]:
    """The meshes of the scene a viewer shows, depth first.

    A mesh with a skin stands where its joints hold it in the pose that the nodes have, and its own
    node does not count. A document without scenes, or without nodes that show a mesh, gives all its
    meshes. Characters of VRM 0.x, which look backwards, are turned around.
    """
    found: list[tuple[int, dict[str, Any], NDArray[np.float64]]] = []
    root = _root(file)
    worlds: dict[int, NDArray[np.float64]] = {}
    waiting = [(node, root) for node in reversed(_roots(file))]
    while waiting:
        number, above = waiting.pop()
        node = file.item("nodes", number, "the scene")
        if number in worlds:
            file.refuse(f"node {number} appears twice in the scene")
        worlds[number] = world = above @ _transform(file, node, number)
        if "mesh" in node:
            file.budget.spend_objects(1)
            found.append((number, node, world))
        children = file.list_in(node, "children", f"node {number}")
        waiting += [(child, world) for child in reversed(children)]
    if found:
        skins: dict[Any, Skin] = {}
        return [
            replace(_placed(file, node, world, worlds, skins), node=number)
            for number, node, world in found
        ]
    count = len(file.items("meshes"))
    file.budget.spend_objects(count)
    return [_placed(file, {"mesh": number}, root, worlds, {}) for number in range(count)]


def world_above(file: GltfFile, number: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(4, 4) of all that a node hangs below, and of the node itself."""
    parents = {
        child: above
        for above, node in enumerate(file.items("nodes"))
        if isinstance(node, dict)
        for child in file.list_in(node, "children", f"node {above}")
        if isinstance(child, int)
    }
    own = _transform(file, file.item("nodes", number, "an animation"), number)
    world, seen = np.eye(4), {number}
    while (number := parents.get(number, -1)) >= 0 and number not in seen:
        seen.add(number)
        world = _transform(file, file.item("nodes", number, "a node"), number) @ world
    return _root(file) @ world, own


def _placed(
    file: GltfFile,
    node: dict[str, Any],
    world: NDArray[np.float64],
    worlds: dict[int, NDArray[np.float64]],
    skins: dict[Any, Skin],
) -> PlacedMesh:
    mesh = file.item("meshes", node["mesh"], "a node")
    names = (holder.get("name") for holder in (node, mesh))
    known = tuple(dict.fromkeys(name for name in names if isinstance(name, str)))
    names_or_number = known or (f"mesh {node['mesh']}",)
    skin = None
    if "skin" in node:
        number = node["skin"] if isinstance(node["skin"], int) else None
        if number not in skins:
            skins[number] = Skin.of(file, node["skin"], partial(_world, file, worlds))
        skin = skins[number]
        if (alike := skin.alike) is not None:
            world, skin = alike, None
    return PlacedMesh(node["mesh"], names_or_number, Placement.of(world), skin)


def _world(
    file: GltfFile, worlds: dict[int, NDArray[np.float64]], number: int
) -> NDArray[np.float64]:
    """(4, 4) of a node; one that the scene does not show, as some joints, stands by itself."""
    if number not in worlds:
        node = file.item("nodes", number, "a skin")
        worlds[number] = _root(file) @ _transform(file, node, number)
    return worlds[number]


def _root(file: GltfFile) -> NDArray[np.float64]:
    """(4, 4) of the scene: glTF and VRM 1.0 look along +Z, VRM 0.x along -Z."""
    extensions = object_of(file.document.get("extensions"))
    backwards = "VRM" in extensions and "VRMC_vrm" not in extensions
    return np.diag([-1.0, 1.0, -1.0, 1.0]) if backwards else np.eye(4)


def _roots(file: GltfFile) -> list[Any]:
    scenes = file.items("scenes")
    if scenes:
        scene = file.item("scenes", file.document.get("scene", 0), "the document")
        return file.list_in(scene, "nodes", "the scene")
    nodes = file.items("nodes")
    children = {
        child
        for number, node in enumerate(nodes)
        if isinstance(node, dict)
        for child in file.list_in(node, "children", f"node {number}")
        if isinstance(child, int)
    }
    return [number for number in range(len(nodes)) if number not in children]


def _transform(file: GltfFile, node: dict[str, Any], number: int) -> NDArray[np.float64]:
    """(4, 4) of a node."""
    of = f"node {number}"
    if "matrix" in node:
        return np.array(_numbers(file, node, "matrix", of, [0] * 16)).reshape(4, 4).T
    x, y, z, w = _numbers(file, node, "rotation", of, [0, 0, 0, 1])
    matrix = np.eye(4)
    matrix[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    matrix[:3, :3] *= _numbers(file, node, "scale", of, [1, 1, 1])
    matrix[:3, 3] = _numbers(file, node, "translation", of, [0, 0, 0])
    return matrix


def _numbers(
    file: GltfFile, node: dict[str, Any], key: str, of: str, default: list[float]
) -> list[float]:
    """As many numbers as the default has."""
    values, count = file.list_in({key: default} | node, key, of), len(default)
    if len(values) != count or not all(_is_real(value) for value in values):
        file.refuse(f"'{key}' of {of} must be {count} finite numbers")
    return [float(value) for value in values]


def _is_real(value: Any) -> bool:
    try:
        return isinstance(value, int | float) and math.isfinite(value)
    except OverflowError:
        return False
