"""Least distortion: every neighbourhood turns steadily while it is stretched.

All edges turn with the surface around them; one Poisson equation per moment joins them. Vertices
that do not move stay, and components that move rigidly follow their screw, both exactly.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import elastomorph.paths.options as options
from elastomorph.curves import CurveNetwork
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.paths.arc import (
    bent_path,
    local_rotations,
    neighbourhoods,
    stored,
    warn_of_loose,
)
from elastomorph.paths.method import Method, Prepared
from elastomorph.paths.rotations import (
    LeastDistortion,
    Neighbourhoods,
    SurfaceEdges,
    VertexRotations,
)

__all__ = ["Rotation", "Turning", "rotation_path"]

# Fewer than for arcs: the equation that joins the edges smooths by itself.
_RINGS = 2


@dataclass(frozen=True)
class Rotation(Method):
    """Least distortion; where polygons would turn over, and do not on the straight line, eased.

    Attributes:
        tolerance: How closely the bends hold the path, as a fraction of D; smaller ones cost more
            bends.
    """

    name = "rotation"
    path = "least distortion of the surface: parts that turn are turned"
    on_surfaces = True

    tolerance: float = options.tolerance()

    def prepare(self, neutral: Mesh, curves: CurveNetwork | None = None) -> Prepared:
        """As `Method.prepare`; curves are not used: the path follows the surface.

        Raises:
            MeshError: The neutral has no polygon with an area.
            BakeError: A turn is too sharp to be stored.
        """
        around, surface = neighbourhoods(neutral), SurfaceEdges.of(neutral)

        def to(target: Mesh) -> Morph:
            warn_of_loose(neutral, target, around)
            turning = Turning.of(neutral, target, around, surface)
            return turning.stored(self.tolerance, self.label)

        return to


@dataclass(frozen=True, eq=False)
class Turning:
    """The least distorted path between two shapes, before it is stored."""

    neutral: Mesh
    target: Mesh
    around: Neighbourhoods
    rotations: VertexRotations
    equation: LeastDistortion

    @classmethod
    def of(
        cls, neutral: Mesh, target: Mesh, around: Neighbourhoods, surface: SurfaceEdges
    ) -> Turning:
        """Find the rotations of a target; nothing is solved yet."""
        rotations = local_rotations(neutral, target, around, _RINGS)
        equation = LeastDistortion.of(neutral.vertices, target.vertices, rotations, surface)
        return cls(neutral, target, around, rotations, equation)

    def stored(self, tolerance: float, label: str) -> Morph:
        """The path as bends within a tolerance."""
        bend = self.equation.bend()
        return stored(
            bend, self.neutral, self.target, self.around, self.rotations, tolerance, label
        )


def rotation_path(
    neutral: Mesh,
    target: Mesh,
    around: Neighbourhoods | None = None,
    surface: SurfaceEdges | None = None,
) -> Callable[[float], NDArray[np.float64]]:
    """The path before it is stored: from t to (V, 3) positions, exact at both ends."""
    around = neighbourhoods(neutral) if around is None else around
    surface = SurfaceEdges.of(neutral) if surface is None else surface
    turning = Turning.of(neutral, target, around, surface)
    warn_of_loose(neutral, target, around)
    return bent_path(neutral, target, turning.equation.bend().at)
