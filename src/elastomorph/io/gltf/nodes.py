"""Which meshes a document shows, and where: nodes in their order, their transforms, skins at rest.

A skin puts a vertex at Σ_j w_j · J_j · B_j · x, with the weights w of the vertex, the transforms J
of the joints in the scene and the inverse bind matrices B. At rest that is often the identity, or
the same for all vertices; where a character is posed, every vertex has a place of its own.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.gltf.accessors import read_floats
from elastomorph.io.gltf.container import GltfFile, object_of
from elastomorph.io.skinning import blended_matrices, common_matrix

_MOST_SETS = 8  # of four joints each, more than any program writes


@dataclass(frozen=True, eq=False)
class Placement:
    """An affine map of vertices, the same for all of them or one each.

    Attributes:
        linear: (3, 3) or (N, 3, 3) what vectors are multiplied with, from the left.
        offset: (3,) or (N, 3) what positions are then moved by.
    """

    linear: NDArray[np.float64]
    offset: NDArray[np.float64]

    @classmethod
    def of(cls, matrix: NDArray[np.float64]) -> Placement:
        """The map of a (4, 4) matrix, or of (N, 4, 4)."""
        return cls(matrix[..., :3, :3], matrix[..., :3, 3])

    def offsets(self, vectors: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) vectors where they are placed; untouched by the unit matrix."""
        if self.linear.ndim == 2 and np.array_equal(self.linear, np.eye(3)):
            return vectors
        pattern = "ij,nj->ni" if self.linear.ndim == 2 else "nij,nj->ni"
        return np.asarray(np.einsum(pattern, self.linear, vectors))

    def positions(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) points where they are placed."""
        return self.offsets(points) + self.offset

    @property
    def mirrors(self) -> bool:
        """Whether it turns polygons inside out, at most vertices."""
        return bool(np.median(np.linalg.det(self.linear)) < 0)


@dataclass(frozen=True, eq=False)
class Skin:
    """The joints that hold a mesh, at rest.

    Attributes:
        number: Its number in the file.
        held: (J, 4, 4) what each joint does to the vertices it holds alone.
    """

    number: int
    held: NDArray[np.float64]

    @classmethod
    def of(cls, file: GltfFile, number: Any, world: Callable[[int], NDArray[np.float64]]) -> Skin:
        """A skin of the file, with the (4, 4) transform of each node."""
        skin = file.item("skins", number, "a node")
        of = f"skin {number}"
        joints = file.list_in(skin, "joints", of)
        if not joints:
            file.refuse(f"{of} has no joints; export it again with its skeleton, or without skin")
        count = len(file.items("nodes"))
        for joint in joints:
            if type(joint) is not int or joint not in range(count):
                file.refuse(f"a joint of {of} is no node of the file: its skeleton is incomplete")
        file.budget.spend(3 * 128 * len(joints))
        held = np.stack([world(joint) for joint in joints])
        given = skin.get("inverseBindMatrices")
        if given is not None:
            what = f"the inverse bind matrices of {of}"
            columns = read_floats(file, given, 16, what).reshape(-1, 4, 4)
            if len(columns) < len(joints):
                file.refuse(f"{what} are {len(columns):,} for {len(joints):,} joints")
            held = held @ columns[: len(joints)].transpose(0, 2, 1)
        if not np.isfinite(held).all():
            file.refuse(f"the joints of {of} are at no place: their transforms are no numbers")
        return cls(number, held)

    @property
    def alike(self) -> NDArray[np.float64] | None:
        """The (4, 4) matrix by which all joints hold the mesh, None where they differ."""
        return common_matrix(self.held)

    def placement(
        self, file: GltfFile, attributes: dict[str, Any], count: int, of: str
    ) -> Placement:
        """Where the joints hold each of the vertices of a primitive."""
        joints, weights = _influences(file, attributes, count, of)
        if not joints.shape[1]:
            return Placement.of(np.eye(4))
        used = weights > 0
        if joints[used].max(initial=0) >= len(self.held):
            file.refuse(
                f"a vertex of {of} is held by joint {joints[used].max():,} of the "
                f"{len(self.held):,} of skin {self.number}"
            )
        common = common_matrix(self.held[np.unique(joints[used])])
        if common is not None:
            return Placement.of(common)
        file.budget.spend(2 * 128 * count)
        return Placement.of(blended_matrices(self.held, np.where(used, joints, 0), weights))


def _influences(
    file: GltfFile, attributes: dict[str, Any], count: int, of: str
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """(N, 4 S) joints of each vertex and their weights, whose sums are 1."""
    joints, weights = [], []
    for number in range(_MOST_SETS):
        names = (f"JOINTS_{number}", f"WEIGHTS_{number}")
        given = [name for name in names if name in attributes]
        if not given:
            break
        if len(given) == 1:
            file.refuse(f"{of} has {given[0]} alone; joints and their weights go together")
        what = f"the {{}} of {of}"
        joints.append(
            read_floats(file, attributes[names[0]], 4, what.format("joints"), count=count)
        )
        weights.append(
            read_floats(file, attributes[names[1]], 4, what.format("weights"), count=count)
        )
    if not joints:
        return np.zeros((count, 0), dtype=np.int64), np.zeros((count, 0))
    weight = np.concatenate(weights, axis=1)
    weight = np.where(np.isfinite(weight) & (weight > 0), weight, 0.0)
    total = weight.sum(axis=1)
    weight[total == 0, 0] = 1.0  # held by its first joint, as engines do
    return (
        np.concatenate(joints, axis=1).astype(np.int64),
        weight / np.where(total == 0, 1.0, total)[:, None],
    )


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
