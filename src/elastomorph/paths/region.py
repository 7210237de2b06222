"""Interpolate part of a face: a method inside a region, a plain path outside, no jump between."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.curves import CurveNetwork, region_weights
from elastomorph.errors import ParameterError
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph

__all__ = ["RESTS", "blend_into_rest", "curve_edges", "weights_inside"]

RESTS = ("linear", "neutral")


def curve_edges(curves: CurveNetwork) -> NDArray[np.int32]:
    """(E, 2) edges between neighbours on a curve, for meshes without polygons."""
    return np.concatenate([np.zeros((0, 2), np.int32), *(curve.edges for curve in curves)])


def weights_inside(
    neutral: Mesh, curves: CurveNetwork, region: ArrayLike, falloff: float
) -> NDArray[np.float64]:
    """(V,) from 0 outside a region to 1 from ``falloff`` rings of edges inwards.

    Args:
        neutral: The mesh.
        curves: They stand in for edges on a mesh without polygons.
        region: (N,) vertex indices, or (V,) bool.
        falloff: Rings of edges.

    Raises:
        CurveError: The region names a vertex that does not exist.
        ParameterError: The region is empty, or the falloff out of its range.
    """
    edges = neutral.edges if len(neutral.faces) else curve_edges(curves)
    weights = region_weights(edges, len(neutral.vertices), region, falloff)
    if not weights.any():
        raise ParameterError("the region is empty: name at least one vertex")
    return weights


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
