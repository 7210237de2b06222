"""Which meshes a document shows, and where: nodes, their order and their transforms."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.gltf.accessors import read_floats
from elastomorph.io.gltf.container import GltfFile

_BOUND_ALIKE = 1e-4  # single precision, through a chain of joints


@dataclass(frozen=True, eq=False)
class PlacedMesh:
    """A mesh as a node shows it."""

    number: int  # Number of the mesh
    names: tuple[str, ...]  # Of the node and of the mesh, as far as they have any; at least one
    linear: NDArray[np.float64]  # (3, 3) what vectors are multiplied with, from the left
    offset: NDArray[np.float64]  # (3,) what positions are then moved by


def placed_meshes(file: GltfFile) -> list[PlacedMesh]:
    """The meshes of the scene a viewer shows, depth first.

    A mesh with a skin stands where its joints hold it, as long as they hold all of it alike. Where
    they are posed, it stays where its vertices are: skinning is not applied. A document without
    scenes, or without nodes that show a mesh, gives all its meshes.
    """
    found: list[dict[str, Any]] = []
    unit = np.eye(4)
    worlds: dict[int, NDArray[np.float64]] = {}
    waiting = [(node, unit) for node in reversed(_roots(file))]
    seen: set[int] = set()
    while waiting:
        number, above = waiting.pop()
        node = file.item("nodes", number, "the scene")
        if number in seen:
            file.refuse(f"node {number} appears twice in the scene")
        seen.add(number)
        worlds[number] = world = above @ _transform(file, node, number)
        if "mesh" in node:
            file.budget.spend_objects(1)
            found.append({**node, "world": world})
        children = file.list_in(node, "children", f"node {number}")
        waiting += [(child, world) for child in reversed(children)]
    if found:
        return [
            _placed(file, node, _bound(file, node, worlds) if "skin" in node else node["world"])
            for node in found
        ]
    count = len(file.items("meshes"))
    file.budget.spend_objects(count)
    return [_placed(file, {"mesh": number}, unit) for number in range(count)]


def _placed(file: GltfFile, node: dict[str, Any], world: NDArray[np.float64]) -> PlacedMesh:
    mesh = file.item("meshes", node["mesh"], "a node")
    names = (holder.get("name") for holder in (node, mesh))
    known = tuple(dict.fromkeys(name for name in names if isinstance(name, str)))
    names_or_number = known or (f"mesh {node['mesh']}",)
    return PlacedMesh(node["mesh"], names_or_number, world[:3, :3], world[:3, 3])


def _bound(
    file: GltfFile, node: dict[str, Any], worlds: dict[int, NDArray[np.float64]]
) -> NDArray[np.float64]:
    """(4, 4) where the joints of a skin hold its mesh: the same for each in the pose of binding."""
    skin = file.item("skins", node["skin"], "a node")
    joints = file.list_in(skin, "joints", "a skin")
    given = skin.get("inverseBindMatrices")
    unit = np.eye(4)
    if given is None or not joints or not all(type(j) is int and j in worlds for j in joints):
        return unit
    of = "the inverse bind matrices of a skin"
    columns = read_floats(file, given, 16, of).reshape(-1, 4, 4)
    if len(columns) < len(joints):
        file.refuse(f"{of} are {len(columns):,} for {len(joints):,} joints")
    held = np.stack([worlds[j] for j in joints]) @ columns[: len(joints)].transpose(0, 2, 1)
    apart = _BOUND_ALIKE * np.abs(held[0]).max()
    if not np.abs(held - held[0]).max() <= apart or np.abs(held[0] - unit).max() <= apart:
        return unit
    return np.asarray(held[0])


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
