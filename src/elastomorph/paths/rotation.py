"""Least distortion: every neighbourhood turns steadily while it is stretched.

All edges turn with the surface around them; one Poisson equation per moment joins them. Vertices
that do not move stay, and components that move rigidly follow their screw, both exactly.
"""

from __future__ import annotations

from dataclasses import dataclass

import elastomorph.paths.options as options
from elastomorph.curves import CurveNetwork
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.paths.arc import (
    Positions,
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
        """A function from target to path.

        Args:
            neutral: The mesh at t = 0.
            curves: Not used: the path follows the surface.

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
    """The least distorted path between two shapes, before it is stored.

    Attributes:
        neutral: The mesh at t = 0.
        target: The mesh at t = 1.
        around: The edges of the neutral.
        rotations: Of its vertices.
        equation: What the bend solves.
    """

    neutral: Mesh
    target: Mesh
    around: Neighbourhoods
    rotations: VertexRotations
    equation: LeastDistortion

    @classmethod
    def of(
        cls,
        neutral: Mesh,
        target: Mesh,
        around: Neighbourhoods,
        surface: SurfaceEdges,
        rings: int = _RINGS,
    ) -> Turning:
        """Find the rotations of a target; nothing is solved yet."""
        rotations = local_rotations(neutral, target, around, rings)
        equation = LeastDistortion.of(neutral.vertices, target.vertices, rotations, surface)
        return cls(neutral, target, around, rotations, equation)

    def stored(self, tolerance: float, label: str) -> Morph:
        """The path as bends within a tolerance."""
        bend = self.equation.bend()
        return stored(
            bend, self.neutral, self.target, tolerance, label, self.around, self.rotations
        )


def rotation_path(
    neutral: Mesh,
    target: Mesh,
    *,
    rings: int = _RINGS,
    around: Neighbourhoods | None = None,
    surface: SurfaceEdges | None = None,
) -> Positions:
    """The path on which edges turn with their neighbourhoods, as nearly as all together can.

    See `elastomorph.paths.rotations.least_distortion` for what is minimised.

    Args:
        neutral: The mesh at t = 0.
        target: The mesh at t = 1.
        rings: Rings of neighbours over which rotations are smoothed.
        around: The edges of the neutral, if they are known.
        surface: Its weighted edges, if they are known.

    Returns:
        A function from t in [0, 1] to (V, 3) positions, exact at both ends.

    Raises:
        TopologyError: Neutral and target differ in vertices or polygons.
        MeshError: The neutral has no polygon with an area.
        ParameterError: `rings` is negative.
    """
    around = neighbourhoods(neutral) if around is None else around
    surface = SurfaceEdges.of(neutral) if surface is None else surface
    turning = Turning.of(neutral, target, around, surface, rings)
    warn_of_loose(neutral, target, around)
    return bent_path(neutral, target, turning.equation.bend().at)
