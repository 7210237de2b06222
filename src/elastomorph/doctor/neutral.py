"""The neutral as all checks see it: its half-edges, neighbours and areas, made once each."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from elastomorph.doctor.settings import Thresholds
from elastomorph.model.mesh import Mesh
from elastomorph.model.polygons import Polygons
from elastomorph.paths.arc import neighbourhoods
from elastomorph.paths.rotations import Neighbourhoods, SurfaceEdges

STILL_SHARE = 0.25
"""Part of a face that no expression moves: skull, back of the head, a good part of the brow."""


@dataclass(frozen=True, eq=False)
class HalfEdges:
    """Each polygon corner with the edge that leaves it; arrays are (C,)."""

    faces: Polygons
    vertex_count: int
    start: NDArray[np.int64]  # vertex of each corner
    end: NDArray[np.int64]  # vertex of the following corner
    following: NDArray[np.int64]  # corner of the same polygon
    previous: NDArray[np.int64]
    # The one corner whose edge runs the other way; -1 at a border, and where more than two
    # polygons meet or two run the same way.
    twin: NDArray[np.int64]
    alike: NDArray[np.int64]  # how many have the same edge in the same direction, itself included
    against: NDArray[np.int64]  # how many have it in the other direction

    @classmethod
    def of(cls, faces: Polygons, vertex_count: int) -> HalfEdges:
        """The half-edges of polygons."""
        start = faces.indices.astype(np.int64)
        following = faces.next_corners
        previous = np.empty_like(following)
        previous[following] = np.arange(len(following))
        end = start[following] if start.size else start
        keys, backward = start * vertex_count + end, end * vertex_count + start
        order = np.argsort(keys, kind="stable")
        ordered = keys[order]
        first = np.searchsorted(ordered, backward)
        against = np.searchsorted(ordered, backward, side="right") - first
        alike = np.searchsorted(ordered, keys, side="right") - np.searchsorted(ordered, keys)
        plain = (alike == 1) & (against == 1) & (start != end)
        twin = np.full(len(start), -1, dtype=np.int64)
        twin[plain] = order[first[plain]]
        return cls(faces, vertex_count, start, end, following, previous, twin, alike, against)

    @property
    def polygons_of_edge(self) -> NDArray[np.int64]:
        """(C,) how many corners have the edge, whichever way it runs."""
        return self.alike + self.against

    @property
    def proper(self) -> NDArray[np.bool_]:
        """(C,) whether the edge joins two different vertices."""
        return np.asarray(self.start != self.end)

    @property
    def border(self) -> NDArray[np.bool_]:
        """(C,) whether the edge has one polygon."""
        return np.asarray(self.proper & (self.polygons_of_edge == 1))

    @property
    def edge_keys(self) -> NDArray[np.int64]:
        """(C,) one number for each edge, whichever way it runs."""
        low, high = np.minimum(self.start, self.end), np.maximum(self.start, self.end)
        return low * self.vertex_count + high


class Neighbours:
    """Which vertices are joined by an edge (V, V), their number and mean length (V,).

    The number of neighbours, ``valence``, is 1 where there are none.
    """

    def __init__(self, mesh: Mesh) -> None:
        count, edges = len(mesh.vertices), mesh.edges
        ends = np.concatenate([edges, edges[:, ::-1]])
        entries = (np.ones(len(ends)), (ends[:, 0], ends[:, 1]))
        self.adjacent = csr_array(coo_array(entries, shape=(count, count)))
        self.valence = np.maximum(np.diff(self.adjacent.indptr), 1)
        sides = mesh.vertices[ends[:, 0]] - mesh.vertices[ends[:, 1]]
        lengths = np.linalg.norm(sides, axis=1)
        self.edge = np.bincount(ends[:, 0], lengths, minlength=count) / self.valence

    def off_mean(self, moved: NDArray[np.float64]) -> NDArray[np.float64]:
        """(V,) how far each of (V, 3) motions is from the mean of its neighbours."""
        mean = (self.adjacent @ moved) / self.valence[:, None]
        return np.asarray(np.linalg.norm(moved - mean, axis=1))


class Neutral:
    """A neutral with what checks of many targets need of it, made when it is first asked for."""

    def __init__(self, mesh: Mesh, limits: Thresholds | None = None) -> None:
        self.mesh, self.limits = mesh, limits or Thresholds()

    @cached_property
    def scale(self) -> float:
        """D, or 1 where all vertices are at one place."""
        return self.mesh.diameter or 1.0

    @cached_property
    def half_edges(self) -> HalfEdges:
        """Its polygons as half-edges."""
        return HalfEdges.of(self.mesh.faces, len(self.mesh.vertices))

    @cached_property
    def neighbours(self) -> Neighbours:
        """Which vertices share an edge."""
        return Neighbours(self.mesh)

    @cached_property
    def around(self) -> Neighbourhoods:
        """What the arcs of single vertices are fitted to."""
        return neighbourhoods(self.mesh)

    @cached_property
    def surface(self) -> SurfaceEdges:
        """What paths that turn with the surface are solved on."""
        return SurfaceEdges.of(self.mesh)

    @cached_property
    def own_areas(self) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """`areas` of the neutral itself."""
        return self.areas(self.mesh.vertices)

    def areas(self, points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """(F,) area of each polygon, folded parts counted twice, and which have none."""
        faces = self.mesh.faces
        if not len(faces):
            return np.zeros(0), np.zeros(0, dtype=bool)
        a, b, c = (points[self._triangles[:, i]] for i in range(3))
        halves = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
        of_triangle = np.repeat(np.arange(len(faces)), faces.sizes - 2)
        areas = np.bincount(of_triangle, halves).astype(np.float64, copy=False)
        corners = points[faces.indices]
        sides = ((corners[faces.next_corners] - corners) ** 2).sum(axis=1)
        longest = np.maximum.reduceat(sides, faces.offsets[:-1])
        return areas, areas <= self.limits.area * longest

    @cached_property
    def _triangles(self) -> NDArray[np.int32]:
        return self.mesh.faces.triangles()

    def moved(self, target: Mesh) -> NDArray[np.float64]:
        """(V, 3) how a target moves each vertex."""
        return target.vertices - self.mesh.vertices
