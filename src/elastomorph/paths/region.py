"""Parts of a face with paths of their own, without a jump.

A method inside a region and a plain path outside; or one path laid over part of another, such as a
jaw that turns under a face that is elastic.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.curves import CurveNetwork, region_weights
from elastomorph.errors import ParameterError
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph

RESTS = ("linear", "neutral")


def curve_edges(curves: CurveNetwork) -> NDArray[np.int32]:
    """(E, 2) edges between neighbours on a curve, for meshes without polygons."""
    return np.concatenate([np.zeros((0, 2), np.int32), *(curve.edges for curve in curves)])


def weights_inside(
    neutral: Mesh, curves: CurveNetwork, region: ArrayLike, falloff: float
) -> NDArray[np.float64]:
    """(V,) from 0 outside a region to 1 from ``falloff`` rings of edges, or of curves, inwards."""
    edges = neutral.edges if len(neutral.faces) else curve_edges(curves)
    weights = region_weights(edges, len(neutral.vertices), region, falloff)
    if not weights.any():
        raise ParameterError("the region is empty: name at least one vertex")
    return weights


def blend_into_rest(
    prepared: Callable[[Mesh], Morph], weights: NDArray[np.float64], rest: str
) -> Callable[[Mesh], Morph]:
    """Fade a path out where (V,) weights fall from 1 inside a region to 0.

    What is outside goes straight to the target; with the rest ``neutral`` it does not move: the
    whole motion fades out, and the path ends at a target that is blended too.
    """
    if rest not in RESTS:
        raise ParameterError(f"rest must be one of {', '.join(RESTS)}, found {rest!r}")
    share = weights[:, None]

    def to(target: Mesh) -> Morph:
        morph = prepared(target)
        if rest == "neutral":
            start, end = morph.neutral.vertices, target.vertices
            blended = np.where(share == 1, end, start + share * (end - start))
            target = target.with_vertices(blended)
        return replace(morph, target=target, bends=morph.bends * share)

    return to


def laid_over(below: Morph, above: Morph, weights: NDArray[np.float64], label: str) -> Morph:
    """A path that follows another one where weights are 1.

    Both have the same Δ and differ in their bends alone. With weights s from 0 to 1,

        V(t) = V₀ + tΔ + Σ_k b_k(t) (1 - s) D_k + Σ_k c_k(t) s E_k

    is exact at both ends and has no jump where s has none. Bends of one curve become one; those of
    the path above are whole, not faded out already.
    """
    for one, other in ((below.neutral, above.neutral), (below.target, above.target)):
        if not np.array_equal(one.vertices, other.vertices):
            raise ParameterError("only paths between the same two shapes can be laid over")
    share = weights[:, None]
    curves: list[BendCurve] = []
    bends: list[NDArray[np.float64]] = []
    for morph, part in ((below, 1.0 - share), (above, share)):
        for curve, bend in zip(morph.bend_curves, morph.bends, strict=True):
            place = next((i for i, own in enumerate(curves) if _same(own, curve)), None)
            if place is None:
                curves.append(curve)
                bends.append(part * bend)
            else:
                bends[place] += part * bend
    stacked = np.stack(bends) if bends else np.zeros((0, *below.neutral.vertices.shape))
    return replace(
        below,
        bends=stacked,
        bend_curves=tuple(curves),
        method=label,
        bake_error=max(below.bake_error, above.bake_error),
    )


def _same(one: BendCurve, other: BendCurve) -> bool:
    return np.array_equal(one.breaks, other.breaks) and np.array_equal(
        one.coefficients, other.coefficients
    )
