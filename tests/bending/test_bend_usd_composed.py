"""Bends of characters that are composed: references, payloads, variants, instances; and damage."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from usd_characters import HEAD, TEETH, character, complaints, define_mesh, jaw, played, slide

import elastomorph as em
from elastomorph.bending.usd import bend_usd
from elastomorph.errors import FileError, FormatError
from elastomorph.io.atomic import inputs_kept
from needs import extra

extra("pxr", "usd")

HALF = {"jawOpen": 0.5}


def saved(stage: Any, path: Path) -> Path:
    stage.GetRootLayer().Export(str(path))
    return path


def bends_by(
    layer: Path, original: Path, mesh: str, *, choice: dict[str, str] | None = None
) -> float:
    """How far the layer moves a mesh from where the original has it, halfway."""
    points = []
    for path in (layer, original):
        stage = opened(path, choice or {})
        points.append(played(stage, mesh, HALF))
    return float(np.linalg.norm(points[0] - points[1], axis=1).max())


def opened(path: Path, choice: dict[str, str]) -> Any:
    """A stage with variants chosen in its session."""
    from pxr import Usd

    stage = Usd.Stage.Open(str(path))
    stage.SetEditTarget(stage.GetSessionLayer())
    for name, variant in choice.items():
        stage.GetPrimAtPath("/body").GetVariantSet(name).SetVariantSelection(variant)
    return stage


@pytest.mark.parametrize("arc", ["references", "payloads", "inherits"])
def test_a_character_that_is_referenced(tmp_path: Path, arc: str) -> None:
    from pxr import Sdf, Usd

    asset = character(tmp_path / "asset.usdc")
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/body")
    stage.SetDefaultPrim(prim)
    if arc == "inherits":
        stage.GetRootLayer().subLayerPaths.append("./asset_class.usda")
        of = Usd.Stage.CreateInMemory()
        of.CreateClassPrim("/kind").GetReferences().AddReference("./asset.usdc")
        saved(of, tmp_path / "asset_class.usda")
        prim.GetInherits().AddInherit(Sdf.Path("/kind"))
    else:
        adder = prim.GetReferences() if arc == "references" else prim.GetPayloads()
        getattr(adder, f"Add{arc[:-1].capitalize()}")("./asset.usdc")
    shot = saved(stage, tmp_path / "shot.usda")
    content = {path: path.read_bytes() for path in tmp_path.iterdir()}
    layer = tmp_path / "shot.bent.usda"
    report = bend_usd(shot, layer)
    assert [target.name for target in report.bent] == ["jawOpen"]
    assert all(path.read_bytes() == own for path, own in content.items())
    gained = report.bent[0].gain * report.extent
    assert bends_by(layer, shot, "/body/head") == pytest.approx(gained, rel=0.1)
    assert complaints(layer) == complaints(shot)
    assert em.read_rig(layer).morphs["jawOpen"].method == "rotation"
    # the asset is a part of what the layer lies over, and is not written over either
    with pytest.raises(FileError, match=r"a part of shot\.usda"):
        bend_usd(shot, asset)


def with_variants(stage: Any, sets: tuple[str, ...] = ("look", "shape")) -> None:
    """A body whose variant set ``shape`` has two heads, of other points; and one that has none."""
    from pxr import UsdGeom, UsdSkel

    body = UsdSkel.Root.Define(stage, "/body").GetPrim()
    stage.SetDefaultPrim(body)
    for name in sets:
        variants = body.GetVariantSets().AddVariantSet(name)
        for choice in ("a", "b"):
            variants.AddVariant(choice)
            variants.SetVariantSelection(choice)
            with variants.GetVariantEditContext():
                if name == "shape":
                    points = HEAD if choice == "a" else HEAD[:35] * 0.8
                    define_mesh(stage, "/body/head", points, 7, {"jawOpen": (jaw(points), None)})
                else:
                    color = UsdGeom.Scope.Define(stage, "/body/colour")
                    color.GetPrim().SetDisplayName(choice)
        variants.SetVariantSelection("a")
    define_mesh(stage, "/body/teeth", TEETH, 5, {"jawOpen": (jaw(TEETH), None)}, ["jawOpen2"])


@pytest.mark.parametrize("referenced", [False, True])
def test_only_the_selected_variant_bends(tmp_path: Path, referenced: bool) -> None:
    from pxr import Usd

    stage = Usd.Stage.CreateInMemory()
    with_variants(stage)
    original = saved(stage, tmp_path / "asset.usda")
    if referenced:
        stage = Usd.Stage.CreateInMemory()
        stage.SetDefaultPrim(stage.DefinePrim("/body"))
        stage.GetDefaultPrim().GetReferences().AddReference("./asset.usda")
        original = saved(stage, tmp_path / "shot.usda")
    layer = tmp_path / "bent.usda"
    report = bend_usd(original, layer)
    assert report.bent[0].meshes == ("/body/head", "/body/teeth")
    assert report.notes == (
        "only the selected variants (shape=a) are changed; the blend shapes of others stay as they "
        "are",
    )
    gained = report.bent[0].gain * report.extent
    assert bends_by(layer, original, "/body/head") == pytest.approx(gained, rel=0.1)
    other = {"shape": "b", "look": "b"}
    assert bends_by(layer, original, "/body/head", choice=other) == 0
    assert bends_by(layer, original, "/body/teeth", choice=other) > 0.1 * gained
    before, after = (Usd.Stage.Open(str(path)) for path in (original, layer))
    for name in ("look", "shape"):
        sets = [stage.GetPrimAtPath("/body").GetVariantSet(name) for stage in (before, after)]
        assert sets[0].GetVariantNames() == sets[1].GetVariantNames()
        assert sets[0].GetVariantSelection() == sets[1].GetVariantSelection() == "a"
    names = [own.GetPrimAtPath("/body").GetVariantSets().GetNames() for own in (before, after)]
    assert sorted(names[0]) == sorted(names[1])
    assert referenced or names[0] == names[1]
    assert complaints(layer) == complaints(original)
    # anew from the original, with the same result
    again = tmp_path / "again.usda"
    bend_usd(layer, again)
    assert again.read_bytes() == layer.read_bytes()


@pytest.mark.parametrize("below", ["/body", "/body/head"])
def test_a_variant_that_brings_a_reference(tmp_path: Path, below: str) -> None:
    """Levels of detail: other points by another file, to which the bends do not belong."""
    from pxr import Usd, UsdSkel

    for name, points in (("high", HEAD), ("low", HEAD[:35])):
        stage = Usd.Stage.CreateInMemory()
        root = UsdSkel.Root.Define(stage, "/asset")
        stage.SetDefaultPrim(root.GetPrim())
        mesh = "/asset/head" if below == "/body" else "/asset"
        define_mesh(stage, mesh, points, 7, {"jawOpen": (jaw(points), None)})
        saved(stage, tmp_path / f"{name}.usda")
    stage = Usd.Stage.CreateInMemory()
    body = UsdSkel.Root.Define(stage, "/body").GetPrim()
    stage.SetDefaultPrim(body)
    detail = body.GetVariantSets().AddVariantSet("detail")
    for name in ("low", "high"):
        detail.AddVariant(name)
        detail.SetVariantSelection(name)
        with detail.GetVariantEditContext():
            prim = stage.DefinePrim(below) if below != "/body" else body
            prim.GetReferences().AddReference(f"./{name}.usda")
    original = saved(stage, tmp_path / "character.usda")
    layer = tmp_path / "bent.usda"
    report = bend_usd(original, layer)
    gained = report.bent[0].gain * report.extent
    assert bends_by(layer, original, "/body/head") == pytest.approx(gained, rel=0.1)
    assert bends_by(layer, original, "/body/head", choice={"detail": "low"}) == 0
    assert "detail=high" in report.notes[0]


def test_blend_shapes_in_an_instance_are_refused(tmp_path: Path) -> None:
    from pxr import Usd

    character(tmp_path / "asset.usdc")
    stage = Usd.Stage.CreateInMemory()
    prim = stage.DefinePrim("/crowd")
    prim.GetReferences().AddReference("./asset.usdc")
    prim.SetInstanceable(True)
    shot = saved(stage, tmp_path / "shot.usda")
    with pytest.raises(FormatError, match=r"/crowd/head/jawOpen lies in the instance /crowd, and"):
        bend_usd(shot, tmp_path / "bent.usda")
    assert not (tmp_path / "bent.usda").exists()


def test_a_blend_shape_of_two_meshes(tmp_path: Path) -> None:
    """Meshes that are copies of each other may share one; any others need their own."""
    from pxr import Usd, UsdGeom, UsdSkel

    def file(name: str, points: np.ndarray) -> Path:
        stage = Usd.Stage.CreateInMemory()
        UsdSkel.Root.Define(stage, "/body")
        define_mesh(stage, "/body/head", HEAD, 7, {"jawOpen": (jaw(HEAD), None)})
        twin = define_mesh(stage, "/body/twin", points, 7, {})
        UsdGeom.XformCommonAPI(twin).SetTranslate((3.0, 0.0, 0.0))
        binding = UsdSkel.BindingAPI.Apply(twin.GetPrim())
        binding.CreateBlendShapesAttr(["jawOpen"])
        binding.CreateBlendShapeTargetsRel().SetTargets(["/body/head/jawOpen"])
        return saved(stage, tmp_path / name)

    layer = tmp_path / "bent.usda"
    assert bend_usd(file("same.usda", HEAD), layer).bent
    assert layer.read_text().count("elastomorph:path") == 1
    with pytest.raises(FormatError, match="share the blend shape /body/head/jawOpen and would"):
        bend_usd(file("other.usda", HEAD * [1.0, 0.2, 3.0]), layer)


def test_existing_layers_and_settings_of_the_stage_are_kept(tmp_path: Path) -> None:
    """What a stage takes from its root layer alone, and what it takes from sublayers."""
    from pxr import Sdf, Usd

    base = character(tmp_path / "base.usda")
    stage = Usd.Stage.CreateInMemory()
    layer = stage.GetRootLayer()
    layer.subLayerPaths.append("./base.usda")
    layer.subLayerOffsets[0] = Sdf.LayerOffset(5.0, 2.0)
    layer.customLayerData = {"renderSettings": {"exposure": 2.5}, "camera": "front"}
    layer.timeCodesPerSecond = 50
    layer.defaultPrim = "body"
    shot = saved(stage, tmp_path / "shot.usda")
    bent = tmp_path / "bent.usda"
    bend_usd(shot, bent)
    before, after = Usd.Stage.Open(str(shot)), Usd.Stage.Open(str(bent))
    for key in ("timeCodesPerSecond", "defaultPrim", "upAxis", "metersPerUnit", "endTimeCode"):
        assert after.GetMetadata(key) == before.GetMetadata(key)
        assert after.HasAuthoredMetadata(key) == before.HasAuthoredMetadata(key)
    kept = {k: v for k, v in after.GetMetadata("customLayerData").items() if k != "elastomorph"}
    assert kept == before.GetMetadata("customLayerData")
    path = "/body/talk.blendShapeWeights"
    for code in (0.0, 5.0, 13.0, 25.0):
        own, other = (each.GetAttributeAtPath(path).Get(code) for each in (before, after))
        assert own == other
    assert base.exists()


def test_a_missing_sublayer_and_damaged_layers(tmp_path: Path) -> None:
    original = character(tmp_path / "character.usdc")
    layer = tmp_path / "bent.usda"
    bend_usd(original, layer)
    text = layer.read_text()
    content = original.read_bytes()
    out = tmp_path / "out.usda"
    for damaged, words in (
        (text[: len(text) // 2], "USD cannot read it"),
        (
            text.replace("./character.usdc", "./gone.usdc"),
            r"a layer over '\./gone\.usdc', which is",
        ),
        (text.replace("./character.usdc", "./bent.usda"), "nothing to bend|goes around|no mesh"),
    ):
        layer.write_text(damaged)
        with pytest.raises(FormatError, match=words):
            bend_usd(layer, out)
    layer.write_text(text)
    original.write_bytes(content[: len(content) // 2])
    with pytest.raises(FormatError, match=r"cannot be read|USD cannot read"):
        bend_usd(layer, out)
    original.unlink()
    with pytest.raises(FormatError, match="which is not there; put that file back"):
        bend_usd(layer, out)
    with pytest.raises(FileError, match="no such file"):
        bend_usd(original, out)
    assert not out.exists()


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("</body/head/jawLeft>", "</body/head/none>", "names the blend shape /body/head/none"),
        ("normalOffsets = [(", "normalOffsets = [(1, 2, 3), (", "normalOffsets of /body/head/jaw"),
        ("normalOffsets = [(0, ", "normalOffsets = [(nan, ", "normalOffsets of /body/head/jaw"),
    ],
)
def test_blend_shapes_that_do_not_fit(tmp_path: Path, old: str, new: str, words: str) -> None:
    original = character(tmp_path / "character.usda", normals=True)
    text = original.read_text()
    assert old in text
    original.write_text(text.replace(old, new, 1))
    with pytest.raises(FormatError, match=words):
        bend_usd(original, tmp_path / "bent.usda")


def test_a_file_without_blend_shapes(tmp_path: Path) -> None:
    from pxr import Usd

    stage = Usd.Stage.CreateInMemory()
    define_mesh(stage, "/hat", HEAD, 7, {})
    with pytest.raises(FormatError, match="no mesh has blend shapes"):
        bend_usd(saved(stage, tmp_path / "hat.usda"), tmp_path / "bent.usda")


def test_names_of_files_that_a_layer_cannot_name(tmp_path: Path) -> None:
    plain = character(tmp_path / "a b@1 [2] ä.usda")
    layer = tmp_path / "bent.usda"
    assert bend_usd(plain, layer).bent
    assert em.read_rig(layer).morphs["jawOpen"].method == "rotation"
    odd = character(tmp_path / "plain.usda").rename(tmp_path / "line\nbreak.usda")
    with pytest.raises(FormatError, match=r"USD cannot name its original"):
        bend_usd(odd, layer)


def test_inputs_of_a_command_are_not_written_over(tmp_path: Path) -> None:
    original = character(tmp_path / "character.usda")
    layer = tmp_path / "bent.usda"
    bend_usd(original, layer)
    with inputs_kept(), pytest.raises(FileError, match="read as an input"):
        bend_usd(layer, layer)


def test_a_straight_character_says_so(tmp_path: Path) -> None:
    from pxr import Usd

    stage = Usd.Stage.CreateInMemory()
    define_mesh(stage, "/head", HEAD, 7, {"jawLeft": (slide(HEAD), None)})
    layer = tmp_path / "bent.usda"
    report = bend_usd(saved(stage, tmp_path / "straight.usda"), layer)
    assert report.bent == ()
    assert report.error == 0
    assert report.targets[0].note.startswith("auto: straight")
    assert (report.output, layer.exists()) == (None, False)
