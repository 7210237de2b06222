"""Pixar's USD library, imported when the first USD file is met, and our own attributes in files.

Next to the offsets that UsdSkel plays, each BlendShape prim carries attributes of our own:

    elastomorph:name     string      the name of the morph, as the rig has it
    elastomorph:path     string      JSON: method, choice, errors, bend curves, limit law, checksum
    elastomorph:bends    vector3f[]  (K·N) bends, one after another, on the N points of the shape
                         vector3d[]  the same, where float32 is too coarse

and the mesh prim

    elastomorph:sliders  string      JSON: morphs in order, correctives, groups, checksum
    elastomorph:points   double3[]   the vertices, where float32 is too coarse
    elastomorph:settings string      JSON: the settings of the character, where there were any
    elastomorph:copyright string     whose it is, where that is known; the layer's comment too

Attributes, not customData: they are typed and compressed, and survive flattening and layering.

Correctives are lists of drivers, whose product drives a shape, or objects as `Corrective.entry`
gives them. A layer of bends has `elastomorph:sliders` of the meshes to which it adds shapes.

A layer that `elastomorph.bend` has put over a file says so in its ``customLayerData``:

    elastomorph          dictionary  version, of the original its path as sublayer and SHA-256,
                                     and the tolerance of the in-betweens, as a fraction of D
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from math import inf
from pathlib import Path
from typing import Any, NamedTuple

from elastomorph.errors import FileError, MissingExtraError

NAME = "elastomorph:name"
PATH = "elastomorph:path"
BENDS = "elastomorph:bends"
POINTS = "elastomorph:points"
SLIDERS = "elastomorph:sliders"
SETTINGS = "elastomorph:settings"
COPYRIGHT = "elastomorph:copyright"
ROOT = "--root="
STILL = "--still"
"""In place of names of meshes, which these cannot be: the folder in which all files must lie, and
that meshes without blend shapes are read too."""
ROOT_VARIABLE = "ELASTOMORPH_USD_ROOT"
"""The environment variable that names that folder for all readers, and for those in processes."""
GROUP_FAMILY = "elastomorph:group"
LAYER = "elastomorph"
LAYER_VERSION = 1


class Original(NamedTuple):
    """What a layer of bends lies over."""

    asset: str  # Its path, as the layer names it
    digest: str  # SHA-256 of its content
    tolerance: float | None  # Of the in-betweens of the layer, as a fraction of D, if it says so


def original_in(layer: Any) -> Original | None:
    """The original that a layer of bends lies over; None of any other layer."""
    said = layer.customLayerData.get(LAYER)
    if not isinstance(said, dict) or list(layer.subLayerPaths) != [said.get("original")]:
        return None
    tolerance = said.get("tolerance")
    stated = tolerance if isinstance(tolerance, float) and 0 < tolerance < inf else None
    return Original(str(said["original"]), str(said.get("sha256")), stated)


def pxr(module: str) -> Any:
    """A module of USD, such as ``UsdSkel``; a MissingExtraError where usd-core is missing."""
    try:
        return import_module(f"pxr.{module}")
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] != "pxr":
            raise
        raise MissingExtraError("usd-core", "usd") from None


@contextmanager
def naming_failure(path: str | Path) -> Iterator[None]:
    """Raise a FileError where USD cannot write a file."""
    failure = pxr("Tf").ErrorException
    try:
        yield
    except failure as error:
        reasons = [getattr(part, "commentary", str(part)) for part in error.args]
        raise FileError(path, f"the file cannot be written: {'; '.join(reasons)}") from error
