"""A rig as prims: Mesh with GeomSubsets and materials, BlendShapes, Skeleton, SkelAnimation."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError
from elastomorph.io.usd.exact import checksum, path_to_json, prim_names
from elastomorph.io.usd.inbetweens import Placement
from elastomorph.io.usd.library import BENDS, GROUP_FAMILY, NAME, PATH, POINTS, pxr
from elastomorph.model.mesh import FaceLabels, Mesh, UVMap
from elastomorph.model.morph import Morph
from elastomorph.rig.fields import MorphFields

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


def define_subsets(stage: Any, prim: Any, mesh: Mesh, taken: list[str], materials: str) -> None:
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
