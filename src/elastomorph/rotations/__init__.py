"""How the surface turns between two meshes, and the paths that turn with it."""

from elastomorph.rotations.components import common_turns
from elastomorph.rotations.edge_equation import SurfaceEdges
from elastomorph.rotations.least_distortion import LeastDistortion
from elastomorph.rotations.polynomial_bend import PolynomialBend, moments_needed
from elastomorph.rotations.turning import ArcBend, EdgeBend
from elastomorph.rotations.vertex_rotations import (
    Neighbourhoods,
    VertexRotations,
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
