"""Writes a layer of bends: it sublayers a file, and overrides its blend shapes and nothing else."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from elastomorph.errors import FileError, FormatError
from elastomorph.io.atomic import replacing_path, same_file
from elastomorph.io.usd.bent_shape import BentShape
from elastomorph.io.usd.library import BENDS, LAYER, LAYER_VERSION, PATH, naming_failure, pxr
from elastomorph.io.usd.original import OriginalFile
from elastomorph.io.usd.prims import array_of_bends, inbetween_name
from elastomorph.io.usd.writer import SUFFIXES


def require_layer_path(path: str | Path) -> None:
    """Refuse a name that is none of a layer."""
    suffix = Path(path).suffix.lower()
    if suffix == ".usdz":
        raise FormatError(
            path,
            "a layer lies over a file beside it, which a package cannot name; write a .usda, or "
            "make a package of that with usdzip",
        )
    if suffix not in SUFFIXES:
        raise FormatError(path, f"expected a name that ends in {', '.join(SUFFIXES)}")


def write_layer(path: str | Path, original: OriginalFile, shapes: Iterable[BentShape]) -> int:
    """Write the layer over a file; its size in bytes.

    Raises:
        FormatError: Another suffix, or a path of the original that USD cannot hold.
        FileError: The file is one that the original is composed of, or cannot be written.
    """
    require_layer_path(path)
    require_other_file(path, original.path, original.files)
    with replacing_path(path) as temporary, naming_failure(path):
        layer = pxr("Sdf").Layer.CreateAnonymous(".usda")
        layer.ImportFromString(original.header)
        asset = _asset(path, original.path)
        layer.subLayerPaths.append(asset)
        layer.documentation = f"Bends of {original.path.name}, by elastomorph."
        said = {"version": LAYER_VERSION, "original": asset, "sha256": original.digest}
        layer.customLayerData = {**layer.customLayerData, LAYER: said}
        with pxr("Sdf").ChangeBlock():
            for shape in shapes:
                _override(layer, shape)
        _list_variants(layer, shapes)
        kind = "usda" if Path(path).suffix.lower() == ".usda" else "usdc"
        mode = temporary.stat().st_mode
        layer.Export(str(temporary), args={"format": kind})
        temporary.chmod(mode)
        return temporary.stat().st_size


def require_other_file(path: str | Path, original: Path, files: Iterable[Path]) -> None:
    """Refuse to write over a file that the original is composed of."""
    for own in files:
        if same_file(path, own):
            raise FileError(
                path,
                f"this file is a part of {original.name}, which bends lie over and never change; "
                "name another output",
            )


def _asset(path: str | Path, original: Path) -> str:
    """The original as the layer names it: from its own folder where there is a way."""
    try:
        way = os.path.relpath(original, Path(path).resolve().parent)
    except ValueError:  # another drive of Windows
        way = str(original)
    asset = Path(way).as_posix()
    if not asset.startswith(("../", "/")) and not Path(way).is_absolute():
        asset = f"./{asset}"
    if not asset.isprintable() or "@@@" in asset or asset.encode("utf-8", "replace") == b"":
        raise FormatError(
            path, f"USD cannot name its original, {original!r}, in a layer; rename that file first"
        )
    return asset


def _override(layer: Any, shape: BentShape) -> None:
    """What the layer says of one blend shape."""
    sdf, values = pxr("Sdf"), pxr("Vt")
    types, uniform = sdf.ValueTypeNames, sdf.VariabilityUniform
    spec = sdf.CreatePrimInLayer(layer, shape.original.place)

    def attribute(name: str, kind: Any, value: Any, *, custom: bool = False) -> Any:
        variability = sdf.VariabilityVarying if custom else uniform
        own = sdf.AttributeSpec(spec, name, kind, variability, custom)
        own.default = value
        return own

    def vectors(rows: np.ndarray[Any, Any]) -> Any:
        return values.Vec3fArray.FromNumpy(np.ascontiguousarray(rows))

    attribute(PATH, types.String, shape.path, custom=True)
    if not shape.bent:
        return
    attribute(BENDS, *array_of_bends(shape.bends), custom=True)
    for i, weight in enumerate(shape.weights.tolist(), start=1):
        name = f"inbetweens:{inbetween_name(weight)}"
        own = attribute(name, types.Point3fArray, vectors(shape.offsets[i]))
        own.SetInfo("weight", weight)
        if shape.normals is not None:
            rows = vectors(shape.normals[i])
            attribute(f"{name}:normalOffsets", types.Vector3fArray, rows)
    if shape.points is not None:
        attribute("pointIndices", types.IntArray, values.IntArray.FromNumpy(shape.points))
        attribute("offsets", types.Vector3fArray, vectors(shape.offsets[0]))
        if shape.normals is not None:
            attribute("normalOffsets", types.Vector3fArray, vectors(shape.normals[0]))


def _list_variants(layer: Any, shapes: Iterable[BentShape]) -> None:
    """Name variant sets only where no layer below does: their order is that of their strength."""
    unlisted: dict[str, list[str]] = {}
    for shape in shapes:
        for prim, name in shape.original.unlisted:
            if name not in unlisted.setdefault(prim, []):
                unlisted[prim].append(name)

    def visit(place: Any) -> None:
        if place.IsPrimPath() or place.IsPrimVariantSelectionPath():
            spec = layer.GetPrimAtPath(place)
            if spec is None or not spec.HasInfo("variantSetNames"):
                return
            spec.variantSetNameList.ClearEdits()
            for name in unlisted.get(str(place.StripAllVariantSelections()), []):
                spec.variantSetNameList.prependedItems.append(name)

    layer.Traverse(pxr("Sdf").Path.absoluteRootPath, visit)
