"""The turn of a head in glTF: a rotation of the node or the bone that carries the face.

A face without bones hangs below a node ``head`` in its neck, which turns. Of files by others, the
bone that VRM calls the head is read, or else a node that is called so, such as ``mixamorig:Head``.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.gltf.accessor_writer import AccessorWriter
from elastomorph.io.gltf.channels import Channel
from elastomorph.io.gltf.container import GltfFile
from elastomorph.io.gltf.lenient import object_of
from elastomorph.io.gltf.nodes import world_above
from elastomorph.rig.performance import HeadTurn, angles_of, head_quaternions

_HEAD = "head"
_NAMED = re.compile(r"(.*[^a-z])?head", re.IGNORECASE)
_SAME = 1e-6


def turned_nodes(
    nodes: Sequence[dict[str, Any]], turn: HeadTurn
) -> tuple[list[dict[str, Any]], int]:
    """The nodes of a scene in which a face hangs in its neck, and the number of the root.

    The face stays node 0, and where it was while the neck is at rest.
    """
    face, *others = nodes
    neck = turn.pivot
    place = np.array(face.get("translation", [0.0, 0.0, 0.0])) - neck
    held = face | {"translation": place.tolist()}
    head = {"name": _HEAD, "translation": neck.tolist(), "children": [0]}
    return [held, *others, head], len(nodes)


def turn_channels(
    accessors: AccessorWriter,
    animations: list[dict[str, Any]],
    counts: list[int],
    turn: HeadTurn,
    node: int,
) -> None:
    """Add the turn of a node to animations of so many frames, at the times that they have."""
    parts = np.split(turn.angles, np.cumsum(counts)[:-1])
    for animation, angles in zip(animations, parts, strict=True):
        output = accessors.rotations(head_quaternions(angles).astype(np.float32))
        own = animation["samplers"]
        target = {"node": node, "path": "rotation"}
        animation["channels"].append({"sampler": len(own), "target": target})
        own.append({"input": own[0]["input"], "interpolation": "LINEAR", "output": output})


def head_node(file: GltfFile, turned: list[int]) -> int | None:
    """Which of the nodes that an animation turns is the head."""
    extensions = object_of(file.document.get("extensions"))
    bones = object_of(object_of(extensions.get("VRMC_vrm")).get("humanoid")).get("humanBones")
    known = object_of(object_of(bones).get("head")).get("node")
    older = object_of(object_of(extensions.get("VRM")).get("humanoid")).get("humanBones")
    for bone in older if isinstance(older, list) else []:
        if object_of(bone).get("bone") == "head":
            known = object_of(bone).get("node")
    for number in turned:
        node = file.item("nodes", number, "an animation")
        name = node.get("name")
        # A mesh that joints hold, such as "Wolf3D_Head", stays where they are when its node turns.
        named = isinstance(name, str) and _NAMED.fullmatch(name) and "skin" not in node
        if number == known or (known is None and named):
            return number
    return None


def rotations_at(channel: Channel, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 4) quaternions at (N,) times: along arcs between keys that no spline joins."""
    from scipy.spatial.transform import Rotation, Slerp

    if channel.kind in ("STEP", "CUBICSPLINE") or len(channel.times) == 1:
        return channel.at(times)
    arcs = Slerp(channel.times, Rotation.from_quat(channel.values))
    found: NDArray[np.float64] = arcs(np.clip(times, *channel.times[[0, -1]])).as_quat()
    return found


def recorded_turn(file: GltfFile, node: int, quaternions: NDArray[np.float64]) -> HeadTurn | None:
    """How a node turns the head that has (T, 4) rotations x, y, z, w in its parent, if it does.

    The angles are those by which it leaves its place at rest, as seen in the scene.
    """
    from scipy.spatial.transform import Rotation

    above, own = world_above(file, node)
    frame = Rotation.from_matrix(_rotation(above))
    rest = Rotation.from_matrix(_rotation(own))
    found = frame * Rotation.from_quat(quaternions) * rest.inv() * frame.inv()
    angles = angles_of(found.as_quat())
    angles = np.where(np.abs(angles) < _SAME, 0.0, angles)
    return HeadTurn((above @ own)[:3, 3], angles) if angles.any() else None


def _rotation(matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotation in a (4, 4) matrix without shear."""
    axes = matrix[:3, :3]
    lengths = np.linalg.norm(axes, axis=0)
    if not (lengths > 0).all() or np.linalg.det(axes) <= 0:
        return np.eye(3)
    turned: NDArray[np.float64] = axes / lengths
    return turned
