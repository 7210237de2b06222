"""Takes meshes and their blend shapes out of a USD file, in a process that may crash.

Of materials that is what UsdPreviewSurface says: other kinds of shaders are passed over, and so is
everything that is no base colour, opacity, roughness or metal. An image must be a file below a
folder of the stage, or lie in a package there.

A mesh stands at rest by its transform, or by the joints of a skeleton. UsdSkel puts a point at
p · G · Σ_j w_j (B_j⁻¹ R_j) · S, with the weights w of the point and rows on the left: G is the
transform in which the mesh was bound, B_j and R_j are those of the joints as bound and at rest, in
the space of the skeleton, and S is the transform of the skeleton. Mostly the joints rest where they
were bound, and B_j⁻¹ R_j is the identity.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.io.choices import ListedMesh, chosen_meshes
from elastomorph.io.isolated import RefusedError, allow_for, serve
from elastomorph.io.skinning import blended_matrices, common_matrix
from elastomorph.io.usd.composed import Composed, open_composed
from elastomorph.io.usd.library import (
    BENDS,
    COPYRIGHT,
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


def place_at_rest(prim: Any, points: int) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    """The (4, 4) matrix from a mesh of so many points to the world, in which rows are multiplied.

    Where joints hold the points differently, also (N, 4, 3) that come first, one a point.
    """
    geometry, binding = pxr("UsdGeom"), pxr("UsdSkel").BindingAPI(prim)
    cache = geometry.XformCache(pxr("Usd").TimeCode.EarliestTime())
    skeleton = binding.GetInheritedSkeleton()
    if not skeleton or not binding.GetJointIndicesPrimvar().HasAuthoredValue():
        return np.array(cache.GetLocalToWorldTransform(prim)), None
    given = _value_at_rest(binding.GetGeomBindTransformAttr())
    bound = np.eye(4) if given is None else np.array(given)
    world = np.array(cache.GetLocalToWorldTransform(skeleton.GetPrim()))
    held = _held(skeleton)
    common = None if held is None else common_matrix(held)
    if held is None or common is not None:
        return (bound if common is None else bound @ common) @ world, None
    joints, weights = _influences(prim, binding, skeleton, points)
    used = np.unique(joints[weights > 0])
    if not used.size:
        return bound @ world, None
    if (common := common_matrix(held[used])) is not None:
        return bound @ common @ world, None
    return world, np.asarray((bound @ blended_matrices(held, joints, weights))[..., :3])


def _held(skeleton: Any) -> NDArray[np.float64] | None:
    """(J, 4, 4) what each joint does at rest; None where the skeleton does not say all of it."""
    names = list(_value_at_rest(skeleton.GetJointsAttr()) or [])
    found = [
        _value_at_rest(skeleton.GetBindTransformsAttr()),
        _value_at_rest(skeleton.GetRestTransformsAttr()),
    ]
    if not names or any(own is None or len(own) != len(names) for own in found):
        return None
    bind, local = (np.array(own, dtype=np.float64).reshape(-1, 4, 4) for own in found)
    parents = pxr("UsdSkel").Topology(names).GetParentIndices()
    rest = local.copy()
    for joint, parent in enumerate(parents):
        if not parent < joint:
            return None  # UsdSkel plays no skeleton in which a joint comes before its parent
        if parent >= 0:
            rest[joint] = local[joint] @ rest[parent]
    try:
        held = np.linalg.inv(bind) @ rest
    except np.linalg.LinAlgError:
        return None
    return held if np.isfinite(held).all() else None


def _influences(
    prim: Any, binding: Any, skeleton: Any, points: int
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """(N, K) joints of the skeleton that hold each point, and their weights, whose sums are 1."""
    path = prim.GetPath()
    indices, amounts = binding.GetJointIndicesPrimvar(), binding.GetJointWeightsPrimvar()
    numbers = np.array(indices.ComputeFlattened() or [], dtype=np.int64)
    weights = np.array(amounts.ComputeFlattened() or [], dtype=np.float64)
    rigid = str(indices.GetInterpolation()) == "constant"
    rows, width = (1 if rigid else points), max(indices.GetElementSize(), 1)
    if not numbers.size == weights.size == rows * width:
        raise RefusedError(
            f"{path} has {numbers.size:,} joint indices and {weights.size:,} joint weights, "
            f"expected {rows * width:,} for {points:,} points; export it again with its skin"
        )
    known = list(_value_at_rest(skeleton.GetJointsAttr()))
    order = np.arange(len(known))
    named = _value_at_rest(binding.GetJointsAttr())
    if named is not None and len(named):
        missing = next((name for name in named if name not in known), None)
        if missing is not None:
            raise RefusedError(
                f"{path} is held by the joint '{str(missing)[:60]}', which its skeleton "
                f"{skeleton.GetPath()} has not; export it again with its skeleton"
            )
        order = np.array([known.index(name) for name in named])
    if numbers.size and not 0 <= numbers.min() <= numbers.max() < len(order):
        raise RefusedError(
            f"{path} is held by joints {numbers.min():,} to {numbers.max():,}, but there are "
            f"{len(order):,}; export it again with its skeleton"
        )
    if not np.isfinite(weights).all() or (weights < 0).any():
        raise RefusedError(f"the joint weights of {path} are no numbers from 0")
    amount = np.broadcast_to(weights.reshape(rows, width), (points, width))
    total = amount.sum(axis=1, keepdims=True)
    if (total <= 0).any():
        raise RefusedError(f"{path} has points that no joint holds; export it again with its skin")
    return order[np.broadcast_to(numbers.reshape(rows, width), (points, width))], amount / total


def _value_at_rest(attribute: Any) -> Any:
    return attribute.Get() if attribute else None


_WRAPS = {"repeat": "repeat", "mirror": "mirror", "clamp": "clamp", "black": "clamp"}


def looks_of(
    arrays: dict[str, NDArray[Any]], materials: dict[str, Any], opened: Composed
) -> dict[str, dict[str, Any]]:
    """What JSON can hold of the looks of materials by name; images go into the arrays."""
    images: dict[str, int] = {}
    found = {}
    for name, material in materials.items():
        shader = _source(material.ComputeSurfaceSource())
        if shader and shader.GetIdAttr().Get() == "UsdPreviewSurface":
            found[name] = _look(arrays, images, shader, opened)
    return found


def coordinates_of(material: Any) -> str | None:
    """The name of the texture coordinates by which a material shows its base colour."""
    shader = _source(material.ComputeSurfaceSource())
    image = _input(shader, "diffuseColor")[1] if shader else None
    reader = _maker(image, "st") if image is not None else None
    if reader and reader.GetIdAttr().Get() == "UsdTransform2d":
        reader = _maker(reader, "in")
    if not reader or reader.GetIdAttr().Get() != "UsdPrimvarReader_float2":
        return None
    return str(_input(reader, "varname")[0] or "") or None


def _maker(shader: Any, name: str) -> Any:
    """The shader that an input is connected with."""
    given = shader.GetInput(name)
    sources = pxr("UsdShade").Utils.GetValueProducingAttributes(given) if given else []
    return pxr("UsdShade").Shader(sources[0].GetPrim()) if sources else None


def _look(
    arrays: dict[str, NDArray[Any]], images: dict[str, int], shader: Any, opened: Composed
) -> dict[str, Any]:
    colour, texture = _input(shader, "diffuseColor")
    alpha, mask = _input(shader, "opacity")
    threshold, _ = _input(shader, "opacityThreshold")
    cutoff = _number(threshold, 0.0)
    clear = mask is not None or _number(alpha, 1.0) < 1.0
    rgb = [_number(part, 0.18) for part in colour] if colour is not None else [0.18] * 3
    look: dict[str, Any] = {
        "colour": [*rgb, 1.0 if mask else _number(alpha, 1.0)],
        "opacity": "mask" if cutoff > 0 else "blend" if clear else "opaque",
        "cutoff": cutoff,
        "finish": [
            _number(_input(shader, name)[0], value)
            for name, value in (("roughness", 0.5), ("metallic", 0.0))
        ],
    }
    if texture is not None:
        factors = _input(texture, "scale")[0] or [1.0] * 4
        look["colour"] = [_number(part, 1.0) for part in (*factors[:3], factors[3] if mask else 1)]
        look["texture"] = _with_texture(arrays, images, texture, opened)
    return look


def _input(shader: Any, name: str) -> tuple[Any, Any]:
    """The value of an input, or the shader of the texture it is connected with."""
    given = shader.GetInput(name)
    if not given:
        return None, None
    for attribute in pxr("UsdShade").Utils.GetValueProducingAttributes(given):
        source = pxr("UsdShade").Shader(attribute.GetPrim())
        connected = source and source.GetPrim() != shader.GetPrim()
        if connected and source.GetIdAttr().Get() == "UsdUVTexture":
            return None, source
        return attribute.Get(), None
    return None, None


def _with_texture(
    arrays: dict[str, NDArray[Any]], images: dict[str, int], shader: Any, opened: Composed
) -> dict[str, Any]:
    asset, _ = _input(shader, "file")
    path = str(getattr(asset, "resolvedPath", "") or "")
    named = str(getattr(asset, "path", "") or "")
    if path and path not in images and _is_near(path, opened):
        content = _bytes(path)
        if content is not None:
            images[path] = len(images)
            arrays[f"image_{images[path]}"] = np.frombuffer(content, dtype=np.uint8)
    return {
        "image": images.get(path),
        "name": named[-60:],
        "wrap": [_WRAPS.get(str(_input(shader, key)[0]), "repeat") for key in ("wrapS", "wrapT")],
        **_transform(shader),
    }


def _transform(texture: Any) -> dict[str, Any]:
    """A UsdTransform2d of the coordinates, turned into one that counts from the top."""
    shader = _maker(texture, "st")
    if not shader or shader.GetIdAttr().Get() != "UsdTransform2d":
        return {}
    across, down = _pair(_input(shader, "scale")[0], 1.0)
    x, y = _pair(_input(shader, "translation")[0], 0.0)
    turn = math.radians(_number(_input(shader, "rotation")[0], 0.0))
    cosine, sine = math.cos(turn), math.sin(turn)
    return {
        "offset": [x - sine * down, 1.0 - cosine * down - y],
        "rotation": turn,
        "scale": [across, down],
    }


def _is_near(path: str, opened: Composed) -> bool:
    """Whether a file, or the package it is in, lies where the stage may take files from."""
    own, part = path, ""
    if pxr("Ar").IsPackageRelativePath(path):
        own, part = pxr("Ar").SplitPackageRelativePathOuter(path)
    try:
        whole = Path(own).resolve()
        inside = any(whole.is_relative_to(folder) for folder in opened.folders)
    except (OSError, RuntimeError, ValueError):
        return False
    return inside and ".." not in part.split("/")


def _bytes(path: str) -> bytes | None:
    if not pxr("Ar").IsPackageRelativePath(path):
        try:
            allow_for(Path(path).stat().st_size)
            return Path(path).read_bytes()
        except OSError:
            return None
    asset = pxr("Ar").GetResolver().OpenAsset(pxr("Ar").ResolvedPath(path))
    return None if asset is None else bytes(asset.GetBuffer())


def _source(found: Any) -> Any:
    """The shader of what ComputeSurfaceSource gives: it alone, or first of several."""
    return found[0] if isinstance(found, tuple) else found


def _number(value: Any, otherwise: float) -> float:
    try:
        found = float(value)
    except (TypeError, ValueError):
        return otherwise
    return found if math.isfinite(found) else otherwise


def _pair(value: Any, otherwise: float) -> tuple[float, float]:
    if value is None or len(value) != 2:
        return otherwise, otherwise
    return _number(value[0], otherwise), _number(value[1], otherwise)


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
        "copyright": text_of(prim, COPYRIGHT),
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
