"""How the surface turns between two meshes, and the paths that turn with it."""

from elastomorph.paths.rotations.bends import ArcBend, EdgeBend, PolynomialBend, moments_needed
from elastomorph.paths.rotations.least_distortion import LeastDistortion, SurfaceEdges
from elastomorph.paths.rotations.vertex_rotations import (
    Neighbourhoods,
    VertexRotations,
    common_turns,
    vertex_rotations,
)

__all__ = [
    "ArcBend",
    "EdgeBend",
    "LeastDistortion",
    "Neighbourhoods",
    "PolynomialBend",
    "SurfaceEdges",
    "VertexRotations",
    "common_turns",
    "moments_needed",
    "vertex_rotations",
]
