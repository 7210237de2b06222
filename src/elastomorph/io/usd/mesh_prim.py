"""A mesh as a UsdGeom.Mesh prim: polygons as they are, texture coordinates, materials, groups."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError
from elastomorph.io.usd.exact import COARSEST, NAME, POINTS
from elastomorph.io.usd.library import pxr
from elastomorph.io.usd.names import prim_names
from elastomorph.model.mesh import FaceLabels, Mesh, UVMap

__all__ = ["GROUP_FAMILY", "as_float32", "define_mesh", "define_subsets", "extent_of"]

GROUP_FAMILY = "elastomorph:group"


def as_float32(path: str | Path, values: NDArray[np.float64], what: str) -> NDArray[np.float32]:
    """Values in the precision that UsdSkel has.

    Raises:
        FormatError: A value is too large for float32.
    """
    if values.size and float(np.abs(values).max()) > float(np.finfo(np.float32).max):
        raise FormatError(
            path, f"{what} is too large for USD, which stores float32; scale the rig down"
        )
    return values.astype(np.float32)


def define_mesh(path: str | Path, stage: Any, place: str, mesh: Mesh) -> Any:
    """A mesh prim with points, polygons and texture coordinates.

    Returns:
        The ``UsdGeom.Mesh``.

    Raises:
        FormatError: A coordinate is too large for float32.
    """
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
        _texture_coordinates(path, prim, mesh.uv)
    return prim


def define_subsets(stage: Any, prim: Any, mesh: Mesh, taken: list[str], materials: str) -> None:
    """Subsets of the polygons: one a material, bound to it, and one a group.

    Args:
        stage: The stage.
        prim: The mesh prim.
        mesh: The mesh.
        taken: Names of the other children of the mesh prim.
        materials: Path of the scope that the materials go to.
    """
    shade, subset_api = pxr("UsdShade"), pxr("UsdGeom").Subset
    names = list(taken)
    if mesh.materials is not None:
        family = pxr("UsdShade").Tokens.materialBind
        subsets = _subsets(stage, prim, mesh.materials, family, names)
        pxr("UsdGeom").Scope.Define(stage, materials)
        plain = prim_names(mesh.materials.names)
        for subset, name, original in zip(subsets, plain, mesh.materials.names, strict=True):
            material = shade.Material.Define(stage, f"{materials}/{name}")
            material.GetPrim().SetDisplayName(original)
            shade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(material)
        subset_api.SetFamilyType(prim, family, "nonOverlapping")
    if mesh.groups is not None:
        _subsets(stage, prim, mesh.groups, GROUP_FAMILY, names)
        subset_api.SetFamilyType(prim, GROUP_FAMILY, "nonOverlapping")


def extent_of(low: NDArray[np.floating], high: NDArray[np.floating]) -> Any:
    """The box around points, as USD stores it."""
    corners = np.stack([low.min(axis=0), high.max(axis=0)]).astype(np.float32)
    return pxr("Vt").Vec3fArray.FromNumpy(corners)


def _subsets(stage: Any, prim: Any, labels: FaceLabels, family: str, names: list[str]) -> list[Any]:
    geometry, values, value_types = pxr("UsdGeom"), pxr("Vt"), pxr("Sdf").ValueTypeNames
    subsets = []
    plain = prim_names(labels.names, names)
    names += plain
    for i, (name, original) in enumerate(zip(plain, labels.names, strict=True)):
        subset = geometry.Subset.Define(stage, prim.GetPath().AppendChild(name))
        subset.CreateElementTypeAttr(geometry.Tokens.face)
        subset.CreateFamilyNameAttr(family)
        faces = np.flatnonzero(labels.of_face == i).astype(np.int32)
        subset.CreateIndicesAttr(values.IntArray.FromNumpy(faces))
        subset.GetPrim().SetDisplayName(original)
        kept = subset.GetPrim().CreateAttribute(NAME, value_types.String, custom=True)
        kept.Set(original)
        subsets.append(subset)
    return subsets


def _texture_coordinates(path: str | Path, prim: Any, uv: UVMap) -> None:
    geometry, values, value_types = pxr("UsdGeom"), pxr("Vt"), pxr("Sdf").ValueTypeNames
    coordinates = as_float32(path, uv.coordinates, "a texture coordinate")
    corners = np.array(uv.corners)
    bare = corners < 0
    sparse = bool(bare.any()) or not len(coordinates)
    if sparse:
        # a corner without coordinates points to a value that is marked as standing for none
        corners[bare] = len(coordinates)
        coordinates = np.concatenate([coordinates, np.zeros((1, coordinates.shape[1]), np.float32)])
    flat = coordinates.shape[1] == 2
    primvar = geometry.PrimvarsAPI(prim).CreatePrimvar(
        "st",
        value_types.TexCoord2fArray if flat else value_types.TexCoord3fArray,
        geometry.Tokens.faceVarying,
    )
    array = values.Vec2fArray if flat else values.Vec3fArray
    primvar.Set(array.FromNumpy(coordinates))
    primvar.SetIndices(values.IntArray.FromNumpy(corners.astype(np.int32)))
    if sparse:
        primvar.SetUnauthoredValuesIndex(len(coordinates) - 1)
