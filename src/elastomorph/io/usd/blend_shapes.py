"""A morph as a UsdSkel.BlendShape prim: sparse offsets, in-betweens, and the exact path."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.usd.exact import BENDS, COARSEST, NAME, PATH, checksum, path_to_json
from elastomorph.io.usd.inbetweens import Placement
from elastomorph.io.usd.library import pxr
from elastomorph.io.usd.mesh_prim import as_float32
from elastomorph.model.morph import Morph
from elastomorph.rig.fields import MorphFields

__all__ = ["SparseShapes", "define_blend_shape", "sparse_shapes"]


@dataclass(frozen=True, eq=False)
class SparseShapes:
    """The shapes that UsdSkel plays, on the points that any of them moves.

    Attributes:
        points: (N,) int32 rising, N ≥ 1.
        offsets: (1 + n, N, 3) float32 from the neutral: the target, then the in-betweens.
        weights: (n,) float32 of the in-betweens, rising.
    """

    points: NDArray[np.int32]
    offsets: NDArray[np.float32]
    weights: NDArray[np.float32]

    @property
    def checksum(self) -> int:
        """Changes when another program changes the shapes."""
        return checksum([self.points, self.offsets, self.weights])


def sparse_shapes(path: str | Path, morph: Morph, placement: Placement) -> SparseShapes:
    """The shapes of a morph at 1 and at its in-betweens.

    Vertices that move less than 1e-7 of D all along the path stay where they are.

    Raises:
        FormatError: An offset is too large for float32.
    """
    fields = MorphFields.of(morph)
    reach = np.concatenate([[1.0], _heights(morph)]) @ np.linalg.norm(fields.fields, axis=2)
    # the noise of scans and solvers below float32 would make most points of a face move
    points = fields.moved[reach > COARSEST * morph.neutral.diameter]
    if not points.size:
        points = np.zeros(1, dtype=np.int32)  # no point at all would mean every point to UsdSkel
    times = np.concatenate([[1.0], placement.weights])
    rows = np.concatenate([morph.delta[None, points], morph.bends[:, points]])
    offsets = np.tensordot(fields.factors(times), rows, axes=1)
    return SparseShapes(
        points,
        as_float32(path, offsets, "an offset"),
        placement.weights.astype(np.float32),
    )


def define_blend_shape(
    path: str | Path, stage: Any, place: str, name: str, morph: Morph, shapes: SparseShapes
) -> None:
    """A BlendShape prim.

    Args:
        path: The file, for messages.
        stage: The stage.
        place: Path of the prim.
        name: Name of the morph.
        morph: The morph.
        shapes: Its shapes.

    Raises:
        FormatError: A bend is too large for float32.
    """
    values, value_types = pxr("Vt"), pxr("Sdf").ValueTypeNames
    shape = pxr("UsdSkel").BlendShape.Define(stage, place)
    vectors = [values.Vec3fArray.FromNumpy(own) for own in shapes.offsets]
    shape.CreateOffsetsAttr(vectors[0])
    shape.CreatePointIndicesAttr(values.IntArray.FromNumpy(shapes.points))
    for weight, own in zip(shapes.weights.tolist(), vectors[1:], strict=True):
        # at least four digits, so that the names sort as the weights do
        digits = f"{weight:.9f}"[2:].rstrip("0").ljust(4, "0")
        inbetween = shape.CreateInbetween(f"at_{digits}")
        inbetween.SetWeight(weight)
        inbetween.SetOffsets(own)
    prim = shape.GetPrim()
    prim.SetDisplayName(name)
    prim.CreateAttribute(NAME, value_types.String, custom=True).Set(name)
    prim.CreateAttribute(PATH, value_types.String, custom=True).Set(
        path_to_json(morph, shapes.checksum)
    )
    bends = morph.bends[:, shapes.points]
    if not bends.size:
        return
    coarse = as_float32(path, bends, "a bend")
    if _rounding(morph, bends - coarse) <= COARSEST * morph.neutral.diameter:
        single = prim.CreateAttribute(BENDS, value_types.Vector3fArray, custom=True)
        single.Set(values.Vec3fArray.FromNumpy(coarse.reshape(-1, 3)))
    else:
        double = prim.CreateAttribute(BENDS, value_types.Vector3dArray, custom=True)
        double.Set(values.Vec3dArray.FromNumpy(bends.reshape(-1, 3)))


def _rounding(morph: Morph, errors: NDArray[np.float64]) -> float:
    """A bound of how far rounded bends move the path: bends of a bake cancel each other."""
    return float((_heights(morph) @ np.linalg.norm(errors, axis=2)).max())


def _heights(morph: Morph) -> NDArray[np.float64]:
    """(K,) the largest value of each bend curve."""
    times = np.linspace(0.0, 1.0, 65)
    return np.array([np.abs(curve(times)).max() for curve in morph.bend_curves])
