"""Takes meshes and their blend shapes out of a USD file, in a process that may crash."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.io.choices import ListedMesh, chosen_meshes
from elastomorph.io.isolated import RefusedError, allow_for, serve
from elastomorph.io.usd.library import (
    BENDS,
    GROUP_FAMILY,
    NAME,
    PATH,
    POINTS,
    SETTINGS,
    SLIDERS,
    pxr,
)

_TEXTURE_NAMES = ("st", "uv", "UVMap", "map1", "Texture_uv", "st0")


def content_of(source: str, *wanted: str) -> dict[str, NDArray[Any]]:
    """The arrays of the meshes of these names or paths, or of all, in a file."""
    try:
        return _content(source, wanted)
    except pxr("Tf").ErrorException as error:
        reasons = [str(getattr(part, "commentary", part)) for part in error.args]
        sentence = " ".join(" ".join(reasons).split())[:300]
    except UnicodeError:
        sentence = "it holds text that is not UTF-8"
    raise RefusedError(f"USD cannot read it: {sentence}")


def _prepare() -> None:
    for module in ("Sdf", "Tf", "Usd", "UsdGeom", "UsdShade", "UsdSkel"):
        pxr(module)


def _content(source: str, wanted: Sequence[str]) -> dict[str, NDArray[Any]]:
    layer = pxr("Sdf").Layer.FindOrOpen(source)
    if layer is None:
        raise RefusedError("USD cannot read it")
    size_of_others = _follow(layer, Path(source).resolve().parent)
    stage = pxr("Usd").Stage.Open(layer)
    arrays: dict[str, NDArray[Any]] = {}
    meshes = [_mesh(arrays, f"{i}_", stage, own) for i, own in enumerate(_chosen(stage, wanted))]
    scene = json.dumps({"size_of_others": size_of_others, "meshes": meshes})
    arrays["scene"] = np.frombuffer(scene.encode("utf-8"), dtype=np.uint8)
    return arrays


def _follow(layer: Any, folder: Path) -> int:
    """Open the files that a layer is composed of; bytes of those beside it.

    Sublayers, references and payloads, in all variants, must be files below the folder; links
    are resolved first. Those of a layer in a package (.usdz) must lie in that package. Search
    paths, URLs and value clips are not followed.
    """
    waiting, seen = [layer], {layer.identifier}
    known: set[str] = set()
    size_of_others = 0
    while waiting:
        current = waiting.pop()
        _refuse_clips(current)
        for asset in filter(None, current.GetCompositionAssetDependencies()):
            target = _in_package(current, asset) or _in_folder(current, asset, folder)
            if not target:
                raise RefusedError(
                    f"it is composed of '{asset[:200]}', which is no file in its own folder; write "
                    "it as one file (usdcat --flatten) and read that"
                )
            if target in known:
                continue
            known.add(target)
            if not pxr("Ar").IsPackageRelativePath(target):
                size = Path(target).stat().st_size
                size_of_others += size
                allow_for(size)
            opened = pxr("Sdf").Layer.FindOrOpen(target)
            if opened is None:
                raise RefusedError(f"it is composed of '{asset[:200]}', which cannot be read")
            if opened.identifier not in seen:
                seen.add(opened.identifier)
                waiting.append(opened)
    return size_of_others


def _in_folder(layer: Any, asset: str, folder: Path) -> str:
    """The file below the folder that a layer names, or nothing."""
    try:
        target = (Path(layer.realPath).parent / asset).resolve()
        inside = target.is_relative_to(folder) and target.is_file()
    except (OSError, ValueError, RuntimeError):
        inside = False
    return str(target) if inside else ""


def _in_package(layer: Any, asset: str) -> str:
    """What a layer in a package names in it, or nothing."""
    paths = pxr("Ar")
    target: str = pxr("Sdf").ComputeAssetPathRelativeToLayer(layer, asset)
    if not paths.IsPackageRelativePath(target):
        return ""
    package, part = paths.SplitPackageRelativePathOuter(target)
    own = paths.SplitPackageRelativePathOuter(layer.realPath)[0]
    return target if package == own and ".." not in part.split("/") else ""


def _refuse_clips(layer: Any) -> None:
    def visit(path: Any) -> None:
        if path.IsPrimPath() or path.IsPrimVariantSelectionPath():
            spec = layer.GetObjectAtPath(path)
            if spec is not None and spec.HasInfo("clips"):
                raise RefusedError(
                    f"the prim {path} takes its values from clips in other files, which is not "
                    "supported"
                )

    layer.Traverse(pxr("Sdf").Path.absoluteRootPath, visit)


def _chosen(stage: Any, wanted: Sequence[str]) -> list[Any]:
    """The prims of the meshes to read."""
    usd = pxr("Usd")
    every = usd.PrimRange.Stage(stage, usd.TraverseInstanceProxies())
    prims = [prim for prim in every if prim.IsA(pxr("UsdGeom").Mesh)]
    shapes = [len(_targets(prim)) for prim in prims]
    # A rig of ours may have no blend shapes.
    need_shapes = not any(shapes) and not any(prim.HasAttribute(SLIDERS) for prim in prims)
    # Whether a mesh is shown takes a walk up to its root: not where none will be read for that.
    by_sight = not wanted and not need_shapes
    listed = [
        ListedMesh(
            (prim.GetPath().pathString, prim.GetName()), count, not by_sight or _is_shown(prim)
        )
        for prim, count in zip(prims, shapes, strict=True)
    ]
    try:
        chosen = chosen_meshes(listed, wanted, need_shapes=need_shapes)
    except ParameterError as problem:
        raise RefusedError(str(problem)) from None
    # Meshes without points show nothing; exporters leave them where something was.
    mesh = pxr("UsdGeom").Mesh
    full = [i for i in chosen if listed[i].shapes or _value(mesh(prims[i]).GetPointsAttr())]
    return [prims[i] for i in full or chosen]


def _is_shown(prim: Any) -> bool:
    """Whether it is rendered: visible, and no stand-in or guide."""
    image, tokens = pxr("UsdGeom").Imageable(prim), pxr("UsdGeom").Tokens
    drawn = image.ComputePurpose() in (tokens.default_, tokens.render)
    return drawn and image.ComputeVisibility() != tokens.invisible


def _mesh(arrays: dict[str, NDArray[Any]], prefix: str, stage: Any, prim: Any) -> dict[str, Any]:
    """What JSON can hold of a mesh; the rest goes into the arrays, under names with a prefix."""
    mesh, keep = pxr("UsdGeom").Mesh(prim), partial(_keep, arrays, prefix)
    keep("points", mesh.GetPointsAttr(), 3)
    keep("counts", mesh.GetFaceVertexCountsAttr())
    keep("indices", mesh.GetFaceVertexIndicesAttr())
    keep("exact_points", prim.GetAttribute(POINTS), 3)
    arrays[f"{prefix}matrix"] = np.array(_to_world(prim), dtype=np.float64)[:, :3]
    return {
        "name": prim.GetName(),
        "left_handed": mesh.GetOrientationAttr().Get() == "leftHanded",
        "sliders": _text(prim, SLIDERS),
        "settings": _text(prim, SETTINGS),
        "texture": _texture(keep, mesh),
        "subsets": _subsets(keep, prim),
        "material": _material(prim),
        "shapes": _shapes(keep, stage, prim),
    }


def _to_world(prim: Any) -> Any:
    """The matrix from points to the world: a skinned mesh stands where it was bound."""
    geometry, binding = pxr("UsdGeom"), pxr("UsdSkel").BindingAPI(prim)
    cache = geometry.XformCache(pxr("Usd").TimeCode.EarliestTime())
    skeleton = binding.GetInheritedSkeleton()
    if not skeleton or not binding.GetJointIndicesPrimvar().HasAuthoredValue():
        return cache.GetLocalToWorldTransform(prim)
    bound = _value(binding.GetGeomBindTransformAttr())
    placed = cache.GetLocalToWorldTransform(skeleton.GetPrim())
    return placed if bound is None else bound * placed


def _targets(prim: Any) -> list[Any]:
    named = prim.GetRelationship(pxr("UsdSkel").Tokens.skelBlendShapeTargets)
    return list(named.GetTargets()) if named else []


def _value(attribute: Any) -> Any:
    """The value that does not move; of one that only moves, the first."""
    if not attribute:
        return None
    value = attribute.Get()
    return attribute.Get(pxr("Usd").TimeCode.EarliestTime()) if value is None else value


def _keep(
    arrays: dict[str, NDArray[Any]], prefix: str, name: str, attribute: Any, columns: int = 0
) -> bool:
    """Whether an attribute has a value, which goes into the arrays."""
    value = _value(attribute)
    if value is None:
        return False
    array = np.array(value)
    if array.dtype.kind not in "fiu":
        raise RefusedError(f"{attribute.GetPath()} holds values that are not numbers")
    if columns and not array.size:
        array = array.reshape(0, columns)
    arrays[f"{prefix}{name}"] = array
    return True


def _text(prim: Any, name: str) -> str | None:
    value = _value(prim.GetAttribute(name))
    return value if isinstance(value, str) else None


def _texture(keep: Callable[..., bool], mesh: Any) -> dict[str, Any] | None:
    known = pxr("UsdGeom").PrimvarsAPI(mesh).GetPrimvarsWithValues()
    by_name = {primvar.GetPrimvarName(): primvar for primvar in known}
    marked = [n for n, p in by_name.items() if p.GetTypeName().role == "TextureCoordinate"]
    plain = [n for n in _TEXTURE_NAMES if n in by_name]
    for name in [n for n in plain if n in marked] + marked + plain:
        primvar = by_name[name]
        kind = str(primvar.GetInterpolation())
        if kind not in ("faceVarying", "vertex", "varying"):
            continue
        if keep("uv", primvar.GetAttr()):
            keep("uv_indices", primvar.GetIndicesAttr())
            return {"kind": kind, "unauthored": primvar.GetUnauthoredValuesIndex()}
    return None


def _subsets(keep: Callable[..., bool], prim: Any) -> list[dict[str, Any]]:
    geometry = pxr("UsdGeom")
    found: list[dict[str, Any]] = []
    for subset in geometry.Subset.GetAllGeomSubsets(geometry.Imageable(prim)):
        family = str(subset.GetFamilyNameAttr().Get() or "")
        if family not in ("materialBind", GROUP_FAMILY):
            continue
        if subset.GetElementTypeAttr().Get() != "face":
            continue
        if keep(f"subset_{len(found)}", subset.GetIndicesAttr()):
            own = subset.GetPrim()
            name = _text(own, NAME) or _material(own) or own.GetDisplayName() or own.GetName()
            found.append({"name": name, "material": family != GROUP_FAMILY})
    return found


def _material(prim: Any) -> str | None:
    """Name of the material bound to this prim itself."""
    shade = pxr("UsdShade")
    if not prim.HasAPI(shade.MaterialBindingAPI):
        return None
    material = shade.MaterialBindingAPI(prim).GetDirectBinding().GetMaterial()
    if not material:
        return None
    name: str = material.GetPrim().GetDisplayName() or material.GetPrim().GetName()
    return name


def _shapes(keep: Callable[..., bool], stage: Any, prim: Any) -> list[dict[str, Any]]:
    skel = pxr("UsdSkel")
    tokens = list(_value(skel.BindingAPI(prim).GetBlendShapesAttr()) or [])
    found = []
    for i, target in enumerate(_targets(prim)):
        shape = skel.BlendShape(stage.GetPrimAtPath(target))
        if not shape:
            raise RefusedError(f"{prim.GetPath()} names the blend shape {target}, which is none")
        own = shape.GetPrim()
        keep(f"shape_{i}_offsets", shape.GetOffsetsAttr(), 3)
        keep(f"shape_{i}_points", shape.GetPointIndicesAttr())
        keep(f"shape_{i}_bends", own.GetAttribute(BENDS), 3)
        inbetweens = []
        for k, inbetween in enumerate(shape.GetInbetweens()):
            weight = inbetween.GetWeight()
            if keep(f"shape_{i}_inbetween_{k}", inbetween.GetAttr(), 3):
                inbetweens.append(weight)
        token = str(tokens[i]) if i < len(tokens) else own.GetName()
        texts = {"token": token, "name": _text(own, NAME), "path": _text(own, PATH)}
        found.append({**texts, "inbetweens": inbetweens})
    return found


if __name__ == "__main__":
    serve(_prepare, content_of)
