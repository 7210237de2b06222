"""Least distortion: every neighbourhood turns steadily while it is stretched.

All edges turn with the surface around them; one Poisson equation per moment joins them. Vertices
that do not move stay, and components that move rigidly follow their screw, both exactly.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

import elastomorph.paths.options as options
from elastomorph.curves import CurveNetwork
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Choice, Morph
from elastomorph.model.surface import winding_number
from elastomorph.paths.arc import (
    TurnedPath,
    bent_path,
    local_rotations,
    neighbourhoods,
    warn_of_loose,
)
from elastomorph.paths.method import Method, Prepared
from elastomorph.paths.rotations import (
    LeastDistortion,
    Neighbourhoods,
    SurfaceEdges,
)
from elastomorph.paths.rotations.passing import Sheets, without_passing

# Fewer than for arcs: the equation that joins the edges smooths by itself.
_RINGS = 2
# A point is inside a surface where the surface winds around it by more than half a turn; heads are
# open at the neck and the eyes. What was inside already, or half, has not been hidden.
_INSIDE, _MORE_INSIDE = 0.5, 0.25
# What goes farther than twice its size, and keeps less than a quarter of that, is put away: inside
# the mask that the face of an avatar is, which winds half around what is behind it, or less.
_AWAY, _LEFT = 2.0, 0.25


@dataclass(frozen=True)
class Rotation(Method):
    """Least distortion, eased where it would turn polygons over, or pass deep through itself.

    Both count only beyond what the straight line does.

    Attributes:
        tolerance: How closely the bends hold the path, as a fraction of D; smaller ones cost more
            bends.
    """

    name = "rotation"
    path = "least distortion of the surface: parts that turn are turned"
    on_surfaces = True
    turns = True

    tolerance: float = options.tolerance()

    def prepare(self, neutral: Mesh, curves: CurveNetwork | None = None) -> Prepared:
        """As `Method.prepare`; curves are not used: the path follows the surface.

        Raises:
            MeshError: The neutral has no polygon with an area.
            BakeError: A turn is too sharp to be stored.
        """
        around, surface = neighbourhoods(neutral), SurfaceEdges.of(neutral)
        sheets, scale = cache(partial(Sheets.of, neutral, around)), neutral.diameter or 1.0

        def to(target: Mesh) -> Morph:
            warn_of_loose(neutral, target, around)
            turning = Turning.of(neutral, target, around, surface)
            return turning.stored(self.tolerance, self.label, sheets(), scale, None)

        return to


@dataclass(frozen=True, eq=False)
class Turning(TurnedPath):
    """The least distorted path between two shapes, before it is stored."""

    surface: SurfaceEdges
    equation: LeastDistortion

    @classmethod
    def of(
        cls, neutral: Mesh, target: Mesh, around: Neighbourhoods, surface: SurfaceEdges
    ) -> Turning:
        """Find the rotations of a target; nothing is solved yet."""
        rotations = local_rotations(neutral, target, around, _RINGS)
        equation = LeastDistortion.of(neutral.vertices, target.vertices, rotations, surface)
        return cls(neutral, target, around, rotations, surface, equation)

    def without(self, vertices: NDArray[np.bool_]) -> Turning:
        """The same path, on which some components go straight."""
        rotations, start, end = self.rotations.without(vertices), self.neutral, self.target
        equation = LeastDistortion.of(start.vertices, end.vertices, rotations, self.surface)
        return replace(self, rotations=rotations, equation=equation)

    def hidden(self, least: float) -> NDArray[np.bool_]:
        """(V,) components that end inside the others, where they are not seen.

        Only those whose path is farther than `least` from the straight line halfway are looked at,
        at the vertices that lie outermost along the axes.
        """
        faces, start, end = self.neutral.faces, self.neutral.vertices, self.target.vertices
        found, nearly = np.zeros((2, len(start)), dtype=bool)
        far = np.linalg.norm(self.equation.at(0.5), axis=1) > least
        triangles = faces.triangles()
        for part in self.around.parts:
            if len(part) == len(start) or not far[part].any():
                continue
            others = triangles[~np.isin(triangles[:, 0], part)]
            outermost = part[np.unique([(sign * end[part]).argmax(axis=0) for sign in (-1.0, 1.0)])]
            size, left = (
                np.linalg.norm(own[part] - own[part].mean(axis=0)) for own in (start, end)
            )
            moved = np.linalg.norm((end - start)[part].sum(axis=0)) / np.sqrt(len(part))
            inside = [abs(winding_number(p, end[others])) for p in end[outermost]]
            if moved > _AWAY * size and left < _LEFT * size:
                found[part] = np.mean(inside) > _MORE_INSIDE
            elif np.mean(inside) > _INSIDE:
                before = [abs(winding_number(p, start[others])) for p in start[outermost]]
                if np.mean(inside) - np.mean(before) > _MORE_INSIDE:
                    (found if min(inside) > _INSIDE else nearly)[part] = True
        # A target that hides most of what it turns hides what ends almost inside, too.
        return found | nearly if found.sum() > nearly.sum() else found

    def stored(
        self, tolerance: float, label: str, sheets: Sheets, scale: float, choice: Choice | None
    ) -> Morph:
        """The path as bends within a tolerance, eased by D, and what was eased in its choice."""
        morph = replace(self.baked(self.equation.bend(), tolerance, label), choice=choice)
        return without_passing(morph, self.around, sheets, self.rotations.whole, scale)


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
