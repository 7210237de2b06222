"""A layer of bends adds the pair bends of targets that meet, and what plays them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from usd_characters import HEAD, OFFSET, TEETH, bind, complaints, define_mesh, jaw, played

import elastomorph as em
from elastomorph.bending.usd import bend_usd
from needs import extra

extra("pxr", "usd")

PAIR = "jawOpen_mouthClose"
MESHES = ("/body/head", "/body/teeth")
CODES = ((0.0, 0.0, 1.0), (3.5, 0.2, 0.9), (4.0, 0.9, 0.1), (10.0, 1.0, 1.0))
"""Time codes, and weights of jawOpen and mouthClose that cross twice between them."""


def meeting(path: Path, *, clip: bool = True, apart: bool = True) -> Path:
    """Head and teeth whose jaw opens, and a target that takes most of it back.

    The weights of the teeth are ``apart`` those of the head, as Blender writes them, or the same.
    """
    from pxr import Gf, Usd, UsdGeom, UsdSkel, Vt

    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(10)
    root = UsdSkel.Root.Define(stage, "/body")
    stage.SetDefaultPrim(root.GetPrim())
    skeleton = UsdSkel.Skeleton.Define(stage, "/body/rig")
    skeleton.CreateJointsAttr(["neck"])
    skeleton.CreateBindTransformsAttr(Vt.Matrix4dArray([Gf.Matrix4d(1.0)]))
    skeleton.CreateRestTransformsAttr(Vt.Matrix4dArray([Gf.Matrix4d(1.0)]))
    numbers = ("", "2" if apart else "")
    tokens = [[f"jawOpen{number}", f"mouthClose{number}"] for number in numbers]
    place = Gf.Matrix4d(1.0).SetTranslate(Gf.Vec3d(*OFFSET.tolist()))
    for mesh, points, shift, columns, names, matrix in (
        (MESHES[0], HEAD, 0.0, 7, tokens[0], None),
        (MESHES[1], TEETH, OFFSET, 5, tokens[1], place),
    ):
        shapes = {"jawOpen": (jaw(points), None), "mouthClose": (-0.9 * jaw(points), None)}
        bind(define_mesh(stage, mesh, points - shift, columns, shapes, names), skeleton, 0, matrix)
    if clip:
        order = list(dict.fromkeys(["other", *tokens[1], *tokens[0]]))
        own = UsdSkel.Animation.Define(stage, "/body/talk")
        own.CreateBlendShapesAttr(order)
        weights = own.CreateBlendShapeWeightsAttr()
        for code, opened, closed in CODES:
            row = {"other": 0.3} | dict.fromkeys((tokens[0][0], tokens[1][0]), opened)
            row |= dict.fromkeys((tokens[0][1], tokens[1][1]), closed)
            weights.Set([row[name] for name in order], code)
        source = UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel()
        source.SetTargets([own.GetPath()])
    stage.GetRootLayer().Export(str(path), args={"format": "usda"})
    return path


def expected(rig: em.Rig, weights: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """Where a rig has the points of both meshes, in their own spaces."""
    x, y, z = rig.pose(weights).T
    points = np.stack([x, -z, y], axis=1)
    return points[: len(HEAD)], points[len(HEAD) :] - OFFSET


def weights_at(path: Path, code: float) -> dict[str, dict[str, float]]:
    """By mesh, the weights of its blend shapes by the names of their prims, as UsdSkel has them."""
    from pxr import Usd, UsdSkel

    stage = Usd.Stage.Open(str(path))
    cache = UsdSkel.Cache()
    assert cache.Populate(UsdSkel.Root(stage.GetDefaultPrim()), Usd.PrimDefaultPredicate)
    query = cache.GetSkelQuery(UsdSkel.Skeleton(stage.GetPrimAtPath("/body/rig"))).GetAnimQuery()
    row = query.ComputeBlendShapeWeights(code)
    found: dict[str, Any] = {}
    for mesh in MESHES:
        prim = stage.GetPrimAtPath(mesh)
        own = cache.GetSkinningQuery(prim).GetBlendShapeMapper().Remap(row)
        targets = prim.GetRelationship("skel:blendShapeTargets").GetTargets()
        found[mesh] = {target.name: w for target, w in zip(targets, own, strict=True)}
    return found


@pytest.mark.parametrize("apart", [True, False])
@pytest.mark.parametrize("suffix", [".usda", ".usdc"])
def test_a_pair_bend_is_added_and_read_back(tmp_path: Path, suffix: str, apart: bool) -> None:
    original = meeting(tmp_path / "face.usda", apart=apart)
    layer = tmp_path / f"bent{suffix}"
    report = bend_usd(original, layer, tolerance=1e-4)
    made, read = em.read_rig(original), em.read_rig(layer)
    assert list(made.pair_bends()) == [PAIR]
    assert list(read.morphs) == ["jawOpen", "mouthClose", PAIR]
    assert read.sliders == made.sliders
    told = {target.name: target for target in report.targets}
    assert told[PAIR].meshes == MESHES
    assert told[PAIR].gain > 1e-3
    assert told[PAIR].error <= 1e-4
    for weights in ({"jawOpen": 0.6, "mouthClose": 0.6}, {"jawOpen": 0.9, "mouthClose": 0.3}):
        away = np.linalg.norm(made.pose(weights) - read.pose(weights), axis=1).max()
        assert away <= 1e-4 * report.extent
        shown = weights | {PAIR: min(weights.values())}
        for mesh, points in zip(MESHES, expected(made, weights), strict=True):
            off = np.linalg.norm(played(layer, mesh, shown) - points, axis=1).max()
            assert off <= 3.2e-4 * report.extent  # three shapes, each within the tolerance
    assert complaints(layer) == complaints(original)


@pytest.mark.parametrize("apart", [True, False])
def test_clips_play_it_between_their_keys_too(tmp_path: Path, apart: bool) -> None:
    """Where the weights cross, the least of both has a kink, which gets a key."""
    original, layer = meeting(tmp_path / "face.usda", apart=apart), tmp_path / "bent.usda"
    report = bend_usd(original, layer, tolerance=1e-4)
    rig = em.read_rig(original)
    for code in (*np.linspace(0, 10, 41).tolist(), 3.76, 8.8):
        before, after = weights_at(original, code), weights_at(layer, code)
        for number, mesh in enumerate(MESHES):
            for name, weight in before[mesh].items():
                assert after[mesh][name] == pytest.approx(weight, abs=1e-6)
            least = min(after[mesh].pop(PAIR), 9.0)
            assert least == pytest.approx(min(after[mesh].values()), abs=2e-4)
            shown = after[mesh] | {PAIR: least}
            off = played(layer, mesh, shown) - expected(rig, before[mesh])[number]
            assert np.linalg.norm(off, axis=1).max() <= 4.2e-4 * report.extent


def test_everything_else_stays_as_it_is(tmp_path: Path) -> None:
    """Singles play what they played; what the file says of its own shapes is not touched."""
    from pxr import Usd

    original, layer = meeting(tmp_path / "face.usda"), tmp_path / "bent.usda"
    bend_usd(original, layer)
    before, after = Usd.Stage.Open(str(original)), Usd.Stage.Open(str(layer))
    known = {prim.GetPath() for prim in before.TraverseAll()}
    added = {str(prim.GetPath()) for prim in after.TraverseAll()} - set(map(str, known))
    assert added == {f"{mesh}/{PAIR}" for mesh in MESHES}
    for prim in before.TraverseAll():
        own = after.GetPrimAtPath(prim.GetPath())
        for attribute in prim.GetAuthoredAttributes():
            if not attribute.GetName().endswith(("blendShapes", "blendShapeWeights")):
                assert own.GetAttribute(attribute.GetName()).Get() == attribute.Get()
        for relationship in prim.GetAuthoredRelationships():
            found = own.GetRelationship(relationship.GetName()).GetTargets()
            assert found[: len(relationship.GetTargets())] == relationship.GetTargets()
    for name in ("jawOpen", "mouthClose"):
        for mesh in MESHES:
            np.testing.assert_array_equal(
                played(layer, mesh, {name: 1.0}), played(original, mesh, {name: 1.0})
            )
            np.testing.assert_array_equal(
                played(layer, mesh, {name: 1.0, PAIR: 1.0}), played(layer, mesh, {name: 1.0})
            )


def test_a_layer_with_pair_bends_is_bent_anew_from_its_original(tmp_path: Path) -> None:
    original, once = meeting(tmp_path / "face.usda"), tmp_path / "once.usda"
    bend_usd(original, once)
    bend_usd(once, tmp_path / "again.usda")
    assert (tmp_path / "again.usda").read_bytes() == once.read_bytes()


def test_a_character_without_a_clip_has_them_for_whoever_drives_them(tmp_path: Path) -> None:
    original, layer = meeting(tmp_path / "face.usda", clip=False), tmp_path / "bent.usda"
    bend_usd(original, layer)
    assert em.read_rig(layer).sliders == em.read_rig(original).sliders


def test_only_one_of_both_has_no_pair(tmp_path: Path) -> None:
    original, layer = meeting(tmp_path / "face.usda"), tmp_path / "bent.usda"
    report = bend_usd(original, layer, only=["jawOpen"])
    assert [target.name for target in report.bent] == ["jawOpen"]
    assert not em.read_rig(layer).pair_bends()
