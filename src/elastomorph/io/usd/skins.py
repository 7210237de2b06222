"""Where a mesh stands at rest: by its transform, or by the joints of a skeleton.

UsdSkel puts a point at p · G · Σ_j w_j (B_j⁻¹ R_j) · S, with the weights w of the point and rows on
the left: G is the transform in which the mesh was bound, B_j and R_j are those of the joints as
bound and at rest, in the space of the skeleton, and S is the transform of the skeleton. Mostly the
joints rest where they were bound, and B_j⁻¹ R_j is the identity.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.isolated import RefusedError
from elastomorph.io.skinning import blended_matrices, common_matrix
from elastomorph.io.usd.library import pxr


def place_at_rest(prim: Any, points: int) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    """The (4, 4) matrix from a mesh of so many points to the world, in which rows are multiplied.

    Where joints hold the points differently, also (N, 4, 3) that come first, one a point.
    """
    geometry, binding = pxr("UsdGeom"), pxr("UsdSkel").BindingAPI(prim)
    cache = geometry.XformCache(pxr("Usd").TimeCode.EarliestTime())
    skeleton = binding.GetInheritedSkeleton()
    if not skeleton or not binding.GetJointIndicesPrimvar().HasAuthoredValue():
        return np.array(cache.GetLocalToWorldTransform(prim)), None
    given = _value(binding.GetGeomBindTransformAttr())
    bound = np.eye(4) if given is None else np.array(given)
    world = np.array(cache.GetLocalToWorldTransform(skeleton.GetPrim()))
    held = _held(skeleton)
    common = None if held is None else common_matrix(held)
    if held is None or common is not None:
        return (bound if common is None else bound @ common) @ world, None
    joints, weights = _influences(prim, binding, skeleton, points)
    used = np.unique(joints[weights > 0])
    if not used.size:
        return bound @ world, None
    if (common := common_matrix(held[used])) is not None:
        return bound @ common @ world, None
    return world, np.asarray((bound @ blended_matrices(held, joints, weights))[..., :3])


def _held(skeleton: Any) -> NDArray[np.float64] | None:
    """(J, 4, 4) what each joint does at rest; None where the skeleton does not say all of it."""
    names = list(_value(skeleton.GetJointsAttr()) or [])
    found = [_value(skeleton.GetBindTransformsAttr()), _value(skeleton.GetRestTransformsAttr())]
    if not names or any(own is None or len(own) != len(names) for own in found):
        return None
    bind, local = (np.array(own, dtype=np.float64).reshape(-1, 4, 4) for own in found)
    parents = pxr("UsdSkel").Topology(names).GetParentIndices()
    rest = local.copy()
    for joint, parent in enumerate(parents):
        if not parent < joint:
            return None  # UsdSkel plays no skeleton in which a joint comes before its parent
        if parent >= 0:
            rest[joint] = local[joint] @ rest[parent]
    try:
        held = np.linalg.inv(bind) @ rest
    except np.linalg.LinAlgError:
        return None
    return held if np.isfinite(held).all() else None


def _influences(
    prim: Any, binding: Any, skeleton: Any, points: int
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """(N, K) joints of the skeleton that hold each point, and their weights, whose sums are 1."""
    path = prim.GetPath()
    indices, amounts = binding.GetJointIndicesPrimvar(), binding.GetJointWeightsPrimvar()
    numbers = np.array(indices.ComputeFlattened() or [], dtype=np.int64)
    weights = np.array(amounts.ComputeFlattened() or [], dtype=np.float64)
    rigid = str(indices.GetInterpolation()) == "constant"
    rows, width = (1 if rigid else points), max(indices.GetElementSize(), 1)
    if not numbers.size == weights.size == rows * width:
        raise RefusedError(
            f"{path} has {numbers.size:,} joint indices and {weights.size:,} joint weights, "
            f"expected {rows * width:,} for {points:,} points; export it again with its skin"
        )
    known = list(_value(skeleton.GetJointsAttr()))
    order = np.arange(len(known))
    named = _value(binding.GetJointsAttr())
    if named is not None and len(named):
        missing = next((name for name in named if name not in known), None)
        if missing is not None:
            raise RefusedError(
                f"{path} is held by the joint '{str(missing)[:60]}', which its skeleton "
                f"{skeleton.GetPath()} has not; export it again with its skeleton"
            )
        order = np.array([known.index(name) for name in named])
    if numbers.size and not 0 <= numbers.min() <= numbers.max() < len(order):
        raise RefusedError(
            f"{path} is held by joints {numbers.min():,} to {numbers.max():,}, but there are "
            f"{len(order):,}; export it again with its skeleton"
        )
    if not np.isfinite(weights).all() or (weights < 0).any():
        raise RefusedError(f"the joint weights of {path} are no numbers from 0")
    amount = np.broadcast_to(weights.reshape(rows, width), (points, width))
    total = amount.sum(axis=1, keepdims=True)
    if (total <= 0).any():
        raise RefusedError(f"{path} has points that no joint holds; export it again with its skin")
    return order[np.broadcast_to(numbers.reshape(rows, width), (points, width))], amount / total


def _value(attribute: Any) -> Any:
    return attribute.Get() if attribute else None
