"""Where the meshes of a file go: in the units of one of them, and beside it as in the file.

A shape is sculpted in the space of its mesh, so positions of the main mesh stay the numbers stored
there, bit for bit, or are only *turned*: by the rotation of its node, and by the axes of the file,
until up is +Y and the front is +Z. Scale and place of its node are not applied, so that what is
made here lies exactly on the mesh it came from. Further meshes go where they stand relative to it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import MeshError

__all__ = ["HasPlace", "Placing", "placings"]

_ROUNDING = 1e-9


class HasPlace(Protocol):
    """Anything with a transform."""

    @property
    def matrix(self) -> NDArray[np.float64]:
        """(4, 3) to the world: what x, y and z become, and the origin."""
        ...


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

    @property
    def is_identity(self) -> bool:
        """Whether it leaves everything as it is."""
        return np.array_equal(self.linear, np.eye(3)) and not self.shift.any()

    @property
    def scale(self) -> float:
        """The most that it lengthens a vector."""
        return float(np.linalg.norm(self.linear, 2))

    def offsets(self, vectors: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., 3) vectors in the space of the rig; exact for turns by right angles."""
        columns = np.abs(self.linear).argmax(axis=1)
        signs = self.linear[np.arange(3), columns]
        exchange = np.zeros((3, 3))
        exchange[np.arange(3), columns] = signs
        if np.array_equal(exchange, self.linear) and set(np.abs(signs).tolist()) == {1.0}:
            turned: NDArray[np.float64] = vectors[..., columns] * signs
        else:
            turned = vectors @ self.linear.T
        return turned

    def positions(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) positions in the space of the rig."""
        placed = self.offsets(points)
        return placed + self.shift if self.shift.any() else placed


def placings(
    axes: NDArray[np.float64] | None, parts: Sequence[HasPlace], main: int = 0
) -> list[Placing]:
    """How to place each mesh beside the main one.

    Args:
        axes: (3, 3) rows: right, up and front of the file; None keeps the main mesh unturned.
        parts: The meshes.
        main: Which of them gives unit and origin.

    Raises:
        MeshError: The transforms are beyond all numbers.
    """
    try:
        return _placings(axes, parts, parts[main].matrix)
    except np.linalg.LinAlgError:
        raise MeshError("its meshes stand at no place: their transforms are too large") from None


def _placings(
    axes: NDArray[np.float64] | None, parts: Sequence[HasPlace], main: NDArray[np.float64]
) -> list[Placing]:
    linear, origin = main[:3].T, main[3]
    if not _is_regular(linear):
        linear = np.eye(3)
    turn = np.eye(3) if axes is None else _orthogonal(axes @ linear)
    placed = []
    for part in parts:
        if np.array_equal(part.matrix, main):
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
