"""Skeletons: eight joints, bound as they stand, posed since, with scale, or one skin a mesh."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gltf_builder import GltfBuilder, chained

# Name, parent and place (metres) of each joint.
JOINTS = (
    ("hips", None, (0.0, 0.9, 0.0)),
    ("spine", 0, (0.0, 1.2, -0.01)),
    ("neck", 1, (0.0, 1.5, 0.0)),
    ("head", 2, (0.0, 1.56, 0.02)),
    ("eye.L", 3, (0.0315, 1.62, 0.0692)),
    ("eye.R", 3, (-0.0315, 1.62, 0.0692)),
    ("arm.L", 1, (0.2, 1.4, 0.0)),
    ("arm.R", 1, (-0.2, 1.4, 0.0)),
)
_NECK, _HEAD = 2, 3


@dataclass
class Skeleton:
    """The joints of a document."""

    roots: list[int] = field(default_factory=list)
    joints: list[int] = field(default_factory=list)  # nodes
    matrices: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 4, 4), np.float32))
    shared: int | None = None  # the skin of all meshes, if there is one
    separate: bool = False

    def skin_for(self, builder: GltfBuilder, name: str) -> int:
        """The skin of a mesh: the shared one, or one of its own with fewer joints."""
        if not self.separate:
            if self.shared is None:
                self.shared = self._skin(builder, "skin")
            return self.shared
        return self._skin(builder, f"skin of {name}")

    def _skin(self, builder: GltfBuilder, name: str) -> int:
        columns = np.ascontiguousarray(self.matrices.transpose(0, 2, 1)).reshape(-1, 16)
        skin = {
            "name": name,
            "joints": list(self.joints),
            "inverseBindMatrices": builder.accessor(columns),
            "skeleton": self.joints[0],
            "extras": {"rig": "biped"},
        }
        return builder.add("skins", skin)


def quarter_turn(axis: int, degrees: float = 90.0) -> list[float]:
    """A quaternion x, y, z, w about an axis."""
    half = np.radians(degrees) / 2
    found = [0.0, 0.0, 0.0, float(np.cos(half))]
    found[axis] = float(np.sin(half))
    return found


def add_skeleton(builder: GltfBuilder, kind: str) -> Skeleton:
    """The joints as nodes: "bind" and "separate" stand as bound, "posed" were turned since.

    "scaled": the skeleton is in centimetres below a node that makes metres of them.
    """
    unit = 100.0 if kind == "scaled" else 1.0
    places = np.array([place for _, _, place in JOINTS]) * unit
    parents = [parent for _, parent, _ in JOINTS]
    inverse = np.tile(np.eye(4), (len(JOINTS), 1, 1))
    inverse[:, :3, 3] = -places
    first = len(builder.json.get("nodes", []))
    children = chained(parents)
    for k, (name, parent, _) in enumerate(JOINTS):
        shift = places[k] - (places[parent] if parent is not None else 0)
        node: dict[str, Any] = {"name": name, "translation": shift.tolist()}
        if children[k]:
            node["children"] = [first + child for child in children[k]]
        if kind == "posed" and k == _HEAD:
            node["rotation"] = quarter_turn(1, 25)
        if kind == "posed" and k == 0:
            node |= {"rotation": quarter_turn(0, -8), "scale": [1.1, 1.1, 1.1]}
        builder.add("nodes", node)
    joints = list(range(first, first + len(JOINTS)))
    if kind == "scaled":
        node = {"name": "Armature", "children": [first], "scale": [0.01, 0.01, 0.01]}
        roots = [builder.add("nodes", node | {"rotation": quarter_turn(0, 0)})]
    else:
        roots = [first]
    return Skeleton(roots, joints, inverse.astype(np.float32), separate=kind == "separate")


def joints_and_weights(positions: NDArray[np.float32]) -> dict[str, NDArray[Any]]:
    """JOINTS_0 and WEIGHTS_0: the head, and below the chin more and more of the neck."""
    share = np.clip((1.545 - positions[:, 1].astype(float)) / 0.05, 0, 1)
    weights = np.zeros((len(positions), 4), np.float32)
    weights[:, 1] = share
    weights[:, 0] = 1 - weights[:, 1]
    joints = np.zeros((len(positions), 4), np.uint8)
    joints[:, 0] = np.where(weights[:, 0] > 0, _HEAD, 0)
    joints[:, 1] = np.where(weights[:, 1] > 0, _NECK, 0)
    return {"JOINTS_0": joints, "WEIGHTS_0": weights}
