"""Normals of the corners of polygons: smooth skin, and edges that stay edges."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.polygons import Polygons, polygon_normals


def corner_pairs(
    faces: Polygons, places: NDArray[np.int64] | None = None
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(P,) corners and (P,) corners at the same vertex, all pairs of them, each with itself.

    The places, (C,) numbers, may say of more than one vertex that they are the same.
    """
    vertices = faces.indices if places is None else places
    order = np.argsort(vertices, kind="stable")
    valence = np.bincount(vertices)
    own = valence[vertices[order]]
    begin = (np.cumsum(valence) - valence)[vertices[order]]
    step = np.arange(own.sum()) - np.repeat(np.cumsum(own) - own, own)
    return np.repeat(order, own), order[np.repeat(begin, own) + step]


class CornerNormals:
    """Finds the normals of every corner of some polygons, pose after pose.

    A corner averages the normals of the polygons around its vertex, weighted by area, but only of
    those that its own polygon meets at less than the crease angle. So a cheek is smooth and the
    edge of a tooth, a lid or a torn lip stays an edge.

    Args:
        faces: The polygons.
        pairs: Corners that are at one place, see `corner_pairs`.
        smooth: (P,) pairs that are smooth whatever their angle.
        crease: In degrees.
    """

    def __init__(
        self,
        faces: Polygons,
        pairs: tuple[NDArray[np.int64], NDArray[np.int64]],
        smooth: NDArray[np.bool_] | None = None,
        *,
        crease: float = 70.0,
    ) -> None:
        from scipy.sparse import csr_array

        self._faces = faces
        self._least = np.cos(np.radians(crease))
        order = np.argsort(pairs[0], kind="stable")
        receiving, giving = (corners[order] for corners in pairs)
        own, other = faces.corner_faces[receiving], faces.corner_faces[giving]
        self._smooth = None if smooth is None else smooth[order]
        # Two polygons meet at several corners, seen from both sides, and at one angle.
        keys = np.minimum(own, other) * len(faces) + np.maximum(own, other)
        keys, self._meeting = np.unique(keys, return_inverse=True)
        self._meets = np.divmod(keys, max(len(faces), 1))
        counts = np.bincount(receiving, minlength=faces.indices.size)
        begins = np.concatenate([[0], np.cumsum(counts)])
        shape = (faces.indices.size, len(faces))
        self._sums = csr_array((np.ones(len(other)), other, begins), shape=shape)

    def of(self, vertices: NDArray[np.float64]) -> NDArray[np.float64]:
        """(C, 3) unit normals at (V, 3) positions; (0, 0, 1) at polygons without area."""
        of_face = polygon_normals(vertices, self._faces)
        units = _units(of_face)
        one, other = (units[numbers] for numbers in self._meets)
        alike = (np.einsum("ij,ij->i", one, other) > self._least)[self._meeting]
        self._sums.data[:] = alike if self._smooth is None else alike | self._smooth
        normals = _units(self._sums @ of_face)
        normals[~normals.any(axis=1)] = (0.0, 0.0, 1.0)
        return normals


def _units(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 3) vectors of length 1, those of no length as they are."""
    lengths = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))
    return vectors / np.where(lengths > 0, lengths, 1.0)[:, None]
