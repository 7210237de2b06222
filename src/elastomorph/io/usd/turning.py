"""A head that turns, in USD: the joint that holds the face turns about the neck."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.usd.library import pxr
from elastomorph.rig.performance import HeadTurn, head_quaternions


def turn_joint(
    stage: Any, place: str, skeleton: Any, turn: HeadTurn, codes: NDArray[np.float64]
) -> None:
    """Turn the one joint of a skeleton by its animation at this place, a key at each time code.

    The joint is bound in the neck and rests there, so that nothing else moves.
    """
    gf, values = pxr("Gf"), pxr("Vt")
    at = gf.Vec3f(*turn.pivot.tolist())
    neck = gf.Matrix4d(1.0).SetTranslate(gf.Vec3d(at))
    bound = values.Matrix4dArray(1, neck)
    skeleton.GetBindTransformsAttr().Set(bound)
    skeleton.GetRestTransformsAttr().Set(bound)
    animation = pxr("UsdSkel").Animation.Get(stage, place)
    animation.GetTranslationsAttr().Set([at])
    rotations = animation.GetRotationsAttr()
    for code, (x, y, z, w) in zip(
        codes.tolist(), head_quaternions(turn.angles).tolist(), strict=True
    ):
        rotations.Set(values.QuatfArray(1, gf.Quatf(w, x, y, z)), code)
