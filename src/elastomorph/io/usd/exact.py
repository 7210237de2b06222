"""What UsdSkel has no word for, as text: the curved paths themselves, and names.

Where another program has changed the shapes, the checksum no longer fits, and what it has written
counts: our attributes (see `elastomorph.io.usd.library`) are then passed over.
"""

from __future__ import annotations

import json
import re
import zlib
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.blend_shapes import curve_from_json, curve_to_json, different_names
from elastomorph.io.choices import choice_from_json, choice_to_json
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.morph import Morph

_VERSION = 1


class ExactPath(NamedTuple):
    """All of a morph but its shapes: their checksum, K bend curves, and arguments of `Morph`."""

    checksum: int
    curves: tuple[BendCurve, ...]
    more: dict[str, Any]


def checksum(arrays: Iterable[NDArray[Any]]) -> int:
    """One number that changes when any of the arrays does."""
    total = 0
    for array in arrays:
        total = zlib.crc32(repr(array.shape).encode(), total)
        total = zlib.crc32(np.ascontiguousarray(array).tobytes(), total)
    return total


def prim_names(names: Iterable[str], taken: Iterable[str] = ()) -> list[str]:
    """A valid prim name for each name, all different, and none of those that are taken.

    Letters of other alphabets become underscores too: USD allows them only since 2024, and many
    programs still refuse them.
    """
    plain = (re.sub(r"[^A-Za-z0-9_]", "_", name) or "_" for name in names)
    valid = (f"_{name}" if name[0].isdecimal() else name for name in plain)
    return different_names(valid, first=1, taken=set(taken))


def path_to_json(
    morph: Morph,
    shapes_checksum: int,
    *,
    curves: Sequence[BendCurve] | None = None,
    bake_error: float | None = None,
) -> str:
    """The path of a morph as text; its numbers come back to the last bit.

    Curves and error are those of the morph, unless a mesh of it has its own.
    """
    return json.dumps(
        {
            "version": _VERSION,
            "method": morph.method,
            "bakeError": float(morph.bake_error if bake_error is None else bake_error),
            "bendCurves": [
                curve_to_json(curve) for curve in (morph.bend_curves if curves is None else curves)
            ],
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
