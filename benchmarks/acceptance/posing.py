"""The vertices that a viewer shows: nodes, morph targets and skins, by the formulas of glTF 2.0."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from acceptance.gltf_file import GltfFile

Floats = NDArray[np.float64]


@dataclass
class Pose:
    """What is set by hand or by a clip; everything else is as the file has it."""

    weights: dict[int, Floats] = field(default_factory=dict)  # by node
    of_mesh: dict[int, Floats] = field(default_factory=dict)  # by mesh, where a node has none
    transforms: dict[tuple[int, str], Floats] = field(default_factory=dict)  # by node and path


@dataclass(frozen=True, eq=False)
class Surface:
    """A primitive of a mesh, as its accessors have it."""

    number: tuple[int, int]  # of the mesh and of the primitive
    positions: Floats  # (V, 3)
    targets: Floats  # (K, V, 3)
    joints: NDArray[np.int64]  # (V, 4 n)
    shares: Floats  # (V, 4 n)


class Scene:
    """What the scene of a document shows."""

    def __init__(self, file: GltfFile) -> None:
        self.file = file
        self._surfaces: dict[tuple[int, int], Surface] = {}

    @cached_property
    def shown(self) -> list[int]:
        """The nodes of the scene that show a mesh, depth first."""
        return [node for node, _ in self._walk(Pose()) if "mesh" in self.file.nodes[node]]

    @cached_property
    def faces(self) -> list[int]:
        """Those of them whose mesh has morph targets."""
        return [node for node in self.shown if self.count(node)]

    def count(self, node: int) -> int:
        """The number of morph targets of the mesh of a node."""
        mesh = self.file.meshes[self.file.nodes[node]["mesh"]]
        return max(len(own.get("targets", [])) for own in mesh["primitives"])

    def names(self, mesh: int) -> list[str]:
        """Names of the morph targets of a mesh, wherever they stand."""
        entry = self.file.meshes[mesh]
        count = max(len(own.get("targets", [])) for own in entry["primitives"])
        for holder in (entry, *entry["primitives"]):
            named = (holder.get("extras") or {}).get("targetNames")
            if named:
                return [str(name) for name in named]
        for primitive in entry["primitives"]:
            held = [(own.get("extras") or {}).get("name") for own in primitive.get("targets", [])]
            if any(held):
                return [name or f"target_{k}" for k, name in enumerate(held)]
        return [f"target_{k}" for k in range(count)]

    def weights(self, node: int, pose: Pose) -> Floats:
        """The weights of the morph targets of the mesh of a node."""
        if node in pose.weights:
            return pose.weights[node]
        entry = self.file.nodes[node]
        if "weights" in entry:
            return np.array(entry["weights"], float)
        if entry["mesh"] in pose.of_mesh:
            return pose.of_mesh[entry["mesh"]]
        stated = self.file.meshes[entry["mesh"]].get("weights")
        return np.array(stated, float) if stated else np.zeros(self.count(node))

    def posed(self, pose: Pose | None = None) -> dict[tuple[int, int], Floats]:
        """(V, 3) world positions by node and number of the primitive, of the faces only."""
        pose = pose or Pose()
        worlds = dict(self._walk(pose))
        found = {}
        for node in self.faces:
            weights = self.weights(node, pose)
            for surface in self.surfaces(node):
                morphed = surface.positions + np.tensordot(
                    weights[: len(surface.targets)], surface.targets, axes=1
                )
                matrices = self._matrices(node, surface, worlds)
                linear = np.broadcast_to(matrices[..., :3], (len(morphed), 3, 3))
                moved = np.einsum("vij,vj->vi", linear, morphed)
                found[node, surface.number[1]] = moved + matrices[..., 3]
        return found

    def surfaces(self, node: int) -> Iterator[Surface]:
        """The primitives of the mesh of a node."""
        mesh = self.file.nodes[node]["mesh"]
        for number in range(len(self.file.meshes[mesh]["primitives"])):
            if (mesh, number) not in self._surfaces:
                self._surfaces[mesh, number] = self._surface(mesh, number)
            yield self._surfaces[mesh, number]

    def matrices(self, node: int, pose: Pose | None = None) -> list[Floats]:
        """(3, 4), or (V, 3, 4) with a skin, of every primitive of the mesh of a node."""
        worlds = dict(self._walk(pose or Pose()))
        return [self._matrices(node, surface, worlds) for surface in self.surfaces(node)]

    def _surface(self, mesh: int, number: int) -> Surface:
        primitive = self.file.meshes[mesh]["primitives"][number]
        attributes = primitive["attributes"]
        positions = self.file.array(attributes["POSITION"])
        targets = [
            self.file.array(own["POSITION"]) if "POSITION" in own else np.zeros_like(positions)
            for own in primitive.get("targets", [])
        ]
        sets = sorted(name for name in attributes if name.startswith("JOINTS_"))
        joints = [self.file.array(attributes[name]) for name in sets]
        shares = [self.file.array(attributes[name.replace("JOINTS", "WEIGHTS")]) for name in sets]
        none = np.zeros((len(positions), 0))
        return Surface(
            (mesh, number),
            positions,
            np.array(targets).reshape(-1, len(positions), 3),
            np.concatenate([none, *joints], axis=1).astype(np.int64),
            _summing_to_one(np.concatenate([none, *shares], axis=1)),
        )

    def _matrices(self, node: int, surface: Surface, worlds: Mapping[int, Floats]) -> Floats:
        skin = self.file.nodes[node].get("skin")
        if skin is None or not surface.joints.shape[1]:
            return worlds[node][:3]
        entry = self.file.skins[skin]
        joints = np.stack([worlds[joint] for joint in entry["joints"]])
        if "inverseBindMatrices" in entry:
            columns = self.file.array(entry["inverseBindMatrices"]).reshape(-1, 4, 4)
            joints = joints @ columns[: len(joints)].transpose(0, 2, 1)
        return np.einsum("vk,vkij->vij", surface.shares, joints[surface.joints][:, :, :3])

    def _walk(self, pose: Pose) -> Iterator[tuple[int, Floats]]:
        """Every node of the scene with its (4, 4) transform to the world."""
        scenes, nodes = self.file.scenes, self.file.nodes
        if scenes:
            roots = scenes[self.file.document.get("scene", 0)].get("nodes", [])
        else:
            below = {child for node in nodes for child in node.get("children", [])}
            roots = [number for number in range(len(nodes)) if number not in below]
        # Characters of VRM 0.x look backwards.
        way = -1.0 if "VRM" in self.file.document.get("extensions", {}) else 1.0
        waiting = [(root, np.diag([way, 1.0, way, 1.0])) for root in reversed(roots)]
        while waiting:
            number, above = waiting.pop()
            world = above @ local(nodes[number], number, pose)
            yield number, world
            children = nodes[number].get("children", [])
            waiting += [(child, world) for child in reversed(children)]


def _summing_to_one(shares: Floats) -> Floats:
    """Compression leaves sums that are not 1, which three.js and other players put right."""
    whole = shares.sum(axis=1, keepdims=True)
    return np.divide(shares, whole, out=shares.copy(), where=whole > 0)


def local(node: dict[str, Any], number: int, pose: Pose) -> Floats:
    """(4, 4) of a node, in the frame of the one above it."""
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    move, turn, scale = (
        pose.transforms.get((number, path), np.array(node.get(path, default), float))
        for path, default in (
            ("translation", [0, 0, 0]),
            ("rotation", [0, 0, 0, 1]),
            ("scale", [1, 1, 1]),
        )
    )
    found = np.eye(4)
    found[:3, :3] = turned(turn / np.linalg.norm(turn)) * scale
    found[:3, 3] = move
    return found


def turned(quaternion: Floats) -> Floats:
    """(3, 3) rotation of a unit quaternion x, y, z, w: v + 2 w (u × v) + 2 u × (u × v)."""
    u, w = quaternion[:3], quaternion[3]
    cross = np.array([[0, -u[2], u[1]], [u[2], 0, -u[0]], [-u[1], u[0], 0]])
    return np.asarray(np.eye(3) + 2 * w * cross + 2 * cross @ cross)
