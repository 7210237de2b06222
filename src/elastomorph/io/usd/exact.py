"""What UsdSkel has no word for: the curved paths themselves, so that a rig comes back as it was.

Next to the offsets that UsdSkel plays, each BlendShape prim carries attributes of our own:

    elastomorph:name     string      the name of the morph, as the rig has it
    elastomorph:path     string      JSON: method, choice, errors, bend curves, limit law, checksum
    elastomorph:bends    vector3f[]  (K·N) bends, one after another, on the N points of the shape
                         vector3d[]  the same, where float32 is too coarse

and the mesh prim

    elastomorph:sliders  string      JSON: morphs in order, correctives, groups, checksum
    elastomorph:points   double3[]   the vertices, where float32 is too coarse
    elastomorph:settings string      JSON: the settings of the character, where there were any

Attributes, not customData: they are typed and compressed, and survive flattening and layering.
Where another program has changed the shapes, the checksum no longer fits, and what it has written
counts: the attributes are then passed over.
"""

from __future__ import annotations

import json
import zlib
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.io.choices import choice_from_json, choice_to_json
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.morph import Choice, Morph

__all__ = [
    "BENDS",
    "COARSEST",
    "NAME",
    "PATH",
    "POINTS",
    "SETTINGS",
    "SLIDERS",
    "ExactPath",
    "checksum",
    "path_from_json",
    "path_to_json",
]

NAME = "elastomorph:name"
PATH = "elastomorph:path"
BENDS = "elastomorph:bends"
POINTS = "elastomorph:points"
SLIDERS = "elastomorph:sliders"
SETTINGS = "elastomorph:settings"
COARSEST = 1e-7  # of D: a rounding to float32 larger than this is not accepted
_VERSION = 1
_MOST_TERMS = 256


class ExactPath:
    """All of a morph but its shapes.

    Attributes:
        method: How the path was made.
        bake_error: As `Morph.bake_error`.
        curves: K bend curves.
        limit_law: As `Morph.limit_law`.
        checksum: Of the shapes that belong to it.
        choice: As `Morph.choice`.
    """

    def __init__(
        self,
        method: str,
        bake_error: float,
        curves: tuple[BendCurve, ...],
        limit_law: BendCurve,
        checksum: int,
        choice: Choice | None,
    ) -> None:
        self.method = method
        self.bake_error = bake_error
        self.curves = curves
        self.limit_law = limit_law
        self.checksum = checksum
        self.choice = choice


def checksum(arrays: Iterable[NDArray[Any]]) -> int:
    """One number that changes when any of the arrays does."""
    total = 0
    for array in arrays:
        total = zlib.crc32(repr(array.shape).encode(), total)
        total = zlib.crc32(np.ascontiguousarray(array).tobytes(), total)
    return total


def path_to_json(morph: Morph, shapes_checksum: int) -> str:
    """The path of a morph as text; its numbers come back to the last bit."""
    return json.dumps(
        {
            "version": _VERSION,
            "method": morph.method,
            "bakeError": float(morph.bake_error),
            "bendCurves": [_curve_to_json(curve) for curve in morph.bend_curves],
            "limitLaw": _curve_to_json(morph.limit_law),
            "choice": choice_to_json(morph.choice),
            "checksum": shapes_checksum,
        }
    )


def path_from_json(text: str) -> ExactPath | None:
    """The path in a text, or None where it is not one that this version can read."""
    try:
        content = json.loads(text)
        error = float(content["bakeError"])
        if content["version"] != _VERSION or not 0 <= error < np.inf:
            return None
        return ExactPath(
            str(content["method"]),
            error,
            tuple(_curve_from_json(curve) for curve in content["bendCurves"]),
            _curve_from_json(content["limitLaw"]),
            int(content["checksum"]),
            choice_from_json(content.get("choice")),
        )
    except (ValueError, TypeError, LookupError, OverflowError, RecursionError):
        return None


def _curve_to_json(curve: BendCurve) -> dict[str, Any]:
    return {"breaks": curve.breaks.tolist(), "coefficients": curve.coefficients.tolist()}


def _curve_from_json(content: Mapping[str, Any]) -> BendCurve:
    if len(content["coefficients"][0]) > _MOST_TERMS:
        raise ParameterError(f"a bend curve has more than {_MOST_TERMS} coefficients a piece")
    return BendCurve(
        np.array(content["breaks"], dtype=np.float64),
        np.array(content["coefficients"], dtype=np.float64),
    )
