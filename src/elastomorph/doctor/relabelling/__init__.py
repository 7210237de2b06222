"""Which vertex of one file is which of another, found from how they are connected."""

from elastomorph.doctor.relabelling.doubts import Doubts, doubts_about
from elastomorph.doctor.relabelling.parts import Parts
from elastomorph.doctor.relabelling.same_polygons import (
    EitherWay,
    corners_either_way,
    corresponding_corners,
    reversed_polygons,
    turned_corners,
)
from elastomorph.doctor.relabelling.search import Mismatch, Relabelling, find_relabelling
from elastomorph.doctor.relabelling.split import split_polygons

__all__ = [
    "Doubts",
    "EitherWay",
    "Mismatch",
    "Parts",
    "Relabelling",
    "corners_either_way",
    "corresponding_corners",
    "doubts_about",
    "find_relabelling",
    "reversed_polygons",
    "split_polygons",
    "turned_corners",
]
