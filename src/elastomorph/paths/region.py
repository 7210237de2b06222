"""Interpolate part of a face: a method inside a region, a plain path outside, no jump between."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork
from elastomorph.errors import ParameterError
from elastomorph.mesh import Mesh
from elastomorph.morph import Morph

__all__ = ["RESTS", "blend_into_rest", "curve_edges"]

RESTS = ("linear", "neutral")


def curve_edges(curves: CurveNetwork) -> NDArray[np.int32]:
    """(E, 2) edges between neighbours on a curve, for meshes without polygons."""
    return np.concatenate([np.zeros((0, 2), np.int32), *(curve.edges for curve in curves)])


def blend_into_rest(
    prepared: Callable[[Mesh], Morph],
    weights: NDArray[np.float64],
    rest: str,
) -> Callable[[Mesh], Morph]:
    """Fade a path out towards the border of a region.

    Args:
        prepared: A function from target to path on the whole mesh.
        weights: (V,) from 0 outside the region to 1 inside.
        rest: What the other vertices do: ``linear``, straight to the target; ``neutral``, nothing:
            the whole motion fades out, so the path ends at a target that is blended too.

    Raises:
        ParameterError: `rest` is unknown.
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
