"""Scans of the small head, of another topology, are registered to its vertices."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import elastomorph as em
from elastomorph.errors import CaptureError, ElastomorphWarning, ParameterError
from needs import extra
from small_head import landmarks

extra("embreex", "capture")
extra("cv2", "capture")

from small_scans import in_single_steps, marked, moved, posed, rig, scanned  # noqa: E402

from elastomorph.capturing.geometry import Similarity, Surface  # noqa: E402
from elastomorph.capturing.landmarks import Landmarks  # noqa: E402
from elastomorph.capturing.scans import registration  # noqa: E402
from elastomorph.capturing.scans.correspondence import ScanPoints  # noqa: E402
from elastomorph.capturing.scans.nonrigid import Elastic, Held  # noqa: E402
from elastomorph.capturing.scans.placing import Marks, placed_next, stillness  # noqa: E402
from elastomorph.capturing.scans.registered_files import Face, read_face  # noqa: E402
from elastomorph.capturing.scans.registration import require_alike, trusted  # noqa: E402
from elastomorph.capturing.scans.scans import read_scan  # noqa: E402

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
    beside = face.vertices[landmarks()["mouth_left"]] + [2.5, 1, 0]
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
        assert 1.3 < found.weights["jawOpen"] <= 1.5


def test_clicks_never_make_a_scan_worse(tmp_path) -> None:
    """On a head of the template's own shape the surface says more than what people click."""
    smile = posed(**SMILE)
    for name, face, seed in (("neutral", posed(), 0), ("smile", smile, 1)):
        em.write(tmp_path / f"{name}.ply", scanned(face, seed=seed, rows=90))
    clicks = {
        name: marked(face, name, off=0.1, seed=seed).points[name]
        for name, face, seed in (("neutral", posed(), 2), ("smile", smile, 3))
    }
    marks = Landmarks(marked(posed()).vertices, points=clicks)
    off = []
    for placed in (None, marks):
        with pytest.warns(ElastomorphWarning):
            found = em.register_all(
                [tmp_path / "neutral.ply", tmp_path / "smile.ply"], rig(), landmarks=placed
            )
        sure = found["neutral"].confidence > 0.5
        off += [
            errors(found["neutral"], posed())[sure].mean(),
            errors(found["smile"], smile)[sure].mean(),
        ]
    assert off[2] < 1.1 * off[0]
    assert off[3] < 1.1 * off[1]


@pytest.fixture(scope="module")
def nodding() -> tuple[Elastic, Face, em.Mesh, Similarity]:
    """The front of a head that opens its jaw, turned by three degrees."""
    face = read_face(rig())
    elastic = Elastic(face.vertices, face.triangles, face.size, face.skin)
    turn = Rotation.from_rotvec(np.radians([3.0, 0, 0])).as_matrix()
    scan = scanned(posed(jawOpen=1.0), rows=90)
    nose = face.vertices[:, 2].max()
    front = (scan.vertices[scan.faces.triangles()][:, :, 2] > nose - 8).all(axis=1)
    used, triangles = np.unique(scan.faces.triangles()[front], return_inverse=True)
    mask = em.Mesh(scan.vertices[used] @ turn.T + [0.5, 0, 0], triangles.reshape(-1, 3))
    return elastic, face, mask, Similarity(1.0, turn, np.array([0.5, 0, 0]))


def turned(found: Similarity, true: Similarity) -> float:
    """Degrees that a scan brought back to its head is turned by."""
    return float(np.degrees(Rotation.from_matrix(found.then(true).rotation).magnitude()))


@pytest.mark.parametrize("known", ["rig", "landmarks"])
def test_an_open_jaw_does_not_drag_the_head(nodding, known: str) -> None:
    """By what a rig never moves, or by the landmarks that stay, the head is where it was."""
    elastic, face, mask, moved_by = nodding
    marks = Marks(landmarks(), {}, "")
    still = stillness(elastic, face.expressions if known == "rig" else None, marks)
    jaw = face.vertices[marks.vertices["chin"]]
    below = np.linalg.norm(face.vertices - jaw, axis=1) < 3
    brow = np.linalg.norm(face.vertices - face.vertices[marks.vertices["nose_bridge"]], axis=1) < 2
    assert still[below & face.skin].max() < 0.5 * still[brow & face.skin].mean()
    before = Similarity.identity()
    found = placed_next(read_scan(mask), marks, elastic, elastic.rest, before, still)
    assert turned(found.similarity, moved_by) < (0.3 if known == "rig" else 0.5)


def test_a_head_that_nothing_holds_is_doubted(nodding) -> None:
    """A mask that fits two places about as well says so; one that has not moved is not doubted."""
    elastic, face, mask, _ = nodding
    marks = Marks({}, {}, "")
    alike = placed_next(
        read_scan(scanned(posed(), rows=90)), marks, elastic, elastic.rest, Similarity.identity()
    )
    doubted = placed_next(read_scan(mask), marks, elastic, elastic.rest, Similarity.identity())
    assert alike.doubt < 0.05
    assert doubted.doubt > 3 * alike.doubt
    unsure = doubted.unsure(face.vertices)
    assert unsure.shape == (len(face.vertices),)
    np.testing.assert_allclose(alike.unsure(face.vertices).max() / face.size, 0, atol=1e-3)


def test_landmarks_count_as_they_are_exact() -> None:
    held = Held(np.arange(4), np.zeros((4, 3)))
    assert held.sure(1.0, np.full((4, 3), 0.1)) == 1
    assert held.sure(0.01, np.full((4, 3), 1.0)) < 1e-3
    assert Held(np.arange(0), np.zeros((0, 3))).sure(1.0, np.zeros((0, 3))) == 0
    np.testing.assert_array_equal(held.without([np.ones(3)] * 4).places, -np.ones((4, 3)))


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
        em.register_all(["a/one.ply", "b/one.ply"], rig())
    with pytest.raises(ParameterError, match="no scan"):
        em.register_all([], rig())
    with pytest.raises(ParameterError, match="there are one"):
        em.register_all(["one.ply"], rig(), neutral="two")


def test_the_files_are_written_together_or_not_at_all(poses, tmp_path, monkeypatch) -> None:
    from elastomorph.capturing.scans import registered_files

    for name, pose in poses.items():
        registered_files.keep_pose(tmp_path / "poses", name, pose)
    registered_files.write_figures(tmp_path / "poses", poses)
    files = registered_files.written_to(tmp_path / "poses", poses)
    assert {file.name for file in files} == {path.name for path in (tmp_path / "poses").iterdir()}
    kept = json.loads((tmp_path / "poses" / "register.json").read_text())
    assert list(kept["poses"]) == ["neutral", "smile"]
    again = em.read(tmp_path / "poses" / "smile.obj")
    np.testing.assert_array_equal(again.vertices, poses["smile"].vertices)

    def full(*args: object, **options: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(registered_files.json, "dumps", full)
    with pytest.raises(em.FileError, match="No space left"):
        registered_files.keep_pose(tmp_path / "other", "smile", poses["smile"])
    assert not (tmp_path / "other").exists()
    before = {path.name: path.read_bytes() for path in (tmp_path / "poses").iterdir()}
    with pytest.raises(em.FileError, match="No space left"):
        registered_files.write_figures(tmp_path / "poses", poses)
    assert before == {path.name: path.read_bytes() for path in (tmp_path / "poses").iterdir()}


def test_a_run_that_was_stopped_goes_on_where_it_was(tmp_path, monkeypatch) -> None:
    """What is finished is kept, and is not made again while nothing that it is made of changes."""
    in_single_steps(monkeypatch)
    faces = {"neutral": posed(), "smile": posed(**SMILE), "wide": posed(jawOpen=0.8)}
    scans = {name: scanned(face, seed=k, rows=50) for k, (name, face) in enumerate(faces.items())}
    made, next_of = [], registration._next

    def stopped(person, scan, *rest):
        if len(made) == 1:
            raise KeyboardInterrupt
        made.append(scan)
        return next_of(person, scan, *rest)

    def run(**changed):
        seen = []
        with pytest.warns(ElastomorphWarning):
            found = em.register_all(
                scans | changed, rig(), output=tmp_path, done=lambda name, _: seen.append(name)
            )
        assert seen == list(scans)
        return found

    monkeypatch.setattr(registration, "_next", stopped)
    with pytest.raises(KeyboardInterrupt):
        em.register_all(scans, rig(), output=tmp_path)
    assert {"neutral.obj", "smile.obj", "confidence.npz", "register.json"} == {
        file.name for file in tmp_path.iterdir()
    }

    def counted(person, scan, *rest):
        made.append(scan)
        return next_of(person, scan, *rest)

    monkeypatch.setattr(registration, "_next", counted)
    made.clear()
    again = run()
    assert len(made) == 1
    made.clear()
    assert run()["wide"].figures == again["wide"].figures
    assert not made
    with pytest.warns(ElastomorphWarning):
        whole = em.register_all(scans, rig())
    for name in scans:
        np.testing.assert_allclose(again[name].vertices, whole[name].vertices, atol=1e-9)
    # Another scan of one pose is made anew, and of another neutral all of them.
    made.clear()
    run(smile=scanned(posed(jawOpen=0.3), rows=50))
    assert len(made) == 1
    made.clear()
    run(neutral=scanned(posed(), seed=9, rows=50))
    assert len(made) == 2
