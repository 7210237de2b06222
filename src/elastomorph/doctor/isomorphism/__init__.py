"""Which vertex of one file is which of another: an isomorphism of their polygons.

Vertices are told apart by colour refinement, matched by a traversal of half-edges or, where that
does not get everywhere, by backtracking; positions choose among the automorphisms.
"""

from elastomorph.doctor.isomorphism.parts import Parts
from elastomorph.doctor.isomorphism.plausibility import Plausibility, plausibility
from elastomorph.doctor.isomorphism.polygons import (
    corners_either_way,
    corresponding_corners,
    reversed_corners,
    reversed_polygons,
    triangles_of,
)
from elastomorph.doctor.isomorphism.search import Mismatch, Relabelling, find_relabelling

__all__ = [
    "Mismatch",
    "Parts",
    "Plausibility",
    "Relabelling",
    "corners_either_way",
    "corresponding_corners",
    "find_relabelling",
    "plausibility",
    "reversed_corners",
    "reversed_polygons",
    "triangles_of",
]
