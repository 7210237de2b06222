"""A rig that was written comes back: everything exact, positions in single precision."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from shutil import copyfile
from typing import Any

import numpy as np
import pytest
from glb_samples import SHARED_VERTICES, chunks_of, glb, rigs, seamed_mesh, triangle_rig
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from elastomorph.errors import ElastomorphWarning
from elastomorph.io.gltf import read_glb, write_glb
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import FaceLabels, Mesh
from elastomorph.model.morph import Morph
from elastomorph.rig import Rig
from elastomorph.rig.positive import with_positive_weights


def assert_same_labels(one: FaceLabels | None, other: FaceLabels | None) -> None:
    assert (one is None) == (other is None)
    if one is not None and other is not None:
        assert one.names == other.names
        assert np.array_equal(one.of_face, other.of_face)


def assert_same_rig(one: Rig, other: Rig) -> None:
    one = with_positive_weights(one)  # as its bends are stored
    scale = one.neutral.diameter or 1.0
    mesh, back = one.neutral, other.neutral
    assert back.faces == mesh.faces
    assert back.vertices.shape == mesh.vertices.shape
    assert (mesh.uv is None) == (back.uv is None)
    if mesh.uv is not None and back.uv is not None:
        assert mesh.uv.coordinates.tobytes() == back.uv.coordinates.tobytes()
        assert np.array_equal(mesh.uv.corners, back.uv.corners)
    assert_same_labels(mesh.materials, back.materials)
    assert_same_labels(mesh.groups, back.groups)
    assert mesh.material_library == back.material_library
    assert list(other.morphs) == list(one.morphs)
    assert other.sliders == one.sliders
    for name, morph in one.morphs.items():
        again = other.morphs[name]
        assert again.method == morph.method
        assert again.bake_error == morph.bake_error
        curves = [morph.limit_law, *kept_curves(morph)]
        for mine, theirs in zip(curves, [again.limit_law, *again.bend_curves], strict=True):
            assert np.array_equal(mine.breaks, theirs.breaks)
            assert np.array_equal(mine.coefficients, theirs.coefficients)
        away = again.at([0, 0.3, 1, 1.2]) - morph.at([0, 0.3, 1, 1.2])
        assert np.linalg.norm(away, axis=2).max() <= 3e-5 * scale


def kept_curves(morph: Morph) -> list[Any]:
    """The curves of the bends that move anything: the others are not written."""
    moments = np.linspace(0, 1, 65)[:, None]
    kept = []
    for curve, bend in zip(morph.bend_curves, morph.bends, strict=True):
        times = curve.breaks[:-1] + moments * np.diff(curve.breaks)
        if np.abs(curve(times)).max() * np.abs(bend).max() > 0:
            kept.append(curve)
    return kept


@given(rig=rigs(), normals=st.sampled_from(["delta", "none"]), sparse=st.booleans())
@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_a_rig_comes_back(
    tmp_path_factory: pytest.TempPathFactory, rig: Rig, normals: Any, sparse: bool
) -> None:
    """Quads, seams, unused and repeated texture coordinates, labels, bends, correctives, groups."""
    path = tmp_path_factory.getbasetemp() / "rig.glb"
    report = write_glb(path, rig, normals=normals, sparse=sparse, tolerance=0)
    back = read_glb(path)
    assert_same_rig(rig, back)
    for name, morph in rig.morphs.items():
        away = back.morphs[name].at(0.4) - morph.at(0.4)
        most = np.linalg.norm(away, axis=1).max() / (rig.neutral.diameter or 1)
        assert most <= report.rounding_error + 1e-15
    again = path.with_name("again.glb")
    write_glb(again, back, normals=normals, sparse=sparse, tolerance=0)
    assert_same_rig(back, read_glb(again))


def rig_on(mesh: Mesh) -> Rig:
    target = mesh.with_vertices(mesh.vertices * [1, 1, 2] + [0, 0.25, 0])
    return Rig(mesh, {"m": Morph(mesh, target, np.zeros((0, *mesh.vertices.shape)), ())})


def test_markers_without_polygons_come_back(tmp_path: Path) -> None:
    rig = rig_on(Mesh(np.arange(15.0).reshape(5, 3)))
    write_glb(tmp_path / "a.glb", rig)
    assert_same_rig(rig, read_glb(tmp_path / "a.glb"))


def test_vertices_outside_all_polygons_keep_their_place(tmp_path: Path) -> None:
    rig = rig_on(Mesh(np.arange(18.0).reshape(6, 3), [[4, 1, 3]]))
    write_glb(tmp_path / "a.glb", rig)
    assert_same_rig(rig, read_glb(tmp_path / "a.glb"))


def test_more_vertices_than_short_indices_can_name(tmp_path: Path) -> None:
    count = 70_000
    vertices = np.random.default_rng(0).normal(size=(count, 3))
    faces = np.arange(count - count % 4).reshape(-1, 4)[::-1]
    bends = np.zeros((0, count, 3))
    mesh = Mesh(vertices, faces)
    up = vertices.copy()
    up[-5:] += 1
    rig = Rig(mesh, {"m": Morph(mesh, mesh.with_vertices(up), bends, ())})
    write_glb(tmp_path / "a.glb", rig)
    back = read_glb(tmp_path / "a.glb")
    assert back.neutral.faces == mesh.faces
    np.testing.assert_allclose(back.morphs["m"].delta, rig.morphs["m"].delta, atol=1e-6)


def test_the_same_rig_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a", "b"):
        write_glb(tmp_path / f"{name}.glb", triangle_rig())
    assert (tmp_path / "a.glb").read_bytes() == (tmp_path / "b.glb").read_bytes()


def rewritten(path: Path, change: Any) -> Path:
    """The file after another program has changed its document."""
    document, blob = chunks_of(path)
    change(document)
    json.dumps(document)
    path.write_bytes(glb(document, blob))
    return path


def test_a_file_whose_triangles_were_reordered_is_read_as_triangles(tmp_path: Path) -> None:
    copyfile(SHARED_VERTICES, tmp_path / "a.glb")

    def reorder(document: dict[str, Any]) -> None:
        document["meshes"][0]["primitives"].reverse()

    with pytest.warns(ElastomorphWarning, match="triangles for polygons"):
        rig = read_glb(rewritten(tmp_path / "a.glb", reorder))
    assert len(rig.neutral.vertices) == 9
    assert set(rig.neutral.faces.sizes.tolist()) == {3}
    assert rig.neutral.materials is not None
    assert rig.neutral.materials.names == ("unnamed", "teeth", "skin")
    assert rig.names == ("a", "b")


def test_a_file_whose_vertices_were_split_says_that_its_polygons_are_lost(tmp_path: Path) -> None:
    """As gltf-transform's weld does: each primitive gets vertices of its own."""
    copyfile(SHARED_VERTICES, tmp_path / "a.glb")

    def split(document: dict[str, Any]) -> None:
        for primitive in document["meshes"][0]["primitives"]:
            own = document["accessors"][primitive["attributes"]["POSITION"]]
            primitive["attributes"]["POSITION"] = len(document["accessors"])
            document["accessors"].append(dict(own))

    with pytest.warns(ElastomorphWarning, match=r"has split .* its polygons are lost") as said:
        rig = read_glb(rewritten(tmp_path / "a.glb", split))
    assert len(said) == 1
    assert set(rig.neutral.faces.sizes.tolist()) == {3}
    assert rig.names == ("a", "b")


def test_a_file_whose_materials_share_all_vertices_is_read_as_ever() -> None:
    rig, mesh = read_glb(SHARED_VERTICES), seamed_mesh()
    assert rig.neutral.faces == mesh.faces
    assert rig.neutral.vertices.tolist() == mesh.vertices.tolist()
    assert rig.names == ("a", "b")
    assert rig.sliders.groups == {"g": ("a", "b")}
    moved = np.array([0.1 * (0.3 - 0.3**2), 0, 0.3])
    np.testing.assert_allclose(rig.pose({"a": 0.3}) - mesh.vertices, [moved] * 7, atol=1e-7)


def parted_rig() -> Rig:
    """Three meshes in the file; "teeth" moves the last polygon alone, its bend comes first."""
    mesh = seamed_mesh()
    up = np.zeros((7, 3))
    up[6] = [0, 1, 0]
    side = np.zeros((2, 7, 3))
    side[0, 6, 0], side[1, :, 2] = 0.3, 0.1
    curves = (BendCurve.polynomial([0, 1, -1]), BendCurve.polynomial([0, 1, 0, -1]))
    none = np.zeros((0, 7, 3))

    def to(moved: np.ndarray) -> Mesh:
        return mesh.with_vertices(mesh.vertices + moved)

    first = np.eye(7)[:, :1] * [0, 0, 1.0]
    return Rig(
        mesh,
        {
            "nothing": Morph(mesh, mesh, none, ()),
            "teeth": Morph(mesh, to(up), side[:1], curves[:1]),
            "corner": Morph(mesh, to(first), side[1:], curves[1:]),
            "both": Morph(mesh, to(0.5 * up), none, ()),
            "all": Morph(mesh, to(np.ones((7, 3))), side, curves),
        },
        correctives={"both": ["teeth", "corner"]},
        groups={"g": ["all", "teeth"], "h": ["corner"]},
    )


@pytest.mark.parametrize("compress", [False, True])
def test_each_material_is_a_mesh_that_has_what_moves_it_and_all_come_back_as_one(
    tmp_path: Path, compress: bool
) -> None:
    rig = parted_rig()
    report = write_glb(tmp_path / "a.glb", rig, compress=compress)
    document = chunks_of(tmp_path / "a.glb")[0]
    assert [len(mesh["primitives"]) for mesh in document["meshes"]] == [1, 1, 1]
    shown = {
        document["nodes"][number]["name"]: document["nodes"][number]["mesh"]
        for number in document["nodes"][0]["children"]
    }
    assert list(shown) == ["skin", "teeth", "unnamed"]
    held = [mesh["extras"].get("targetNames", []) for mesh in document["meshes"]]
    # "skin" is the second polygon: its normals turn with the last, which it touches, and the first.
    everything = [
        *("nothing", "teeth", "teeth.bend1", "corner", "corner.bend1"),
        *("both", "all", "all.bend1", "all.bend2"),
    ]
    assert held[0] == everything
    assert held[1] == [
        n for n in everything if n not in ("nothing", "teeth", "teeth.bend1", "both", "all.bend1")
    ]
    assert [name for name in held[2] if name.startswith("teeth")] == ["teeth", "teeth.bend1"]
    assert "nothing" not in held[2]
    back = read_glb(tmp_path / "a.glb")
    assert list(back.morphs) == list(rig.morphs)
    assert back.sliders == rig.sliders
    assert back.neutral.faces == rig.neutral.faces
    allowed = 1.01 * (report.rounding_error + report.dropped_error) * rig.neutral.diameter + 1e-7
    for name in rig.names:
        for t in (0.4, 1.0):
            away = np.linalg.norm(back.pose({name: t}) - rig.pose({name: t}), axis=1)
            assert away.max() <= 3 * allowed
    for name, morph in rig.morphs.items():
        curves = [(one.breaks.tolist(), one.coefficients.tolist()) for one in morph.bend_curves]
        found = back.morphs[name].bend_curves
        assert [(one.breaks.tolist(), one.coefficients.tolist()) for one in found] == curves


def test_the_meshes_of_a_face_come_back_in_whatever_order_they_are_shown(tmp_path: Path) -> None:
    write_glb(tmp_path / "a.glb", parted_rig())
    expected = read_glb(tmp_path / "a.glb")

    def reverse(document: dict[str, Any]) -> None:
        document["nodes"][0]["children"].reverse()

    assert_same_rig(read_glb(rewritten(tmp_path / "a.glb", reverse)), expected)


def test_one_material_of_a_face_can_be_read_alone(tmp_path: Path) -> None:
    write_glb(tmp_path / "a.glb", parted_rig())
    teeth = read_glb(tmp_path / "a.glb", mesh="teeth")
    assert len(teeth.neutral.vertices) == 4
    assert list(teeth.morphs) == ["corner", "all"]
    assert len(teeth.morphs["corner"].bends) == 1
    assert_same_rig(read_glb(tmp_path / "a.glb"), read_glb(tmp_path / "a.glb", mesh="face"))


def test_a_face_that_has_lost_a_material_is_read_as_the_meshes_it_has(tmp_path: Path) -> None:
    write_glb(tmp_path / "a.glb", parted_rig())

    def lose(document: dict[str, Any]) -> None:
        document["nodes"][0]["children"].pop()

    with pytest.warns(ElastomorphWarning, match="meshes are missing"):
        rig = read_glb(rewritten(tmp_path / "a.glb", lose))
    assert set(rig.neutral.faces.sizes.tolist()) == {3}
    assert set(rig.names) == {"nothing", "teeth", "corner", "all"}


def test_a_mesh_of_ours_beside_another_keeps_its_polygons_and_bends(tmp_path: Path) -> None:
    """As where hair was added in another program."""
    own = rig_on(seamed_mesh())
    write_glb(tmp_path / "a.glb", own)
    alone = read_glb(tmp_path / "a.glb")

    def add(document: dict[str, Any]) -> None:
        first = document["meshes"][0]["primitives"][0]
        kept = {"attributes": {"POSITION": first["attributes"]["POSITION"]}}
        document["meshes"].append({"primitives": [{**kept, "indices": first["indices"]}]})
        document["nodes"].append({"mesh": len(document["meshes"]) - 1, "name": "hair"})
        document["scenes"][0]["nodes"].append(len(document["nodes"]) - 1)

    both = read_glb(rewritten(tmp_path / "a.glb", add))
    count = len(alone.neutral.vertices)
    assert len(both.neutral.vertices) > count
    sizes = alone.neutral.faces.sizes.tolist()
    assert both.neutral.faces.sizes.tolist()[: len(sizes)] == sizes
    assert both.names == alone.names
    for t in (0.3, 1.0):
        np.testing.assert_array_equal(both.pose({"m": t})[:count], alone.pose({"m": t}))
        np.testing.assert_array_equal(both.pose({"m": t})[count:], both.neutral.vertices[count:])
    assert_same_rig(alone, read_glb(tmp_path / "a.glb", mesh=name_of_mesh(tmp_path / "a.glb")))


def name_of_mesh(path: Path) -> str:
    name: str = chunks_of(path)[0]["meshes"][0]["name"]
    return name


def test_morph_targets_in_another_order_keep_their_bends(tmp_path: Path) -> None:
    """They are known by name."""
    rig = triangle_rig()
    write_glb(tmp_path / "a.glb", rig)

    def swap(document: dict[str, Any]) -> None:
        mesh = document["meshes"][0]
        mesh["primitives"][0]["targets"].reverse()
        mesh["extras"]["targetNames"].reverse()

    assert_same_rig(rig, read_glb(rewritten(tmp_path / "a.glb", swap)))


STRAIGHT = {"breaks": [0, 1], "coefficients": [[0]]}


@pytest.mark.parametrize(
    ("where", "what", "reason"),
    [
        ("version", 4, "update elastomorph"),
        ("version", "1", "no version"),
        ("version", True, "no version"),
        ("version", 0, "no version"),
        ("version", 1.5, "no version"),
        ("morphs", {}, "no list"),
        ("morphs", [3], "no object"),
        ("morphs", [{"name": "m", "target": "gone", "limit_law": STRAIGHT}], "does not exist"),
        ("morphs", [{"name": "m", "target": "lift", "limit_law": None}], "curve is damaged"),
        ("morphs", [{"name": n, "target": "lift", "limit_law": STRAIGHT} for n in "ab"], "twice"),
        ("correctives", [{"name": "x", "drivers": ["lift"]}], "no slider"),
        ("correctives", [{"drivers": ["lift"]}], "no slider ''"),
        ("correctives", 2 * [{"name": "lift", "drivers": ["lift"]}], "'lift' twice"),
        ("groups", [{"name": "x", "members": [1]}], "no lists of names"),
    ],
)
@pytest.mark.parametrize("version", [1, 3])
def test_damaged_extras_do_not_keep_the_face_from_being_read(
    tmp_path: Path, where: str, what: Any, reason: str, version: int
) -> None:
    write_glb(tmp_path / "a.glb", triangle_rig())

    def damage(document: dict[str, Any]) -> None:
        stored = document["meshes"][0]["extras"]["elastomorph"]
        stored["version"] = version
        stored[where] = what

    with pytest.warns(ElastomorphWarning, match=reason):
        rig = read_glb(rewritten(tmp_path / "a.glb", damage))
    assert rig.names == ("lift", "lift.bend1")


def folded(document: dict[str, Any]) -> None:
    stored = document["meshes"][0]["extras"]["elastomorph"]
    stored["version"] = 2
    stored["morphs"][0]["fold"] = {"breaks": [0, 0.5, 1], "coefficients": [[0, 1], [0.5, -1]]}


def test_a_fold_is_a_bend_that_is_delta(tmp_path: Path) -> None:
    """The weight of the target itself is then t + fold(t)."""
    write_glb(tmp_path / "a.glb", triangle_rig())
    plain = read_glb(tmp_path / "a.glb").morphs["lift"]
    rig = read_glb(rewritten(tmp_path / "a.glb", folded))
    assert len(rig.morphs["lift"].bends) == len(plain.bends) + 1
    for t, fold in ((-1.0, -1.0), (0.25, 0.25), (0.5, 0.5), (0.75, 0.25), (1.0, 0.0), (2.0, -1.0)):
        expected = plain.at(t) + fold * plain.delta
        np.testing.assert_allclose(rig.pose({"lift": t}), expected, atol=1e-12)
    write_glb(tmp_path / "b.glb", rig, tolerance=0)
    np.testing.assert_allclose(
        read_glb(tmp_path / "b.glb").pose({"lift": 0.25}), rig.pose({"lift": 0.25}), atol=1e-7
    )


def test_versions_are_whole_numbers_with_or_without_a_point(tmp_path: Path) -> None:
    write_glb(tmp_path / "a.glb", triangle_rig())

    def pointed(document: dict[str, Any]) -> None:
        document["meshes"][0]["extras"]["elastomorph"]["version"] = 1.0

    assert_same_rig(triangle_rig(), read_glb(rewritten(tmp_path / "a.glb", pointed)))


def test_version_1_knows_no_fold(tmp_path: Path) -> None:
    """What a reader of version 1 passes over, all pass over: a file means the same to all."""
    write_glb(tmp_path / "a.glb", triangle_rig())

    def older(document: dict[str, Any]) -> None:
        folded(document)
        document["meshes"][0]["extras"]["elastomorph"]["version"] = 1

    assert_same_rig(triangle_rig(), read_glb(rewritten(tmp_path / "a.glb", older)))


def test_a_pair_bend_of_a_product_comes_back(tmp_path: Path) -> None:
    """It has no target, which version 1 does not know, whatever its law."""
    rig = triangle_rig()
    bend = np.ones((1, len(rig.neutral.vertices), 3))
    pair = Morph(rig.neutral, rig.neutral, bend, (BendCurve.power(2),))
    lift = rig.morphs["lift"]
    morphs = {"lift": lift, "other": lift, "pair": pair}
    with_pair = Rig(rig.neutral, morphs, correctives={"pair": ["lift", "other"]})
    write_glb(tmp_path / "a.glb", with_pair)
    back = read_glb(tmp_path / "a.glb")
    assert back.sliders.names == ("lift", "other")
    for weights in ({"lift": 0.5}, {"lift": 0.5, "other": 0.75}, {"lift": 1.0, "other": 1.0}):
        np.testing.assert_allclose(back.pose(weights), with_pair.pose(weights), atol=1e-6)


def test_what_only_elastomorph_asks_may_be_missing(tmp_path: Path) -> None:
    """Another writer needs no law of stiff materials, and no choice."""
    write_glb(tmp_path / "a.glb", triangle_rig())

    def least(document: dict[str, Any]) -> None:
        for morph in document["meshes"][0]["extras"]["elastomorph"]["morphs"]:
            for key in ("limit_law", "bake_error", "method"):
                del morph[key]

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        rig = read_glb(rewritten(tmp_path / "a.glb", least))
    np.testing.assert_allclose(
        rig.pose({"lift": 0.5}), triangle_rig().pose({"lift": 0.5}), atol=1e-7
    )


def test_a_target_added_by_another_program_is_a_morph_of_its_own(tmp_path: Path) -> None:
    write_glb(tmp_path / "a.glb", triangle_rig())

    def add(document: dict[str, Any]) -> None:
        mesh = document["meshes"][0]
        mesh["primitives"][0]["targets"].append(mesh["primitives"][0]["targets"][0])
        mesh["extras"]["targetNames"].append("extra")

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        rig = read_glb(rewritten(tmp_path / "a.glb", add))
    assert rig.names == ("lift", "extra")
    np.testing.assert_array_equal(rig.morphs["extra"].delta, rig.morphs["lift"].delta)


def test_a_bend_that_moves_nothing_to_speak_of_turns_no_normal(tmp_path: Path) -> None:
    """Fitting normals to a curve of 1e-200 would make them infinite."""
    neutral = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    target = neutral.with_vertices(neutral.vertices + [[0, 0, 1.0], [0, 0, 0], [0, 0, 0]])
    curve = BendCurve.polynomial([0.0, -1e-200, 1e-200])
    morph = Morph(neutral, target, np.ones((1, 3, 3)) * [[[1.0], [2.0], [3.0]]], (curve,))
    write_glb(tmp_path / "r.glb", Rig(neutral, {"a": morph}), tolerance=0)
    back = read_glb(tmp_path / "r.glb")
    assert len(back.morphs["a"].bends) == 1
    np.testing.assert_allclose(back.pose({"a": 0.5}), morph.at(0.5), atol=1e-7)
