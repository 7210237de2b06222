"""Matches as anchors of a surface: where points of it are in a pose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.tracking.matches import Matches, consistent
from elastomorph.capturing.tracking.reference import Reference
from elastomorph.errors import CaptureError

Points = NDArray[np.float64]

# Reach of matches, in D, and how much the surface resists bending, in the turns of the beginning.
_BEGINNING = ((0.1, 0.5), (0.03, 0.5), (0.015, 0.2), (0.01, 0.2), (0.01, 0.2))
# Of D: how far from the surface of the neutral a point of its skin may be.
_OFF_SURFACE = 0.01
# Fewest matches with which a pose can be followed.
_FEWEST_MATCHES = 12


@dataclass(frozen=True, eq=False)
class Anchors:
    """Points of the surface whose places matches tell.

    Attributes:
        corners: (N, 3) vertices of the triangle that each lies in.
        weights: (N, 3) of those.
        goals: (N, 3) where they are in the pose.
    """

    corners: NDArray[np.int64]
    weights: Points
    goals: Points

    @classmethod
    def of(cls, reference: Reference, start: Points, matches: Matches | None) -> Anchors:
        """Those of the matches that lie on the neutral and agree with their neighbours.

        Raises:
            CaptureError: there are matches, but too few of them are left.
        """
        if matches is None:
            return cls(np.zeros((0, 3), dtype=np.int64), np.zeros((0, 3)), np.zeros((0, 3)))
        surface, extent = reference.surface, reference.extent
        closest = surface.closest(matches.neutral)
        corners = surface.triangles[closest.triangles]
        expected = np.einsum("ni,nij->nj", closest.weights, start[corners])
        lift = matches.neutral - closest.points
        good = closest.distances < _OFF_SURFACE * extent
        good[good] = consistent(matches.chosen(good), (expected + lift)[good], extent)
        if np.count_nonzero(good) < _FEWEST_MATCHES:
            raise CaptureError(
                f"{np.count_nonzero(good)} points of the skin were found both in the neutral and "
                f"in the pose, expected at least {_FEWEST_MATCHES}: are both of one person, "
                "sharp, and lit alike?"
            )
        return cls(corners[good], closest.weights[good], (matches.pose - lift)[good])

    def equations(self, vertices: Points, weight: float, robust: float) -> tuple[Points, Points]:
        """(V, 3, 3) A and (V, 3) b that pull the vertices; beyond `robust`, a length, less."""
        quadratic, linear = np.zeros((len(vertices), 3, 3)), np.zeros_like(vertices)
        off = self.goals - np.einsum("ni,nij->nj", self.weights, vertices[self.corners])
        pull = weight / (1 + (off**2).sum(axis=1) / robust**2) ** 2
        shares = self.weights * pull[:, None]
        for corner, share in zip(self.corners.T, shares.T, strict=True):
            np.add.at(quadratic, corner, share[:, None, None] * np.eye(3))
            np.add.at(linear, corner, share[:, None] * (vertices[corner] + off))
        return quadratic, linear


def begun(reference: Reference, start: Points, anchors: Anchors) -> Points:
    """(V, 3) the surface as matches alone have it, begun at another pose."""
    deformation = reference.deformation.around(start)
    vertices = start
    for robust, bending in _BEGINNING if len(anchors.corners) else ():
        quadratic, linear = anchors.equations(vertices, 1.0, robust * reference.extent)
        vertices = deformation.solve(vertices, quadratic, linear, arap=0.02, bending=bending)
    return vertices
