"""Circular arcs: every vertex turns about its joint, in closed form.

The rotation of the surface around a vertex, smoothed over a few rings, and the chord of the vertex
fix the arc: a jaw swings about its hinge and a lid runs around its eyeball, though nobody says
where hinge and eyeball are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import elastomorph.paths.options as options
from elastomorph.curves import CurveNetwork
from elastomorph.errors import warn
from elastomorph.model.mesh import Mesh, require_same_topology
from elastomorph.model.morph import Morph
from elastomorph.paths.bake import bake_polynomial
from elastomorph.paths.method import Method, Prepared
from elastomorph.paths.region import curve_edges
from elastomorph.paths.rotations import (
    ArcBend,
    Neighbourhoods,
    PolynomialBend,
    VertexRotations,
    moments_needed,
    vertex_rotations,
)
from elastomorph.paths.rotations.bends import at_nodes
from elastomorph.paths.rotations.flips import without_flips

_RINGS = 12


@dataclass(frozen=True)
class Arc(Method):
    """Circular arcs; where polygons would turn over, and do not on the straight line, eased.

    Attributes:
        tolerance: How closely the bends hold the path, as a fraction of D; smaller ones cost more
            bends.
    """

    name = "arc"
    path = "circular arcs of the local rotation"
    turns = True

    tolerance: float = options.tolerance()

    def prepare(self, neutral: Mesh, curves: CurveNetwork | None = None) -> Prepared:
        """As `Method.prepare`; curves stand in for edges on a neutral without polygons.

        Raises:
            BakeError: A turn is too sharp to be stored.
        """
        around = neighbourhoods(neutral, curves)

        def to(target: Mesh) -> Morph:
            warn_of_loose(neutral, target, around)
            return Arcs.of(neutral, target, around).stored(self.tolerance, self.label)

        return to


@dataclass(frozen=True, eq=False)
class TurnedPath:
    """The rotations of a path between two shapes."""

    neutral: Mesh
    target: Mesh
    around: Neighbourhoods
    rotations: VertexRotations

    def baked(self, bend: PolynomialBend, tolerance: float, label: str) -> Morph:
        """A path as few bends, eased where polygons would turn over."""
        ends, bent = (self.neutral, self.target), (bend.coefficients, bend.bent)
        morph = bake_polynomial(*bent, *ends, tolerance=tolerance, method=label)
        return without_flips(morph, self.around, self.rotations.whole)


@dataclass(frozen=True, eq=False)
class Arcs(TurnedPath):
    """The arcs between two shapes, before they are stored: of the (V,) vertices that move."""

    moving: NDArray[np.bool_]
    bend: ArcBend

    @classmethod
    def of(
        cls, neutral: Mesh, target: Mesh, around: Neighbourhoods, only_turns: bool = False
    ) -> Arcs:
        """Find the arcs; with `only_turns` straight where edges hardly turn by their rotations."""
        rotations = local_rotations(neutral, target, around, _RINGS)
        if only_turns:
            rotations = rotations.where_edges_turn(neutral.vertices, target.vertices, around)
        chords = target.vertices - neutral.vertices
        moving = (chords != 0).any(axis=1)
        bend = ArcBend.of(chords[moving], rotations.vectors[moving])
        return cls(neutral, target, around, rotations, moving, bend)

    def at(self, t: float) -> NDArray[np.float64]:
        """(V, 3) offset from the straight line."""
        offsets = np.zeros((len(self.moving), 3))
        offsets[self.moving] = self.bend.at(t)
        return offsets

    def stored(self, tolerance: float, label: str) -> Morph:
        """The path as bends within a tolerance."""
        count = moments_needed(2.0 * float(self.bend.half.max(initial=0.0)))
        bend = PolynomialBend(at_nodes(self.bend.at, count), self.moving)
        return self.baked(bend, tolerance, label)


def neighbourhoods(neutral: Mesh, curves: CurveNetwork | None = None) -> Neighbourhoods:
    """The edges around every vertex: those of the polygons, or of curves where there are none."""
    edges = neutral.edges
    if not len(neutral.faces) and curves is not None:
        edges = curve_edges(curves)
    return Neighbourhoods.of(len(neutral.vertices), edges)


def local_rotations(
    neutral: Mesh, target: Mesh, around: Neighbourhoods, rings: int
) -> VertexRotations:
    """The rotations that a path turns by."""
    require_same_topology(neutral, target)
    return vertex_rotations(
        neutral.vertices, target.vertices, around, diameter=neutral.diameter, rings=rings
    )


def bent_path(
    neutral: Mesh, target: Mesh, bend: Callable[[float], NDArray[np.float64]]
) -> Callable[[float], NDArray[np.float64]]:
    """V₀ + tΔ and a bend, counted from the nearer end so that both ends are exact."""
    start, end = neutral.vertices, target.vertices
    chords = end - start

    def path(t: float) -> NDArray[np.float64]:
        near = start + t * chords if t <= 0.5 else end + (t - 1.0) * chords
        return np.asarray(near + bend(t))

    return path


def warn_of_loose(neutral: Mesh, target: Mesh, around: Neighbourhoods) -> None:
    """Warn of vertices that move, but have no edges from which their rotation could be known."""
    loose = np.diff(around.at_vertex.indptr) == 0
    loose &= (neutral.vertices != target.vertices).any(axis=1)
    if loose.any():
        warn(
            f"{int(loose.sum()):,} moving vertices of {neutral.name} are on no polygon (the first "
            f"is {int(np.argmax(loose))}): nothing says how they turn, so they move straight"
        )
