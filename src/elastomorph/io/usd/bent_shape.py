"""What a bend adds to a blend shape that is there: in-betweens on its points, and its exact path.

The shape itself, V₀ + Y on the points that it names, stays as it is: at weight 1 all programs show
what they showed before. An in-between at w is stored as UsdSkel adds it to the points at rest,

    Y(w) = w Y + Σ_k b_k(w) D_k

with the bends D_k in the space of the mesh. A point that bends move but the shape does not joins
its points with Y = 0; a point that the shape names twice gets the bends once.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.usd.exact import checksum, path_to_json
from elastomorph.io.usd.original import OriginalMesh, OriginalShape
from elastomorph.io.usd.prims import COARSEST, as_float32, rounded_bends
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.model.polygons import polygon_normals


@dataclass(frozen=True, eq=False)
class BentShape:
    """What a layer says of one blend shape, N points of it."""

    original: OriginalShape
    path: str  # The exact path, as JSON
    bends: NDArray[np.floating]  # (K, N, 3) as they are stored; K may be 0
    weights: NDArray[np.float32]  # (n,) of the in-betweens, rising
    offsets: NDArray[np.float32]  # (1 + n, N, 3) of the shape and its in-betweens
    normals: NDArray[np.float32] | None  # (1 + n, N, 3), where the shape has offsets of normals
    # (N,) int32, where points joined those that the shape names; otherwise those stay
    points: NDArray[np.int32] | None

    @property
    def bent(self) -> bool:
        """Whether the path of this shape is not straight."""
        return bool(len(self.bends))

    @property
    def bytes(self) -> int:
        """Of the arrays that a layer holds of it."""
        own = 1 if self.points is None else 0
        arrays = [self.bends, self.offsets[own:], self.points]
        arrays += [] if self.normals is None else [self.normals[own:]]
        return sum(array.nbytes for array in arrays if array is not None)


def bent_shape(
    path: str | Path,
    mesh: OriginalMesh,
    shape: OriginalShape,
    morph: Morph,
    weights: NDArray[np.float64],
    extent: float,
) -> BentShape:
    """What becomes of a blend shape where its morph is bent and has in-betweens at these weights.

    Morph and ``extent`` D are those of the rig that the meshes of the file are together.
    """
    of_rig = morph.bends[:, mesh.vertices]
    peaks = np.array([curve.height for curve in morph.bend_curves])
    # a sum over no bends is 0 everywhere
    moves = peaks @ np.linalg.norm(of_rig, axis=2) > COARSEST * extent
    moved = np.flatnonzero(moves)
    if not moved.size:
        return straight_shape(path, shape, morph)
    there = shape.found.points
    joining = np.setdiff1d(moved, there).astype(np.int64)
    points = np.concatenate([there, joining])
    bends = mesh.own(of_rig[:, points], points)
    again = np.ones(len(points), dtype=bool)
    again[np.unique(points, return_index=True)[1]] = False
    bends[:, again] = 0.0
    target = np.concatenate([shape.found.offsets[0], np.zeros((len(joining), 3))])
    floats = weights.astype(np.float32)
    at = np.concatenate([[1.0], floats.astype(np.float64)])
    factors = np.stack([curve(at) for curve in morph.bend_curves], axis=1)
    factors[0] = 0.0
    exact = at[:, None, None] * target + np.tensordot(factors, bends, axes=1)
    offsets = as_float32(path, exact, "an offset")
    scale = max(mesh.place.scale, np.finfo(float).tiny)
    size = mesh.part.mesh.diameter * scale
    text = path_to_json(
        morph,
        checksum([points.astype(np.int32), offsets, floats]),
        bake_error=morph.bake_error * morph.neutral.diameter / size if size else 0.0,
    )
    stored = rounded_bends(path, bends, peaks, extent / scale)
    normals = None
    if shape.normals is not None:
        given = np.concatenate([shape.normals, np.zeros((len(joining), 3))])
        normals = as_float32(path, _normals(mesh.mesh, points, at, exact, given), "a normal")
    joined = points.astype(np.int32) if joining.size else None
    return BentShape(shape, text, stored, floats, offsets, normals, joined)


def straight_shape(path: str | Path, shape: OriginalShape, morph: Morph) -> BentShape:
    """A shape that no bend moves: what is known of its morph is kept beside it all the same."""
    offsets = as_float32(path, shape.found.offsets[:1], "an offset")
    none = np.zeros(0, dtype=np.float32)
    belonging = checksum([shape.found.points.astype(np.int32), offsets, none])
    text = path_to_json(morph, belonging, curves=(), bake_error=0.0)
    return BentShape(shape, text, np.zeros((0, 0, 3)), none, offsets, None, None)


def _normals(
    mesh: Mesh,
    points: NDArray[np.int64],
    at: NDArray[np.float64],
    offsets: NDArray[np.float64],
    given: NDArray[np.float64],
) -> NDArray[np.float64]:
    """(1 + n, N, 3) offsets of normals: of the straight path, and what the bends turn beside."""
    found = at[:, None, None] * given
    for row, time, own in zip(found[1:], at[1:], offsets[1:], strict=True):
        pair = []
        for moved in (own, time * offsets[0]):
            vertices = mesh.vertices.copy()
            np.add.at(vertices, points, moved)
            pair.append(_vertex_normals(mesh, vertices)[points])
        row += pair[0] - pair[1]
    return found


def _vertex_normals(mesh: Mesh, vertices: NDArray[np.float64]) -> NDArray[np.float64]:
    """(V, 3) unit normals, those of the polygons around a vertex by their areas."""
    normals = np.zeros_like(vertices)
    faces = mesh.faces
    np.add.at(normals, faces.indices, polygon_normals(vertices, faces)[faces.corner_faces])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return normals / np.where(lengths > 0, lengths, 1.0)
