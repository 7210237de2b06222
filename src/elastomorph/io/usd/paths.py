"""The path of a blend shape that was read: the exact one, or straight pieces between in-betweens.

UsdSkel plays V₀ + Π(t), straight from in-between to in-between: with offsets Y_i at weights w_i,

    V(t) = V₀ + tΔ + Σ_i h_i(t) (Y_i - w_i Δ)        h_i(w_j) = δ_ij, linear between the weights

which is a path with one bend an in-between. Beyond 0 and 1 both go straight on.
"""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ElastomorphWarning, FormatError
from elastomorph.io.untrusted import naming_file
from elastomorph.io.usd.exact import checksum, path_from_json
from elastomorph.io.usd.scene import FoundShape
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph

__all__ = ["hat", "morph_of", "values_needed"]

_CLOSE = 1e-6  # UsdSkel passes over in-betweens nearer than this to 0 and 1


def values_needed(shape: FoundShape) -> int:
    """How many displacement fields the morph of a shape will have, at most."""
    bends = len(shape.bends) // max(len(shape.points), 1)
    return 2 + max(bends, len(shape.weights))


def morph_of(path: str | Path, neutral: Mesh, name: str, shape: FoundShape) -> Morph:
    """The morph of a blend shape.

    Raises:
        FormatError: Two in-betweens have the same weight and are not the same.
    """
    delta = _spread(neutral, shape.points, shape.offsets[0])
    with naming_file(path):
        target = neutral.with_vertices(neutral.vertices + delta)
        if shape.path is not None:
            exact = _exact(neutral, target, shape)
            if exact is not None:
                return exact
            warnings.warn(
                f"{path}: the blend shape '{name}' was changed since elastomorph wrote it; its "
                "in-betweens are read instead of its curved path",
                ElastomorphWarning,
                stacklevel=4,
            )
        weights, rows = _inner(path, name, shape)
        bends = np.zeros((len(weights), *delta.shape))
        for bend, weight, row in zip(bends, weights, rows, strict=True):
            bend[:] = _spread(neutral, shape.points, shape.offsets[1 + row]) - weight * delta
        curves = tuple(hat(weights, i) for i in range(len(weights)))
        method = "inbetweens" if curves else "linear"
        return Morph(neutral, target, bends, curves, method=method, bare=not curves)


def hat(weights: NDArray[np.float64], i: int) -> BendCurve:
    """The curve that is 1 at one weight, 0 at the others and at 0 and 1, and linear between.

    Args:
        weights: (n,) rising between 0 and 1.
        i: Which of them.
    """
    knots = np.concatenate([[0.0], weights, [1.0]])
    before, peak, after = knots[i : i + 3]
    breaks = np.unique([0.0, before, peak, after, 1.0])
    coefficients = np.zeros((len(breaks) - 1, 2))
    place = int(np.searchsorted(breaks, before))
    coefficients[place] = (0.0, 1 / (peak - before))
    coefficients[place + 1] = (1.0, -1 / (after - peak))
    return BendCurve(breaks, coefficients)


def _exact(neutral: Mesh, target: Mesh, shape: FoundShape) -> Morph | None:
    """The morph that elastomorph stored, unless the shapes are no longer those it belongs to."""
    stored = path_from_json(shape.path or "")
    order = np.argsort(shape.weights)
    shapes = shape.offsets[np.concatenate([[0], 1 + order])]
    own = checksum(
        [
            shape.points.astype(np.int32),
            shapes.astype(np.float32),
            shape.weights[order].astype(np.float32),
        ]
    )
    if stored is None or stored.checksum != own:
        return None
    if len(shape.bends) != len(stored.curves) * len(shape.points):
        return None
    bends = np.zeros((len(stored.curves), *neutral.vertices.shape))
    bends[:, shape.points] = shape.bends.reshape(len(bends), len(shape.points), 3)
    return Morph(
        neutral,
        target,
        bends,
        stored.curves,
        method=stored.method,
        limit_law=stored.limit_law,
        bake_error=stored.bake_error,
        choice=stored.choice,
    )


def _inner(path: str | Path, name: str, shape: FoundShape) -> tuple[NDArray[np.float64], list[int]]:
    """Rising weights between 0 and 1, and which in-between each is."""
    order = np.argsort(shape.weights, kind="stable").tolist()
    kept: list[int] = []
    for row in order:
        weight = shape.weights[row]
        if not _CLOSE < weight < 1 - _CLOSE:
            warnings.warn(
                f"{path}: the blend shape '{name}' has an in-between at the weight {weight:g}, "
                "which is not between 0 and 1; it is left out",
                ElastomorphWarning,
                stacklevel=5,
            )
        elif kept and weight - shape.weights[kept[-1]] <= _CLOSE:
            if not np.array_equal(shape.offsets[1 + row], shape.offsets[1 + kept[-1]]):
                raise FormatError(
                    path,
                    f"the blend shape '{name}' has two different in-betweens at the weight "
                    f"{weight:g}; remove one of them",
                )
        else:
            kept.append(row)
    return shape.weights[kept], kept


def _spread(
    neutral: Mesh, points: NDArray[np.int64], offsets: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(V, 3) from offsets of some points; a point named twice moves by both, as in UsdSkel."""
    field = np.zeros(neutral.vertices.shape)
    np.add.at(field, points, offsets)
    return field
