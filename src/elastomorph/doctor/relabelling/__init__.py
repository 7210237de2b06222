"""Which vertex of one file is which of another, found from how they are connected."""

from elastomorph.doctor.relabelling.parts import Parts
from elastomorph.doctor.relabelling.same_polygons import corresponding_corners, reversed_polygons
from elastomorph.doctor.relabelling.search import Mismatch, Relabelling, find_relabelling

__all__ = [
    "Mismatch",
    "Parts",
    "Relabelling",
    "corresponding_corners",
    "find_relabelling",
    "reversed_polygons",
]
