"""How the surface turns between two meshes, and the paths that turn with it."""

from elastomorph.rotations.components import common_turn
from elastomorph.rotations.least_distortion import SurfaceEdges, least_distortion
from elastomorph.rotations.turning import ArcBend, EdgeBend
from elastomorph.rotations.vertex_rotations import (
    Neighbourhoods,
    VertexRotations,
    vertex_rotations,
)

__all__ = [
    "ArcBend",
    "EdgeBend",
    "Neighbourhoods",
    "SurfaceEdges",
    "VertexRotations",
    "common_turn",
    "least_distortion",
    "vertex_rotations",
]
