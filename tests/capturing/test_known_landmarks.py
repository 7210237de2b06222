"""Templates that come with landmarks need no clicks."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.capturing.landmarks import LANDMARKS, known_landmarks
from elastomorph.samples import head

PAIRS = [(name, name.replace("right", "left")) for name in LANDMARKS if "right" in name]


def require_a_face(places: dict[str, np.ndarray]) -> None:
    """Where points of a face are to each other: y up, the subject's left at positive x."""
    assert set(places) == set(LANDMARKS)
    for right, left in PAIRS:
        assert places[right][0] < 0 < places[left][0]
        np.testing.assert_allclose(places[right] * [-1, 1, 1], places[left], atol=0.02)
    for row in (
        ("nose_bridge", "nose_tip", "upper_lip", "mouth_left", "lower_lip", "chin"),
        ("left_eye_outer", "left_nostril", "mouth_left"),
    ):
        heights = [places[name][1] for name in row]
        assert heights == sorted(heights, reverse=True)
    assert max(places, key=lambda name: places[name][2]) == "nose_tip"
    assert places["left_eye_inner"][0] < places["left_eye_outer"][0] < places["left_jaw"][0]


def test_our_own_head() -> None:
    mesh = head()
    found = known_landmarks("built-in", mesh)
    require_a_face({name: mesh.vertices[vertex] for name, vertex in found.items()})
    taller = mesh.with_vertices(mesh.vertices * [1, 1.2, 1])
    assert known_landmarks("taller.obj", taller) == found


def test_a_mesh_without_a_list_has_none(tmp_path: Path) -> None:
    assert known_landmarks(tmp_path / "face.obj", em.Mesh(np.eye(3), [[0, 1, 2]])) == {}


@pytest.mark.realdata
def test_a_list_of_68_points(data_dir: Path) -> None:
    file = data_dir / "ict-facekit" / "generic_neutral_mesh.obj"
    mesh = em.read(file)
    found = known_landmarks(file, mesh)
    require_a_face({name: mesh.vertices[vertex] for name, vertex in found.items()})
    assert known_landmarks(data_dir / "ict-facekit", mesh) == found, "the folder, as a rig"


@pytest.mark.parametrize("content", ["no json", "[]", '{"idx_to_landmark_verts": [1, 2]}', "{}"])
def test_other_lists_are_not_meant(tmp_path: Path, content: str) -> None:
    (tmp_path / "vertex_indices.json").write_text(content)
    assert known_landmarks(tmp_path / "face.obj", em.Mesh(np.eye(3), [[0, 1, 2]])) == {}


@pytest.mark.parametrize("bad", [3, -1, 1.5, "1", True])
def test_a_list_of_another_mesh_is_named(tmp_path: Path, bad: object) -> None:
    vertices = [0] * 67 + [bad]
    (tmp_path / "vertex_indices.json").write_text(json.dumps({"idx_to_landmark_verts": vertices}))
    with pytest.raises(em.FormatError, match=r"vertex_indices\.json"):
        known_landmarks(tmp_path / "face.obj", em.Mesh(np.eye(3), [[0, 1, 2]]))


def test_denser_points_lie_where_people_click() -> None:
    """Those of MediaPipe's model, and the 68 among them, at the corners of eyes and mouth."""
    mesh = head()
    clicks = known_landmarks("built-in", mesh)
    few, dense = (known_landmarks("built-in", mesh, points) for points in ("68", "mediapipe"))
    assert list(few) == [str(number) for number in range(68)]
    assert len(dense) == 478
    assert known_landmarks("built-in", mesh, "clicks") == clicks
    for name, number, of_478 in (
        ("right_eye_outer", 36, 33),
        ("left_eye_outer", 45, 263),
        ("mouth_right", 48, 61),
        ("mouth_left", 54, 291),
        ("chin", 8, 152),
        ("nose_tip", 30, 4),
    ):
        assert few[str(number)] == clicks[name]
        apart = mesh.vertices[few[str(number)]] - mesh.vertices[dense[str(of_478)]]
        assert np.linalg.norm(apart) < 0.01 * mesh.diameter, name


@pytest.mark.realdata
def test_denser_points_of_a_scanned_head_agree_with_its_own_list(data_dir: Path) -> None:
    """ICT FaceKit lists 68 of its own: without the jaw, whose points slide, within 3 % of D."""
    file = data_dir / "ict-facekit" / "generic_neutral_mesh.obj"
    mesh = em.read(file)
    own = known_landmarks(file, mesh, "68")
    dense = known_landmarks(file, mesh, "mediapipe")
    for number, of_478 in (
        (36, 33),
        (39, 133),
        (42, 362),
        (45, 263),
        (48, 61),
        (54, 291),
        (27, 168),
    ):
        apart = mesh.vertices[own[str(number)]] - mesh.vertices[dense[str(of_478)]]
        assert np.linalg.norm(apart) < 0.01 * mesh.diameter, number
    with pytest.raises(em.ParameterError):
        known_landmarks(file, mesh, "70")
