"""From polygons with texture seams to the triangles of glTF, reversibly.

glTF has one texture coordinate a vertex, so a vertex whose corners have several is repeated. The
first V vertices of the file are those of the mesh in their order; the copies follow. Each polygon
becomes a fan of triangles from its first corner, in the order of the polygons within a material,
so the polygons can be read back from the triangles and their sizes.

Where there are several materials, the triangles of each are a mesh with vertices of its own:
players keep the morph targets of all vertices that a primitive names, once a primitive.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.mesh import Mesh, UVMap
from elastomorph.model.polygons import Polygons


@dataclass(frozen=True, eq=False)
class MaterialTriangles:
    """The triangles of one material, a mesh of the file."""

    label: int  # Index into the names of the materials, or -1 for none
    triangles: NDArray[np.int32]  # (T, 3) int32 vertices of the layout
    rows: NDArray[np.int32]  # (N,) the vertices of the layout that it has, rising

    @property
    def local(self) -> NDArray[np.int32]:
        """(T, 3) its triangles, by the numbers of vertices that it has."""
        return np.searchsorted(self.rows, self.triangles).astype(np.int32)


@dataclass(frozen=True, eq=False)
class Layout:
    """The vertices and triangles of a file."""

    vertex_of: NDArray[np.int32]  # (N,) mesh vertex of each of the file; 0 … V - 1 first
    uv_of: NDArray[np.int32]  # (N,) texture coordinate of each vertex of the file, or -1
    corners: NDArray[np.int32]  # (C,) int32 vertex of the file at each polygon corner
    primitives: tuple[MaterialTriangles, ...]  # One a material, by label; unlabelled ones last
    texture: NDArray[np.float32] | None  # (N, 2) u and 1 - v, as glTF counts from the top

    def rows(self, vectors: NDArray[np.float64]) -> NDArray[np.float32]:
        """(N, 3) vectors of the vertices of the file, from (V, 3) of those of the mesh."""
        return vectors.astype(np.float32)[self.vertex_of]

    def copies(self, rows: NDArray[Any]) -> NDArray[Any]:
        """(N, …) rows of the vertices of the file, from (V, …) of those of the mesh."""
        return rows[self.vertex_of]


def lay_out(mesh: Mesh) -> Layout:
    """Split the vertices along texture seams and cut the polygons into triangles.

    A vertex is split only where texture coordinates really differ in single precision; two
    entries of the UV map with the same coordinates do not split it.
    """
    count = len(mesh.vertices)
    vertex_of = np.arange(count, dtype=np.int32)
    uv_of = np.full(count, -1, dtype=np.int32)
    corners, texture = mesh.faces.indices, None
    if mesh.uv is not None and len(mesh.faces):
        flipped = _flipped(mesh.uv)
        vertex_of, uv_of, corners = _split(mesh.faces, mesh.uv, flipped, count)
        texture = np.where(uv_of[:, None] >= 0, flipped[uv_of], np.float32(0))
    triangles = Polygons(corners, mesh.faces.offsets).triangles()
    primitives = _primitives(mesh, triangles, np.arange(len(vertex_of), dtype=np.int32))
    return Layout(vertex_of, uv_of, corners, primitives, texture)


def _flipped(uv: UVMap) -> NDArray[np.float32]:
    """(max(T, 1), 2) float32, with v counted from the top."""
    flipped = np.zeros((max(len(uv.coordinates), 1), 2), dtype=np.float32)
    flipped[: len(uv.coordinates), 0] = uv.coordinates[:, 0]
    flipped[: len(uv.coordinates), 1] = 1.0 - uv.coordinates[:, 1]
    return flipped + np.float32(0)  # -0 and 0 are the same place


def _split(
    faces: Polygons, uv: UVMap, flipped: NDArray[np.float32], count: int
) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.int32]]:
    """Vertex and texture coordinate of each vertex of the file, and its place at each corner."""
    place = np.unique(flipped, axis=0, return_inverse=True)[1].reshape(-1).astype(np.int64) + 1
    kind = np.where(uv.corners >= 0, place[uv.corners], 0)
    keys = faces.indices.astype(np.int64) * (place.max() + 1) + kind
    pairs, first, of_corner = np.unique(keys, return_index=True, return_inverse=True)
    vertex = faces.indices[first]
    # Of the pairs of a vertex, the one met first in the file keeps its number.
    by_vertex = np.lexsort((first, vertex))
    leads = np.append(True, np.diff(vertex[by_vertex]) != 0)[: len(pairs)]
    kept, copies = by_vertex[leads], np.sort(by_vertex[~leads])
    number = np.empty(len(pairs), dtype=np.int32)
    number[kept] = vertex[kept]
    number[copies] = count + np.arange(len(copies))
    vertex_of = np.concatenate([np.arange(count, dtype=np.int32), vertex[copies]])
    uv_of = np.full(len(vertex_of), -1, dtype=np.int32)
    uv_of[number] = uv.corners[first]
    return vertex_of, uv_of, number[of_corner.reshape(-1)]


def _primitives(
    mesh: Mesh, triangles: NDArray[np.int32], every: NDArray[np.int32]
) -> tuple[MaterialTriangles, ...]:
    if mesh.materials is None or not len(mesh.faces):
        return (MaterialTriangles(-1, triangles, every),)
    labels = np.repeat(mesh.materials.of_face, mesh.faces.sizes - 2)
    found = np.unique(labels)
    order = [*found[found >= 0].tolist(), *found[found < 0].tolist()]
    if len(order) == 1:
        return (MaterialTriangles(order[0], triangles, every),)
    parts = [triangles[labels == label] for label in order]
    rows = [np.unique(own) for own in parts]
    # Vertices without polygons go with the first.
    rows[0] = np.union1d(rows[0], np.setdiff1d(every, triangles))
    return tuple(map(MaterialTriangles, order, parts, rows))
