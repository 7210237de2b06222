"""A layer holds a USD character where shapes add up: bent or not, and again."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from test_bend_usd_composed import opened, saved, with_variants
from test_bend_usd_pairs import MESHES, PAIR, expected, meeting, weights_at
from usd_characters import HEAD, complaints, define_character, played

import elastomorph as em
from elastomorph.bending.usd import bend_usd, hold_usd
from elastomorph.errors import FileError, FormatError
from needs import extra
from small_head import head, shapes

extra("pxr", "usd")

HINGE = em.Corrective(("jawOpen", "mouthClose"), "hinge", (1.0, 0.75))
LEAST = em.Corrective(("jawOpen", "mouthClose"), "min")
CODES = (*np.linspace(0, 10, 41).tolist(), 3.58, 3.76, 8.8)


def adding(name: str, law: em.Corrective) -> Callable[[em.Rig], em.Rig]:
    """Return what adds a corrective that lifts the front half of all meshes."""

    def held(rig: em.Rig) -> em.Rig:
        moved = rig.neutral.vertices.copy()
        moved[moved[:, 0] > 0] += [0.0, 0.0625, 0.0]
        shape = em.interpolate(rig.neutral, rig.neutral.with_vertices(moved), "linear")
        correctives = {**rig.sliders.correctives, name: law}
        return em.Rig(rig.neutral, {**rig.morphs, name: shape}, correctives=correctives)

    return held


def law_of(law: em.Corrective, weights: dict[str, float]) -> float:
    return float(law.weight(np.array([weights.get(name, 0.0) for name in law.drivers])))


def inbetweens(path: Path) -> dict[str, list[float]]:
    """Weights of the in-betweens of all blend shapes, by their paths."""
    from pxr import Usd, UsdSkel

    stage = Usd.Stage.Open(str(path))
    shapes = [UsdSkel.BlendShape(prim) for prim in stage.TraverseAll()]
    return {
        str(own.GetPath()): sorted(each.GetWeight() for each in own.GetInbetweens())
        for own in shapes
        if own
    }


@pytest.mark.parametrize("apart", [True, False])
@pytest.mark.parametrize("law", [HINGE, LEAST])
def test_clips_drive_correctives_by_their_law(
    tmp_path: Path, law: em.Corrective, apart: bool
) -> None:
    original, layer = meeting(tmp_path / "face.usda", apart=apart), tmp_path / "held.usda"
    before = original.read_bytes()
    report = hold_usd(original, layer, adding("extra", law))
    assert original.read_bytes() == before
    assert [own.name for own in report.bent] == ["extra"]
    assert complaints(layer) == complaints(original)
    read = em.read_rig(layer, method="linear")
    assert read.sliders.correctives == {"extra": law}
    for code in CODES:
        were, are = weights_at(original, code), weights_at(layer, code)
        for number, mesh in enumerate(MESHES):
            points = expected(read, were[mesh])[number]
            off = played(layer, mesh, are[mesh]) - points
            assert np.linalg.norm(off, axis=1).max() <= 1.01 * report.tolerance * report.extent
            driven = are[mesh].pop("extra")
            assert are[mesh] == pytest.approx(were[mesh], abs=1e-6)
            size = 0.0625 / report.extent
            assert driven == pytest.approx(law_of(law, were[mesh]), abs=report.tolerance / size)


def test_only_shapes_and_their_weights_are_added(tmp_path: Path) -> None:
    """Targets whose paths nobody has chosen have none in the layer either."""
    from pxr import Usd

    original, layer = meeting(tmp_path / "face.usda"), tmp_path / "held.usda"
    hold_usd(original, layer, adding("extra", HINGE))
    stages = [Usd.Stage.Open(str(path)) for path in (original, layer)]
    before, after = ({str(p.GetPath()): p for p in stage.TraverseAll()} for stage in stages)
    assert after.keys() - before.keys() == {f"{mesh}/extra" for mesh in MESHES}
    for path, prim in before.items():
        for attribute in prim.GetAuthoredAttributes():
            if not attribute.GetName().endswith(("blendShapes", "blendShapeWeights")):
                assert after[path].GetAttribute(attribute.GetName()).Get() == attribute.Get()
        added = {*after[path].GetAuthoredPropertyNames()} - {*prim.GetAuthoredPropertyNames()}
        assert added == ({"elastomorph:sliders"} if path in MESHES else set())
    for key in ("upAxis", "metersPerUnit", "startTimeCode", "endTimeCode", "defaultPrim"):
        assert stages[1].GetMetadata(key) == stages[0].GetMetadata(key)
    em.unbend(layer, tmp_path / "back.usda")
    assert (tmp_path / "back.usda").read_bytes() == original.read_bytes()


def test_a_layer_of_bends_keeps_them(tmp_path: Path) -> None:
    original = meeting(tmp_path / "face.usda")
    bent, layer = tmp_path / "bent.usda", tmp_path / "held.usdc"
    bend_usd(original, bent, tolerance=1e-4)
    report = hold_usd(bent, layer, adding("extra", HINGE))
    assert report.original == original.resolve()
    assert report.tolerance == 1e-4
    old, new = inbetweens(bent), inbetweens(layer)
    assert {path: own for path, own in new.items() if path in old} == old
    assert max(map(len, old.values())) > 1
    one, two = em.read_rig(bent), em.read_rig(layer)
    assert two.names == one.names
    assert two.sliders.correctives == {**one.sliders.correctives, "extra": HINGE}
    for weights in ({"jawOpen": 0.5}, {"jawOpen": 0.4, "mouthClose": 0.7}):
        np.testing.assert_allclose(two.pose(weights), one.pose(weights), atol=3e-5 * report.extent)
    for code in CODES:
        weights = weights_at(layer, code)[MESHES[0]]
        both = [weights["jawOpen"], weights["mouthClose"]]
        assert weights[PAIR] == pytest.approx(min(both), abs=2e-4)
    em.unbend(layer, tmp_path / "back.usda")
    assert (tmp_path / "back.usda").read_bytes() == original.read_bytes()


@pytest.mark.parametrize("bent", [False, True])
def test_what_is_held_can_be_held_again(tmp_path: Path, bent: bool) -> None:
    source = meeting(tmp_path / "face.usda")
    if bent:
        bend_usd(source, tmp_path / "bent.usda")
        source = tmp_path / "bent.usda"
    first, second, third = (tmp_path / f"{number}.usda" for number in range(3))
    hold_usd(source, first, adding("extra", HINGE))
    hold_usd(first, second, adding("more", LEAST))
    found = em.read_rig(second, method=None if bent else "linear")
    assert [*found.pair_bends()] == [PAIR] * bent
    assert {name: found.sliders.correctives[name] for name in ("extra", "more")} == {
        "extra": HINGE,
        "more": LEAST,
    }
    assert hold_usd(second, third, lambda rig: rig).output is None
    assert not third.exists()


def test_what_is_held_can_be_bent(tmp_path: Path) -> None:
    original, held = meeting(tmp_path / "face.usda"), tmp_path / "held.usda"
    hold_usd(original, held, adding("extra", HINGE))
    bend_usd(held, tmp_path / "both.usda")
    bend_usd(original, tmp_path / "bent.usda")
    both, bent = em.read_rig(tmp_path / "both.usda"), em.read_rig(tmp_path / "bent.usda")
    assert both.sliders.correctives == {**bent.sliders.correctives, "extra": HINGE}
    rig = adding("extra", HINGE)(bent)
    weights = {"jawOpen": 0.8, "mouthClose": 0.9}
    np.testing.assert_allclose(both.pose(weights), rig.pose(weights), atol=1e-6)
    only = tmp_path / "only.usda"
    bend_usd(held, only, only=["jawOpen"])
    assert em.read_rig(only).sliders.correctives == {"extra": HINGE}


def test_a_driver_that_no_animation_moves_is_at_rest(tmp_path: Path) -> None:
    """A hinge of three sliders, of which the clip of the file moves two."""
    from pxr import Usd, UsdSkel

    original, layer = meeting(tmp_path / "face.usda"), tmp_path / "held.usda"
    stage = Usd.Stage.Open(str(original))
    for mesh in MESHES:
        shape = UsdSkel.BlendShape.Define(stage, f"{mesh}/lift")
        count = len(stage.GetPrimAtPath(mesh).GetAttribute("points").Get())
        shape.CreateOffsetsAttr([(0.0, 0.0, 0.1)] * count)
        binding = UsdSkel.BindingAPI(stage.GetPrimAtPath(mesh))
        binding.GetBlendShapesAttr().Set([*binding.GetBlendShapesAttr().Get(), "lift"])
        binding.GetBlendShapeTargetsRel().AddTarget(shape.GetPath())
    stage.Save()
    law = em.Corrective((*HINGE.drivers, "lift"), "hinge", (*HINGE.numbers, -0.5))
    report = hold_usd(original, layer, adding("extra", law))
    for code in CODES:
        weights = weights_at(layer, code)[MESHES[0]]
        hinge = law_of(HINGE, weights)
        assert weights["extra"] == pytest.approx(hinge, abs=report.tolerance * report.extent * 16)


def test_what_has_normals_gets_those_of_the_corrective(tmp_path: Path) -> None:
    """Offsets lead from the normals of the neutral to those of the shape, as all tell them."""
    from pxr import Usd, UsdSkel

    stage = Usd.Stage.CreateInMemory()
    define_character(stage, normals=True)
    original, layer = tmp_path / "face.usda", tmp_path / "held.usda"
    stage.GetRootLayer().Export(str(original))

    def held(rig: em.Rig) -> em.Rig:
        points = rig.neutral.vertices
        leaning = rig.neutral.with_vertices(points + points[:, 1:2] * [0.0, 0.0, 0.5])
        shape = em.interpolate(rig.neutral, leaning, "linear")
        law = {"tilt": em.Corrective(("jawOpen", "jawLeft"))}
        return em.Rig(rig.neutral, {**rig.morphs, "tilt": shape}, correctives=law)

    hold_usd(original, layer, held)
    stage = Usd.Stage.Open(str(layer))
    shape = UsdSkel.BlendShape(stage.GetPrimAtPath("/body/head/tilt"))
    points, offsets = (
        np.array(own.Get()) for own in (shape.GetPointIndicesAttr(), shape.GetOffsetsAttr())
    )
    moved = HEAD.copy()
    moved[points] += offsets
    turned = vertex_normals(moved) - vertex_normals(HEAD)
    np.testing.assert_allclose(shape.GetNormalOffsetsAttr().Get(), turned[points], atol=1e-5)
    assert np.abs(turned).max() > 0.1
    teeth = UsdSkel.BlendShape(stage.GetPrimAtPath("/body/teeth/tilt"))
    assert not teeth.GetNormalOffsetsAttr().HasAuthoredValue()


def vertex_normals(points: np.ndarray) -> np.ndarray:
    """Of a sheet of quads, seven in a row: those around a vertex by their areas."""
    grid, found = points.reshape(9, 7, 3), np.zeros((9, 7, 3))
    first, second = grid[1:, 1:] - grid[:-1, :-1], grid[1:, :-1] - grid[:-1, 1:]
    areas = np.cross(first, second)
    for rows in (slice(0, -1), slice(1, None)):
        for columns in (slice(0, -1), slice(1, None)):
            found[rows, columns] += areas
    return (found / np.linalg.norm(found, axis=2, keepdims=True)).reshape(-1, 3)


def test_what_cannot_be_written_is_one_sentence(tmp_path: Path) -> None:
    original = meeting(tmp_path / "face.usda")
    with pytest.raises(FileError, match=r"a part of face\.usda, which bends"):
        hold_usd(original, original, adding("extra", HINGE))
    with pytest.raises(FormatError, match="a layer lies over a file beside it"):
        hold_usd(original, tmp_path / "held.usdz", adding("extra", HINGE))
    assert [*tmp_path.iterdir()] == [original]


def test_paths_of_the_original_stay_its_own(tmp_path: Path) -> None:
    """Of a file that elastomorph wrote with bends, the layer holds correctives alone."""
    ends = {name: shapes()[name] for name in ("jawOpen", "mouthClose")}
    em.write(tmp_path / "face.usda", em.Rig(head(), ends))
    report = hold_usd(tmp_path / "face.usda", tmp_path / "held.usda", adding("extra", HINGE))
    assert [own.name for own in report.bent] == ["extra"]
    before, after = em.read_rig(tmp_path / "face.usda"), em.read_rig(tmp_path / "held.usda")
    assert after.sliders.correctives == {**before.sliders.correctives, "extra": HINGE}
    for name, morph in before.morphs.items():
        np.testing.assert_array_equal(after[name].bends, morph.bends)


def test_what_a_variant_brings_is_held_in_it(tmp_path: Path) -> None:
    from pxr import Usd

    stage = Usd.Stage.CreateInMemory()
    with_variants(stage)
    original, layer = saved(stage, tmp_path / "face.usda"), tmp_path / "held.usda"
    report = hold_usd(original, layer, adding("extra", em.Corrective(("jawOpen",), "hinge", (2,))))
    assert "only the selected variants (shape=a) are changed" in report.notes[-1]
    assert complaints(layer) == complaints(original)
    for choice, meshes in (("a", ("/body/head", "/body/teeth")), ("b", ("/body/teeth",))):
        stage = opened(layer, {"shape": choice})
        added = {str(p.GetPath()) for p in stage.TraverseAll() if p.GetName() == "extra"}
        assert added == {f"{mesh}/extra" for mesh in meshes}


def test_an_instance_is_refused(tmp_path: Path) -> None:
    from pxr import Usd

    meeting(tmp_path / "face.usda")
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/one")
    prim.GetReferences().AddReference("./face.usda")
    prim.SetInstanceable(True)
    shot = saved(stage, tmp_path / "shot.usda")
    with pytest.raises(
        FormatError, match="nothing in an instance can be overridden; take the file"
    ):
        hold_usd(shot, tmp_path / "held.usda", adding("extra", HINGE))
