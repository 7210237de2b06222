"""Where the meshes of an FBX file go: upright, in the units of the mesh itself.

A shape is sculpted in the space of its mesh, so positions stay the numbers stored there, bit for
bit, only *turned*: by the rotation of the node, and by the axes of the file, until up is +Y and the
front is +Z. Scale and place of the node are not applied, so that what is made here lies exactly on
the mesh it came from. Further meshes go where they stand relative to the first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import MeshError
from elastomorph.io.fbx.part import FbxPart

__all__ = ["Placing", "placings"]

_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class Placing:
    """An affine map from the space of one mesh to that of the rig.

    Attributes:
        linear: (3, 3), for offsets.
        shift: (3,), added to positions.
    """

    linear: NDArray[np.float64]
    shift: NDArray[np.float64]

    @property
    def mirrors(self) -> bool:
        """Whether it turns polygons inside out."""
        return bool(np.linalg.det(self.linear) < 0)

    def offsets(self, vectors: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) vectors in the space of the rig; exact for turns by right angles."""
        columns = np.abs(self.linear).argmax(axis=1)
        signs = self.linear[np.arange(3), columns]
        exchange = np.zeros((3, 3))
        exchange[np.arange(3), columns] = signs
        if np.array_equal(exchange, self.linear) and set(np.abs(signs).tolist()) == {1.0}:
            turned: NDArray[np.float64] = vectors[:, columns] * signs
        else:
            turned = vectors @ self.linear.T
        return turned

    def positions(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) positions in the space of the rig."""
        placed = self.offsets(points)
        return placed + self.shift if self.shift.any() else placed


def placings(axes: NDArray[np.float64], parts: Sequence[FbxPart]) -> list[Placing]:
    """How to place each mesh beside the first.

    Args:
        axes: (3, 3) rows: right, up and front of the file.
        parts: The meshes; the first gives unit and origin.

    Raises:
        MeshError: The transforms are beyond all numbers.
    """
    try:
        return _placings(axes, parts)
    except np.linalg.LinAlgError:
        raise MeshError("its meshes stand at no place: their transforms are too large") from None


def _placings(axes: NDArray[np.float64], parts: Sequence[FbxPart]) -> list[Placing]:
    linear, origin = parts[0].matrix[:3].T, parts[0].matrix[3]
    if not _is_regular(linear):
        linear = np.eye(3)
    turn = _orthogonal(axes @ linear)
    placed = []
    for part in parts:
        if np.array_equal(part.matrix, parts[0].matrix):
            placed.append(Placing(turn, np.zeros(3)))
            continue
        relative = np.linalg.solve(
            linear, np.column_stack([part.matrix[:3].T, part.matrix[3] - origin])
        )
        placed.append(Placing(_rounded(turn @ relative[:, :3]), turn @ relative[:, 3]))
    return placed


def _orthogonal(linear: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotation (and mirroring) in a linear map, without its scale: its polar factor."""
    left, _, right = np.linalg.svd(linear)
    return _rounded(left @ right)


def _rounded(linear: NDArray[np.float64]) -> NDArray[np.float64]:
    """Without the rounding of sines and cosines, where it is all that differs from right angles."""
    whole = np.round(linear) + 0.0
    return whole if np.abs(whole - linear).max() < _ROUNDING else linear


def _is_regular(linear: NDArray[np.float64]) -> bool:
    scales = np.linalg.svd(linear, compute_uv=False)
    return bool(scales[-1] > _ROUNDING * scales[0])
