"""A rig as USD: UsdSkel blend shapes whose in-betweens follow the curved paths.

The file holds, in whatever program opens it, /Face (a SkelRoot), /Face/Mesh with its blend shapes
and subsets below it, /Face/Skeleton of one joint, /Face/Animation with the weights, and
/Face/Materials. +Y is up. Where the head turns, the joint that holds the face turns about the neck.
Images of materials are files beside it, which have its name before theirs, or lie in the package.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import FormatError, ParameterError
from elastomorph.io.atomic import replacing, replacing_path
from elastomorph.io.blend_shapes import driven_weights, require_turn
from elastomorph.io.usd.exact import checksum, path_to_json, prim_names
from elastomorph.io.usd.inbetweens import Placement, place_inbetweens
from elastomorph.io.usd.library import (
    BENDS,
    COPYRIGHT,
    GROUP_FAMILY,
    NAME,
    PATH,
    POINTS,
    SETTINGS,
    SLIDERS,
    naming_failure,
    pxr,
)
from elastomorph.io.usd.materials import Images, define_look
from elastomorph.model.mesh import FaceLabels, Mesh, UVMap
from elastomorph.model.morph import Morph
from elastomorph.rig import Rig
from elastomorph.rig.fields import MorphFields
from elastomorph.rig.performance import HeadTurn, head_quaternions

_JOINT = "root"
COARSEST = 1e-7  # of D: a rounding to float32 larger than this is not accepted


def set_text(prim: Any, name: str, text: str) -> None:
    """An attribute of our own that holds text."""
    prim.CreateAttribute(name, pxr("Sdf").ValueTypeNames.String, custom=True).Set(text)


def extent_of(low: NDArray[np.floating], high: NDArray[np.floating]) -> Any:
    """The box around points, as USD stores it."""
    corners = np.stack([low.min(axis=0), high.max(axis=0)]).astype(np.float32)
    return pxr("Vt").Vec3fArray.FromNumpy(corners)


def define_mesh(path: str | Path, stage: Any, place: str, mesh: Mesh) -> Any:
    """A ``UsdGeom.Mesh`` with points, polygons and texture coordinates."""
    geometry, values, value_types = pxr("UsdGeom"), pxr("Vt"), pxr("Sdf").ValueTypeNames
    prim = geometry.Mesh.Define(stage, place)
    points = as_float32(path, mesh.vertices, "a coordinate")
    prim.CreatePointsAttr(values.Vec3fArray.FromNumpy(points))
    if np.abs(points - mesh.vertices).max() > COARSEST * mesh.diameter:
        exact = prim.GetPrim().CreateAttribute(POINTS, value_types.Double3Array, custom=True)
        exact.Set(values.Vec3dArray.FromNumpy(np.array(mesh.vertices)))
    prim.CreateFaceVertexCountsAttr(values.IntArray.FromNumpy(mesh.faces.sizes.astype(np.int32)))
    prim.CreateFaceVertexIndicesAttr(values.IntArray.FromNumpy(np.array(mesh.faces.indices)))
    prim.CreateSubdivisionSchemeAttr(geometry.Tokens.none)
    prim.CreateOrientationAttr(geometry.Tokens.rightHanded)
    prim.CreateExtentAttr(extent_of(points, points))
    if mesh.uv is not None:
        _set_texture_coordinates(path, prim, mesh.uv)
    return prim


def _set_texture_coordinates(path: str | Path, prim: Any, uv: UVMap) -> None:
    geometry, values, value_types = pxr("UsdGeom"), pxr("Vt"), pxr("Sdf").ValueTypeNames
    coordinates = as_float32(path, uv.coordinates, "a texture coordinate")
    corners = np.array(uv.corners)
    bare = corners < 0
    sparse = bool(bare.any()) or not len(coordinates)
    if sparse:
        # a corner without coordinates points to a value that is marked as standing for none
        corners[bare] = len(coordinates)
        coordinates = np.concatenate([coordinates, np.zeros((1, coordinates.shape[1]), np.float32)])
    width = coordinates.shape[1]
    kind = getattr(value_types, f"TexCoord{width}fArray")
    primvar = geometry.PrimvarsAPI(prim).CreatePrimvar("st", kind, geometry.Tokens.faceVarying)
    primvar.Set(getattr(values, f"Vec{width}fArray").FromNumpy(coordinates))
    primvar.SetIndices(values.IntArray.FromNumpy(corners.astype(np.int32)))
    if sparse:
        primvar.SetUnauthoredValuesIndex(len(coordinates) - 1)


def define_subsets(
    stage: Any, prim: Any, mesh: Mesh, taken: list[str], materials: str, images: Images
) -> None:
    """Subsets of the polygons: one a material, bound to it in this scope, and one a group.

    Their names differ from those that other children of the mesh prim have taken.
    """
    shade = pxr("UsdShade")
    names = list(taken)
    if mesh.materials is not None:
        family = shade.Tokens.materialBind
        subsets = _define_family(stage, prim, mesh.materials, family, names)
        pxr("UsdGeom").Scope.Define(stage, materials)
        plain = prim_names(mesh.materials.names)
        for subset, name, original in zip(subsets, plain, mesh.materials.names, strict=True):
            material = shade.Material.Define(stage, f"{materials}/{name}")
            material.GetPrim().SetDisplayName(original)
            shade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(material)
            if look := (mesh.appearance or {}).get(original):
                define_look(stage, material, look, None if mesh.uv is None else images)
        looks = (mesh.appearance or {}).values()
        prim.CreateDoubleSidedAttr(any(look.double_sided for look in looks))
    if mesh.groups is not None:
        _define_family(stage, prim, mesh.groups, GROUP_FAMILY, names)


def _define_family(
    stage: Any, prim: Any, labels: FaceLabels, family: str, taken: list[str]
) -> list[Any]:
    """A subset a label; their names join those that are taken."""
    geometry = pxr("UsdGeom")
    subsets = []
    plain = prim_names(labels.names, taken)
    taken += plain
    for i, (name, original) in enumerate(zip(plain, labels.names, strict=True)):
        subset = geometry.Subset.Define(stage, prim.GetPath().AppendChild(name))
        subset.CreateElementTypeAttr(geometry.Tokens.face)
        subset.CreateFamilyNameAttr(family)
        faces = np.flatnonzero(labels.of_face == i).astype(np.int32)
        subset.CreateIndicesAttr(pxr("Vt").IntArray.FromNumpy(faces))
        subset.GetPrim().SetDisplayName(original)
        set_text(subset.GetPrim(), NAME, original)
        subsets.append(subset)
    geometry.Subset.SetFamilyType(prim, family, "nonOverlapping")
    return subsets


@dataclass(frozen=True, eq=False)
class SparseShapes:
    """The shapes that UsdSkel plays, on the points that any of them moves."""

    points: NDArray[np.int32]  # (N,) int32 rising, N ≥ 1
    offsets: NDArray[np.float32]  # (1 + n, N, 3) from the neutral: target, then in-betweens
    weights: NDArray[np.float32]  # (n,) float32 of the in-betweens, rising


def sparse_shapes(path: str | Path, morph: Morph, placement: Placement) -> SparseShapes:
    """The shapes of a morph at 1 and at its in-betweens.

    Vertices that move less than 1e-7 of D all along the path stay where they are.
    """
    fields = MorphFields.of(morph)
    peaks = np.array([1.0, *(curve.height for curve in morph.bend_curves)])
    reach = peaks @ np.linalg.norm(fields.fields, axis=2)
    # the noise of scans and solvers below float32 would make most points of a face move
    points = fields.moved[reach > COARSEST * morph.neutral.diameter]
    if not points.size:
        points = np.zeros(1, dtype=np.int32)  # no point at all would mean every point to UsdSkel
    times = np.concatenate([[1.0], placement.weights])
    rows = np.concatenate([morph.delta[None, points], morph.bends[:, points]])
    offsets = np.tensordot(fields.factors(times), rows, axes=1)
    offsets = as_float32(path, offsets, "an offset")
    return SparseShapes(points, offsets, placement.weights.astype(np.float32))


def define_blend_shape(
    path: str | Path, stage: Any, place: str, name: str, morph: Morph, shapes: SparseShapes
) -> None:
    """A BlendShape prim with its in-betweens, and the exact path of the morph beside them."""
    values = pxr("Vt")
    shape = pxr("UsdSkel").BlendShape.Define(stage, place)
    vectors = [values.Vec3fArray.FromNumpy(own) for own in shapes.offsets]
    shape.CreateOffsetsAttr(vectors[0])
    shape.CreatePointIndicesAttr(values.IntArray.FromNumpy(shapes.points))
    for weight, own in zip(shapes.weights.tolist(), vectors[1:], strict=True):
        inbetween = shape.CreateInbetween(inbetween_name(weight))
        inbetween.SetWeight(weight)
        inbetween.SetOffsets(own)
    prim = shape.GetPrim()
    prim.SetDisplayName(name)
    set_text(prim, NAME, name)
    belonging = checksum([shapes.points, shapes.offsets, shapes.weights])
    set_text(prim, PATH, path_to_json(morph, belonging))
    bends = morph.bends[:, shapes.points]
    if not bends.size:
        return
    peaks = np.array([curve.height for curve in morph.bend_curves])
    stored = rounded_bends(path, bends, peaks, morph.neutral.diameter)
    kind, array = array_of_bends(stored)
    prim.CreateAttribute(BENDS, kind, custom=True).Set(array)


def inbetween_name(weight: float) -> str:
    """The name of an in-between; at least four digits, so that names sort as the weights do."""
    return "at_" + f"{weight:.9f}"[2:].rstrip("0").ljust(4, "0")


def rounded_bends(
    path: str | Path, bends: NDArray[np.float64], peaks: NDArray[np.float64], extent: float
) -> NDArray[np.floating]:
    """(K, N, 3) bends as they are stored: float32, unless that moves the path too far.

    Bends of a bake cancel each other, so that rounding counts by the peaks (K,) of their curves.
    """
    coarse = as_float32(path, bends, "a bend")
    rounding = (peaks @ np.linalg.norm(bends - coarse, axis=2)).max()
    return coarse if rounding <= COARSEST * extent else bends


def array_of_bends(bends: NDArray[np.floating]) -> tuple[Any, Any]:
    """The type and the value of the attribute that holds (K, N, 3) bends."""
    of = "d" if bends.dtype == np.float64 else "f"
    kind = getattr(pxr("Sdf").ValueTypeNames, f"Vector3{of}Array")
    return kind, getattr(pxr("Vt"), f"Vec3{of}Array").FromNumpy(bends.reshape(-1, 3))


def as_float32(path: str | Path, values: NDArray[np.float64], what: str) -> NDArray[np.float32]:
    """Numbers as USD stores them; a FormatError where they are too large for that."""
    if values.size and float(np.abs(values).max()) > float(np.finfo(np.float32).max):
        raise FormatError(
            path, f"{what} is too large for USD, which stores float32; scale the rig down"
        )
    return values.astype(np.float32)


def define_skeleton(stage: Any, place: str, mesh: Any, count: int, shapes: list[str]) -> Any:
    """A skeleton of one joint that never moves, which UsdSkel wants around blend shapes.

    The mesh prim, of so many points, is bound to the joint and to the blend shapes below it.
    """
    gf, values = pxr("Gf"), pxr("Vt")
    identity = values.Matrix4dArray(1, gf.Matrix4d(1.0))
    skeleton = pxr("UsdSkel").Skeleton.Define(stage, place)
    skeleton.CreateJointsAttr([_JOINT])
    skeleton.CreateBindTransformsAttr(identity)
    skeleton.CreateRestTransformsAttr(identity)
    binding = pxr("UsdSkel").BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    binding.CreateGeomBindTransformAttr(gf.Matrix4d(1.0))
    # one influence a point: a constant one is allowed, but not all importers know it
    indices = binding.CreateJointIndicesPrimvar(constant=False, elementSize=1)
    indices.Set(values.IntArray(count, 0))
    weights = binding.CreateJointWeightsPrimvar(constant=False, elementSize=1)
    weights.Set(values.FloatArray(count, 1.0))
    binding.CreateBlendShapesAttr(shapes)
    targets = [mesh.GetPath().AppendChild(shape) for shape in shapes]
    binding.CreateBlendShapeTargetsRel().SetTargets(targets)
    return skeleton


def define_animation(
    stage: Any,
    place: str,
    skeleton: Any,
    shapes: list[str],
    animation: tuple[NDArray[np.float64], NDArray[np.float64], str] | None,
    fps: float,
) -> None:
    """The weights of the blend shapes of these names: all at rest, or an animation.

    That is rising times (T,) in seconds, weights (T, J), one column a morph, and a name. It sets
    the time range of the stage.
    """
    gf, values = pxr("Gf"), pxr("Vt")
    prim = pxr("UsdSkel").Animation.Define(stage, place)
    prim.CreateJointsAttr([_JOINT])
    prim.CreateTranslationsAttr([gf.Vec3f(0.0)])
    prim.CreateRotationsAttr([gf.Quatf(1.0)])
    prim.CreateScalesAttr([gf.Vec3h(1.0)])
    prim.CreateBlendShapesAttr(shapes)
    weights = prim.CreateBlendShapeWeightsAttr(values.FloatArray(len(shapes), 0.0))
    source = pxr("UsdSkel").BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel()
    source.SetTargets([prim.GetPath()])
    stage.SetTimeCodesPerSecond(fps)
    stage.SetFramesPerSecond(fps)
    if animation is None:
        return
    times, rows, name = animation
    prim.GetPrim().SetDisplayName(name)
    codes = codes_of(times, fps)
    for code, row in zip(codes.tolist(), rows.astype(np.float32), strict=True):
        weights.Set(values.FloatArray.FromNumpy(row), code)
    stage.SetStartTimeCode(float(codes[0]))
    stage.SetEndTimeCode(float(codes[-1]))


def codes_of(times: NDArray[np.float64], fps: float) -> NDArray[np.float64]:
    """(T,) time codes of seconds."""
    codes = times * fps
    near = np.round(codes)
    return np.where(np.abs(codes - near) < 1e-6, near, codes)  # 7 / 30 · 30 is not quite 7


def turn_joint(
    stage: Any, place: str, skeleton: Any, turn: HeadTurn, codes: NDArray[np.float64]
) -> None:
    """Turn the one joint of a skeleton by its animation at this place, a key at each time code.

    The joint is bound in the neck and rests there, so that nothing else moves.
    """
    gf, values = pxr("Gf"), pxr("Vt")
    at = gf.Vec3f(*turn.pivot.tolist())
    neck = gf.Matrix4d(1.0).SetTranslate(gf.Vec3d(at))
    bound = values.Matrix4dArray(1, neck)
    skeleton.GetBindTransformsAttr().Set(bound)
    skeleton.GetRestTransformsAttr().Set(bound)
    animation = pxr("UsdSkel").Animation.Get(stage, place)
    animation.GetTranslationsAttr().Set([at])
    rotations = animation.GetRotationsAttr()
    for code, (x, y, z, w) in zip(
        codes.tolist(), head_quaternions(turn.angles).tolist(), strict=True
    ):
        rotations.Set(values.QuatfArray(1, gf.Quatf(w, x, y, z)), code)


SUFFIXES = (".usd", ".usda", ".usdc")
_PACKAGE = ".usdz"
_ROOT = "/Face"


@dataclass(frozen=True)
class BlendShapeReport:
    """How one morph stands in the file.

    Attributes:
        name: Name of the morph in the rig.
        prim_name: Its name in the file, where spaces, dots and accents are not allowed.
        inbetweens: Weights of its in-betweens, rising between 0 and 1.
        error: Largest distance between the straight pieces that UsdSkel plays and the curved
            path, as a fraction of D, for weights from 0 to 1 and besides the rounding to float32.
        straight_error: What it would be without in-betweens.
        points: Vertices that it moves.
    """

    name: str
    prim_name: str
    inbetweens: tuple[float, ...]
    error: float
    straight_error: float
    points: int


@dataclass(frozen=True)
class UsdReport:
    """What was written.

    Attributes:
        path: The file.
        size: Its size in bytes.
        tolerance: The error asked for, as a fraction of D.
        shapes: One entry a morph, in the order of the rig.
    """

    path: Path
    size: int
    tolerance: float
    shapes: tuple[BlendShapeReport, ...]

    @property
    def error(self) -> float:
        """The largest error of all morphs, as a fraction of D."""
        return max((shape.error for shape in self.shapes), default=0.0)

    @property
    def above_tolerance(self) -> tuple[BlendShapeReport, ...]:
        """The morphs for which the in-betweens allowed did not suffice."""
        return tuple(shape for shape in self.shapes if shape.error > self.tolerance)


def write_usd(
    path: str | Path,
    rig: Rig,
    *,
    tolerance: float = 1e-3,
    most_inbetweens: int = 3,
    animation: tuple[ArrayLike, ArrayLike, str] | None = None,
    fps: float = 30.0,
    meters_per_unit: float = 0.01,
    settings: Mapping[str, Any] | None = None,
    turn: HeadTurn | None = None,
) -> UsdReport:
    """Write a rig as UsdSkel blend shapes.

    UsdSkel in-betweens are piecewise linear in the weight. Each morph gets the fewest that keep
    it within the tolerance of its curved path, where they help most. The curved paths are kept
    too, and `read_usd` gives them back; correctives become shapes of their own, and other
    programs must drive them.

    Args:
        path: The file: .usda is text, .usdc and .usd are binary, .usdz a package with its images.
            Images of the others lie beside it, with its name before theirs.
        rig: The rig.
        tolerance: Distance between the two paths that is small enough, as a fraction of D.
        most_inbetweens: Largest number of in-betweens of a morph.
        animation: Times (T,) in seconds, rising; slider weights (T, S) in the order of
            ``rig.names``, 1 the target; and a name. All weights are 0 where it is left out.
        fps: Time codes in a second.
        meters_per_unit: Length of a unit in metres; by default that of files that state none.
        settings: How the rig was made, as JSON; `elastomorph.io.registry` gives it back.
        turn: How the joint that holds the face, then in its neck, turns with the animation.

    Returns:
        The in-betweens and the remaining error of each morph, and the size of the file.

    Raises:
        MissingExtraError: usd-core is not installed.
        ParameterError: An argument is out of its range, or not a rig.
        FormatError: Another suffix, a coordinate too large for float32, or a name that is no text.
        FileError: The file cannot be written.
    """
    if not isinstance(rig, Rig):
        raise ParameterError(f"expected a Rig to write, found {type(rig).__name__}")
    require_usd_settings(tolerance, most_inbetweens, fps, meters_per_unit)
    suffix = Path(path).suffix.lower()
    if suffix not in (*SUFFIXES, _PACKAGE):
        raise FormatError(path, f"expected a name that ends in {', '.join((*SUFFIXES, _PACKAGE))}")
    _require_texts(path, rig)
    motion = animation and (*driven_weights(rig, *animation[:2]), str(animation[2]))
    images = Images("" if suffix == _PACKAGE else f"{Path(path).stem}_")
    with replacing_path(path) as temporary, naming_failure(path), ExitStack() as beside:
        stage = pxr("Usd").Stage.CreateInMemory()
        pxr("UsdGeom").SetStageMetersPerUnit(stage, meters_per_unit)
        shapes = _author(path, stage, rig, tolerance, most_inbetweens, motion, fps, turn, images)
        if settings is not None:
            text = json.dumps(settings, ensure_ascii=False, allow_nan=False)
            set_text(stage.GetPrimAtPath(f"{_ROOT}/Mesh"), SETTINGS, text)
        if rig.neutral.copyright:
            set_text(stage.GetPrimAtPath(f"{_ROOT}/Mesh"), COPYRIGHT, rig.neutral.copyright)
        layer, mode = stage.GetRootLayer(), temporary.stat().st_mode
        # A comment is read by people; of other programs' files it may say anything.
        layer.comment = rig.neutral.copyright
        if suffix == _PACKAGE:
            _pack(temporary, layer, images)
        else:
            for content, name in images.names.items():
                beside.enter_context(replacing(Path(path).parent / name)).write(content)
            kind = "usda" if suffix == ".usda" else "usdc"
            layer.Export(str(temporary), args={"format": kind})
        temporary.chmod(mode)
        size = temporary.stat().st_size
    return UsdReport(Path(path), size, tolerance, shapes)


def _pack(path: Path, layer: Any, images: Images) -> None:
    """Write a package of a layer and its images."""
    with TemporaryDirectory() as folder:
        first = Path(folder) / "face.usdc"
        layer.Export(str(first))
        package = pxr("Sdf").ZipFileWriter.CreateNew(str(path))
        package.AddFile(str(first), first.name)
        for content, name in images.names.items():
            file = Path(folder) / name
            file.write_bytes(content)
            package.AddFile(str(file), name)
        package.Save()


def require_usd_settings(
    tolerance: float = 0.0,
    most_inbetweens: int = 0,
    fps: float = 30.0,
    meters_per_unit: float = 0.01,
) -> None:
    """Check options of `write_usd`."""
    for what, number in (("fps", fps), ("meters_per_unit", meters_per_unit)):
        if not (np.isfinite(number) and number > 0):
            raise ParameterError(f"{what} must be a number above 0, found {number!r}")
    if not (np.isfinite(tolerance) and tolerance >= 0):
        raise ParameterError(f"the tolerance must be a number of at least 0, found {tolerance!r}")
    if not isinstance(most_inbetweens, int) or most_inbetweens < 0:
        raise ParameterError(
            f"most_inbetweens must be a whole number of at least 0, found {most_inbetweens!r}"
        )


def _require_texts(path: str | Path, rig: Rig) -> None:
    """Refuse names with a NUL, at which USD would end them, or half a character."""
    labels = (rig.neutral.materials, rig.neutral.groups)
    for name in (*rig.morphs, *(name for own in labels if own is not None for name in own.names)):
        if "\0" in name or name.encode("utf-8", "replace").decode() != name:
            raise FormatError(path, f"the name {name!r} cannot be stored as text; rename it")


def _author(
    path: str | Path,
    stage: Any,
    rig: Rig,
    tolerance: float,
    most: int,
    animation: tuple[NDArray[np.float64], NDArray[np.float64], str] | None,
    fps: float,
    turn: HeadTurn | None,
    images: Images,
) -> tuple[BlendShapeReport, ...]:
    require_turn(turn, 0 if animation is None else len(animation[0]))
    pxr("UsdGeom").SetStageUpAxis(stage, pxr("UsdGeom").Tokens.y)
    root = pxr("UsdSkel").Root.Define(stage, _ROOT)
    stage.SetDefaultPrim(root.GetPrim())
    pxr("Usd").ModelAPI(root.GetPrim()).SetKind(pxr("Kind").Tokens.component)
    mesh = define_mesh(path, stage, f"{_ROOT}/Mesh", rig.neutral)
    names = prim_names(rig.morphs)
    low, high = rig.neutral.vertices.copy(), rig.neutral.vertices.copy()
    reports = []
    for plain, (name, morph) in zip(names, rig.morphs.items(), strict=True):
        placement = place_inbetweens(morph, tolerance=tolerance, most=most)
        shapes = sparse_shapes(path, morph, placement)
        define_blend_shape(path, stage, f"{_ROOT}/Mesh/{plain}", name, morph, shapes)
        low[shapes.points] += np.minimum(shapes.offsets.min(axis=0), 0)
        high[shapes.points] += np.maximum(shapes.offsets.max(axis=0), 0)
        weights, errors = placement.weights.tolist(), (placement.error, placement.straight_error)
        reports.append(BlendShapeReport(name, plain, tuple(weights), *errors, len(shapes.points)))
    define_subsets(stage, mesh, rig.neutral, names, f"{_ROOT}/Materials", images)
    skeleton = define_skeleton(stage, f"{_ROOT}/Skeleton", mesh, len(low), names)
    define_animation(stage, f"{_ROOT}/Animation", skeleton, names, animation, fps)
    if turn is not None and animation is not None:
        turn_joint(stage, f"{_ROOT}/Animation", skeleton, turn, codes_of(animation[0], fps))
        reach = np.linalg.norm(np.maximum(high - turn.pivot, turn.pivot - low), axis=1).max()
        low, high = (np.array([turn.pivot + side * reach]) for side in (-1, 1))
    root.CreateExtentAttr(extent_of(low, high))
    sliders = {
        "version": 1,
        "morphs": list(rig.morphs),
        "correctives": {
            name: entry if "law" in (entry := own.entry()) else entry["drivers"]
            for name, own in rig.sliders.correctives.items()
        },
        "groups": {name: list(own) for name, own in rig.sliders.groups.items()},
        "materialLibrary": rig.neutral.material_library,
        "checksum": checksum([rig.neutral.vertices.astype(np.float32)]),
    }
    set_text(mesh.GetPrim(), SLIDERS, json.dumps(sliders))
    return tuple(reports)
