"""What bends add to the normals of vertices, where the targets of the file turn them too.

A player lights a face by n₀ + t·δ + Σ_k b_k(t)·d_k, with the normals n₀ of the mesh and δ of the
target, both of which stay as their author made them. The d_k are fitted to how much more than δ the
surface turns on its path. Vertices at the same place with the same normal are one here, so that a
texture seam does not show and a hard edge does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from elastomorph.bending.face import Face
from elastomorph.bending.plan import BentMorph
from elastomorph.bending.spaces import MeshSpace
from elastomorph.io.gltf.morph_targets import NormalField, normal_deltas
from elastomorph.model.mesh import Mesh
from elastomorph.model.polygons import Polygons

Fields = NDArray[np.float64]

_LIKE = 1e-3  # a normal that is turned by less (0.06°) is lit alike


@dataclass(frozen=True, eq=False)
class NormalBends:
    """The surface that normals are computed of.

    Attributes:
        mesh: Its vertices are one for each place and normal.
        of_vertex: (V,) which of them each vertex of the face is, -1 where nothing moves.
        first: (S,) a vertex of the face that each of them is.
        corners: What normals are summed over.
        at_rest: (S, 3) unit normals of the neutral.
    """

    mesh: Mesh
    of_vertex: NDArray[np.int64]
    first: NDArray[np.int64]
    corners: NormalField
    at_rest: Fields

    @classmethod
    def of(cls, face: Face, spaces: Sequence[tuple[NDArray[np.int64], MeshSpace]]) -> NormalBends:
        """That of a face, from its vertices in each of some primitives."""
        neutral, place = face.rig.neutral, face.welding.place
        normals = np.zeros_like(neutral.vertices)
        for vertices, space in spaces:
            normals[vertices[space.rows]] = space.scene_normals
        rows = np.column_stack([place, np.round(normals / _LIKE)])
        moving = np.flatnonzero(place >= 0)
        _, first, label = np.unique(rows[moving], axis=0, return_index=True, return_inverse=True)
        of_vertex = np.full(len(place), -1, dtype=np.int64)
        of_vertex[moving] = label.reshape(-1)
        triangles = of_vertex[neutral.faces.triangles()]
        twice = np.roll(triangles, 1, axis=1) == triangles
        solid = triangles[(triangles >= 0).all(axis=1) & ~twice.any(axis=1)]
        mesh = Mesh(neutral.vertices[moving[first]], Polygons.of(solid.astype(np.int32)))
        corners = NormalField.of(mesh.faces)
        return cls(mesh, of_vertex, moving[first], corners, corners.normals(mesh.vertices))

    def bends(self, bent: BentMorph, target: Fields, bends: Fields) -> Fields:
        """(K, V, 3) what the bends (K, V, 3) of a morph to a target (V, 3) add to normals."""
        count = len(bends)
        end = self.mesh.with_vertices(target[self.first])
        fields, curves = bends[:, self.first], bent.morph.bend_curves
        if bent.fold is not None:  # its part is played by the normals of the target itself
            fields = np.concatenate([fields, (end.vertices - self.mesh.vertices)[None]])
            curves = (*curves, bent.fold)
        path = replace(bent.morph, neutral=self.mesh, target=end, bends=fields, bend_curves=curves)
        added = normal_deltas(self.corners, path, range(len(curves)), self.at_rest)[1 : count + 1]
        peaks = np.array([curve.height for curve in curves[:count]])
        added[np.linalg.norm(added, axis=2) * peaks[:, None] < _LIKE] = 0.0
        padded = np.concatenate([added, np.zeros_like(added[:, :1])], axis=1)
        return np.asarray(padded[:, self.of_vertex])
