"""Takes meshes and their blend shapes out of a USD file, in a process that may crash."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.io.choices import ListedMesh, chosen_meshes
from elastomorph.io.isolated import RefusedError, serve
from elastomorph.io.usd.composed import Composed, open_composed
from elastomorph.io.usd.library import (
    BENDS,
    GROUP_FAMILY,
    NAME,
    PATH,
    POINTS,
    ROOT,
    SETTINGS,
    SLIDERS,
    STILL,
    pxr,
)
from elastomorph.io.usd.looks import coordinates_of, looks_of
from elastomorph.io.usd.skins import place_at_rest

_TEXTURE_NAMES = ("st", "uv", "UVMap", "map1", "Texture_uv", "st0")


def content_of(source: str, *wanted: str) -> dict[str, NDArray[Any]]:
    """The arrays of the meshes of these names or paths, or of all, in a file."""
    with refusing():
        return _content(source, wanted)


@contextmanager
def refusing() -> Iterator[None]:
    """Refuse the file, in one sentence, for what USD raises."""
    try:
        yield
    except pxr("Tf").ErrorException as error:
        reasons = [str(getattr(part, "commentary", part)) for part in error.args]
        sentence = " ".join(" ".join(reasons).split())[:300]
        raise RefusedError(f"USD cannot read it: {sentence}") from None
    except UnicodeError:
        raise RefusedError("USD cannot read it: it holds text that is not UTF-8") from None


def prepare() -> None:
    """Import what a worker of USD needs."""
    for module in ("Sdf", "Tf", "Usd", "UsdGeom", "UsdShade", "UsdSkel"):
        pxr(module)


def _content(source: str, wanted: Sequence[str]) -> dict[str, NDArray[Any]]:
    root = next((own.removeprefix(ROOT) for own in wanted if own.startswith(ROOT)), None)
    wanted = [name for name in wanted if not name.startswith(ROOT)]
    opened = open_composed(source, root)
    return scene_of(opened, chosen_prims(opened.stage, wanted))


def scene_of(opened: Composed, prims: Sequence[Any]) -> dict[str, NDArray[Any]]:
    """The arrays of the meshes that these prims are; ``scene`` is JSON of all that is no array."""
    arrays: dict[str, NDArray[Any]] = {}
    meshes = [_mesh(arrays, f"{i}_", opened.stage, own) for i, own in enumerate(prims)]
    up = str(pxr("UsdGeom").GetStageUpAxis(opened.stage))
    materials: dict[str, Any] = {}
    for prim in prims:
        for bound in (prim, *_bound_subsets(prim)):
            if (material := _bound(bound)) is not None:
                materials.setdefault(_name_of(material), material)
    looks = looks_of(arrays, materials, opened)
    images = sum(array.nbytes for name, array in arrays.items() if name.startswith("image_"))
    others = {"size_of_others": opened.size_of_others + images, "looks": looks}
    scene = {"up": up, "meshes": meshes, **others}
    arrays["scene"] = text_array(scene)
    return arrays


def text_array(content: Any) -> NDArray[np.uint8]:
    """JSON as an array of bytes."""
    return np.frombuffer(json.dumps(content).encode("utf-8"), dtype=np.uint8)


def chosen_prims(stage: Any, wanted: Sequence[str]) -> list[Any]:
    """The prims of the meshes to read."""
    usd = pxr("Usd")
    every = usd.PrimRange.Stage(stage, usd.TraverseInstanceProxies())
    prims = [prim for prim in every if prim.IsA(pxr("UsdGeom").Mesh)]
    shapes = [len(shape_targets(prim)) for prim in prims]
    # A rig of ours may have no blend shapes.
    still = STILL in wanted or any(prim.HasAttribute(SLIDERS) for prim in prims)
    wanted = [name for name in wanted if name != STILL]
    need_shapes = not any(shapes) and not still
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
    points = arrays.get(f"{prefix}points", np.zeros(0))
    matrix, held = place_at_rest(prim, len(points) if points.ndim else 0)
    arrays[f"{prefix}matrix"] = matrix[:, :3]
    if held is not None:
        arrays[f"{prefix}held"] = held
    return {
        "name": prim.GetName(),
        "left_handed": mesh.GetOrientationAttr().Get() == "leftHanded",
        "sliders": text_of(prim, SLIDERS),
        "settings": text_of(prim, SETTINGS),
        "texture": _texture(keep, mesh, _shown_coordinates(prim)),
        "subsets": _subsets(keep, prim),
        "material": _material(prim),
        "shapes": _shapes(keep, stage, prim),
    }


def shape_targets(prim: Any) -> list[Any]:
    """Paths of the blend shapes of a mesh."""
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


def text_of(prim: Any, name: str) -> str | None:
    """A text of our own on a prim."""
    value = _value(prim.GetAttribute(name))
    return value if isinstance(value, str) else None


def _shown_coordinates(prim: Any) -> list[str]:
    """Names of the texture coordinates by which the materials of a mesh show their images."""
    bound = filter(None, map(_bound, (prim, *_bound_subsets(prim))))
    return [name for name in map(coordinates_of, bound) if name is not None]


def _texture(keep: Callable[..., bool], mesh: Any, shown: Sequence[str]) -> dict[str, Any] | None:
    """Which texture coordinates were kept: those that are shown, or else the likeliest."""
    known = pxr("UsdGeom").PrimvarsAPI(mesh).GetPrimvarsWithValues()
    by_name = {primvar.GetPrimvarName(): primvar for primvar in known}
    marked = [n for n, p in by_name.items() if p.GetTypeName().role == "TextureCoordinate"]
    plain = [n for n in _TEXTURE_NAMES if n in by_name]
    named = [name for name in shown if name in by_name]
    for name in named + [n for n in plain if n in marked] + marked + plain:
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
            name = text_of(own, NAME) or _material(own) or own.GetDisplayName() or own.GetName()
            found.append({"name": name, "material": family != GROUP_FAMILY})
    return found


def _bound_subsets(prim: Any) -> list[Any]:
    geometry = pxr("UsdGeom")
    subsets = geometry.Subset.GetAllGeomSubsets(geometry.Imageable(prim))
    return [subset.GetPrim() for subset in subsets]


def _bound(prim: Any) -> Any:
    """The material bound to this prim itself."""
    shade = pxr("UsdShade")
    if not prim.HasAPI(shade.MaterialBindingAPI):
        return None
    return shade.MaterialBindingAPI(prim).GetDirectBinding().GetMaterial() or None


def _name_of(material: Any) -> str:
    name: str = material.GetPrim().GetDisplayName() or material.GetPrim().GetName()
    return name


def _material(prim: Any) -> str | None:
    material = _bound(prim)
    return None if material is None else _name_of(material)


def _shapes(keep: Callable[..., bool], stage: Any, prim: Any) -> list[dict[str, Any]]:
    skel = pxr("UsdSkel")
    tokens = list(_value(skel.BindingAPI(prim).GetBlendShapesAttr()) or [])
    found = []
    for i, target in enumerate(shape_targets(prim)):
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
        texts = {"name": text_of(own, NAME), "path": text_of(own, PATH)}
        found.append({"token": token, "prim": own.GetName(), **texts, "inbetweens": inbetweens})
    return found


if __name__ == "__main__":
    serve(prepare, content_of)
