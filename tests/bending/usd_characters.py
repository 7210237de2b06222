"""A USD character of several meshes, and what UsdSkel itself makes of one."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from blended_points import blended

HINGE = np.array([0.0, 0.2, 0.0])
ANGLE = 0.6


def sheet(rows: int, columns: int, width: float, depth: float) -> np.ndarray:
    """(N, 3) a sheet below a hinge that runs along x."""
    z, x = np.mgrid[:rows, :columns]
    across, down = width * (x / (columns - 1) - 0.5), -depth * z / (rows - 1)
    return np.stack([across, 0.05 * np.cos(3 * across) + 0 * down, down], axis=-1).reshape(-1, 3)


def jaw(points: np.ndarray) -> np.ndarray:
    """Offsets of points that turn around the hinge, the more the lower they are."""
    part = np.clip(-points[:, 2] / 0.5, 0, 1)
    angle = ANGLE * part * part * (3 - 2 * part)
    arm = points - HINGE
    cos, sin = np.cos(angle), np.sin(angle)
    turned = np.stack(
        [arm[:, 0], cos * arm[:, 1] - sin * arm[:, 2], sin * arm[:, 1] + cos * arm[:, 2]], axis=1
    )
    return turned - arm


def slide(points: np.ndarray) -> np.ndarray:
    """Offsets of points that move aside, which needs no bend."""
    return np.broadcast_to([0.05, 0.0, 0.0], points.shape).copy()


def define_mesh(
    stage: Any,
    path: str,
    points: np.ndarray,
    columns: int,
    shapes: Mapping[str, tuple[np.ndarray, list[int] | None]],
    tokens: list[str] | None = None,
    *,
    normals: bool = False,
) -> Any:
    """A mesh of quads in rows, with blend shapes below it: offsets, of these points only."""
    from pxr import UsdGeom, UsdSkel

    mesh = UsdGeom.Mesh.Define(stage, path)
    mesh.CreatePointsAttr(points.tolist())
    starts = [i for i in range(len(points) - columns) if (i + 1) % columns]
    mesh.CreateFaceVertexCountsAttr([4] * len(starts))
    mesh.CreateFaceVertexIndicesAttr(
        [corner for i in starts for corner in (i, i + 1, i + columns + 1, i + columns)]
    )
    mesh.CreateSubdivisionSchemeAttr("none")
    mesh.CreateExtentAttr(UsdGeom.PointBased.ComputeExtent(mesh.GetPointsAttr().Get()))
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    targets = []
    for name, (offsets, indices) in shapes.items():
        shape = UsdSkel.BlendShape.Define(stage, mesh.GetPath().AppendChild(name))
        shape.CreateOffsetsAttr(offsets.tolist())
        if normals:
            shape.CreateNormalOffsetsAttr((0.1 * offsets).tolist())
        if indices is not None:
            shape.CreatePointIndicesAttr(indices)
        targets.append(shape.GetPath())
    if targets:
        binding.CreateBlendShapesAttr(tokens or list(shapes))
        binding.CreateBlendShapeTargetsRel().SetTargets(targets)
    return mesh


def bind(mesh: Any, skeleton: Any, joint: int, matrix: Any = None) -> None:
    """Bind all points of a mesh to one joint."""
    from pxr import Gf, UsdSkel

    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    count = len(mesh.GetPointsAttr().Get())
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    binding.CreateJointIndicesPrimvar(constant=False, elementSize=1).Set([joint] * count)
    binding.CreateJointWeightsPrimvar(constant=False, elementSize=1).Set([1.0] * count)
    binding.CreateGeomBindTransformAttr(matrix or Gf.Matrix4d(1.0))


HEAD, TEETH = sheet(9, 7, 1.0, 0.5), sheet(5, 5, 0.3, 0.1) + [0.0, 0.1, -0.38]
OFFSET = np.array([0.0, 0.3, 0.1])  # the teeth were modelled elsewhere


def define_character(stage: Any, root: str = "/body", *, normals: bool = False) -> None:
    """Head, teeth placed by their binding, and a hat; a skeleton, materials, an animation.

    The tokens of blend shapes are numbered, as Blender does it, so that each has a weight.
    """
    from pxr import Gf, UsdGeom, UsdShade, UsdSkel, Vt

    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetTimeCodesPerSecond(25)
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(10)
    UsdSkel.Root.Define(stage, root)
    stage.SetDefaultPrim(stage.GetPrimAtPath(root.split("/", 2)[1] and f"/{root.split('/')[1]}"))
    skeleton = UsdSkel.Skeleton.Define(stage, f"{root}/rig")
    skeleton.CreateJointsAttr(["neck", "neck/head"])
    matrices = [Gf.Matrix4d(1.0), Gf.Matrix4d(1.0).SetTranslate(Gf.Vec3d(0, 0, 0.5))]
    skeleton.CreateBindTransformsAttr(Vt.Matrix4dArray(matrices))
    skeleton.CreateRestTransformsAttr(Vt.Matrix4dArray(matrices))
    below = np.flatnonzero(jaw(HEAD).any(axis=1))
    head = define_mesh(
        stage,
        f"{root}/head",
        HEAD,
        7,
        {"jawOpen": (jaw(HEAD)[below], below.tolist()), "jawLeft": (slide(HEAD), None)},
        ["jawOpen2", "jawLeft"],
        normals=normals,
    )
    teeth = define_mesh(
        stage, f"{root}/teeth", TEETH - OFFSET, 5, {"jawOpen": (jaw(TEETH), None)}, ["jawOpen"]
    )
    hat = define_mesh(stage, f"{root}/hat", HEAD + [0, 0, 1.0], 7, {})
    bind(head, skeleton, 1)
    bind(teeth, skeleton, 1, Gf.Matrix4d(1.0).SetTranslate(Gf.Vec3d(*OFFSET.tolist())))
    bind(hat, skeleton, 0)
    skin = UsdShade.Material.Define(stage, f"{root}/skin")
    UsdShade.MaterialBindingAPI.Apply(head.GetPrim()).Bind(skin)
    clip = UsdSkel.Animation.Define(stage, f"{root}/talk")
    clip.CreateJointsAttr(["neck", "neck/head"])
    clip.CreateTranslationsAttr([Gf.Vec3f(0), Gf.Vec3f(0, 0, 0.5)])
    clip.CreateRotationsAttr([Gf.Quatf(1), Gf.Quatf(1)])
    clip.CreateScalesAttr([Gf.Vec3h(1), Gf.Vec3h(1)])
    clip.CreateBlendShapesAttr(["jawLeft", "jawOpen", "jawOpen2"])
    weights = clip.CreateBlendShapeWeightsAttr()
    for code, weight in ((0, 0.0), (4, 0.4), (10, 1.0)):
        weights.Set([0.0, weight, weight], code)
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets(
        [clip.GetPath()]
    )


def character(path: Path, **options: Any) -> Path:
    """The character in a file."""
    from pxr import Usd

    stage = Usd.Stage.CreateInMemory()
    define_character(stage, **options)
    kind = "usda" if path.suffix == ".usda" else "usdc"
    stage.GetRootLayer().Export(str(path), args={"format": kind})
    return path


def played(source: Any, mesh: str, weights: Mapping[str, float]) -> np.ndarray:
    """(N, 3) points of a mesh of a stage or file, by UsdSkel, weights by names of prims."""
    from pxr import Usd

    stage = Usd.Stage.Open(str(source)) if isinstance(source, Path) else source
    prim = stage.GetPrimAtPath(mesh)
    names = [target.name for target in prim.GetRelationship("skel:blendShapeTargets").GetTargets()]
    points = blended(prim, [weights.get(name, 0.0) for name in names])
    return np.array(points, dtype=np.float64)


def complaints(path: Path) -> list[str]:
    """What all validators of USD say about a file, whatever its name."""
    from pxr import Usd, UsdValidation

    known = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    found = UsdValidation.ValidationContext(known).Validate(Usd.Stage.Open(str(path)))
    said = {f"{error.GetName()}: {error.GetMessage()}" for error in found}
    return sorted(sentence.replace(str(path), "") for sentence in said)
