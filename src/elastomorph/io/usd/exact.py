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
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.blend_shapes import curve_from_json, curve_to_json
from elastomorph.io.choices import choice_from_json, choice_to_json
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.morph import Morph

__all__ = [
    "BENDS",
    "COARSEST",
    "GROUP_FAMILY",
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
GROUP_FAMILY = "elastomorph:group"
COARSEST = 1e-7  # of D: a rounding to float32 larger than this is not accepted
_VERSION = 1


@dataclass(frozen=True, eq=False)
class ExactPath:
    """All of a morph but its shapes.

    Attributes:
        checksum: Of the shapes that belong to it.
        curves: K bend curves.
        more: Further arguments of `Morph`.
    """

    checksum: int
    curves: tuple[BendCurve, ...]
    more: Mapping[str, Any]


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
            "bendCurves": [curve_to_json(curve) for curve in morph.bend_curves],
            "limitLaw": curve_to_json(morph.limit_law),
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
        more = {
            "method": str(content["method"]),
            "bake_error": error,
            "limit_law": curve_from_json(content["limitLaw"]),
            "choice": choice_from_json(content.get("choice")),
        }
        curves = tuple(curve_from_json(curve) for curve in content["bendCurves"])
        return ExactPath(int(content["checksum"]), curves, more)
    except (ValueError, TypeError, LookupError, OverflowError, RecursionError):
        return None
