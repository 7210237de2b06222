"""Skinned meshes stand where UsdSkel holds them at rest."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import elastomorph as em
from blended_points import blended
from elastomorph.bending.usd import bend_usd
from elastomorph.errors import FormatError
from needs import extra

extra("pxr", "usd")

ROWS, COLUMNS = 5, 3


def sheet(height: float) -> np.ndarray:
    y, x = np.mgrid[:ROWS, :COLUMNS]
    return np.stack([0.2 * x, 0.25 * y + height, 0.05 * x * x], axis=-1).reshape(-1, 3)


def swing(points: np.ndarray) -> np.ndarray:
    """Offsets of points that turn around x, the more the higher they are."""
    angle = 0.5 * (points[:, 1] - points[:, 1].min())
    cos, sin = np.cos(angle), np.sin(angle)
    y, z = points[:, 1], points[:, 2] - 0.4
    moved = np.stack([points[:, 0], cos * y - sin * z, sin * y + cos * z + 0.4], axis=1)
    return moved - points


def matrix(angle: float, shift: tuple[float, float, float], scale: float = 1.0) -> Any:
    from pxr import Gf

    turn = Gf.Rotation(Gf.Vec3d(1, 0.3, 0).GetNormalized(), angle)
    return Gf.Matrix4d().SetScale(scale) * Gf.Matrix4d().SetTransform(turn, Gf.Vec3d(*shift))


def character(path: Path, joints: dict[str, Any], *, rest: Any = None, order: Any = None) -> Path:
    """Skin held by two joints in turn, and an eye, bound elsewhere, by the second alone."""
    from pxr import Usd, UsdGeom, UsdSkel, Vt

    stage = Usd.Stage.CreateInMemory()
    root = UsdSkel.Root.Define(stage, "/body")
    UsdGeom.XformCommonAPI(root).SetTranslate((0.0, 5.0, 0.0))
    skeleton = UsdSkel.Skeleton.Define(stage, "/body/rig")
    UsdGeom.XformCommonAPI(skeleton).SetRotate((0.0, 30.0, 0.0))
    skeleton.CreateJointsAttr(["neck", "neck/head"])
    bind = [matrix(10, (0, 0.2, 0)), matrix(40, (0, 1.0, 0.1))]
    skeleton.CreateBindTransformsAttr(Vt.Matrix4dArray(bind))
    local = [bind[0], bind[1] * bind[0].GetInverse()] if rest is None else rest
    skeleton.CreateRestTransformsAttr(Vt.Matrix4dArray(local))
    blend = np.linspace(0, 1, ROWS).repeat(COLUMNS)
    for name, points, held, placed in (
        ("skin", sheet(0.0), np.stack([1 - blend, blend], axis=1), None),
        (
            "eye",
            10 * sheet(0.0),
            np.tile([0.0, 1.0], (ROWS * COLUMNS, 1)),
            matrix(0, (0, 1, 0), 0.05),
        ),
    ):
        mesh = UsdGeom.Mesh.Define(stage, f"/body/{name}")
        UsdGeom.XformCommonAPI(mesh).SetTranslate((9.0, 9.0, 9.0))  # which skinning ignores
        mesh.CreatePointsAttr(points.tolist())
        starts = [i for i in range((ROWS - 1) * COLUMNS) if (i + 1) % COLUMNS]
        mesh.CreateFaceVertexCountsAttr([4] * len(starts))
        corners = [(i, i + 1, i + COLUMNS + 1, i + COLUMNS) for i in starts]
        mesh.CreateFaceVertexIndicesAttr(np.ravel(corners).tolist())
        shape = UsdSkel.BlendShape.Define(stage, f"/body/{name}/up")
        shape.CreateOffsetsAttr(swing(points).tolist())
        binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
        binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
        binding.CreateBlendShapesAttr(["up"])
        binding.CreateBlendShapeTargetsRel().SetTargets([shape.GetPath()])
        if placed is not None:
            binding.CreateGeomBindTransformAttr(placed)
        if order is not None:
            binding.CreateJointsAttr(order)
        binding.CreateJointIndicesPrimvar(constant=False, elementSize=2).Set(
            joints.get(name, [0, 1] * len(points))
        )
        binding.CreateJointWeightsPrimvar(constant=False, elementSize=2).Set(
            held.astype(np.float32).ravel().tolist()
        )
    stage.GetRootLayer().Export(str(path))
    return path


def at_rest(path: Path, name: str, weight: float) -> np.ndarray:
    """(N, 3) points in the world as UsdSkel blends and skins them."""
    from pxr import Usd, UsdGeom, UsdSkel

    stage = Usd.Stage.Open(str(path))
    cache = UsdSkel.Cache()
    assert cache.Populate(UsdSkel.Root(stage.GetPrimAtPath("/body")), Usd.PrimDefaultPredicate)
    skeleton = UsdSkel.Skeleton(stage.GetPrimAtPath("/body/rig"))
    prim = stage.GetPrimAtPath(f"/body/{name}")
    points = blended(prim, [weight])
    transforms = cache.GetSkelQuery(skeleton).ComputeSkinningTransforms(0.0)
    skinning = cache.GetSkinningQuery(prim)
    mapper = skinning.GetJointMapper()
    assert skinning.ComputeSkinnedPoints(
        mapper.RemapTransforms(transforms) if mapper else transforms, points, 0.0
    )
    world = UsdGeom.XformCache().GetLocalToWorldTransform(skeleton.GetPrim())
    return np.array([world.Transform(own) for own in points])


POSED = [matrix(-20, (0.1, 0.3, 0)), matrix(70, (0, 0.9, 0.4))]


def apart(rig: em.Rig, path: Path, weight: float) -> float:
    """How far the rig is from what UsdSkel shows, wherever the main mesh is put."""
    shown = np.concatenate([at_rest(path, name, weight) for name in ("skin", "eye")])
    own = rig.pose({"up": weight})
    # where the main mesh goes is free: the best rigid map, by orthogonal Procrustes
    own, shown = own - own.mean(axis=0), shown - shown.mean(axis=0)
    left, _, right = np.linalg.svd(own.T @ shown)
    assert np.linalg.det(left @ right) > 0
    return float(np.linalg.norm(own @ left @ right - shown, axis=1).max())


def as_bound(rig: em.Rig) -> bool:
    """Whether the skin has the shape in which it is stored."""
    skin = rig.neutral.vertices[: ROWS * COLUMNS]
    spans = [np.linalg.norm(own[:, None] - own, axis=2) for own in (skin, sheet(0.0))]
    return bool(np.abs(spans[0] - spans[1]).max() < 1e-6)


@pytest.mark.parametrize("posed", [False, True])
def test_meshes_stand_as_usd_shows_them_at_rest(tmp_path: Path, posed: bool) -> None:
    path = character(tmp_path / "skin.usda", {}, rest=POSED if posed else None)
    rig = em.read_rig(path, method="linear")
    for weight in (0.0, 1.0):
        assert apart(rig, path, weight) < 2e-6
    assert as_bound(rig) is not posed


@pytest.mark.parametrize("posed", [False, True])
def test_a_posed_character_is_bent_where_it_rests(tmp_path: Path, posed: bool) -> None:
    path = character(tmp_path / "skin.usda", {}, rest=POSED if posed else None)
    layer = tmp_path / "bent.usda"
    report = bend_usd(path, layer, tolerance=1e-4)
    assert report.bent[0].gain > 1e-2
    rig = em.read_rig(layer)
    assert rig.morphs["up"].method == "rotation"
    made = em.read_rig(path)
    for weight in (0.2, 0.5, 0.9):
        assert apart(rig, layer, weight) < 1.1e-4 * report.extent
        away = made.pose({"up": weight}) - rig.pose({"up": weight})
        assert np.linalg.norm(away, axis=1).max() < 2e-5 * report.extent


def test_joints_of_a_mesh_in_an_order_of_its_own(tmp_path: Path) -> None:
    swapped = {name: [1, 0] * (ROWS * COLUMNS) for name in ("skin", "eye")}
    plain = character(tmp_path / "plain.usda", {}, rest=POSED)
    named = ["neck/head", "neck"]
    own = character(tmp_path / "own.usda", swapped, rest=POSED, order=named)
    rigs = [em.read_rig(path, method="linear") for path in (plain, own)]
    np.testing.assert_allclose(
        rigs[0].neutral.vertices, rigs[1].neutral.vertices, rtol=0, atol=1e-12
    )


@pytest.mark.parametrize(
    ("indices", "order", "words"),
    [
        ([0, 7] * 15, None, r"/body/skin is held by joints 0 to 7, but there are 2"),
        ([0, 1] * 14, None, "28 joint indices and 30 joint weights, expected 30 for 15 points"),
        ([0, 1] * 15, ["neck", "neck/tail"], "the joint 'neck/tail', which its skeleton /body/rig"),
    ],
)
def test_skins_with_missing_joints_are_refused(
    tmp_path: Path, indices: list[int], order: list[str] | None, words: str
) -> None:
    path = character(tmp_path / "skin.usda", {"skin": indices}, rest=POSED, order=order)
    with pytest.raises(FormatError, match=words):
        em.read_rig(path, method="linear")


def test_a_skeleton_that_does_not_say_how_it_rests(tmp_path: Path) -> None:
    """Its meshes stand as they were bound."""
    path = character(tmp_path / "skin.usda", {}, rest=POSED[:1])
    rig = em.read_rig(path, method="linear")
    assert as_bound(rig)
