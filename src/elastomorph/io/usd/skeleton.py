"""The skeleton that UsdSkel wants around blend shapes, and the animation of their weights."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.usd.library import pxr

__all__ = ["WeightAnimation", "bind_mesh", "define_animation", "define_skeleton"]

_JOINT = "root"


@dataclass(frozen=True, eq=False)
class WeightAnimation:
    """Weights of all morphs over time.

    Attributes:
        times: (T,) seconds, rising.
        weights: (T, J) float64, one column a morph.
        name: What people call it.
    """

    times: NDArray[np.float64]
    weights: NDArray[np.float64]
    name: str


def define_skeleton(stage: Any, place: str) -> Any:
    """A skeleton of one joint that never moves."""
    identity = pxr("Vt").Matrix4dArray(1, pxr("Gf").Matrix4d(1.0))
    skeleton = pxr("UsdSkel").Skeleton.Define(stage, place)
    skeleton.CreateJointsAttr([_JOINT])
    skeleton.CreateBindTransformsAttr(identity)
    skeleton.CreateRestTransformsAttr(identity)
    return skeleton


def bind_mesh(mesh: Any, skeleton: Any, count: int, shapes: list[str]) -> None:
    """Bind a mesh to the skeleton's joint and to the blend shapes below it.

    Args:
        mesh: The mesh prim.
        skeleton: The skeleton.
        count: Number of points.
        shapes: Names of the blend shapes, children of the mesh prim.
    """
    binding = pxr("UsdSkel").BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    binding.CreateGeomBindTransformAttr(pxr("Gf").Matrix4d(1.0))
    # one influence a point: a constant one is allowed, but not all importers know it
    binding.CreateJointIndicesPrimvar(constant=False, elementSize=1).Set(
        pxr("Vt").IntArray(count, 0)
    )
    binding.CreateJointWeightsPrimvar(constant=False, elementSize=1).Set(
        pxr("Vt").FloatArray(count, 1.0)
    )
    binding.CreateBlendShapesAttr(shapes)
    binding.CreateBlendShapeTargetsRel().SetTargets(
        [mesh.GetPath().AppendChild(shape) for shape in shapes]
    )


def define_animation(
    stage: Any,
    place: str,
    skeleton: Any,
    shapes: list[str],
    animation: WeightAnimation | None,
    fps: float,
) -> None:
    """The weights of the blend shapes: all at rest, or over time.

    Args:
        stage: The stage; its time range is set where there is an animation.
        place: Path of the prim.
        skeleton: The skeleton that plays it.
        shapes: Names of the blend shapes.
        animation: Weights over time, if any.
        fps: Time codes in a second.
    """
    gf, values = pxr("Gf"), pxr("Vt")
    prim = pxr("UsdSkel").Animation.Define(stage, place)
    prim.CreateJointsAttr([_JOINT])
    prim.CreateTranslationsAttr([gf.Vec3f(0.0)])
    prim.CreateRotationsAttr([gf.Quatf(1.0)])
    prim.CreateScalesAttr([gf.Vec3h(1.0)])
    prim.CreateBlendShapesAttr(shapes)
    weights = prim.CreateBlendShapeWeightsAttr(values.FloatArray(len(shapes), 0.0))
    pxr("UsdSkel").BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets(
        [prim.GetPath()]
    )
    stage.SetTimeCodesPerSecond(fps)
    stage.SetFramesPerSecond(fps)
    if animation is None:
        return
    prim.GetPrim().SetDisplayName(animation.name)
    codes = animation.times * fps
    near = np.round(codes)
    codes = np.where(np.abs(codes - near) < 1e-6, near, codes)  # 7 / 30 · 30 is not quite 7
    for code, row in zip(codes.tolist(), animation.weights.astype(np.float32), strict=True):
        weights.Set(values.FloatArray.FromNumpy(row), code)
    stage.SetStartTimeCode(float(codes[0]))
    stage.SetEndTimeCode(float(codes[-1]))
