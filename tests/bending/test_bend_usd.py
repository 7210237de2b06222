"""A layer of bends plays the paths in UsdSkel, and changes nothing else of a character."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from usd_characters import HEAD, OFFSET, TEETH, character, complaints, jaw, played

import elastomorph as em
from elastomorph.bending.usd import UsdBendReport, bend_usd, unbend_usd
from elastomorph.cli import main
from elastomorph.errors import FileError, FormatError, ParameterError
from needs import extra

extra("pxr", "usd")

TIMES = (0.0, 0.1, 0.25, 0.37, 0.5, 0.66, 0.9, 1.0)


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return character(tmp_path_factory.mktemp("character") / "plain.usda")


@pytest.fixture
def original(plain: Path, tmp_path: Path) -> Path:
    return Path(shutil.copy(plain, tmp_path / "character.usda"))


def parts(rig: em.Rig, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions of head and teeth, in the spaces of their meshes, where up is z."""
    x, y, z = positions.T
    positions = np.stack([x, -z, y], axis=1)
    return positions[: len(HEAD)], positions[len(HEAD) : len(HEAD) + len(TEETH)] - OFFSET


def farthest_from_path(layer: Path, extent: float) -> float:
    """How far UsdSkel plays a layer from the rig that is read from it, as a fraction of D."""
    rig, largest = em.read_rig(layer), 0.0
    for name in ("jawOpen", "jawLeft"):
        for time in TIMES:
            expected = parts(rig, rig.pose({name: time}))
            for mesh, points in zip(("/body/head", "/body/teeth"), expected, strict=True):
                found = played(layer, mesh, {name: time})
                largest = max(largest, float(np.linalg.norm(found - points, axis=1).max()))
    return largest / extent


@pytest.mark.parametrize("suffix", [".usda", ".usdc", ".usd"])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-4])
def test_usd_plays_the_path_within_the_tolerance(
    original: Path, suffix: str, tolerance: float
) -> None:
    layer = original.with_name(f"bent{suffix}")
    report = bend_usd(original, layer, tolerance=tolerance)
    assert [target.name for target in report.bent] == ["jawOpen"]
    assert 0 < report.error <= tolerance
    assert report.bent[0].gain > 20 * tolerance
    assert report.bent[0].meshes == ("/body/head", "/body/teeth")
    assert report.bytes == layer.stat().st_size
    found = farthest_from_path(layer, report.extent)
    assert 0.3 * report.error < found <= 1.01 * tolerance
    # halfway a straight line would be that far from the arc
    straight = played(original, "/body/head", {"jawOpen": 0.5})
    bent = played(layer, "/body/head", {"jawOpen": 0.5})
    apart = np.linalg.norm(bent - straight, axis=1).max() / report.extent
    assert apart == pytest.approx(report.bent[0].gain, rel=0.05)


def test_the_path_is_read_back_as_it_was_made(original: Path) -> None:
    """That of the default method for the whole character, not the straight pieces."""
    layer = original.with_name("bent.usdc")
    report = bend_usd(original, layer)
    made, read = em.read_rig(original), em.read_rig(layer)
    assert list(made.morphs) == list(read.morphs) == ["jawOpen", "jawLeft"]
    assert read.morphs["jawOpen"].method == made.morphs["jawOpen"].method == "rotation"
    for time in np.linspace(0, 1, 33):
        away = made.pose({"jawOpen": time}) - read.pose({"jawOpen": time})
        assert np.linalg.norm(away, axis=1).max() <= 2e-5 * report.extent


def test_the_rest_of_the_character_stays(original: Path) -> None:
    from pxr import Usd

    content = original.read_bytes()
    layer = original.with_name("bent.usda")
    bend_usd(original, layer)
    assert original.read_bytes() == content
    before, after = Usd.Stage.Open(str(original)), Usd.Stage.Open(str(layer))
    assert [p.GetPath() for p in before.TraverseAll()] == [p.GetPath() for p in after.TraverseAll()]
    for prim in before.TraverseAll():
        other = after.GetPrimAtPath(prim.GetPath())
        assert other.GetTypeName() == prim.GetTypeName()
        assert other.GetAppliedSchemas() == prim.GetAppliedSchemas()
        for attribute in prim.GetAuthoredAttributes():
            own = other.GetAttribute(attribute.GetName())
            for time in (Usd.TimeCode.Default(), 0.0, 4.0, 7.5):
                assert own.Get(time) == attribute.Get(time), attribute.GetPath()
        for relationship in prim.GetAuthoredRelationships():
            own = other.GetRelationship(relationship.GetName())
            assert own.GetTargets() == relationship.GetTargets()
    keys = ("upAxis", "metersPerUnit", "timeCodesPerSecond", "startTimeCode", "endTimeCode")
    for key in (*keys, "defaultPrim"):
        assert after.GetMetadata(key) == before.GetMetadata(key) is not None
    touched = {
        prim.GetTypeName()
        for prim in after.TraverseAll()
        if len(prim.GetPrimStack()) > 1
        and any(
            after.GetRootLayer() == spec.layer and spec.properties for spec in prim.GetPrimStack()
        )
    }
    assert touched == {"BlendShape"}
    assert complaints(layer) == complaints(original)


def test_both_ends_are_those_of_the_original_to_the_last_bit(original: Path) -> None:
    layer = original.with_name("bent.usdc")
    bend_usd(original, layer, tolerance=1e-4)
    for name in ("jawOpen", "jawLeft"):
        for time in (0.0, 1.0):
            for mesh in ("/body/head", "/body/teeth"):
                before, after = (played(own, mesh, {name: time}) for own in (original, layer))
                np.testing.assert_array_equal(after, before)


def test_animations_play_bent_without_a_change(original: Path) -> None:
    """In-betweens are a function of the weight; the teeth have a weight of their own."""
    from pxr import Usd, UsdSkel

    layer = original.with_name("bent.usdc")
    report = bend_usd(original, layer)
    stage = Usd.Stage.Open(str(layer))
    root = UsdSkel.Root(stage.GetPrimAtPath("/body"))
    cache = UsdSkel.Cache()
    assert cache.Populate(root, Usd.PrimDefaultPredicate)
    query = cache.GetSkelQuery(UsdSkel.Skeleton(stage.GetPrimAtPath("/body/rig")))
    rig = em.read_rig(layer)
    for code in (0.0, 2.0, 4.0, 7.0, 10.0):
        weights = query.GetAnimQuery().ComputeBlendShapeWeights(code)
        assert weights[1] == weights[2]
        for number, mesh in enumerate(("/body/head", "/body/teeth")):
            target = cache.GetSkinningQuery(stage.GetPrimAtPath(mesh))
            row = target.GetBlendShapeMapper().Remap(weights)
            points = played(layer, mesh, {"jawOpen": row[0]})
            expected = parts(rig, rig.pose({"jawOpen": weights[1]}))[number]
            away = np.linalg.norm(points - expected, axis=1).max()
            assert away <= 1.01 * report.tolerance * report.extent


def test_what_seams_share_moves_together(original: Path) -> None:
    """In-betweens of all meshes are at the same weights, so that none opens between them."""
    from pxr import Usd, UsdSkel

    layer = original.with_name("bent.usdc")
    bend_usd(original, layer, tolerance=1e-4)
    stage = Usd.Stage.Open(str(layer))
    weights = [
        [own.GetWeight() for own in UsdSkel.BlendShape(stage.GetPrimAtPath(path)).GetInbetweens()]
        for path in ("/body/head/jawOpen", "/body/teeth/jawOpen")
    ]
    assert len(weights[0]) > 3
    assert weights[0] == weights[1]


def test_a_layer_is_bent_anew_from_its_original(original: Path) -> None:
    """Never twice: what comes out is what the original gives."""
    once, again = original.with_name("once.usda"), original.with_name("again.usda")
    first = bend_usd(original, once)
    second = bend_usd(once, again)
    assert again.read_bytes() == once.read_bytes()
    assert second.original == first.original == original
    assert first.notes == ()
    assert second.notes == (
        "the file is a layer: what is written lies over the file under it, in its place",
    )
    finer = bend_usd(once, once, tolerance=1e-4)
    assert len(finer.bent[0].inbetweens) > len(first.bent[0].inbetweens)
    assert farthest_from_path(once, finer.extent) < 1.01e-4


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('over "body"\n{', 'over "body"\n{\n    double mood = 3\n', r"/body\.mood in it was added"),
        (
            'over "body"\n{',
            'over "body" (\n    active = false\n)\n{',
            "/body in it was added or ch",
        ),
        ('over "body"\n{', 'def Cube "hat" {\n}\nover "body"\n{', "/hat in it was added or chan"),
    ],
)
def test_what_someone_added_to_a_layer_is_not_lost(
    original: Path, old: str, new: str, words: str
) -> None:
    layer = original.with_name("bent.usda")
    bend_usd(original, layer)
    text = layer.read_text()
    assert old in text
    layer.write_text(text.replace(old, new))
    with pytest.raises(FormatError, match=words):
        bend_usd(layer, original.with_name("again.usda"))


def test_unbend_gives_the_original_back(original: Path, tmp_path: Path) -> None:
    layer, copy = original.with_name("bent.usdc"), original.with_name("copy.usda")
    bend_usd(original, layer)
    assert unbend_usd(layer, copy) == original
    assert copy.read_bytes() == original.read_bytes()
    with pytest.raises(FormatError, match=r"name a \.usda file"):
        unbend_usd(layer, original.with_name("copy.usdc"))
    (tmp_path / "elsewhere").mkdir()
    with pytest.raises(FormatError, match="name a copy in its folder"):
        unbend_usd(layer, tmp_path / "elsewhere" / "copy.usda")
    with pytest.raises(FormatError, match="it is no layer of bends"):
        unbend_usd(original, copy)
    with pytest.raises(FileError, match=r"a part of character\.usda, which bends lie over"):
        unbend_usd(layer, original)


def test_a_layer_in_another_folder_names_its_original(original: Path, tmp_path: Path) -> None:
    """It proves by the digest of its original that it may be read from there."""
    (tmp_path / "bent").mkdir()
    layer = tmp_path / "bent" / "character.usdc"
    bend_usd(original, layer)
    assert em.read_rig(layer).morphs["jawOpen"].method == "rotation"
    assert bend_usd(layer, tmp_path / "bent" / "again.usdc").original == original
    original.write_text(original.read_text() + "\n")
    for use in (em.read_rig, lambda path: bend_usd(path, tmp_path / "new.usda")):
        with pytest.raises(FormatError, match="has changed since and lies in another folder"):
            use(layer)
    original.unlink()
    with pytest.raises(FormatError, match=r"a layer over '\.\./character\.usda', which is not the"):
        em.read_rig(layer)


def test_a_changed_original_beside_its_layer_is_read_as_it_is(original: Path) -> None:
    """Where the shapes are those that were bent, their paths still fit."""
    layer = original.with_name("bent.usdc")
    bend_usd(original, layer)
    original.write_text(original.read_text().replace("timeCodesPerSecond = 25", "doc = 'x'"))
    assert em.read_rig(layer).morphs["jawOpen"].method == "rotation"


def test_packages_are_bent_by_a_layer_beside_them(original: Path) -> None:
    from pxr import UsdUtils

    package = original.with_name("character.usdz")
    assert UsdUtils.CreateNewUsdzPackage(str(original), str(package))
    content = package.read_bytes()
    layer = original.with_name("bent.usda")
    report = bend_usd(package, layer)
    assert package.read_bytes() == content
    assert "@./character.usdz@" in layer.read_text()
    assert farthest_from_path(layer, report.extent) <= 1.01e-3
    assert unbend_usd(layer, original.with_name("copy.usdz")) == package
    with pytest.raises(FormatError, match="a package cannot name"):
        bend_usd(original, original.with_name("bent.usdz"))


def test_points_that_only_bends_move_join_those_of_a_shape(original: Path) -> None:
    """Physical methods move what their target leaves where it is."""
    layer = original.with_name("bent.usda")
    below = np.flatnonzero(jaw(HEAD).any(axis=1))
    report = bend_usd(original, layer, method={"jawOpen": "plate"})
    rig = em.read_rig(layer)
    moved = np.flatnonzero(rig.morphs["jawOpen"].bends[:, : len(HEAD)].any(axis=(0, 2)))
    assert len(np.setdiff1d(moved, below)) > 0
    assert farthest_from_path(layer, report.extent) <= 1.01e-3
    for mesh in ("/body/head", "/body/teeth"):
        np.testing.assert_array_equal(
            played(layer, mesh, {"jawOpen": 1.0}), played(original, mesh, {"jawOpen": 1.0})
        )


def test_normals_follow_only_where_shapes_have_them(tmp_path: Path) -> None:
    from pxr import Usd, UsdSkel

    path = character(tmp_path / "normals.usda", normals=True)
    layer = tmp_path / "bent.usdc"
    bend_usd(path, layer)
    stage = Usd.Stage.Open(str(layer))
    head, teeth = (
        UsdSkel.BlendShape(stage.GetPrimAtPath(f"/body/{mesh}/jawOpen")).GetInbetweens()
        for mesh in ("head", "teeth")
    )
    assert len(head) == len(teeth) > 1
    assert not any(own.GetNormalOffsetsAttr() for own in teeth)
    shape = UsdSkel.BlendShape(stage.GetPrimAtPath("/body/head/jawOpen"))
    whole = np.array(shape.GetNormalOffsetsAttr().Get())
    below = np.array(shape.GetPointIndicesAttr().Get())
    for own in head:
        weight = {"jawOpen": own.GetWeight()}
        bent, straight = (
            grid_normals(played(file, "/body/head", weight)) for file in (layer, path)
        )
        beside = np.array(own.GetNormalOffsets()) - own.GetWeight() * whole
        expected = (bent - straight)[below]
        assert np.abs(expected).max() > 5e-3
        # two ways to make a normal at a vertex: by the areas around it, and by the grid
        assert np.abs(beside - expected).max() < 0.25 * np.abs(expected).max()


def grid_normals(points: np.ndarray) -> np.ndarray:
    """(N, 3) unit normals of the head, by differences along its rows and columns."""
    grid = points.reshape(9, 7, 3)
    down, across = np.gradient(grid, axis=(0, 1))
    normals = np.cross(across, down).reshape(-1, 3)
    return np.asarray(normals / np.linalg.norm(normals, axis=1, keepdims=True))


def test_inbetweens_of_the_artist_are_kept(original: Path) -> None:
    from pxr import Usd, UsdSkel

    stage = Usd.Stage.Open(str(original))
    shape = UsdSkel.BlendShape(stage.GetPrimAtPath("/body/teeth/jawOpen"))
    inbetween = shape.CreateInbetween("half")
    inbetween.SetWeight(0.5)
    inbetween.SetOffsets([(0.0, 0.1, 0.0)] * len(TEETH))
    stage.Save()
    layer = original.with_name("bent.usda")
    report = bend_usd(original, layer)
    assert (report.bent, report.output, report.bytes) == ((), None, 0)
    assert not layer.exists()  # nothing bends
    report = bend_usd(original, layer, method={"jawLeft": "ease"})
    assert [target.name for target in report.bent] == ["jawLeft"]
    assert report.targets[0].note == "keeps the in-betweens it has"
    assert report.notes == ("targets that have in-betweens already, and keep them: jawOpen",)
    for mesh in ("/body/head", "/body/teeth"):
        for time in TIMES:
            np.testing.assert_array_equal(
                played(layer, mesh, {"jawOpen": time}), played(original, mesh, {"jawOpen": time})
            )


def test_only_some_targets_bend(original: Path) -> None:
    layer = original.with_name("bent.usda")
    report = bend_usd(original, layer, only=["jawLeft"], method="ease")
    assert [target.name for target in report.bent] == ["jawLeft"]
    assert [target.note for target in report.targets][:1] == ["not asked for"]
    # what was not asked for is known to be straight: it is not bent when it is read
    assert em.read_rig(layer).morphs["jawOpen"].method == "linear"
    layer.unlink()
    assert bend_usd(original, layer, only=["jawLeft"]).output is None
    assert not layer.exists()  # nothing bends
    with pytest.raises(ParameterError, match="jawOpne"):
        bend_usd(original, layer, only=["jawOpne"])
    with pytest.raises(ParameterError, match="a list of names"):
        bend_usd(original, layer, only="jawOpen")
    with pytest.raises(ParameterError, match="tolerance"):
        bend_usd(original, layer, tolerance=0)


def test_a_dry_run_writes_nothing(original: Path) -> None:
    before = sorted(original.parent.iterdir())
    tried = bend_usd(original, None)
    assert sorted(original.parent.iterdir()) == before
    assert tried.output is None
    done = bend_usd(original, original.with_name("bent.usdc"))
    assert tried.bent == done.bent
    assert abs(tried.bytes - done.bytes) < 200  # the path of the original is another


def test_the_original_is_never_written_over(original: Path) -> None:
    content = original.read_bytes()
    with pytest.raises(FileError, match=r"a part of character\.usda"):
        bend_usd(original, original)
    (original.parent / "link.usda").symlink_to(original)
    with pytest.raises(FileError, match=r"a part of character\.usda"):
        bend_usd(original, original.with_name("link.usda"))
    assert original.read_bytes() == content


def test_the_verb_bends_usd(original: Path) -> None:
    layer, copy = original.with_name("bent.usdc"), original.with_name("copy.usda")
    report = em.bend(original, layer, only=["jawOpen"])
    assert isinstance(report, UsdBendReport)
    assert [target.name for target in report.bent] == ["jawOpen"]
    assert len(report.bent[0].inbetweens) > 1  # by default what auto bends has some
    em.unbend(layer, copy)
    assert copy.read_bytes() == original.read_bytes()


@pytest.mark.parametrize("option", ["max_targets", "fold", "keys_tolerance"])
def test_options_without_effect_are_refused(original: Path, option: str) -> None:
    with pytest.raises(ParameterError, match=f"{option} is for glTF; a layer of USD has none"):
        em.bend(original, original.with_name("bent.usda"), **{option: True})
    assert not original.with_name("bent.usda").exists()


def status(*words: object) -> object:
    """What the program ends with."""
    with pytest.raises(SystemExit) as end:
        main([str(word) for word in words])
    return end.value.code


def test_the_program_bends_usd(original: Path, capsys: pytest.CaptureFixture[str]) -> None:
    layer = original.with_name("bent.usda")
    assert status("bend", original, "--dry-run") == 0
    said = capsys.readouterr().out
    assert re.search(r"jawOpen +\d\.\d+ +0\.\d+ +\d+ +[\d,]+", said)
    assert "1 of 2 targets bend" in said
    assert "nothing was written" in said
    assert not layer.exists()
    assert status("bend", original, "-o", layer, "--tolerance", "1e-4") == 0
    assert farthest_from_path(layer, 1.118) < 1.01e-4
    assert status("bend", original, "-o", original) == 1
    assert "name another output" in capsys.readouterr().err
