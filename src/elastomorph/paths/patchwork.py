"""One path laid over part of another: a jaw that turns under a face that is elastic.

Both lead from the same neutral to the same target, so they share Δ and differ in their bends alone.
With weights s from 0 to 1,

    V(t) = V₀ + tΔ + Σ_k b_k(t) (1 - s) D_k + Σ_k c_k(t) s E_k

is exact at both ends and has no jump where s has none. Bends of one curve become one.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.morph import Morph

__all__ = ["laid_over"]


def laid_over(below: Morph, above: Morph, weights: NDArray[np.float64], label: str) -> Morph:
    """A path that follows another one where weights are 1.

    Args:
        below: The path where weights are 0.
        above: The path where weights are 1, between the same shapes; its bends are whole, not
            faded out already.
        weights: (V,) from 0 to 1.
        label: What the path is called.

    Raises:
        ParameterError: The paths do not lead from the same neutral to the same target.
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
