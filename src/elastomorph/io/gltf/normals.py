"""Vertex normals and how they turn with a morph.

A normal is the angle-weighted mean of the polygons around a vertex, taken on the mesh before it is
split along texture seams, so both sides of a seam are lit alike.

glTF adds normals as it adds positions, n₀ + tδ + Σ_k b_k(t) d_k, and viewers scale the sum to unit
length. δ = n(V₁) - n(V₀) makes both ends right. The d_k are the least-squares fit of what is
missing in between, over Chebyshev nodes t_i of [0, 1]:

    min Σ_i ‖ Σ_k b_k(t_i) d_k - (n(V(t_i)) - n₀ - t_i δ) ‖²

for each vertex. The b_k are the same for all vertices, so this is one small pseudo-inverse. A fit
over all of [0, 1] stays closer on the whole than making the sum right only at the moment where a
bend is largest; the tests measure the angles that are left at a quarter, half and three quarters.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.morph import Morph
from elastomorph.model.polygons import Polygons

# A bend that moves vertices less than this fraction of D turns no normal: what a fit would find
# for it is rounding over nothing.
_NOTHING = 1e-12

_UP = (0.0, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class NormalField:
    """The corners that vertex normals are summed over."""

    before: NDArray[np.int32]  # (C,) vertex before each corner
    at: NDArray[np.int32]  # (C,) vertex of each corner
    after: NDArray[np.int32]  # (C,) vertex after each corner

    @classmethod
    def of(cls, faces: Polygons) -> NormalField:
        """The corners of all polygons."""
        after = faces.next_corners
        before = np.empty_like(after)
        before[after] = np.arange(len(after))
        return cls(faces.indices[before], faces.indices, faces.indices[after])

    def normals(self, vertices: NDArray[np.float64]) -> NDArray[np.float64]:
        """(V, 3) unit normals of the vertices; (0, 0, 1) where there is no area around one."""
        here = vertices[self.at]
        to_next, to_last = vertices[self.after] - here, vertices[self.before] - here
        normal = np.cross(to_next, to_last)
        length = np.linalg.norm(normal, axis=1)
        angle = np.arctan2(length, np.einsum("ij,ij->i", to_next, to_last))
        weight = np.divide(angle, length, out=np.zeros_like(angle), where=length > 0)
        summed = np.stack(
            [
                np.bincount(self.at, weights=weight * normal[:, axis], minlength=len(vertices))
                for axis in range(3)
            ],
            axis=1,
        ).astype(np.float64)
        length = np.linalg.norm(summed, axis=1, keepdims=True)
        # Where polygons back on each other cancel, what is left is rounding and no direction.
        solid = length > 1e-9
        return np.where(solid, summed / np.where(solid, length, 1.0), _UP)


def normal_deltas(
    field: NormalField,
    morph: Morph,
    bends: Sequence[int],
    neutral_normals: NDArray[np.float64],
) -> NDArray[np.float64]:
    """(1 + bends, V, 3) what Δ and some bends of a morph add to (V, 3) normals n₀: δ and d_k."""
    delta = field.normals(morph.target.vertices) - neutral_normals
    if not bends:
        return delta[None]
    times = _nodes(len(bends) + 3)
    curves: list[BendCurve] = [morph.bend_curves[k] for k in bends]
    weights = np.stack([curve(times) for curve in curves], axis=1)
    missing = np.stack([field.normals(shape) for shape in morph.at(times)])
    missing -= neutral_normals + times[:, None, None] * delta
    reach = np.abs(weights).max(axis=0) * np.abs(morph.bends[list(bends)]).max(axis=(1, 2))
    turns = reach > _NOTHING * (morph.neutral.diameter or 1.0)
    fitted = np.zeros((len(bends), *delta.shape))
    fitted[turns] = np.tensordot(np.linalg.pinv(weights[:, turns]), missing, axes=1)
    return np.concatenate([delta[None], fitted])


def _nodes(count: int) -> NDArray[np.float64]:
    return np.asarray((1 - np.cos(np.pi * (np.arange(count) + 0.5) / count)) / 2)
