"""UsdSkel's own word on where blend shapes move the points of a mesh."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


def blended(prim: Any, weights: Sequence[float]) -> Any:
    """The points of a mesh (N, 3), as UsdSkel keeps them, by weights of its blend shapes."""
    from pxr import UsdGeom, UsdSkel, Vt

    query = UsdSkel.BlendShapeQuery(UsdSkel.BindingAPI(prim))
    points = UsdGeom.Mesh(prim).GetPointsAttr().Get()
    row = Vt.FloatArray([float(weight) for weight in weights])
    sub_weights, shapes, sub_shapes = query.ComputeSubShapeWeights(row)
    assert query.ComputeDeformedPoints(
        sub_weights,
        shapes,
        sub_shapes,
        query.ComputeBlendShapePointIndices(),
        query.ComputeSubShapePointOffsets(),
        points,
    )
    return points
