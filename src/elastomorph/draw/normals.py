"""Normals for shading: smooth over the skin, sharp where the surface really folds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.polygon_normals import polygon_normals
from elastomorph.model.polygons import Polygons

__all__ = ["CornerPairs", "corner_normals"]


@dataclass(frozen=True, eq=False)
class CornerPairs:
    """Which corners of a mesh meet at a vertex; found once, used for every pose.

    Attributes:
        first: (P,) int64 corner that receives a normal.
        second: (P,) int64 corner at the same vertex that may give its polygon's normal.
    """

    first: NDArray[np.int64]
    second: NDArray[np.int64]

    @classmethod
    def of(cls, faces: Polygons) -> CornerPairs:
        """All pairs of corners at the same vertex, each corner with itself included."""
        order = np.argsort(faces.indices, kind="stable")
        valence = np.bincount(faces.indices)
        own = valence[faces.indices[order]]
        begin = (np.cumsum(valence) - valence)[faces.indices[order]]
        step = np.arange(own.sum()) - np.repeat(np.cumsum(own) - own, own)
        return cls(np.repeat(order, own), order[np.repeat(begin, own) + step])


def corner_normals(
    vertices: NDArray[np.float64], faces: Polygons, pairs: CornerPairs, *, crease: float = 70.0
) -> NDArray[np.float64]:
    """Unit normals for every polygon corner.

    A corner averages the normals of the polygons around its vertex, weighted by area, but only of
    those that its own polygon meets at less than the crease angle. So a cheek is smooth and the
    edge of a tooth, a lid or a torn lip stays an edge.

    Args:
        vertices: (V, 3).
        faces: The polygons.
        pairs: Their corner pairs.
        crease: Angle in degrees above which two polygons do not share a normal.

    Returns:
        (C, 3) float64; (0, 0, 1) at corners of polygons without area.
    """
    of_face = polygon_normals(vertices, faces)
    lengths = np.linalg.norm(of_face, axis=1, keepdims=True)
    units = np.divide(of_face, lengths, out=np.zeros_like(of_face), where=lengths > 0)
    first, second = faces.corner_faces[pairs.first], faces.corner_faces[pairs.second]
    alike = np.einsum("ij,ij->i", units[first], units[second]) > np.cos(np.radians(crease))
    giving, receiving = second[alike], pairs.first[alike]
    normals = np.stack(
        [
            np.bincount(receiving, weights=of_face[giving, axis], minlength=faces.indices.size)
            for axis in range(3)
        ],
        axis=1,
    ).astype(np.float64)  # bincount counts in whole numbers where there is nothing to add
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    flat = lengths[:, 0] == 0
    normals = np.divide(normals, lengths, out=normals, where=lengths > 0)
    normals[flat] = (0.0, 0.0, 1.0)
    return np.asarray(normals)
