"""A face mesh as curves: edge loops traced, chosen and joined until each vertex is on one."""

from elastomorph.curves.extraction import edge_loops, extract_curves
from elastomorph.curves.network import (
    Curve,
    CurveNetwork,
    region_of,
    region_weights,
    require_curves_of,
)

__all__ = [
    "Curve",
    "CurveNetwork",
    "edge_loops",
    "extract_curves",
    "region_of",
    "region_weights",
    "require_curves_of",
]
