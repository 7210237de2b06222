"""Polygons without an area, which have no normal to shade with."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.findings import Finding, finding
from elastomorph.doctor.words import counted, listed
from elastomorph.model.mesh import Mesh
from elastomorph.model.polygons import Polygons

__all__ = ["AreaCheck"]


class AreaCheck:
    """Measures the polygons of the neutral once, then those of its targets."""

    def __init__(self, neutral: Mesh, least: float) -> None:
        """Measure the neutral.

        Args:
            neutral: The neutral.
            least: Part of the longest edge squared, and of the area in the neutral, up to which a
                polygon has no area.
        """
        self._faces, self._least = neutral.faces, least
        self._triangles = neutral.faces.triangles()
        self._of_polygon = np.repeat(np.arange(len(neutral.faces)), neutral.faces.sizes - 2)
        self._areas = self._measure(neutral.vertices)
        self._none = self._without_area(neutral.vertices, self._areas)

    def neutral(self, mesh: Mesh, file: str) -> list[Finding]:
        """Polygons of the neutral without an area."""
        return self._found(self._none, file, mesh, "no area")

    def target(self, mesh: Mesh, file: str) -> list[Finding]:
        """Polygons that have an area in the neutral and none in a target."""
        areas = self._measure(mesh.vertices)
        lost = self._without_area(mesh.vertices, areas) | (areas <= self._least * self._areas)
        return self._found(lost & ~self._none, file, mesh, "no area, though they do in the neutral")

    def _measure(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(F,) area of each polygon, folded parts counted twice instead of cancelling."""
        a, b, c = (points[self._triangles[:, i]] for i in range(3))
        areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
        total = np.bincount(self._of_polygon, areas, minlength=len(self._faces))
        return np.asarray(total, dtype=np.float64)

    def _without_area(
        self, points: NDArray[np.float64], areas: NDArray[np.float64]
    ) -> NDArray[np.bool_]:
        if not len(self._faces):
            return np.zeros(0, dtype=bool)
        corners = points[self._faces.indices]
        sides = ((corners[self._faces.next_corners] - corners) ** 2).sum(axis=1)
        longest = np.maximum.reduceat(sides, self._faces.offsets[:-1])
        return np.asarray(areas <= self._least * longest)

    def _found(
        self, without: NDArray[np.bool_], file: str, mesh: Mesh, words: str
    ) -> list[Finding]:
        faces = np.flatnonzero(without)
        if not faces.size:
            return []
        lines = mesh.source.face_lines if mesh.source else None
        message = f"{counted(faces, 'polygon has', 'polygons have')} {words}: {listed(faces)}"
        return [
            finding(
                "zero-area",
                file,
                message,
                line=None if lines is None else int(lines[faces[0]]),
                vertices=_vertices(self._faces, without),
            )
        ]


def _vertices(faces: Polygons, chosen: NDArray[np.bool_]) -> list[int]:
    return [int(v) for v in np.unique(faces.indices[chosen[faces.corner_faces]])]
