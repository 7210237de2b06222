"""The checks, grouped by what they look at, and what those of all targets share."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.connectivity import HalfEdges, Neighbours
from elastomorph.doctor.settings import Thresholds
from elastomorph.model.mesh import Mesh
from elastomorph.paths.arc import neighbourhoods
from elastomorph.paths.rotations import Neighbourhoods, SurfaceEdges

__all__ = ["STILL_SHARE", "Neutral"]

STILL_SHARE = 0.25
"""Part of a face that no expression moves: skull, back of the head, a good part of the brow."""


class Neutral:
    """A neutral with what checks of many targets need of it, made when it is first asked for.

    Attributes:
        mesh: The neutral.
        limits: From where on to report.
    """

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
