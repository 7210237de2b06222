"""From the scene, where paths are made, back to the space of a mesh.

With the linear part L of a vertex's place, a displacement d of the scene is L⁻¹d in the mesh. A
normal n of the mesh is shown as L⁻ᵀn, and so what is added to it in the scene is Lᵀd there.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.gltf.accessors import read_floats
from elastomorph.io.gltf.container import GltfFile
from elastomorph.io.gltf.primitives import Attributes

Field = NDArray[np.float64]

_LEAST_VOLUME = 1e-12  # of a unit cube: what is flatter than this came out of rounding


@dataclass(frozen=True, eq=False)
class MeshSpace:
    """The vertices of a primitive, as the file stores them.

    Attributes:
        file: The file.
        block: The vertices where the scene shows them.
        attributes: Numbers of the accessors of the primitive.
        of: What messages call the mesh.
    """

    file: GltfFile
    block: Attributes
    attributes: dict[str, Any]
    of: str

    @property
    def rows(self) -> slice:
        """Which of the vertices of the mesh these are."""
        return slice(self.block.start, self.block.start + len(self.block.vertices))

    def require_place(self) -> None:
        """Refuse a mesh that moves, but is flattened to a plane, a line or a point."""
        if self.block.displacements and self.block.placement.linear.ndim == 2:
            self._require_solid(self.block.placement.linear)

    def displacements(self, field: Field) -> Field:
        """(N, 3) displacements in the mesh."""
        linear = self.block.placement.linear
        if linear.ndim == 3:
            moved = np.flatnonzero(field.any(axis=1))
            self._require_solid(linear[moved])
            found = np.zeros_like(field)
            found[moved] = np.linalg.solve(linear[moved], field[moved, :, None])[..., 0]
            return found
        if self._is_unit:
            return field
        self._require_solid(linear)
        return np.asarray(np.linalg.solve(linear, field.T).T)

    def normals(self, field: Field) -> Field:
        """(N, 3) of the mesh, from what is added to unit normals in the scene."""
        if self._is_unit:
            return field
        linear = self.block.placement.linear
        pattern = "ji,nj->ni" if linear.ndim == 2 else "nji,nj->ni"
        turned = np.einsum(pattern, linear, field)
        # Lᵀn of the unit normal n in the scene has this length, where the mesh has a unit normal.
        length = np.linalg.norm(np.einsum(pattern, linear, self.scene_normals), axis=1)
        return np.asarray(turned / np.where(length > 0, length, 1.0)[:, None])

    def tangents(self, normals: Field) -> Field:
        """(N, 3) what is added to tangents where this is added to the normals of the mesh.

        To first order in the turn: t stays perpendicular to n for -(t·d) n, and keeps its
        direction within the surface.
        """
        tangents, at_rest = self._attribute("TANGENT", 4), self._attribute("NORMAL", 3)
        if tangents is None or at_rest is None:
            return np.zeros_like(normals)
        along = np.einsum("ni,ni->n", tangents[:, :3], normals)
        return np.asarray(-along[:, None] * at_rest)

    @cached_property
    def scene_normals(self) -> Field:
        """(N, 3) unit normals where the scene shows them; zero where the file has none."""
        found = self._attribute("NORMAL", 3)
        if found is None:
            return np.zeros_like(self.block.vertices)
        if not self._is_unit:
            linear = self.block.placement.linear
            # The cofactors are |L| L⁻ᵀ, and never fail.
            rows = np.swapaxes(linear, -1, -2)
            cofactors = np.stack(
                [np.cross(rows[..., (i + 1) % 3, :], rows[..., (i + 2) % 3, :]) for i in range(3)],
                axis=-1,
            )
            pattern = "ij,nj->ni" if linear.ndim == 2 else "nij,nj->ni"
            found = np.einsum(pattern, cofactors, found)
        length = np.linalg.norm(found, axis=1, keepdims=True)
        return np.asarray(found / np.where(length > 0, length, 1.0))

    @property
    def _is_unit(self) -> bool:
        return np.array_equal(self.block.placement.linear, np.eye(3))

    def _attribute(self, name: str, width: int) -> Field | None:
        if name not in self.attributes:
            return None
        what = f"the {name.lower()}s of {self.of}"
        count = len(self.block.vertices)
        return read_floats(self.file, self.attributes[name], width, what, count=count)

    def _require_solid(self, linear: Field) -> None:
        """Refuse vertices whose place says nothing of where they were."""
        volume = np.abs(np.linalg.det(linear))
        largest = np.abs(linear).max(axis=(-2, -1), initial=0.0)
        if (volume <= _LEAST_VOLUME * largest**3).any():
            self.file.refuse(
                f"{self.of} is flattened where the scene shows it at rest (a node or a joint has "
                "a scale of 0), so its bends cannot be taken back to it; give it a scale"
            )
