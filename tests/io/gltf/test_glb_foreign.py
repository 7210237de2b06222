"""Files as other programs write them: quantised, sparse, interleaved, in pieces, in folders."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from glb_samples import CORNERS, MOVED, SQUARE, HandMade, square

from elastomorph.errors import FormatError, ParameterError
from elastomorph.io.gltf import read_glb


def test_triangles_and_a_straight_path_for_each_target(tmp_path: Path) -> None:
    file = square()
    file.document["meshes"][0]["extras"] = {"targetNames": ["smile"]}
    rig = read_glb(file.write(tmp_path / "a.glb"))
    np.testing.assert_array_equal(rig.neutral.vertices, SQUARE)
    assert rig.neutral.faces.indices.tolist() == CORNERS
    assert rig.neutral.materials is rig.neutral.groups is rig.neutral.uv is None
    assert rig.names == ("smile",)
    np.testing.assert_array_equal(rig.pose({"smile": 0.5}), SQUARE + MOVED / 2)


@pytest.mark.parametrize(
    ("extras", "names"),
    [
        (None, ("target_0", "target_1")),
        ([], ("target_0", "target_1")),
        ({"targetNames": "ab"}, ("target_0", "target_1")),
        ({"targetNames": ["a", 3]}, ("a", "target_1")),
        ({"targetNames": [None, "a"]}, ("target_0", "a")),
        ({"targetNames": [None, None]}, ("target_0", "target_1")),
        ({"targetNames": ["a"]}, ("a", "target_1")),
        ({"targetNames": ["a", "a"]}, ("a", "a_2")),
        ({"targetNames": ["a_2", "a_2"]}, ("a_2", "a_2_2")),
        ({"targetNames": ["a", "b", "c"]}, ("a", "b")),
    ],
)
def test_targets_are_named_or_numbered(tmp_path: Path, extras: Any, names: Any) -> None:
    file = square()
    file.document["meshes"][0]["primitives"][0]["targets"].append({})
    if extras is not None:
        file.document["meshes"][0]["extras"] = extras
    rig = read_glb(file.write(tmp_path / "a.glb"))
    assert rig.names == names
    assert not rig.morphs[names[1]].delta.any()  # a target that moves nothing


@pytest.mark.parametrize("holder", ["primitive", "target"])
def test_targets_may_be_named_in_their_primitive_or_by_themselves(
    tmp_path: Path, holder: str
) -> None:
    """As older exporters of VRM and Maya do."""
    file = square()
    primitive = file.document["meshes"][0]["primitives"][0]
    primitive["targets"].append({})
    if holder == "primitive":
        primitive["extras"] = {"targetNames": ["A", "blink"]}
    else:
        for target, name in zip(primitive["targets"], ("A", "blink"), strict=True):
            target["extras"] = {"name": name}
    rig = read_glb(file.write(tmp_path / "a.glb"))
    assert rig.names == ("A", "blink")
    np.testing.assert_array_equal(rig.morphs["A"].delta, MOVED)


def test_accessors_without_bytes_are_zeros(tmp_path: Path) -> None:
    """Of positions too, with sparse values that lift one vertex; of indices, and of targets."""
    file = HandMade()
    sparse = {
        "count": 1,
        "indices": {"bufferView": file.view(b"\x02"), "componentType": 5121},
        "values": {"bufferView": file.view(np.array([1, 2, 3], dtype="<f4").tobytes())},
    }
    common = {"componentType": 5126, "count": 3, "type": "VEC3"}
    file.primitive(
        attributes={"POSITION": file.accessor(**common, sparse=sparse)},
        indices=file.array([0, 1, 2], "u1"),
        targets=[{"POSITION": file.accessor(**common)}],
    )
    file.primitive(
        attributes={"POSITION": file.array(SQUARE)},
        indices=file.accessor(componentType=5123, count=3, type="SCALAR"),
    )
    rig = read_glb(file.write(tmp_path / "a.glb"))
    assert rig.neutral.vertices[:3].tolist() == [[0, 0, 0], [0, 0, 0], [1, 2, 3]]
    assert rig.neutral.faces.indices.tolist() == [0, 1, 2, 3, 3, 3]
    assert not rig.morphs["target_0"].delta.any()


@pytest.mark.parametrize(
    ("required", "way"), [(["VRM"], [-1, 1, -1]), (["VRMC_vrm", "VRMC_springBone"], [1, 1, 1])]
)
def test_vrm_files_are_glb_files(tmp_path: Path, required: list[str], way: list[int]) -> None:
    """Avatars: their own extensions say nothing about the surface, but which way VRM 0.x looks."""
    file = square()
    file.document["extensionsUsed"] = [*required, "UNKNOWN_thing"]
    file.document["extensionsRequired"] = required
    file.document["extensions"] = {name: {"meta": {"title": "a"}} for name in required}
    rig = read_glb(file.write(tmp_path / "a.vrm"))
    np.testing.assert_array_equal(rig.morphs["target_0"].delta, MOVED * np.array(way))


def head_and_hair() -> HandMade:
    """A square with a target, and another without beside it."""
    file = square()
    file.document["meshes"][0]["name"] = "headMesh"
    file.document["meshes"].append({"primitives": [], "name": "hair"})
    file.primitive(
        1, attributes={"POSITION": file.array(SQUARE + 9)}, indices=file.array(CORNERS, "u1")
    )
    file.document["nodes"] = [{"mesh": 0, "name": "head"}, {"mesh": 1, "translation": [1, 0, 0]}]
    file.document["scenes"] = [{"nodes": [0, 1]}]
    return file


def test_a_mesh_without_targets_is_part_of_the_neutral(tmp_path: Path) -> None:
    rig = read_glb(head_and_hair().write(tmp_path / "a.glb"))
    np.testing.assert_array_equal(
        rig.neutral.vertices, np.concatenate([SQUARE, SQUARE + [10, 9, 9]])
    )
    assert not rig.morphs["target_0"].delta[4:].any()
    assert rig.neutral.groups is not None
    assert rig.neutral.groups.names == ("head", "hair")


def test_meshes_are_chosen_by_the_name_of_their_node_or_their_own(tmp_path: Path) -> None:
    path = head_and_hair().write(tmp_path / "a.glb")
    for name in ("head", "headMesh", ["head", "headMesh"]):
        rig = read_glb(path, mesh=name)
        np.testing.assert_array_equal(rig.neutral.vertices, SQUARE)
        assert rig.names == ("target_0",)
        assert rig.neutral.groups is None
    hair = read_glb(path, mesh="hair")
    np.testing.assert_array_equal(hair.neutral.vertices, SQUARE + [10, 9, 9])
    assert hair.names == ()
    words = r"a\.glb: no mesh is called 'nose'; there are 'head' \(1 shapes\), 'hair' \(no shapes\)"
    with pytest.raises(FormatError, match=words):
        read_glb(path, mesh="nose")
    with pytest.raises(ParameterError, match="name at least one mesh"):
        read_glb(path, mesh=[])


@pytest.mark.parametrize(
    ("kind", "largest"), [("i1", 127), ("u1", 255), ("<i2", 32767), ("<u2", 65535)]
)
def test_quantised_positions(tmp_path: Path, kind: str, largest: int) -> None:
    """Normalised: n / largest; signed ones have two ways to say -1. Otherwise as they are."""
    signed = "i" in kind
    least = -largest - 1 if signed else 0
    whole = np.array([[0, largest, 1], [least, 0, 2], [least + 1, 3, 0]])
    for normalized in (True, False):
        file = HandMade()
        file.document["extensionsRequired"] = ["KHR_mesh_quantization"]
        position = file.array(np.pad(whole, ((0, 0), (0, 1))), kind, normalized=normalized)
        file.document["accessors"][position]["type"] = "VEC3"
        size = np.dtype(kind).itemsize
        file.document["bufferViews"][0]["byteStride"] = 4 * size
        file.primitive(attributes={"POSITION": position}, indices=file.array([0, 1, 2], "u1"))
        found = read_glb(file.write(tmp_path / "a.glb")).neutral.vertices
        expected = np.maximum(whole / largest, -1) if normalized else whole
        np.testing.assert_allclose(found, expected, rtol=1e-15)


def test_a_step_of_nothing_is_no_gap(tmp_path: Path) -> None:
    file = square()
    for view in file.document["bufferViews"]:
        view["byteStride"] = 0
    rig = read_glb(file.write(tmp_path / "a.glb"))
    np.testing.assert_array_equal(rig.neutral.vertices, SQUARE)
    np.testing.assert_array_equal(rig.morphs["target_0"].delta, MOVED)


def test_sparse_targets_with_and_without_a_base(tmp_path: Path) -> None:
    for based in (True, False):
        file = HandMade()
        values = np.array([[0, 0, 7], [0, 5, 0]], dtype="<f4")
        sparse = {
            "count": 2,
            "indices": {"bufferView": file.view(b"\x01\x03"), "componentType": 5121},
            "values": {"bufferView": file.view(b"pad!" + values.tobytes()), "byteOffset": 4},
        }
        fields: dict[str, Any] = {"componentType": 5126, "count": 4, "type": "VEC3"}
        if based:
            fields["bufferView"] = file.view(MOVED.astype("<f4").tobytes())
        target = file.accessor(**fields, sparse=sparse)
        file.primitive(
            attributes={"POSITION": file.array(SQUARE)},
            indices=file.array(CORNERS, "<u4"),
            targets=[{"POSITION": target}],
        )
        expected = MOVED.copy() if based else np.zeros((4, 3))
        expected[[1, 3]] = values
        rig = read_glb(file.write(tmp_path / "a.glb"))
        np.testing.assert_array_equal(rig.morphs["target_0"].delta, expected)


def test_interleaved_positions_and_texture_coordinates(tmp_path: Path) -> None:
    texture = np.array([[0, 1], [1, 1], [1, 0], [0.5, 0.25]])
    rows = np.concatenate([SQUARE, texture], axis=1).astype("<f4")
    file = HandMade()
    view = file.view(rows.tobytes(), byteStride=20)
    common = {"bufferView": view, "componentType": 5126, "count": 4}
    file.primitive(
        attributes={
            "POSITION": file.accessor(**common, type="VEC3"),
            "TEXCOORD_0": file.accessor(**common, type="VEC2", byteOffset=12),
        },
        indices=file.array(CORNERS, "<u2"),
    )
    mesh = read_glb(file.write(tmp_path / "a.glb")).neutral
    np.testing.assert_array_equal(mesh.vertices, SQUARE)
    assert mesh.uv is not None
    np.testing.assert_array_equal(mesh.uv.coordinates, texture * [1, -1] + [0, 1])
    assert mesh.uv.corners.tolist() == CORNERS


def test_primitives_become_one_mesh_with_their_materials(tmp_path: Path) -> None:
    """Those on the same accessors share their vertices; others follow."""
    file = square()
    first = file.document["meshes"][0]["primitives"][0]
    first["material"] = 1
    file.primitive(**{**first, "indices": file.array([0, 1, 3], "<u2"), "material": 0})
    file.primitive(
        attributes={"POSITION": file.array(SQUARE + 5)},
        indices=file.array([3, 2, 1], "u1"),
        targets=[{"POSITION": file.array(2 * MOVED)}],
    )
    file.document["materials"] = [{"name": "teeth"}, {}]
    rig = read_glb(file.write(tmp_path / "a.glb"))
    mesh = rig.neutral
    np.testing.assert_array_equal(mesh.vertices, np.concatenate([SQUARE, SQUARE + 5]))
    assert mesh.faces.indices.tolist() == [*CORNERS, 0, 1, 3, 7, 6, 5]
    assert mesh.materials is not None
    assert mesh.materials.names == ("material 1", "teeth")
    assert mesh.materials.of_face.tolist() == [0, 0, 1, -1]
    np.testing.assert_array_equal(rig.morphs["target_0"].delta, np.concatenate([MOVED, 2 * MOVED]))


def test_meshes_are_placed_by_their_nodes_and_share_targets_by_name(tmp_path: Path) -> None:
    """A quarter turn about z, twice the size, under a moved parent; a mirror turns triangles."""
    file = square()
    half = np.sqrt(0.5)
    file.document["meshes"][0]["extras"] = {"targetNames": ["smile"]}
    file.document["meshes"].append({"primitives": [], "extras": {"targetNames": ["blink"]}})
    shared = file.document["meshes"][0]["primitives"][0]
    file.primitive(1, **shared)
    mirror = [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
    file.document["nodes"] = [
        {"translation": [10, 0, 0], "children": [1, 2]},
        {"mesh": 0, "rotation": [0, 0, half, half], "scale": [2, 2, 2], "name": "face"},
        {"mesh": 1, "matrix": mirror, "name": "eye"},
    ]
    rig = read_glb(file.write(tmp_path / "a.glb"))
    turn = np.array([[0, -2, 0], [2, 0, 0], [0, 0, 2]])
    np.testing.assert_allclose(rig.neutral.vertices[:4], SQUARE @ turn.T + [10, 0, 0], atol=1e-12)
    np.testing.assert_allclose(rig.neutral.vertices[4:], SQUARE * [-1, 1, 1] + [10, 0, 0])
    assert rig.neutral.faces.indices[6:].tolist() == [4, 6, 5, 4, 7, 6]
    assert rig.names == ("smile", "blink")
    np.testing.assert_allclose(rig.morphs["smile"].delta[:4], MOVED @ turn.T, atol=1e-12)
    assert not rig.morphs["smile"].delta[4:].any()
    np.testing.assert_allclose(rig.morphs["blink"].delta[4:], MOVED)
    assert rig.neutral.groups is not None
    assert rig.neutral.groups.names == ("face", "eye")


def test_a_skinned_mesh_without_binding_follows_its_joints_not_its_node(tmp_path: Path) -> None:
    """Inverse bind matrices that are left out are identities, as glTF has it."""
    file = square()
    file.document["nodes"] = [{"mesh": 0, "skin": 0, "translation": [5, 5, 5]}, {}]
    file.document["skins"] = [{"joints": [1]}]
    rig = read_glb(file.write(tmp_path / "a.glb"))
    np.testing.assert_array_equal(rig.neutral.vertices, SQUARE)
    file.document["nodes"][1]["translation"] = [0, 7, 0]
    rig = read_glb(file.write(tmp_path / "a.glb"))
    np.testing.assert_array_equal(rig.neutral.vertices, SQUARE + [0, 7, 0])


def skinned(held: Any, posed: Any = None) -> HandMade:
    """A square of two joints that hold it by a matrix, or one of them by another, and a plain one.

    Both meshes and the joints are below a node of a tenth of the size, as after a conversion.
    """
    file = square()
    file.document["meshes"].append(
        {"primitives": [dict(file.document["meshes"][0]["primitives"][0])]}
    )
    worlds = [np.eye(4), np.eye(4)]
    worlds[0][:3, 3], worlds[1][:3, 3] = [0, 10, 0], [3, 12, 1]
    for world in worlds:
        world[:3] *= 0.1
    inverse = [np.linalg.inv(world) @ held for world in worlds]
    if posed is not None:
        inverse[1] = np.linalg.inv(worlds[1]) @ posed
    matrices = np.stack(inverse).transpose(0, 2, 1).reshape(-1, 16)
    number = file.array(matrices)
    file.document["accessors"][number]["type"] = "MAT4"
    file.document["skins"] = [{"joints": [3, 4], "inverseBindMatrices": number}]
    file.document["nodes"] = [
        {"scale": [0.1, 0.1, 0.1], "children": [1, 2, 3]},
        {"mesh": 0, "skin": 0, "name": "face"},
        {"mesh": 1, "name": "eye"},
        {"translation": [0, 10, 0], "children": [4]},
        {"translation": [3, 2, 1]},
    ]
    return file


def test_a_skinned_mesh_stands_where_its_joints_hold_it(tmp_path: Path) -> None:
    """Beside those without a skin, as viewers show it; offsets are turned and scaled with it."""
    held = np.array([[0, -0.1, 0, 1], [0.1, 0, 0, 0], [0, 0, 0.1, -2], [0, 0, 0, 1]])
    rig = read_glb(skinned(held).write(tmp_path / "a.glb"))
    moved = SQUARE @ held[:3, :3].T + held[:3, 3]
    np.testing.assert_allclose(rig.neutral.vertices[:4], moved, atol=1e-5)
    np.testing.assert_allclose(rig.neutral.vertices[4:], 0.1 * SQUARE, atol=1e-6)
    delta = rig.morphs["target_0"].delta
    np.testing.assert_allclose(delta[:4], MOVED @ held[:3, :3].T, atol=1e-6)
    np.testing.assert_allclose(delta[4:], 0.1 * MOVED, atol=1e-6)


@pytest.mark.parametrize("posed", [None, np.diag([1, 2, 1, 1.0])])
def test_a_skinned_mesh_held_as_it_is_or_posed_keeps_its_vertices(
    tmp_path: Path, posed: Any
) -> None:
    rig = read_glb(skinned(np.eye(4), posed).write(tmp_path / "a.glb"))
    np.testing.assert_array_equal(rig.neutral.vertices[:4], SQUARE)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda d: d["accessors"][-1].update(type="VEC3"), "inverse bind matrices of skin 0 has a"),
        (lambda d: d["skins"][0].update(joints=[3, 4, 2]), "are 2 for 3 joints"),
        (lambda d: d["nodes"][1].update(skin=5), "names number 5 of 1 skins"),
    ],
)
def test_a_skin_that_contradicts_itself_is_refused(tmp_path: Path, change: Any, words: str) -> None:
    file = skinned(np.eye(4))
    change(file.document)
    with pytest.raises(FormatError, match=words):
        read_glb(file.write(tmp_path / "a.glb"))


def test_without_a_scene_the_roots_or_else_all_meshes_are_read(tmp_path: Path) -> None:
    file = square()
    del file.document["scene"], file.document["scenes"]
    file.document["nodes"] = [{"mesh": 0}, {"children": [0], "translation": [1, 0, 0]}]
    rig = read_glb(file.write(tmp_path / "a.glb"))
    np.testing.assert_array_equal(rig.neutral.vertices, SQUARE + [1, 0, 0])
    del file.document["nodes"]
    rig = read_glb(file.write(tmp_path / "a.glb"))
    np.testing.assert_array_equal(rig.neutral.vertices, SQUARE)


@pytest.mark.parametrize(
    ("mode", "corners", "expected"),
    [
        (5, [0, 1, 3, 2], [[0, 1, 3], [3, 1, 2]]),
        (5, [0, 1, 2, 2, 0, 3], [[0, 1, 2], [0, 2, 3]]),
        (6, [0, 1, 2, 3], [[0, 1, 2], [0, 2, 3]]),
    ],
)
def test_strips_and_fans(tmp_path: Path, mode: int, corners: Any, expected: Any) -> None:
    file = HandMade()
    file.primitive(
        attributes={"POSITION": file.array(SQUARE)}, indices=file.array(corners, "u1"), mode=mode
    )
    faces = read_glb(file.write(tmp_path / "a.glb")).neutral.faces
    found = [np.roll(face, -int(np.argmin(face))).tolist() for face in faces]
    assert found == [np.roll(face, -int(np.argmin(face))).tolist() for face in expected]


def test_triangles_without_indices_take_the_vertices_in_turn(tmp_path: Path) -> None:
    file = HandMade()
    file.primitive(attributes={"POSITION": file.array(SQUARE[:3])})
    assert read_glb(file.write(tmp_path / "a.glb")).neutral.faces.indices.tolist() == [0, 1, 2]


def test_lines_beside_triangles_are_passed_over(tmp_path: Path) -> None:
    file = square()
    file.primitive(attributes={"POSITION": file.array(SQUARE)}, mode=1)
    assert len(read_glb(file.write(tmp_path / "a.glb")).neutral.vertices) == 4
