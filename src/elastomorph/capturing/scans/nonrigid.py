"""A template drawn onto a scan, coarse to fine.

Each step looks for the points that belong to the vertices and deforms the template towards the
planes there. Along the surface a scan says nothing, so nearly nothing pulls along it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry import Deformation, Surface, to_places
from elastomorph.capturing.scans.correspondence import Matches, ScanPoints, outer

Points = NDArray[np.float64]

# How much a point of the scan pulls along the surface, beside across it.
_ALONG = 0.02
# Reach of a scan that explains a vertex, in parts of the extent.
_EXPLAINED = 0.02
# A landmark counts fully where its square is so many times that of the surface.
_AS_EXACT = 3.0
# The length of edges, in parts of the template's extent, that stiffness is given for.
_EDGE = 0.011


@dataclass(frozen=True)
class Stage:
    """Steps of one stiffness.

    Attributes:
        bending: weight of curvature, for vertices `_EDGE` apart.
        arap: weight of lengths, likewise.
        reach: distance at which a point counts a quarter, in parts of the extent.
        steps: how many.
    """

    bending: float
    arap: float
    reach: float
    steps: int


# To another person's face: as smooth as can be, for features are to stay where they are.
ADAPT = (
    Stage(50.0, 0.1, 0.05, 5),
    Stage(20.0, 0.02, 0.028, 5),
    Stage(5.0, 0.005, 0.014, 5),
    Stage(2.0, 0.002, 0.009, 4),
)
# To another expression of the same face: where it goes between landmarks, smoothness tells better
# than lengths do.
FOLLOW = (
    Stage(25.0, 0.04, 0.05, 4),
    Stage(10.0, 0.01, 0.028, 4),
    Stage(2.5, 0.003, 0.014, 4),
    Stage(1.0, 0.001, 0.009, 4),
)
# To what the rig's own expressions leave over.
FINISH = (Stage(5.0, 0.005, 0.017, 5), Stage(1.5, 0.0015, 0.01, 5))
# To vertices that were followed, as stiff beside them; no point of a scan counts.
_COMPLETED = Stage(0.5, 0.002, 0.0, 6)


@dataclass(frozen=True, eq=False)
class Held:
    """Places of single vertices that are known: landmarks.

    Attributes:
        vertices: (K,) of the template.
        places: (K, 3).
    """

    vertices: NDArray[np.int64]
    places: Points

    def without(self, off: Sequence[Points]) -> Held:
        """The same, each brought back by how far beside its vertex it is."""
        return Held(self.vertices, self.places - np.reshape(off, (-1, 3)))

    def sure(self, off: float, missed: Points) -> float:
        """From 0 to 1, how much landmarks may say beside a surface that fits.

        The surface is off by a distance, landmarks are by (K, 3): by clicks that are worse than a
        surface that fits nearly everywhere no scan is made better.
        """
        if not len(missed):
            return 0.0
        square = float((missed**2).sum(axis=1).mean()) + 1e-300
        return min(1.0, _AS_EXACT * off**2 / square)


class Elastic:
    """A template at rest, prepared to be drawn onto scans.

    Attributes:
        rest: (V, 3).
        triangles: (T, 3).
        size: extent of the template, the unit of all lengths that are parts.
        outer: (V,) which vertices a scanner can see.
        deformation: of the template at rest.
    """

    def __init__(
        self,
        rest: Points,
        triangles: NDArray[np.integer],
        size: float,
        seen: NDArray[np.bool_] | None = None,
    ) -> None:
        self.rest, self.triangles, self.size = rest, triangles, size
        self.outer = outer(Surface(rest, triangles)) if seen is None else seen
        self.deformation = Deformation(rest, triangles)
        first, second = self.deformation.edges.T
        self.edge = float(np.median(np.linalg.norm(rest[first] - rest[second], axis=1)))
        # The finer a template, the more vertices pull at one piece of it.
        self._finer = _EDGE * size / self.edge

    def with_rest(self, rest: Points) -> Elastic:
        """The same template at rest elsewhere."""
        return Elastic(rest, self.triangles, self.size, self.outer)

    def normals(self, vertices: Points) -> Points:
        """(V, 3) at positions of the template."""
        return Surface(vertices, self.triangles).normals

    def at_landmarks(self, vertices: Points, held: Held) -> Points:
        """The template bent smoothly so that its landmarks are where they were found."""
        if not len(held.vertices):
            return vertices
        quadratic, linear = self._held(held, 100.0)
        return self.deformation.solve(vertices, quadratic, linear, arap=0.02, bending=5.0, rounds=4)

    def drawn(
        self,
        vertices: Points,
        scan: ScanPoints,
        stages: tuple[Stage, ...],
        held: Held,
        hold: float,
    ) -> Points:
        """The template drawn onto a scan.

        Args:
            vertices: (V, 3) to begin with.
            scan: in the same place and size.
            stages: one after another.
            held: landmarks.
            hold: weight of a landmark beside that of a point of the scan.
        """
        for stage in stages:
            for _ in range(stage.steps):
                vertices = self._step(vertices, scan, stage, held, hold)
        return vertices

    def completed(self, vertices: Points, weights: Points) -> Points:
        """The template at rest, bent to where some of its vertices were found.

        What was not found lies as the face at rest lets it, whatever it was begun from.

        Args:
            vertices: (V, 3).
            weights: (V,) of those that were found, beside those of points of a scan; else 0.
        """
        return self.deformation.solve(
            vertices,
            weights[:, None, None] * np.eye(3),
            weights[:, None] * vertices,
            arap=_COMPLETED.arap * self._finer**2,
            bending=_COMPLETED.bending * self._finer**4,
            rounds=_COMPLETED.steps,
        )

    def explained(self, vertices: Points, scan: ScanPoints) -> float:
        """How much of the skin a scan has near some vertices."""
        weights = self.matches(vertices, scan, _EXPLAINED).weights(_EXPLAINED * self.size)
        return float(weights[self.outer].sum())

    def matches(self, vertices: Points, scan: ScanPoints, reach: float) -> Matches:
        """The points of a scan that belong to the vertices; the reach is a part of the extent."""
        return scan.matches(vertices, self.normals(vertices), turn=reach * self.size)

    def _step(
        self, vertices: Points, scan: ScanPoints, stage: Stage, held: Held, hold: float
    ) -> Points:
        found = self.matches(vertices, scan, stage.reach)
        weights = found.weights(stage.reach * self.size) * self.outer
        across = found.normals[:, :, None] * found.normals[:, None, :] + _ALONG * np.eye(3)
        quadratic, linear = self._held(held, hold * self._finer**2)
        quadratic += weights[:, None, None] * across
        linear += weights[:, None] * np.einsum("nij,nj->ni", across, found.points)
        return self.deformation.solve(
            vertices,
            quadratic,
            linear,
            arap=stage.arap * self._finer**2,
            bending=stage.bending * self._finer**4,
            rounds=2,
        )

    def _held(self, held: Held, weight: float) -> tuple[Points, Points]:
        """What landmarks add to the quadratic and the linear part."""
        return to_places(len(self.rest), held.vertices, held.places, weight)
