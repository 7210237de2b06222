"""A character goes in and comes out whole, with its paths bent."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_characters import ANGLE, SmallFile, flap, flap_character

import elastomorph as em
from elastomorph.bending.opened import OpenedCharacter
from elastomorph.io.gltf.accessors import read_floats
from elastomorph.io.gltf.container import GltfFile, open_gltf
from small_head import straight


def bent_file(file: SmallFile, folder: Path, name: str = "a.glb", **options: Any) -> GltfFile:
    """The file, bent, with its original as ``a.glb`` beside it."""
    path = file.write(folder / name)
    out = path.with_name(f"bent {name}")
    em.bend(path, out, **options)
    return open_gltf(out)


def targets_of(file: GltfFile, mesh: int = 0) -> list[list[dict[str, Any]]]:
    """The targets of each primitive."""
    return [own["targets"] for own in file.document["meshes"][mesh]["primitives"]]


def positions(file: GltfFile, weights: Callable[[str], float]) -> Any:
    """The vertices of each primitive of the first mesh, under weights of its targets by name."""
    mesh = file.document["meshes"][0]
    names = mesh["extras"]["targetNames"]
    found = []
    for primitive in mesh["primitives"]:
        here = read_floats(file, primitive["attributes"]["POSITION"], 3, "a test")
        for name, target in zip(names, primitive["targets"], strict=True):
            here = here + weights(name) * read_floats(file, target["POSITION"], 3, "a test")
        found.append(here)
    return np.concatenate(found)


def sliders(file: GltfFile, **values: float) -> Callable[[str], float]:
    """The weight of each target, as a runtime computes it from the extras of the first mesh."""
    found: dict[str, float] = {}
    for morph in file.document["meshes"][0]["extras"]["elastomorph"]["morphs"]:
        t = values.get(morph["name"], 0.0)
        found[morph["target"]] = t + (_value(morph["fold"], t) if "fold" in morph else 0.0)
        for bend in morph["bends"]:
            found[bend["target"]] = _value(bend["curve"], t)
    return lambda name: found[name]


def _value(curve: dict[str, Any], t: float) -> float:
    starts = curve["breaks"][:-1]
    piece = max(i for i, start in enumerate(starts) if start <= t)
    terms = curve["coefficients"][piece]
    return sum(own * (t - starts[piece]) ** n for n, own in enumerate(terms))


def test_a_flap_turns_on_its_hinge(tmp_path: Path) -> None:
    """Halfway its end has turned by half of the angle, across the seam of its primitives."""
    file = bent_file(flap_character(), tmp_path)
    shape = positions(file, sliders(file))
    half = positions(file, sliders(file, open=0.5))
    end = shape[:, 1] > 0.99
    expected = [0.5 + 0.5 * np.cos(ANGLE / 2), 0.5 * np.sin(ANGLE / 2)]
    np.testing.assert_allclose(half[end, 1:], np.tile(expected, (end.sum(), 1)), atol=0.01)
    straight = positions(open_gltf(tmp_path / "a.glb"), lambda name: 0.5 * (name == "open"))
    assert np.abs(straight[end, 1] - expected[0]).min() > 0.05


def test_what_is_at_one_place_stays_at_one_place(tmp_path: Path) -> None:
    """The primitives split their vertices along the diagonals of the flap."""
    file = bent_file(flap_character(), tmp_path)
    shape, half = positions(file, sliders(file)), positions(file, sliders(file, open=0.5))
    for row in shape:
        here = half[(shape == row).all(axis=1)]
        assert np.abs(here - here[0]).max() < 1e-6


@pytest.mark.parametrize("t", [0.0, 1.0])
def test_at_the_ends_of_sliders_the_face_is_that_of_the_original(tmp_path: Path, t: float) -> None:
    file = bent_file(flap_character(), tmp_path)
    expected = positions(open_gltf(tmp_path / "a.glb"), lambda name: t * (name == "open"))
    np.testing.assert_allclose(positions(file, sliders(file, open=t)), expected, atol=1e-6)


def test_what_was_there_stays_in_its_place(tmp_path: Path) -> None:
    """Only meshes with bends, and what they are made of, are any different."""
    bent = bent_file(flap_character(), tmp_path)
    original = open_gltf(tmp_path / "a.glb")
    before, after = original.document, bent.document
    for key in ("asset", "scene", "scenes", "nodes"):
        assert after[key] == before[key]
    for key in ("accessors", "bufferViews"):
        assert after[key][: len(before[key])] == before[key]
    assert after["meshes"][2] == before["meshes"][2]  # nothing moves it
    assert after["meshes"][1]["extras"]["other"] is True
    assert {k: v for k, v in after["extras"].items() if k != "elastomorph"} == before["extras"]
    for was, now in zip(before["meshes"][:2], after["meshes"][:2], strict=True):
        for old, new in zip(was["primitives"], now["primitives"], strict=True):
            assert new["targets"][: len(old["targets"])] == old["targets"]
            assert {**new, "targets": old["targets"]} == old
    content = bytes(original.buffer(0))
    assert bytes(bent.buffer(0))[: len(content)] == content


def test_primitives_of_a_mesh_keep_equal_counts_and_those_at_rest_cost_nothing(
    tmp_path: Path,
) -> None:
    file = flap_character()
    shape, _, triangles = flap()
    hinge = {"POSITION": file.array(shape - [0, 5, 0])}
    still = {"POSITION": file.array(np.zeros_like(shape)), "NORMAL": None}
    del still["NORMAL"]
    primitive = {"attributes": hinge, "targets": [still, dict(still)]}
    primitive["indices"] = file.array(triangles.reshape(-1), "<u2")
    file.json["meshes"][0]["primitives"].append(primitive)
    bent = bent_file(file, tmp_path)
    counts = {len(own) for own in targets_of(bent)}
    assert len(counts) == 1
    added = bent.document["accessors"][targets_of(bent)[2][-1]["POSITION"]]
    assert "bufferView" not in added
    assert "sparse" not in added
    assert added["min"] == added["max"] == [0, 0, 0]


@pytest.mark.parametrize("place", ["mesh", "primitive", "target"])
def test_new_targets_are_named_where_the_others_are(tmp_path: Path, place: str) -> None:
    bent = bent_file(flap_character(names=place), tmp_path)
    added = [name for name in bent.document["meshes"][0]["extras"]["targetNames"] if "." in name]
    assert added[0] == "open.bend1"
    for primitive in bent.document["meshes"][0]["primitives"]:
        if place == "primitive":
            assert primitive["extras"]["targetNames"] == ["open", "slide", *added]
        if place == "target":  # where glTF allows no names
            assert all("extras" not in target for target in primitive["targets"][2:])
    assert set(em.read_rig(tmp_path / "bent a.glb").names) == {"open", "slide"}


def test_a_target_named_like_a_bend_is_one_of_two_things(tmp_path: Path) -> None:
    """A bend that lost its curve or a shape of an artist: what to do of either is said."""
    file = flap_character()
    names = file.json["meshes"][0]["extras"]["targetNames"]
    names[1] = "open.bend1"
    path = file.write(tmp_path / "a.glb")
    with pytest.warns(em.ElastomorphWarning, match="read as a slider of its own; if another") as by:
        assert em.read_rig(path).names == ("open", "open.bend1")
    assert len(by) == 1
    with pytest.raises(em.FormatError, match=r"--from BENT.*rename them.*'open_bend1'"):
        em.bend(path, tmp_path / "b.glb")
    names[1] = "open_bend1"  # as it says
    found = bent_file(file, tmp_path).document["meshes"][0]["extras"]["targetNames"]
    assert found[:3] == ["open", "open_bend1", "open.bend1"]


@pytest.mark.filterwarnings("error")
def test_a_target_named_like_a_bend_is_ordinary_where_the_file_says_so(tmp_path: Path) -> None:
    """Its name is then not given again."""
    file = flap_character(teeth=False)
    extras = file.json["meshes"][0]["extras"]
    extras["targetNames"][1] = "open.bend1"
    morphs = [{"name": name, "target": name, "method": "linear"} for name in extras["targetNames"]]
    extras["elastomorph"] = {"version": 1, "morphs": morphs}
    bent = bent_file(file, tmp_path)
    names = bent.document["meshes"][0]["extras"]["targetNames"]
    assert names[:3] == ["open", "open.bend1", "open.bend1_"]
    rig = em.read_rig(tmp_path / "bent a.glb")
    assert rig.names == ("open", "open.bend1")
    assert [len(morph.bends) > 0 for morph in rig.morphs.values()] == [True, False]


def test_default_weights_are_extended_by_those_of_the_bends(tmp_path: Path) -> None:
    file = flap_character(weights=[0.25, 0.5])
    file.json["meshes"][0]["weights"] = [1, 0]
    bent = bent_file(file, tmp_path).document
    morph = bent["meshes"][0]["extras"]["elastomorph"]["morphs"][0]
    expected = [_value(own["curve"], 0.25) for own in morph["bends"]]
    assert bent["nodes"][0]["weights"][:2] == [0.25, 0.5]
    np.testing.assert_allclose(bent["nodes"][0]["weights"][2:], expected)
    assert bent["meshes"][0]["weights"] == [1, 0, *[0.0] * len(expected)]


def test_bends_of_a_placed_and_a_mirrored_mesh_are_in_its_own_space(tmp_path: Path) -> None:
    """Wherever a node puts it, the same numbers are stored."""
    plain = bent_file(flap_character(teeth=False), tmp_path)
    half = np.sqrt(0.5)
    placed = flap_character(
        teeth=False, translation=[3, 1, 2], rotation=[0, half, 0, half], scale=[2, 2, -2]
    )
    other = bent_file(placed, tmp_path, "b.glb")
    np.testing.assert_allclose(
        positions(other, sliders(other, open=0.5)), positions(plain, sliders(plain, open=0.5)),
        atol=2e-5,
    )  # fmt: skip


def test_bends_of_a_posed_skin_go_back_vertex_by_vertex(tmp_path: Path) -> None:
    """Where joints that turn share vertices, each has a place of its own at rest."""
    file = flap_character(teeth=False, skin=0)
    file.node(name="root")
    file.node(name="turned", rotation=[0.5, 0, 0, np.sqrt(0.75)], translation=[0, 0.3, 0])
    file.json["skins"] = [{"joints": [2, 3]}]
    for primitive in file.json["meshes"][0]["primitives"]:
        shown = primitive["attributes"]
        number = file.json["accessors"][shown["POSITION"]]["count"]
        share = np.linspace(0, 1, number)
        weights = np.stack([1 - share, share, 0 * share, 0 * share], axis=1)
        shown["JOINTS_0"] = file.array(np.tile([0, 1, 0, 0], (number, 1)), "|u1")
        shown["WEIGHTS_0"] = file.array(weights)
    bent_file(file, tmp_path)
    expected, found = em.read_rig(tmp_path / "a.glb"), em.read_rig(tmp_path / "bent a.glb")
    assert np.ptp(expected.neutral.vertices[:, 2]) > 0.2
    for t in (0.3, 0.6):
        off = found.pose({"open": t}) - expected.pose({"open": t})
        assert np.abs(off).max() < 3e-4
    straight = em.read_rig(tmp_path / "a.glb", method="linear").pose({"open": 0.5})
    assert np.abs(straight - expected.pose({"open": 0.5})).max() > 0.02


def test_expressions_of_avatars_mean_what_they_meant(tmp_path: Path) -> None:
    """VRM 0.x and 1.0 name morph targets by their numbers, which are those of the same targets."""
    bind = {"mesh": 0, "index": 1, "weight": 100}
    old = {"blendShapeMaster": {"blendShapeGroups": [{"name": "A", "binds": [bind]}]}}
    new = {"expressions": {"preset": {"aa": {"morphTargetBinds": [{"node": 0, "index": 0}]}}}}
    file = flap_character()
    file.json["extensions"] = {"VRM": old, "VRMC_vrm": new}
    file.json["extensionsUsed"] = ["VRM", "VRMC_vrm"]
    bent = bent_file(file, tmp_path, "a.vrm")
    assert bent.document["extensions"] == file.json["extensions"]
    assert bent.document["meshes"][0]["extras"]["targetNames"][:2] == ["open", "slide"]


def test_teeth_follow_the_skin_on_the_same_arc(tmp_path: Path) -> None:
    rig = em.read_rig(tmp_path / "bent a.glb") if bent_file(flap_character(), tmp_path) else None
    assert rig is not None
    teeth = rig.neutral.vertices[:, 2] > 0.05
    halfway = rig.pose({"open": 0.5})[teeth]
    rest = rig.neutral.vertices[teeth] - [0, 0.5, 0]
    c, s = np.cos(ANGLE / 2), np.sin(ANGLE / 2)
    expected = rest @ np.array([[1, 0, 0], [0, c, s], [0, -s, c]]) + [0, 0.5, 0]
    np.testing.assert_allclose(halfway, expected, atol=1e-4)


def test_a_bent_file_is_read_with_the_paths_of_its_original(tmp_path: Path) -> None:
    bent_file(flap_character(), tmp_path)
    expected = em.read_rig(tmp_path / "a.glb")
    found = em.read_rig(tmp_path / "bent a.glb")
    for t in (0.3, 0.5, 0.8):
        np.testing.assert_allclose(found.pose({"open": t}), expected.pose({"open": t}), atol=2e-4)


@pytest.mark.parametrize("version", [0, 1])
def test_a_viewer_gets_the_whole_file_with_the_paths_of_a_rig(tmp_path: Path, version: int) -> None:
    """The path of the rig is in it, and so is all that the file says; both face as glTF does."""
    file = flap_character(normals=True)
    file.json["extensions"] = [{"VRM": {}}, {"VRMC_vrm": {}}][version]
    path = file.write(tmp_path / "a.vrm")
    rig = em.read_rig(path, method="rotation")
    if version == 0:
        assert np.allclose(rig.neutral.vertices[:9, [0, 2]], -flap()[0][:9, [0, 2]])
    copy = tmp_path / "b.vrm"
    copy.write_bytes(OpenedCharacter.of(open_gltf(path)).glb(rig))
    source, document = open_gltf(path).document, open_gltf(copy).document
    assert document["extensions"] == source["extensions"]
    assert document["meshes"][0]["primitives"][0]["attributes"]["NORMAL"]
    again = em.read_rig(copy)
    assert len(again.neutral.vertices) == len(rig.neutral.vertices)
    for t in (0.3, 0.7):
        apart = again["open"].at(t) - rig["open"].at(t)
        assert np.linalg.norm(apart, axis=1).max() < 3e-5
    straight = em.read_rig(path, method="linear")
    copy.write_bytes(OpenedCharacter.of(open_gltf(path)).glb(straight))
    assert (open_gltf(copy).document, open_gltf(copy).chunk) == (source, open_gltf(path).chunk)
    with pytest.raises(em.FormatError, match="not that of its meshes"):
        OpenedCharacter.of(open_gltf(path)).glb(em.read_rig(path, mesh="flap"))


def test_normals_turn_with_the_path(tmp_path: Path) -> None:
    """At the end of the flap, where the surface turns rigidly, by half of the angle halfway."""
    file = bent_file(flap_character(normals=True), tmp_path)
    names = file.document["meshes"][0]["extras"]["targetNames"]
    weights = sliders(file, open=0.5)
    for primitive in file.document["meshes"][0]["primitives"]:
        shape = read_floats(file, primitive["attributes"]["POSITION"], 3, "a test")
        normal = read_floats(file, primitive["attributes"]["NORMAL"], 3, "a test")
        straight = normal
        for name, target in zip(names, primitive["targets"], strict=True):
            moved = read_floats(file, target["NORMAL"], 3, "a test")
            normal = normal + weights(name) * moved
            straight = straight + 0.5 * (name == "open") * moved
        end = shape[:, 1] > 0.8
        exact = np.array([0, -np.sin(ANGLE / 2), np.cos(ANGLE / 2)])
        off = np.linalg.norm(normal[end] - exact, axis=1).max()
        assert off < 0.05 < np.linalg.norm(straight[end] - exact, axis=1).min()


def test_tangents_stay_across_the_normals(tmp_path: Path) -> None:
    file = bent_file(flap_character(normals=True, tangents=True), tmp_path)
    for targets in targets_of(file):
        for target in targets[2:]:
            normal = read_floats(file, target["NORMAL"], 3, "a test")
            tangent = read_floats(file, target["TANGENT"], 3, "a test")
            # n = z and t = y at rest: what tilts n along y tilts t against z.
            np.testing.assert_allclose(tangent[:, 2], -normal[:, 1], atol=1e-6)
            assert not tangent[:, :2].any()


def test_targets_without_normals_get_bends_without_normals(tmp_path: Path) -> None:
    file = bent_file(flap_character(), tmp_path)
    assert all(list(target) == ["POSITION"] for own in targets_of(file) for target in own)


def test_quantized_targets_get_quantized_bends_in_rows_of_four_bytes(tmp_path: Path) -> None:
    file = bent_file(flap_character(quantized=True), tmp_path)
    first = len(open_gltf(tmp_path / "a.glb").document["accessors"])
    added = [
        file.document["accessors"][target["POSITION"]]
        for own in targets_of(file)
        for target in own[2:]
    ]
    # Sparse ones are floats: glTF-Transform empties sparse arrays of normalized numbers.
    for own in added:
        assert own["componentType"] == (5126 if "sparse" in own else 5122)
        assert ("normalized" in own) == ("sparse" not in own)
    for own in file.document["accessors"][first:]:
        view = file.document["bufferViews"][own.get("bufferView", 0)]
        assert "bufferView" not in own or view["byteStride"] % 4 == 0
    half = 2 * positions(file, sliders(file, open=0.5))
    plain = bent_file(flap_character(), tmp_path, "b.glb")
    expected = positions(plain, sliders(plain, open=0.5))
    np.testing.assert_allclose(half, expected, atol=5e-4)


@pytest.mark.parametrize(("tolerance", "code"), [(1e-5, 5122), (0.04, 5120)])
def test_targets_of_eight_bits_get_bends_of_sixteen_where_they_must(
    tmp_path: Path, tolerance: float, code: int
) -> None:
    file = flap_character(quantized=True, kind="|i1", teeth=False)
    bent = bent_file(file, tmp_path, tolerance=tolerance)
    added = [
        bent.document["accessors"][target["POSITION"]]
        for own in targets_of(bent)
        for target in own[2:]
    ]
    assert {own["componentType"] for own in added} <= {code, 5126}
    assert all("sparse" in own for own in added if own["componentType"] == 5126)
    assert em.bend(tmp_path / "a.glb", None, tolerance=tolerance).storage_error < 1e-2


@pytest.mark.parametrize("name", ["a.gltf", "embedded.gltf"])
def test_a_document_with_its_bytes_elsewhere_keeps_them_there(tmp_path: Path, name: str) -> None:
    flap_character().write(tmp_path / name)
    away = tmp_path / "away"
    away.mkdir()
    before = {file.name: file.read_bytes() for file in tmp_path.iterdir() if file.is_file()}
    report = em.bend(tmp_path / name, away / "b.gltf")
    assert {f.name: f.read_bytes() for f in tmp_path.iterdir() if f.is_file()} == before
    files = {file.name for file in away.iterdir()}
    more = set() if "embedded" in name else {"some bytes.bin", "b.bends.bin"}
    assert files == {"b.gltf", *more}
    assert report.bytes == sum(file.stat().st_size for file in away.iterdir())
    rig = em.read_rig(away / "b.gltf")
    assert len(rig.morphs["open"].bends)
    em.unbend(away / "b.gltf", away / "c.gltf")
    assert open_gltf(away / "c.gltf").document == open_gltf(tmp_path / name).document


def test_a_moved_character_takes_along_what_it_refers_to(tmp_path: Path) -> None:
    file = flap_character()
    skin = [{"uri": "maps/skin.png"}, {"uri": "maps/sk%69n.png"}]  # the same, written otherwise
    file.json["images"] = [*skin, {"uri": "data:image/png;base64,AAAA"}]
    file.write(tmp_path / "a.gltf")
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps" / "skin.png").write_bytes(b"a picture")
    away = tmp_path / "away"
    away.mkdir()
    report = em.bend(tmp_path / "a.gltf", away / "a.gltf")
    assert (away / "maps" / "skin.png").read_bytes() == b"a picture"
    sizes = [own.stat().st_size for own in away.rglob("*") if own.is_file()]
    assert report.bytes == sum(sizes)  # each file once


def test_only_some_targets_bend_by_the_methods_named(tmp_path: Path) -> None:
    path = flap_character().write(tmp_path / "a.glb")
    assert em.bend(path, None, only=["slide"]).bent == ()
    report = em.bend(path, None, method={"open": "linear"})
    assert (report.bent, report.straight) == ((), ("open", "slide"))
    report = em.bend(path, None, method="rotation")
    assert [own.name for own in report.bent] == ["open"]
    with pytest.raises(em.ParameterError, match="wide"):
        em.bend(path, None, only=["wide"])


def test_no_more_targets_than_there_is_room_for(tmp_path: Path) -> None:
    path = flap_character().write(tmp_path / "a.glb")
    whole = em.bend(path, None)
    assert whole.targets > 3
    some = em.bend(path, tmp_path / "b.glb", max_targets=3)
    assert (some.targets_before, some.targets) == (2, 3)
    assert some.bent[0].error > whole.bent[0].error
    none = em.bend(path, None, max_targets=2)
    assert [own.name for own in none.left_out] == ["open"]
    # What stays straight is off by all that it would have bent by.
    assert none.largest_error == pytest.approx(whole.bent[0].gain, rel=1e-6)


def test_a_report_without_an_output_is_that_of_the_file(tmp_path: Path) -> None:
    path = flap_character().write(tmp_path / "a.glb")
    planned = em.bend(path, None)
    assert list(tmp_path.iterdir()) == [path]
    done = em.bend(path, tmp_path / "b.glb")
    assert planned.bytes == done.bytes == (tmp_path / "b.glb").stat().st_size
    assert planned.bent == done.bent


@pytest.mark.parametrize("options", [{"method": "linear"}, {"max_targets": 2}], ids=repr)
@pytest.mark.parametrize("name", ["a.glb", "a.gltf"])
def test_a_file_in_which_nothing_bends_is_not_written(
    tmp_path: Path, name: str, options: dict[str, Any]
) -> None:
    path = flap_character().write(tmp_path / name)
    before = sorted(tmp_path.iterdir())
    out = path.with_stem("b")
    for output, curves in ((None, None), (out, None), (out, tmp_path / "curves.json")):
        report = em.bend(path, output, curves=curves, **options)
        assert (report.output, report.bent, report.targets) == (None, (), 2)
        assert report.bytes == report.bytes_before
        assert sorted(tmp_path.iterdir()) == before


def test_a_head_keeps_its_polygons(tmp_path: Path) -> None:
    rig = straight("jawOpen", "eyeBlink_L")
    em.write(tmp_path / "head.glb", rig)
    em.bend(tmp_path / "head.glb", tmp_path / "bent.glb")
    found = em.read_rig(tmp_path / "bent.glb")
    assert found.neutral.faces == rig.neutral.faces
    expected = em.read_rig(tmp_path / "head.glb", method="auto")
    for name in rig.names:
        away = found.pose({name: 0.5}) - expected.pose({name: 0.5})
        assert np.abs(away).max() < 3e-4 * rig.neutral.diameter
    assert len(found.morphs["jawOpen"].bends)


def test_the_source_may_lie_where_nothing_can_be_written(tmp_path: Path) -> None:
    media = tmp_path / "media"
    media.mkdir()
    path = flap_character().write(media / "a.glb")
    path.chmod(0o444)
    media.chmod(0o555)
    try:
        em.bend(path, tmp_path / "b.glb")
    finally:
        media.chmod(0o755)
    assert (tmp_path / "b.glb").exists()
    shutil.rmtree(media)


def test_the_numbers_of_a_report_are_json(tmp_path: Path) -> None:
    from elastomorph.cli.bend import _facts

    path = flap_character().write(tmp_path / "a.glb")
    facts = json.loads(json.dumps(_facts(em.bend(path, None))))
    assert facts["bent"][0]["name"] == "open"
    assert facts["output"] is None


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-7])
def test_bends_hold_their_paths_within_the_tolerance(tmp_path: Path, tolerance: float) -> None:
    """The flap turns on its hinge, an arc that is known."""
    path = flap_character().write(tmp_path / "flap.glb")
    report = em.bend(path, None, tolerance=tolerance)
    assert report.bent
    assert all(own.error <= tolerance for own in report.bent)
    loose = em.bend(path, None, tolerance=10 * tolerance)
    assert sum(own.bends for own in loose.bent) <= sum(own.bends for own in report.bent)
