"""The turn of a head in GLB: a node that turns, and bones of others."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from glb_samples import CORNERS, MOVED, SQUARE, HandMade, triangle_rig
from scipy.spatial.transform import Rotation
from viewer_checks import validated

import elastomorph as em
from elastomorph.errors import FormatError, ParameterError
from elastomorph.io.gltf import write_glb
from elastomorph.rig.performance import HeadTurn, head_rotations
from foreign_files import chunks_of

ANGLES = np.array([[0, 0, 0], [0.9, 0.2, -0.1], [1.4, -0.7, 0.3], [-0.4, 0.5, 0.3]])
TIMES = np.arange(4) / 4
WEIGHTS = np.array([[0.0], [0.25], [0.5], [1.0]])
NECK = np.array([0.3, -0.2, 0.7])


def turned(path: Path, **options: Any) -> Path:
    animation = (TIMES, WEIGHTS, "talk")
    write_glb(path, triangle_rig(), animation=animation, turn=HeadTurn(NECK, ANGLES), **options)
    return path


@pytest.mark.parametrize("compress", [False, True])
def test_a_take_comes_back(tmp_path: Path, compress: bool) -> None:
    """So does the rig, as from a file in which nothing turns."""
    path = turned(tmp_path / "a.glb", compress=compress)
    take = em.read_performance(path)
    assert take.names == ("lift", "HeadYaw", "HeadPitch", "HeadRoll")
    np.testing.assert_allclose(take.head, ANGLES, atol=1e-6)
    np.testing.assert_allclose(take.weights[:, :1], WEIGHTS, atol=1e-6)
    write_glb(tmp_path / "still.glb", triangle_rig(), compress=compress)
    one, other = em.read_rig(path), em.read_rig(tmp_path / "still.glb")
    np.testing.assert_allclose(one.neutral.vertices, other.neutral.vertices, atol=1e-12)
    assert "HeadYaw" not in em.read_performance(still(tmp_path / "b.glb")).names


def test_a_face_at_rest_turns_too(tmp_path: Path) -> None:
    path = tmp_path / "a.glb"
    turn = HeadTurn(NECK, ANGLES)
    write_glb(path, triangle_rig(), animation=(TIMES, 0 * WEIGHTS, "nod"), turn=turn)
    np.testing.assert_allclose(em.read_performance(path).head, ANGLES, atol=1e-6)


def test_a_head_that_goes_on_turning_does_not_jump_back(tmp_path: Path) -> None:
    """Past half a turn, and past straight down, to where another name of its place is nearer."""
    angles = np.linspace([2.9, 1.2, -0.2], [3.6, 1.9, 0.4], 4)
    write_glb(
        tmp_path / "a.glb",
        triangle_rig(),
        animation=(TIMES, WEIGHTS, "talk"),
        turn=HeadTurn(NECK, angles),
    )
    head = em.read_performance(tmp_path / "a.glb").head
    np.testing.assert_allclose(head, angles, atol=1e-5)


def still(path: Path) -> Path:
    write_glb(path, triangle_rig(), animation=(TIMES, WEIGHTS, "talk"))
    return path


def test_nodes_place_vertices_as_the_turn_does(tmp_path: Path) -> None:
    """The head node is in the neck, the face below it is moved back, and only the head turns."""
    path = turned(tmp_path / "a.glb")
    document = chunks_of(path)[0]
    assert document["scenes"][0]["nodes"] == [1]
    face, head = document["nodes"]
    assert head["name"] == "head"
    assert head["children"] == [0]
    (clip,) = document["animations"]
    targets = [(c["target"]["node"], c["target"]["path"]) for c in clip["channels"]]
    assert targets == [(0, "weights"), (1, "rotation")]
    (at,) = [s["output"] for s in clip["samplers"][1:]]
    accessor = document["accessors"][at]
    view = document["bufferViews"][accessor["bufferView"]]
    start = view["byteOffset"] + accessor["byteOffset"]
    keys = np.frombuffer(chunks_of(path)[1], "<f4", 16, start).reshape(4, 4)
    points = triangle_rig().neutral.vertices
    for quaternion, angles in zip(keys, ANGLES, strict=True):
        below = points + face["translation"]
        placed = Rotation.from_quat(quaternion).apply(below) + head["translation"]
        expected = (points - NECK) @ head_rotations([angles])[0].T + NECK
        np.testing.assert_allclose(placed, expected, atol=1e-6)


def test_other_programs_find_no_fault(node: str, tmp_path: Path) -> None:
    validated(node, turned(tmp_path / "a.glb"))


def character(name: str, **extensions: Any) -> HandMade:
    """A face beside a bone that rests turned, below another that is turned and larger."""
    file = HandMade()
    file.primitive(
        attributes={"POSITION": file.array(SQUARE)},
        indices=file.array(CORNERS, "<u2"),
        targets=[{"POSITION": file.array(MOVED)}],
    )
    spine, rest = bones()
    file.document["nodes"] += [
        {
            "name": "spine",
            "rotation": spine.as_quat().tolist(),
            "scale": [2, 2, 2],
            "children": [2],
        },
        {"name": name, "rotation": rest.as_quat().tolist()},
    ]
    file.document["scenes"] = [{"nodes": [0, 1]}]
    file.document["meshes"][0]["extras"] = {"targetNames": ["jawOpen"]}
    if extensions:
        file.document["extensions"] = extensions
    # Seen in the scene the head is turned by R, so that its bone is by S⁻¹ R S rest.
    turns = [spine.inv() * Rotation.from_matrix(r) * spine * rest for r in head_rotations(ANGLES)]
    seconds = file.array(TIMES)
    file.document["animations"] = [
        {
            "samplers": [
                {"input": seconds, "output": file.array(WEIGHTS.ravel())},
                {"input": seconds, "output": file.array([turn.as_quat() for turn in turns])},
            ],
            "channels": [
                {"sampler": 0, "target": {"node": 0, "path": "weights"}},
                {"sampler": 1, "target": {"node": 2, "path": "rotation"}},
            ],
        }
    ]
    return file


def bones() -> tuple[Rotation, Rotation]:
    return Rotation.from_rotvec([0.4, -1.1, 0.3]), Rotation.from_rotvec([1.2, 0.2, -0.5])


VRM_1 = {"VRMC_vrm": {"humanoid": {"humanBones": {"head": {"node": 2}}}}}


@pytest.mark.parametrize(
    ("name", "extensions"), [("Head", {}), ("mixamorig:Head", {}), ("J_Bip_C_Head", VRM_1)]
)
def test_bones_of_others_turn_the_head(
    tmp_path: Path, name: str, extensions: dict[str, Any]
) -> None:
    path = character(name, **extensions).write(tmp_path / "a.glb")
    np.testing.assert_allclose(em.read_performance(path).head, ANGLES, atol=1e-6)


def test_a_character_of_vrm_0_looks_backwards(tmp_path: Path) -> None:
    """It is turned around when read, and its yaw, pitch and roll are counted so."""
    bone = {"VRM": {"humanoid": {"humanBones": [{"bone": "head", "node": 2}]}}}
    path = character("J_Bip_C_Head", **bone).write(tmp_path / "a.glb")
    np.testing.assert_allclose(em.read_performance(path).head, ANGLES * [1, -1, -1], atol=1e-6)


@pytest.mark.parametrize("name", ["forehead", "HeadTop_End", "spine.001"])
def test_other_bones_do_not(tmp_path: Path, name: str) -> None:
    path = character(name).write(tmp_path / "a.glb")
    assert em.read_performance(path).names == ("jawOpen",)


def test_between_keys_it_turns_along_the_arc(tmp_path: Path) -> None:
    """A head with keys of its own, far apart: weights are asked for between them."""
    file = character("head")
    half = np.pi / 4
    for number in (1, 2):
        file.document["nodes"][number].pop("rotation")
    file.document["animations"][0]["samplers"][1] = {
        "input": file.array([0.0, 0.75]),
        "output": file.array([[0, 0, 0, 1], [0, np.sin(half), 0, np.cos(half)]]),
    }
    head = em.read_performance(file.write(tmp_path / "a.glb")).head
    np.testing.assert_allclose(head[:, 0], np.linspace(0, -np.pi / 2, 4), atol=1e-6)


def test_rotations_that_are_none_are_refused(tmp_path: Path) -> None:
    file = character("head")
    sampler = file.document["animations"][0]["samplers"][1]
    sampler["output"] = file.array(np.zeros((4, 4)))
    with pytest.raises(FormatError, match="rotations of animation 0 are no quaternions"):
        em.read_performance(file.write(tmp_path / "a.glb"))


def test_splines_through_no_rotation_are_refused(tmp_path: Path) -> None:
    """From a quaternion to its negative, halfway through zero."""
    file = character("head")
    ends = np.outer([0, 1, 0, 0, -1, 0], [0, 0, 0, 1])
    keys = {"input": file.array([0.0, 0.75]), "output": file.array(ends)}
    file.document["animations"][0]["samplers"][1] = keys | {"interpolation": "CUBICSPLINE"}
    with pytest.raises(FormatError, match="rotations of animation 0 are no quaternions"):
        em.read_performance(file.write(tmp_path / "a.glb"))


def test_a_mesh_in_a_skin_is_no_bone(tmp_path: Path) -> None:
    """Exporters key every node: that of "Wolf3D_Head" before the bone, and it turns nothing."""
    file = character("Head")
    file.document["nodes"][0] |= {"name": "Wolf3D_Head", "skin": 0}
    file.document["skins"] = [{"joints": [2]}]
    still = {"input": file.array([0.0]), "output": file.array([[0.0, 0, 0, 1]])}
    own = file.document["animations"][0]
    own["samplers"].append(still)
    own["channels"].insert(0, {"sampler": 2, "target": {"node": 0, "path": "rotation"}})
    head = em.read_performance(file.write(tmp_path / "a.glb")).head
    np.testing.assert_allclose(head, ANGLES, atol=1e-6)


def test_a_turn_needs_one_animation_of_its_length(tmp_path: Path) -> None:
    turn, rig = HeadTurn(NECK, ANGLES), triangle_rig()
    several = [(TIMES, WEIGHTS, "a"), (TIMES, WEIGHTS, "b")]
    for animation in (None, (TIMES[:2], WEIGHTS[:2], "talk"), several):
        with pytest.raises(ParameterError, match="a head is turned with an animation"):
            write_glb(tmp_path / "a.glb", rig, animation=animation, turn=turn)
    assert not list(tmp_path.iterdir())
