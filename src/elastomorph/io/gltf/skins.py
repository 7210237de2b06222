"""Where vertices are at rest: by the transform of a node, or by the joints of a skin.

A skin puts a vertex at Σ_j w_j · J_j · B_j · x, with the weights w of the vertex, the transforms J
of the joints in the scene and the inverse bind matrices B. At rest that is often the identity, or
the same for all vertices; where a character is posed, every vertex has a place of its own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.gltf.accessors import read_floats
from elastomorph.io.gltf.container import GltfFile
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
