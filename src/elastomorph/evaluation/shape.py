"""What the eye sees in an in-between without a ground truth: seams, flips and stretch."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork
from elastomorph.errors import TimeLawWarning
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.model.polygons import Polygons, polygon_normals
from elastomorph.paths.interpolate import interpolate
from elastomorph.physics import CLOSURES, Material


@dataclass(frozen=True)
class Shape:
    """The worst of an in-between, or of several."""

    # Largest jump between two curves that share an edge, as a fraction of D: by how much more the
    # two ends of the edge part than they do when the whole face follows the limit law.
    seam: float = 0.0
    flips: int = 0  # Polygons whose normal turns against that of the neutral and that of the target
    # Largest ratio, at least 1, by which an edge is longer than at both ends or shorter than at
    # both ends; infinite where an edge collapses to a point.
    stretch: float = 1.0

    def worst(self, other: Shape) -> Shape:
        """The worse of two, number by number."""
        return Shape(
            max(self.seam, other.seam),
            max(self.flips, other.flips),
            max(self.stretch, other.stretch),
        )


@dataclass(frozen=True, eq=False)
class ShapeProbe:
    """What in-betweens are compared with: edges and normals of neutral and target, found once."""

    faces: Polygons  # The polygons
    edges: NDArray[np.int32]  # (E, 2) edges whose length is above 0 at one end at least
    shorter: NDArray[np.float64]  # (E,) length of each edge at the end where it is shorter
    longer: NDArray[np.float64]  # (E,) length at the end where it is longer
    # (S, 2) edges between vertices of different curves, or of a curve and of none.
    seam_edges: NDArray[np.int32]
    neutral_normals: NDArray[np.float64]  # (F, 3) area-weighted normals
    target_normals: NDArray[np.float64]  # (F, 3) area-weighted normals
    diameter: float  # D

    @classmethod
    def of(cls, neutral: Mesh, target: Mesh, curve_of: NDArray[np.integer]) -> ShapeProbe:
        """Prepare for in-betweens of two meshes; `curve_of` is -1 where a vertex has no curve."""
        edges = neutral.edges
        lengths = np.stack(
            [_edge_lengths(mesh.vertices, edges) for mesh in (neutral, target)], axis=0
        )
        real = lengths.max(axis=0) > 0
        ends = np.asarray(curve_of)[edges]
        return cls(
            neutral.faces,
            edges[real],
            lengths.min(axis=0)[real],
            lengths.max(axis=0)[real],
            edges[ends[:, 0] != ends[:, 1]],
            polygon_normals(neutral.vertices, neutral.faces),
            polygon_normals(target.vertices, target.faces),
            neutral.diameter,
        )

    def at(self, morph: Morph, time: float, positions: NDArray[np.float64]) -> Shape:
        """Measure one in-between, whose (V, 3) positions are ``morph.at(time)``."""
        return Shape(self.seam(morph, time), self.flips(positions), self.stretch(positions))

    def seam(self, morph: Morph, time: float) -> float:
        """max ‖e_i - e_j‖/D over the seam edges, with e = V(t) - (V₀ + (t + limit law(t))Δ)."""
        if not len(self.seam_edges):
            return 0.0
        # e without V₀ + tΔ, which cancels: a path that is the limit law has e = 0 exactly.
        weights = np.array([float(curve(time)) for curve in morph.bend_curves])
        offset = np.tensordot(weights, morph.bends, axes=1)
        offset -= float(morph.limit_law(time)) * morph.delta
        return float(_edge_lengths(offset, self.seam_edges).max()) / self.diameter

    def flips(self, positions: NDArray[np.float64]) -> int:
        """The number of polygons with n·n₀ < 0 and n·n₁ < 0."""
        normals = polygon_normals(positions, self.faces)
        against_neutral = np.einsum("fi,fi->f", normals, self.neutral_normals) < 0
        against_target = np.einsum("fi,fi->f", normals, self.target_normals) < 0
        return int(np.count_nonzero(against_neutral & against_target))

    def stretch(self, positions: NDArray[np.float64]) -> float:
        """max over the edges of l/max(l₀, l₁) and min(l₀, l₁)/l."""
        if not len(self.edges):
            return 1.0
        lengths = _edge_lengths(positions, self.edges)
        # An edge that is a point at one end has min = 0, and cannot be shorter than that.
        with np.errstate(divide="ignore"):
            shrunk = np.divide(
                self.shorter, lengths, out=np.zeros_like(lengths), where=self.shorter > 0
            )
        return max(1.0, float((lengths / self.longer).max()), float(shrunk.max()))


def _edge_lengths(
    positions: NDArray[np.float64], edges: NDArray[np.integer]
) -> NDArray[np.float64]:
    along = positions[edges[:, 1]] - positions[edges[:, 0]]
    squared: NDArray[np.float64] = np.einsum("ei,ei->e", along, along)
    return np.sqrt(squared)


@dataclass(frozen=True, eq=False)
class ClosureSeam:
    """One in-between under one closure."""

    closure: str  # Its name
    morph: Morph  # The path
    shape: Shape  # Seam, flips and stretch of the in-between


def closure_seams(
    neutral: Mesh,
    target: Mesh,
    curves: CurveNetwork,
    *,
    closures: Sequence[str] = CLOSURES,
    time: float = 0.5,
    order: int = 2,
    material: Material | None = None,
) -> list[ClosureSeam]:
    """Solve one in-between under several closures, with the load t^order, and measure its seams.

    That a closure's law runs backwards is no news here, so no warning is given of it.
    """
    probe = ShapeProbe.of(neutral, target, curves.curve_of)
    found = []
    for closure in closures:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", TimeLawWarning)
            morph = interpolate(
                neutral,
                target,
                "beam",
                order=order,
                closure=closure,
                material=material,
                curves=curves,
            )
        found.append(ClosureSeam(closure, morph, probe.at(morph, time, morph.at(time))))
    return found
