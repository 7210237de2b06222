"""A face mesh as curves: edge loops traced, chosen and joined until each vertex is on one."""

from elastomorph.curves.extraction import extract_curves
from elastomorph.curves.loops import edge_loops
from elastomorph.curves.network import Curve, CurveNetwork, require_curves_of
from elastomorph.curves.region import region_of, region_weights

__all__ = [
    "Curve",
    "CurveNetwork",
    "edge_loops",
    "extract_curves",
    "region_of",
    "region_weights",
    "require_curves_of",
]
