"""Meshes and blend shapes of an FBX file come as a rig: exact, upright, one slider a channel."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import elastomorph as em
from elastomorph.errors import (
    ElastomorphWarning,
    FileError,
    FormatError,
    MissingExtraError,
    ParameterError,
)
from elastomorph.io.fbx import read_fbx
from elastomorph.io.fbx.reader import FbxMesh, read_meshes
from elastomorph.io.npz.members import open_npz
from elastomorph.rig import Rig
from fbx_samples import Z_UP, Element, Model, Shape, as_binary, as_text, quad, scene
from needs import installed

installed("ufbx", "fbx")

Reader = Callable[..., Rig]


@pytest.fixture
def rig_of(tmp_path: Path) -> Reader:
    def read(
        elements: Sequence[Element],
        encoding: Callable[[Sequence[Element]], bytes] = as_binary,
        **options: Any,
    ) -> Rig:
        path = tmp_path / "face.fbx"
        path.write_bytes(encoding(elements))
        return read_fbx(path, **options)

    return read


def corners(rig: Rig) -> list[list[int]]:
    return [polygon.tolist() for polygon in rig.neutral.faces]


@pytest.mark.parametrize("encoding", [as_text, as_binary])
def test_points_polygons_and_offsets_arrive_as_written(
    rig_of: Reader, encoding: Callable[[Sequence[Element]], bytes]
) -> None:
    """In the order of the file, bit for bit, as text and as binary with compressed arrays."""
    random = np.random.default_rng(7)
    points = random.normal(size=(40, 3))
    polygons = [random.permutation(40)[: random.integers(3, 8)].tolist() for _ in range(30)]
    moved = np.sort(random.permutation(40)[:17])
    offsets = random.normal(size=(17, 3))
    model = Model("head", points, polygons, {"a.smile": [Shape(moved, offsets)]}, deformer="a")
    rig = rig_of(scene(model), encoding)
    assert rig.neutral.vertices.tobytes() == points.tobytes()
    assert corners(rig) == polygons
    expected = points.copy()
    expected[moved] += offsets
    assert rig.names == ("smile",)
    assert rig.morphs["smile"].target.vertices.tobytes() == expected.tobytes()
    assert rig.pose({"smile": 1.0}) == pytest.approx(expected, abs=1e-15)


def test_a_channel_with_in_betweens_is_a_path_straight_from_shape_to_shape(
    rig_of: Reader,
) -> None:
    """Full weights 25, 60 and 100: numpy.interp between the shapes, at any weight."""
    random = np.random.default_rng(3)
    shapes = random.normal(size=(3, 4, 3))
    keys = [Shape(range(4), s, w) for s, w in zip(shapes, (60.0, 100.0, 25.0), strict=True)]
    rig = rig_of(scene(quad(channels={"b.jaw": keys}, deformer="b")))
    morph = rig.morphs["jaw"]
    assert len(morph.bends) == 2
    times = np.concatenate([[0, 0.25, 0.6, 1], random.uniform(size=40)])
    known = np.array([np.zeros((4, 3)), shapes[2], shapes[0], shapes[1]]).reshape(4, 12)
    expected = np.stack([np.interp(times, [0, 0.25, 0.6, 1], known[:, i]) for i in range(12)], 1)
    moved = (morph.at(times) - rig.neutral.vertices).reshape(-1, 12)
    assert moved == pytest.approx(expected, abs=1e-14)


def test_in_betweens_on_the_straight_line_need_no_bends(rig_of: Reader) -> None:
    keys = [Shape([1], [[0.5, 0, 1]], 50.0), Shape([1], [[1, 0, 2]], 100.0)]
    assert len(rig_of(scene(quad(channels={"jaw": keys}))).morphs["jaw"].bends) == 0


def test_weight_1_reaches_the_last_shape_whatever_its_full_weight(rig_of: Reader) -> None:
    keys = [Shape([1], [[1, 0, 0]], 20.0), Shape([1], [[0, 4, 0]], 40.0)]
    morph = rig_of(scene(quad(channels={"jaw": keys}))).morphs["jaw"]
    assert (morph.at([0.5, 1.0]) - morph.neutral.vertices)[:, 1].tolist() == [[1, 0, 0], [0, 4, 0]]


def test_shapes_that_lie_on_no_path_from_0_to_1_are_named_in_a_warning(rig_of: Reader) -> None:
    keys = [Shape([1], [[9, 9, 9]], -50.0), Shape([1], [[0, 4, 0]], 100.0)]
    with pytest.warns(ElastomorphWarning, match="'jaw' has 2 shapes, of which 1 are kept"):
        rig = rig_of(scene(quad(channels={"jaw": keys})))
    assert rig.morphs["jaw"].delta[1].tolist() == [0, 4, 0]


@pytest.mark.parametrize(
    ("channel", "shape", "name"),
    [
        ("blendShape1.jawOpen", "jawOpen", "jawOpen"),
        ("blendShape1.jawOpen", "jawOpenShape", "jawOpen"),
        ("head:shapes.jawOpen", "jawOpen", "jawOpen"),
        ("jaw.L", "", "jaw.L"),
        ("", "jawOpen", "jawOpen"),
        ("Mund öffnen", "Key", "Mund öffnen"),
    ],
)
def test_sliders_have_the_name_that_people_see(
    rig_of: Reader, channel: str, shape: str, name: str
) -> None:
    keys = [Shape([1], [[1, 0, 0]], name=shape)]
    assert rig_of(scene(quad(channels={channel: keys}))).names == (name,)


def test_all_meshes_become_one_and_share_their_sliders(rig_of: Reader) -> None:
    """In the order of the file; the one with most channels gives unit and origin."""
    teeth = quad(
        name="teeth",
        channels={"jaw": [Shape([0], [[0, -1, 0]])]},
        translation=[3, 0, 0],
        scaling=[0.02, 0.02, 0.02],
    )
    head = quad(
        name="head",
        channels={"jaw": [Shape([1], [[0, -2, 0]])], "smile": [Shape([2], [[1, 0, 0]])]},
        translation=[1, 0, 0],
        scaling=[0.01, 0.01, 0.01],
    )
    eye = Model("eye", [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    rig = rig_of(scene(teeth, eye, head))
    own = np.array(head.vertices)
    assert rig.neutral.vertices[7:].tobytes() == own.astype(float).tobytes()
    assert rig.neutral.vertices[:4] == pytest.approx(2 * own + [200, 0, 0], abs=1e-12)
    assert rig.neutral.vertices[4:7] == pytest.approx(
        100 * np.array(eye.vertices) - [100, 0, 0], abs=1e-12
    )
    assert corners(rig) == [[0, 1, 2, 3], [4, 5, 6], [7, 8, 9, 10]]
    assert rig.neutral.groups is not None
    assert rig.neutral.groups.names == ("teeth", "eye", "head")
    assert rig.names == ("jaw", "smile")
    jaw = np.zeros((11, 3))
    jaw[0], jaw[8] = [0, -2, 0], [0, -2, 0]
    assert rig.morphs["jaw"].delta == pytest.approx(jaw, abs=1e-12)
    assert np.flatnonzero(rig.morphs["smile"].delta.any(axis=1)).tolist() == [9]


def test_in_betweens_of_one_slider_may_differ_from_mesh_to_mesh(rig_of: Reader) -> None:
    first = quad(channels={"jaw": [Shape([0], [[1, 0, 0]], 30.0), Shape([0], [[0, 1, 0]])]})
    other = quad(
        name="b", channels={"jaw": [Shape([0], [[3, 0, 0]], 70.0), Shape([0], [[0, 1, 0]])]}
    )
    morph = rig_of(scene(first, other)).morphs["jaw"]
    moved = morph.at([0.3, 0.7]) - morph.neutral.vertices
    assert moved[0, 0] == pytest.approx([1, 0, 0], abs=1e-15)
    assert moved[1, 4] == pytest.approx([3, 0, 0], abs=1e-15)
    assert moved[0, 4] == pytest.approx([3 * 3 / 7, 0, 0], abs=1e-15)


def test_hidden_meshes_and_lower_levels_of_detail_are_left_out(rig_of: Reader) -> None:
    levels = Model("levels", lod_group=True, children=[quad(name="fine"), quad(name="coarse")])
    hidden = Model("old", shown=False, children=[quad(name="backup")])
    rig = rig_of(scene(levels, hidden, quad(name="other")))
    assert rig.neutral.groups is not None
    assert sorted(rig.neutral.groups.names) == ["fine", "other"]


def test_where_all_is_hidden_it_is_taken_all_the_same(rig_of: Reader) -> None:
    assert len(rig_of(scene(quad(shown=False)))) == 1


def test_meshes_are_chosen_by_name_with_or_without_shapes(rig_of: Reader) -> None:
    eye = Model("eye", [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    rig = rig_of(scene(quad(), eye, quad(name="brow")), mesh=["eye", "face"])
    assert rig.neutral.groups is not None
    assert rig.neutral.groups.names == ("face", "eye")
    assert rig.neutral.vertices[4:].tolist() == eye.vertices
    alone = rig_of(scene(quad(), eye), mesh="eye")
    assert alone.neutral.vertices.tolist() == eye.vertices
    assert alone.names == ()
    with pytest.raises(FormatError, match=r"no mesh is called 'nose'; there are 'face' \(1 shapes"):
        rig_of(scene(quad(), eye), mesh="nose")


def test_texture_coordinates_and_materials_of_all_meshes(rig_of: Reader) -> None:
    one = quad(uv=([[0, 0], [1, 0], [1, 1], [0.25, 0.75]], [3, 2, 1, 0]), materials=(["skin"], [0]))
    lip = {"lip": [Shape([0], [[1, 0, 0]])]}
    two = Model(
        "lips",
        np.eye(3),
        [[0, 1, 2], [2, 1, 0]],
        lip,
        uv=([[0.5, 0.5]], [0] * 6),
        materials=(["red", "skin"], [1, 0]),
    )
    bare = Model("bare", np.eye(3), [[0, 1, 2]], lip)
    mesh = rig_of(scene(one, two, bare)).neutral
    assert mesh.uv is not None
    assert mesh.uv.coordinates[mesh.uv.corners[:4]].tolist() == [
        [0.25, 0.75],
        [1, 1],
        [1, 0],
        [0, 0],
    ]
    assert mesh.uv.coordinates[mesh.uv.corners[4:10]].tolist() == [[0.5, 0.5]] * 6
    assert mesh.uv.corners[10:].tolist() == [-1] * 3
    assert mesh.materials is not None
    names = [mesh.materials.names[i] if i >= 0 else None for i in mesh.materials.of_face.tolist()]
    assert names == ["skin", "skin", "red", None]


def test_vertex_groups_of_blenders_shape_keys_weigh_their_offsets(rig_of: Reader) -> None:
    shape = {"lift": [Shape([0, 2], [[0, 0, 1], [0, 8, 0]], name="lift")]}
    model = quad(channels=shape, vertex_weights={"lift": [100.0, 25.0]})
    rig = rig_of(scene(model, creator="Blender (stable FBX IO) - 2.79 (sub 0) - 3.7.13"))
    assert rig.morphs["lift"].delta.tolist() == [[0, 0, 1], [0, 0, 0], [0, 2, 0], [0, 0, 0]]


def test_two_channels_of_one_name_stay_two_sliders(rig_of: Reader) -> None:
    model = quad(
        channels={"a.x": [Shape([0], [[1, 0, 0]])], "x": [Shape([0], [[0, 1, 0]])]}, deformer="a"
    )
    rig = rig_of(scene(model))
    assert rig.names == ("x", "x_2")
    assert rig.morphs["x_2"].delta[0].tolist() == [0, 1, 0]


def test_files_without_shapes_say_what_to_switch_on(rig_of: Reader) -> None:
    with pytest.raises(
        FormatError, match=r"no mesh has blend shapes.*'face' \(no shapes\)\. Switch"
    ):
        rig_of(scene(quad(channels={})))
    with pytest.raises(FormatError, match="there are no meshes"):
        rig_of(scene())


def test_a_neutral_without_shapes_is_a_mesh(rig_of: Reader, tmp_path: Path) -> None:
    with pytest.raises(FormatError):
        rig_of(scene(quad(channels={})))
    mesh = em.read(tmp_path / "face.fbx")
    np.testing.assert_array_equal(mesh.vertices, np.array(quad().vertices))
    with_shapes = rig_of(scene(quad()))
    np.testing.assert_array_equal(mesh.vertices, with_shapes.neutral.vertices)
    with pytest.raises(FormatError, match="rig"):
        em.read(tmp_path / "face.fbx")


def test_missing_files_and_missing_ufbx(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(FileError, match="no such file"):
        read_fbx(tmp_path / "none.fbx")
    monkeypatch.setattr("elastomorph.io.fbx.reader.find_spec", lambda name: None)
    with pytest.raises(MissingExtraError, match=r"elastomorph\[fbx\]"):
        read_fbx(tmp_path / "none.fbx")


def test_any_name_of_a_file_is_fine(tmp_path: Path) -> None:
    path = tmp_path / "Gesicht – größer 顔.fbx"
    path.write_bytes(as_binary(scene(quad())))
    assert read_fbx(path).neutral.name == str(path)


def test_z_up_points_and_offsets_are_turned_alike(rig_of: Reader) -> None:
    rig = rig_of(scene(quad(), axes=Z_UP))
    assert rig.neutral.vertices.tolist() == [[0, 0.5, 0], [1, 0.5, 0], [1, 0.5, -2], [0, 0.5, -2]]
    assert rig.morphs["lift"].delta[2].tolist() == [0.25, -0.125, -0.5]


def test_channels_without_shapes_are_passed_over(rig_of: Reader) -> None:
    channels = {**quad().channels, "blendShape1.none": []}
    assert rig_of(scene(quad(channels=channels))).names == ("lift",)


def test_a_full_weight_of_0_or_below_means_nothing_but_its_shape_does(rig_of: Reader) -> None:
    for weight in (0.0, -100.0):
        shape = Shape([2], [[0.25, 0.5, -0.125]], weight, "lift")
        rig = rig_of(scene(quad(channels={"blendShape1.lift": [shape]})))
        assert rig.morphs["lift"].delta[2].tolist() == [0.25, 0.5, -0.125]


def test_a_choice_of_no_meshes_is_none(rig_of: Reader) -> None:
    with pytest.raises(ParameterError, match="name at least one mesh"):
        rig_of(scene(quad()), mesh=[])


PART = {
    "matrix": np.eye(4, 3),
    "vertices": np.eye(3),
    "face_indices": np.arange(3),
    "face_offsets": np.array([0, 3]),
    "uv_coordinates": np.zeros((2, 2)),
    "uv_corners": np.array([0, 1, 1]),
    "material_names": np.array(["skin"]),
    "material_of_face": np.array([0]),
    "channel_names": np.array(["lift"]),
    "key_counts": np.array([1]),
    "key_weights": np.array([1.0]),
    "key_sizes": np.array([1]),
    "key_vertices": np.array([2]),
    "key_offsets": np.ones((1, 3)),
}


def part_with(folder: Path, **changes: Any) -> FbxMesh:
    """What is made of arrays as the worker writes them, some of them changed."""
    arrays = {f"0_{name}": array for name, array in {**PART, **changes}.items()}
    names = {"mesh_names": np.array(["face"]), "mesh_shown": np.array([1])}
    np.savez(folder / "content.npz", **names, **arrays)
    with open_npz(folder / "content.npz") as members:
        (part,) = read_meshes("face.fbx", members)
    return part


@pytest.mark.parametrize(
    ("changes", "lost"),
    [
        ({"uv_corners": np.array([0, 1, 2])}, "uv"),
        ({"uv_corners": np.array([0, -1, 1])}, "uv"),
        ({"uv_coordinates": np.full((2, 2), np.nan)}, "uv"),
        ({"material_of_face": np.array([1])}, "materials"),
        ({"material_of_face": np.array([-2])}, "materials"),
    ],
)
def test_a_face_is_not_lost_for_its_texture_or_materials(
    tmp_path: Path, changes: dict[str, Any], lost: str
) -> None:
    whole, part = part_with(tmp_path), part_with(tmp_path, **changes)
    for name in ("uv", "materials"):
        assert getattr(whole, name) is not None
        assert (getattr(part, name) is None) == (name == lost)
    assert len(part.vertices) == 3


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"face_indices": np.array([0, 1, 3])}, "polygons of points that do not exist"),
        ({"key_vertices": np.array([-1])}, "shapes of points that do not exist"),
        ({"matrix": np.full((4, 3), np.inf)}, "its transform is not finite"),
        ({"key_sizes": np.array([2])}, r"has the shape \(1,\)"),
    ],
)
def test_a_mesh_that_contradicts_itself_is_refused(
    tmp_path: Path, changes: dict[str, Any], words: str
) -> None:
    with pytest.raises(FormatError, match=words):
        part_with(tmp_path, **changes)


def test_a_shape_at_next_to_nothing_of_the_full_weight_is_on_no_path(rig_of: Reader) -> None:
    """The ratio of two weights may be 0 where neither is."""
    shapes = [Shape([1], [[0, 0, 1]], 1e-320, "a"), Shape([2], [[0, 0, 2]], 1e300, "b")]
    with pytest.warns(ElastomorphWarning, match="has 2 shapes, of which 1 are kept"):
        rig = rig_of(scene(quad(channels={"blendShape1.lift": shapes})))
    (morph,) = rig.morphs.values()
    assert morph.delta[2].tolist() == [0, 0, 2]
    assert len(morph.bends) == 0
