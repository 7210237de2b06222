"""Interpolate part of a face: a method inside a region, a plain path outside, no jump between."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.curves import CurveNetwork
from elastomorph.errors import ParameterError
from elastomorph.mesh import Mesh
from elastomorph.morph import Morph

__all__ = ["RESTS", "as_region", "blend_into_rest", "curve_edges"]

RESTS = ("linear", "neutral")


def as_region(region: ArrayLike, vertex_count: int) -> NDArray[np.int64]:
    """The vertices of a region, each once and in order.

    Raises:
        ParameterError: Not vertex indices of the mesh, or none.
    """
    indices = np.atleast_1d(np.asarray(region))
    if indices.ndim != 1 or indices.size == 0 or not np.issubdtype(indices.dtype, np.integer):
        raise ParameterError("a region must be a list of vertex indices with at least one entry")
    bad = indices[(indices < 0) | (indices >= vertex_count)]
    if bad.size:
        raise ParameterError(
            f"the region names vertex {bad[0]}, but the mesh has {vertex_count:,} vertices "
            f"(0 to {vertex_count - 1:,})"
        )
    return np.unique(indices).astype(np.int64)


def curve_edges(curves: CurveNetwork) -> NDArray[np.int32]:
    """(E, 2) edges between neighbours on a curve, for meshes without polygons."""
    pairs = [np.zeros((0, 2), dtype=np.int32)]
    for curve in curves:
        following = np.roll(curve.vertices, -1) if curve.closed else curve.vertices[1:]
        pairs.append(np.stack([curve.vertices[: len(following)], following], axis=1))
    return np.concatenate(pairs)


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
