"""What a layer of bends must know of the file it goes over, in a process that may crash."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.isolated import RefusedError, allow_for, serve
from elastomorph.io.usd.composed import Composed, digest_of, open_composed
from elastomorph.io.usd.library import BENDS, NAME, PATH, SLIDERS, original_in, pxr
from elastomorph.io.usd.worker import (
    chosen_prims,
    prepare,
    refusing,
    scene_of,
    shape_targets,
    text_array,
)

# What composition takes from each layer of a stack by itself, not from the first alone.
_OF_EACH_LAYER = ("subLayers", "subLayerOffsets", "primChildren", "layerRelocates", "relocates")
_NOT_KEPT = ("documentation", "comment", "owner", "sessionOwner", "hasOwnedSubLayers")
_OF_OVERS = ("specifier", "variantSetNames", "typeName")
_OURS = (
    *(BENDS, PATH, "offsets", "pointIndices", "normalOffsets"),
    # Of shapes that are added, and the weights that drive them.
    *(NAME, SLIDERS, "skel:blendShapes", "skel:blendShapeTargets"),
    *("blendShapes", "blendShapeWeights"),
)


def content_of(source: str, *only_files: str) -> dict[str, NDArray[Any]]:
    """The arrays of all meshes that are rendered, and ``layer``: JSON of what else is needed.

    Of a layer of bends these are those of the file that it lies over. With ``files`` as argument,
    it is only told which file that is.
    """
    with refusing():
        opened = open_composed(source)
        original = original_in(opened.layer)
        if only_files:
            if original is None:
                raise RefusedError("it is no layer of bends, so there is nothing to take away")
            way = str((Path(source).resolve().parent / original.asset).resolve())
            return {"layer": text_array({"original": way, "files": [way, *opened.files]})}
        if original is not None:
            _require_nothing_else(opened.layer)
            source = str((Path(source).resolve().parent / original.asset).resolve())
            size = Path(source).stat().st_size
            allow_for(size)
            opened = open_composed(source)
            opened = replace(opened, size_of_others=opened.size_of_others + size)
        prims = chosen_prims(opened.stage, ())
        arrays = scene_of(opened, prims)
        content = {
            "original": source,
            "digest": digest_of(source),
            "files": [source, *opened.files],
            "header": _header(opened.layer),
            "meshes": [_places(arrays, f"{i}_", opened, prim) for i, prim in enumerate(prims)],
            "animations": _animations(arrays, opened, prims),
            "tolerance": None if original is None else original.tolerance,
        }
        arrays["layer"] = text_array(content)
        return arrays


def _require_nothing_else(layer: Any) -> None:
    """Refuse a layer of bends to which somebody has added something, which would be lost."""

    def visit(path: Any) -> None:
        if path.IsPropertyPath():
            ours = path.name in _OURS or path.name.startswith("inbetweens:")
        else:
            spec = layer.GetPrimAtPath(path) if path.IsPrimPath() else None
            ours = spec is None or (
                set(spec.ListInfoKeys()) <= set(_OF_OVERS) and spec.typeName in ("", "BlendShape")
            )
        if not ours:
            raise RefusedError(
                f"it is a layer of bends, but {path} in it was added or changed by someone and "
                "would be lost; move that to a layer of its own"
            )

    layer.Traverse(pxr("Sdf").Path.absoluteRootPath, visit)


def _header(layer: Any) -> str:
    """A layer, as text, of all that a stage takes from its root layer alone.

    Units, axes and times of a stage come from there and are not inherited from sublayers.
    """
    header = pxr("Sdf").Layer.CreateAnonymous(".usda")
    source, copied = layer.pseudoRoot, header.pseudoRoot
    for key in source.ListInfoKeys():
        if key not in _OF_EACH_LAYER and key not in _NOT_KEPT:
            copied.SetInfo(key, source.GetInfo(key))
    text: str = header.ExportToString()
    return text


def _places(
    arrays: dict[str, NDArray[Any]], prefix: str, opened: Composed, prim: Any
) -> dict[str, Any]:
    """Where the blend shapes of a mesh can be overridden; their normals go into the arrays."""
    shapes = []
    skel = pxr("UsdSkel")
    for i, target in enumerate(shape_targets(prim)):
        own = opened.stage.GetPrimAtPath(target)
        normals = skel.BlendShape(own).GetNormalOffsetsAttr().Get()
        if normals is not None and len(normals):
            arrays[f"{prefix}shape_{i}_normals"] = np.array(normals)
        selections = _selections(prim, own)
        place, unlisted = _place(opened, own, selections)
        shapes.append(
            {
                "prim": own.GetPath().pathString,
                "place": place,
                "unlisted": unlisted,
                "variants": [f"{name}={choice}" for name, choice in selections.items()],
                "instance": _instance(own),
            }
        )
    place, unlisted = _place(opened, prim, _selections(prim))
    tokens = skel.BindingAPI(prim).GetBlendShapesAttr().Get() or ()
    source = _animation_of(prim)
    return {
        "path": prim.GetPath().pathString,
        "shapes": shapes,
        "place": place,
        "unlisted": unlisted,
        "tokens": [] if _instance(prim) else list(tokens),
        "children": list(prim.GetAllChildrenNames()),
        "animation": source.GetPath().pathString if source else "",
    }


def _animation_of(prim: Any) -> Any:
    """The prim of the animation that a mesh follows; an invalid one where there is none."""
    binding = pxr("UsdSkel").BindingAPI
    skeleton = binding(prim).GetInheritedSkeleton()
    return binding(skeleton.GetPrim() if skeleton else prim).GetInheritedAnimationSource()


def _animations(
    arrays: dict[str, NDArray[Any]], opened: Composed, prims: list[Any]
) -> list[dict[str, Any]]:
    """The animations that meshes follow; times and weights, the first at rest, go into arrays."""
    sources = {own.GetPath().pathString: own for own in map(_animation_of, prims) if own}
    found: list[dict[str, Any]] = []
    for path, prim in sources.items():
        clip = pxr("UsdSkel").Animation(prim)
        tokens, weights = clip.GetBlendShapesAttr().Get(), clip.GetBlendShapeWeightsAttr()
        times = weights.GetTimeSamples()
        rows = [weights.Get(), *map(weights.Get, times)]
        if tokens and rows[0] is None:
            rows[0] = [0.0] * len(tokens)
        if not tokens or _instance(prim) or {len(row or ()) for row in rows} != {len(tokens)}:
            continue
        place, unlisted = _place(opened, prim, _selections(prim))
        arrays[f"animation_{len(found)}_times"] = np.array(times, dtype=np.float64)
        arrays[f"animation_{len(found)}_weights"] = np.array(rows, dtype=np.float64)
        found.append({"path": path, "place": place, "unlisted": unlisted, "tokens": list(tokens)})
    return found


def _instance(prim: Any) -> str | None:
    """The instance that a prim lies in, below which nothing can be overridden."""
    while prim and prim.IsInstanceProxy():
        prim = prim.GetParent()
        if prim.IsInstance() and not prim.IsInstanceProxy():
            path: str = prim.GetPath().pathString
            return path
    return None


def _selections(*prims: Any) -> dict[str, str]:
    """The variants, by variant set, that have a say in any of these prims."""
    found: dict[str, str] = {}
    for prim in prims:
        for arc in pxr("Usd").PrimCompositionQuery(prim).GetCompositionArcs():
            node = arc.GetTargetNode() if arc.HasSpecs() else None
            while node:  # a variant may bring a reference, which brings the prim
                path = node.path
                while not path.IsAbsoluteRootPath():
                    if path.IsPrimVariantSelectionPath():
                        name, choice = path.GetVariantSelection()
                        found[name] = choice
                    path = path.GetParentPath()
                node = node.parent
    return found


def _place(opened: Composed, prim: Any, selections: dict[str, str]) -> tuple[str, list[list[str]]]:
    """The path of a prim, inside the variants that it depends on.

    With it the prims, and variant sets of them, of which a layer must say that they exist: those
    that no layer beside it names.
    """
    layers = opened.stage.GetLayerStack(False)
    place, unlisted = "", []
    for prefix in prim.GetPath().GetPrefixes():
        place += ("" if place.endswith("}") else "/") + prefix.name
        ancestor = opened.stage.GetPrimAtPath(prefix)
        for name in ancestor.GetVariantSets().GetNames():
            if name not in selections:
                continue
            place += f"{{{name}={selections[name]}}}"
            specs = filter(None, (layer.GetPrimAtPath(prefix) for layer in layers))
            if not any(name in spec.variantSetNameList.GetAddedOrExplicitItems() for spec in specs):
                unlisted.append([prefix.pathString, name])
    return place, unlisted


if __name__ == "__main__":
    serve(prepare, content_of)
