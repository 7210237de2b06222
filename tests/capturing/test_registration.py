"""Scans of the built-in head, of another topology, are registered to its vertices."""

from __future__ import annotations

import json

import numpy as np
import pytest

import elastomorph as em
from elastomorph.errors import CaptureError, ElastomorphWarning, ParameterError
from needs import extra

extra("embreex", "capture")
extra("cv2", "capture")

from small_scans import marked, moved, posed, rig, scanned  # noqa: E402

from elastomorph.capturing.geometry.surface import Surface  # noqa: E402
from elastomorph.capturing.landmarks.known_landmarks import known_landmarks  # noqa: E402
from elastomorph.capturing.scans.correspondence import ScanPoints  # noqa: E402
from elastomorph.capturing.scans.face import Face, read_face  # noqa: E402
from elastomorph.capturing.scans.nonrigid import Elastic, Held  # noqa: E402
from elastomorph.capturing.scans.recognition import require_alike  # noqa: E402
from elastomorph.capturing.scans.scans import read_scan  # noqa: E402
from elastomorph.capturing.scans.trust import trusted  # noqa: E402

pytestmark = pytest.mark.photographs

Z_UP = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
SMILE = {"jawOpen": 0.6, "mouthSmile_L": 0.7}


@pytest.fixture(scope="module")
def poses() -> dict[str, em.Mesh]:
    """A neutral and a smile, scanned in millimetres with z up, and without landmarks."""
    scans = {
        "neutral": moved(scanned(posed()), 10, Z_UP),
        "smile": moved(scanned(posed(**SMILE), seed=1), 10, Z_UP),
    }
    with pytest.warns(ElastomorphWarning, match="says nothing about correspondence"):
        return em.register_all(scans, rig())


def errors(pose: em.Mesh, truth: np.ndarray) -> np.ndarray:
    """(V,) distances in % of the extent."""
    return 100 * np.linalg.norm(pose.vertices - truth, axis=1) / pose.figures["extent"]


def test_units_and_axes_are_found_without_landmarks(poses) -> None:
    placing = poses["neutral"].figures["placing"]
    assert placing["scale"] == pytest.approx(0.1, rel=0.01)
    np.testing.assert_allclose(np.array(placing["rotation"]) @ Z_UP, np.eye(3), atol=0.01)


def test_the_template_becomes_the_scanned_neutral(poses) -> None:
    off = errors(poses["neutral"], posed())
    assert poses["neutral"].faces == rig().neutral.faces
    assert poses["neutral"].figures["surface_mean"] < 0.02
    seen = poses["neutral"].confidence > 0.5
    assert seen.mean() > 0.5
    assert off[seen].mean() < 0.5  # along the surface it is as smooth as can be, no more


def test_the_rig_knows_how_the_skin_moves(poses) -> None:
    """Of the expressions that were photographed the rig's own weights are found again."""
    smile = poses["smile"]
    found = smile.figures["expressions"]
    for name, weight in SMILE.items():
        assert found[name] == pytest.approx(weight, abs=0.12)
    still = poses["neutral"].confidence > 0.5
    moving = still & (np.linalg.norm(posed(**SMILE) - posed(), axis=1) > 0.1)
    truth = poses["neutral"].vertices + posed(**SMILE) - posed()
    assert errors(smile, truth)[moving].mean() < 0.5
    assert smile.figures["correspondence"] == "by the rig's expressions"


def cheek_of(face: Face) -> np.ndarray:
    """(3,) on the skin, aside of the mouth."""
    beside = face.vertices[known_landmarks("built-in", rig().neutral)["mouth_left"]] + [2.5, 1, 0]
    return face.vertices[np.linalg.norm(face.vertices - beside, axis=1).argmin()]


def test_what_a_hole_hides_is_not_trusted() -> None:
    """Within a hole confidence falls with the way to what is shown, elsewhere it stays."""
    face = read_face(rig())
    elastic = Elastic(face.vertices, face.triangles, face.size, face.skin)
    scan = read_scan(scanned(posed()))
    cheek = cheek_of(face)
    corners = scan.surface.vertices[scan.surface.triangles]
    torn = scan.only((np.linalg.norm(corners - cheek, axis=2) > 2).all(axis=1))
    still = np.zeros(len(face.vertices))
    whole, holed = (
        trusted(elastic, face.vertices, ScanPoints(own.surface, elastic.edge), still)
        for own in (scan, torn)
    )
    away = np.linalg.norm(face.vertices - cheek, axis=1)
    skin = face.skin & whole.shown
    assert np.count_nonzero(skin & (away < 0.6)) > 2
    assert (holed.confidence[skin & (away < 0.6)] < 0.5).all()
    assert (whole.confidence[skin & (away < 0.6)] > 0.9).all()
    far = skin & (away > 4.5)  # the hole ends up to a polygon beyond 2, and trust falls around it
    np.testing.assert_allclose(holed.confidence[far], whole.confidence[far], atol=1e-6)


def test_weights_end_where_an_expression_is_another_one() -> None:
    face = read_face(rig().only(["jawOpen"]))
    elastic = Elastic(face.vertices, face.triangles, face.size, face.skin)
    assert face.expressions is not None
    scan = ScanPoints(Surface(posed(jawOpen=2.0)[face.first], face.triangles), elastic.edge)
    nothing = Held(np.zeros(0, dtype=np.int64), np.zeros((0, 3)))
    for before in ({}, {"jawOpen": 1.0}):
        found = face.expressions.fitted(face.vertices, elastic, scan, nothing, before)
        assert 1.3 < found["jawOpen"] <= 1.5


def test_what_was_not_followed_lies_as_the_rest_lets_it() -> None:
    """Wherever it was begun: what a hidden place was drawn onto is no part of the answer."""
    face = read_face(rig())
    elastic = Elastic(face.vertices, face.triangles, face.size, face.skin)
    goal = posed(jawOpen=0.2)[face.first]
    cheek = cheek_of(face)
    hidden = np.linalg.norm(face.vertices - cheek, axis=1) < 1.5
    known = np.where(hidden | ~face.skin, 0.0, 1.0)
    found = elastic.completed(goal + np.where(hidden, 1.0, 0.0)[:, None] * [1.0, 0, 0], known)
    off = 100 * np.linalg.norm(found - goal, axis=1) / face.size
    assert off[hidden].mean() < 0.3  # it was begun 3.3 off
    assert off[face.skin & ~hidden].mean() < 0.1


def test_landmarks_left_and_right_exchanged_are_told() -> None:
    marks = marked(posed())
    own = dict(marks.points["mesh"])
    swapped = {
        name.replace("left", "*").replace("right", "left").replace("*", "right"): place
        for name, place in own.items()
    }
    from elastomorph.capturing.landmarks.landmarks import Landmarks

    with pytest.raises(CaptureError, match="mirrored"):
        em.register(
            scanned(posed(), rows=60),
            rig(),
            landmarks=Landmarks(marks.vertices, points={"mesh": swapped}),
        )


def test_what_is_no_face_asks_for_landmarks() -> None:
    grid = np.stack(np.meshgrid(np.arange(40.0), np.arange(40.0)), axis=-1).reshape(-1, 2)
    number = np.arange(1600).reshape(40, 40)
    quads = np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], axis=-1)
    plane = em.Mesh(np.pad(grid, ((0, 0), (0, 1))), quads.reshape(-1, 4))
    with pytest.raises(CaptureError, match="landmarks"):
        em.register(plane, rig())


def test_a_ball_with_the_landmarks_of_a_face_is_no_face() -> None:
    """A template can be drawn onto anything, and lies on it closely."""
    face = read_face(rig().neutral)
    elastic = Elastic(face.vertices, face.triangles, face.size, face.skin)
    require_alike(elastic, 2 * face.vertices @ Z_UP.T, "a head")
    away = face.vertices - face.vertices.mean(axis=0)
    ball = 10 * away / np.linalg.norm(away, axis=1, keepdims=True)
    with pytest.raises(CaptureError, match=r"a ball is not shaped like the template.*landmarks"):
        require_alike(elastic, ball, "a ball")


def test_two_heads_in_one_file_are_told() -> None:
    one = scanned(posed(), rows=50)
    two = em.Mesh(
        np.concatenate([one.vertices, one.vertices + [60, 0, 0]]),
        np.concatenate([one.faces.triangles(), one.faces.triangles() + len(one.vertices)]),
    )
    with pytest.raises(CaptureError, match="leave one head"):
        em.register(two, rig())


@pytest.mark.parametrize(
    ("mesh", "words"),
    [
        (em.Mesh([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), "no polygons"),
        (em.Mesh([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]]), "none of its polygons"),
    ],
)
def test_scans_without_a_surface_are_told(mesh, words) -> None:
    with pytest.raises(CaptureError, match=words):
        em.register(mesh, rig())


def test_scans_are_named_apart() -> None:
    with pytest.raises(ParameterError, match="two scans are called"):
        em.register_all(["a/one.ply", "b/one.ply"], "built-in")
    with pytest.raises(ParameterError, match="no scan"):
        em.register_all([], "built-in")
    with pytest.raises(ParameterError, match="there are one"):
        em.register_all(["one.ply"], "built-in", neutral="two")


def test_the_files_are_written_together_or_not_at_all(poses, tmp_path, monkeypatch) -> None:
    from elastomorph.capturing.scans import registered_files

    files = registered_files.write_registered(tmp_path / "poses", poses)
    assert {file.name for file in files} == {path.name for path in (tmp_path / "poses").iterdir()}
    kept = json.loads((tmp_path / "poses" / "register.json").read_text())
    assert list(kept["poses"]) == ["neutral", "smile"]
    again = em.read(tmp_path / "poses" / "smile.obj")
    np.testing.assert_array_equal(again.vertices, poses["smile"].vertices)

    def full(*args: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(registered_files, "write_confidence", full)
    with pytest.raises(em.FileError, match="No space left"):
        registered_files.write_registered(tmp_path / "other", poses)
    assert not (tmp_path / "other").exists()
