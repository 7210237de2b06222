"""Discrete operators of a polygon mesh seen as a surface."""

from elastomorph.model.surface.laplacian import SurfaceOperators, surface_operators
from elastomorph.model.surface.triangulation import Triangulation, triangulate

__all__ = ["SurfaceOperators", "Triangulation", "surface_operators", "triangulate"]
