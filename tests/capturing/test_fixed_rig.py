"""Cameras that stay: solved from several poses, and poses seen by them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from spotted import cameras, centres_off, egg, finder, renamed, seen, taken

import elastomorph.capturing.cameras.cameras as solving
import elastomorph.capturing.cameras.fixed_rig as module
from elastomorph.capturing.cameras.cameras import solve_pose
from elastomorph.capturing.cameras.fixed_rig import looked_at, same_cameras, solve_in_rig, solve_rig
from elastomorph.capturing.cameras.frames import brought
from elastomorph.capturing.geometry import Camera
from elastomorph.capturing.photographs import Photograph, Photographs
from elastomorph.errors import CaptureError
from needs import extra

pytestmark = pytest.mark.photographs

extra("pycolmap", "capture")

CAMERAS = cameras()
EGG = egg()
TURN = Rotation.from_rotvec([0.03, -0.05, 0.02]).as_matrix()
POSES = {
    "neutral": EGG,
    "a": EGG.moved(np.array([0.4, 0.2, -0.3]), TURN),
    "b": EGG.moved(np.array([-0.3, 0.5, 0.2]), TURN.T),
    "c": EGG.moved(np.array([0.1, -0.4, 0.0])),
}


@pytest.fixture
def views(monkeypatch):
    """What each photograph shows, pose → photograph → features."""
    found = {
        pose: {c.name: seen(c, shape, 100 * number + k) for k, c in enumerate(CAMERAS)}
        for number, (pose, shape) in enumerate(POSES.items())
    }
    for place in (solving, module):
        monkeypatch.setattr(place, "find_features", finder(found))
    return found


def photographs() -> dict[str, Photographs]:
    return {pose: taken(CAMERAS, pose) for pose in POSES}


def test_several_poses_say_more_of_cameras_than_one(views):
    poses = photographs()
    same = same_cameras(poses, "neutral")
    alone = solve_pose(poses["neutral"])
    parts = []
    found = solve_rig(poses, "neutral", say=lambda text, part: parts.append(part))
    rig = found["neutral"]
    assert (np.diff(parts) > -1e-9).all()
    assert len(rig.cameras) == len(CAMERAS)
    assert centres_off(rig.cameras, CAMERAS) < 0.8 * centres_off(alone.cameras, CAMERAS)
    assert len(rig.points) == pytest.approx(len(alone.points), rel=0.05)
    assert not any("own" in remark for remark in rig.remarks)
    solved = solve_in_rig(poses["a"], rig, same["a"])
    np.testing.assert_allclose(found["a"].points, solved.points, atol=1e-6)
    for one, other in zip(solved.cameras, rig.cameras, strict=True):
        assert one.name == other.name
        np.testing.assert_allclose(one.position, other.position, atol=1e-9)
    assert len(solved.points) > 0.9 * len(rig.points)
    # The head moved, and is as large as it was.
    frame = brought(rig, solved, "a", rigid=True)
    np.testing.assert_allclose(frame.similarity.rotation, _in_rig(rig, TURN.T), atol=5e-4)


def _in_rig(rig, turn: np.ndarray) -> np.ndarray:
    """A turn of the true world as the rig's own frame has it."""
    world = CAMERAS[0].rotation.T @ rig.cameras[0].rotation
    return world.T @ turn @ world


def test_a_camera_that_was_moved_is_left_out(views):
    poses = photographs()
    rig = solve_rig({pose: poses[pose] for pose in ("neutral", "b")}, "neutral")["neutral"]
    moved = replace(CAMERAS[4], translation=CAMERAS[4].translation + np.array([0.6, 0.4, 0.0]))
    views["a"]["04.jpg"] = seen(moved, POSES["a"], 9)
    solved = solve_in_rig(poses["a"], rig, same_cameras(poses, "neutral")["a"])
    assert list(solved.rejected) == ["04.jpg"]
    assert "the camera moved" in solved.rejected["04.jpg"]
    for k, camera in enumerate(CAMERAS):
        other = replace(camera, translation=camera.translation + np.array([0.7, -0.5 * k, k]))
        views["a"][camera.name] = seen(other, POSES["a"], k)
    with pytest.raises(CaptureError, match="leave out --rig fixed"):
        solve_in_rig(poses["a"], rig, same_cameras(poses, "neutral")["a"])


def test_lenses_that_differ_are_told_apart(views):
    """Cameras of one make and zoom, of which each lens is a little different."""
    random = np.random.default_rng(3)
    each = [replace(c, focal=c.focal * (1 + 0.01 * random.normal())) for c in CAMERAS]
    for number, (pose, shape) in enumerate(POSES.items()):
        views[pose].update({c.name: seen(c, shape, 50 * number + k) for k, c in enumerate(each)})
    rig = solve_rig(photographs(), "neutral")["neutral"]
    assert "each camera has a lens of its own" in rig.remarks
    focals = np.array([camera.focal for camera in rig.cameras])
    true = np.array([camera.focal for camera in each])
    assert np.corrcoef(focals, true)[0, 1] > 0.9


def named(pose: str, names: list[str]) -> Photographs:
    return Photographs(
        pose,
        tuple(
            Photograph(Path(pose) / name, (30, 40), None, "", "X", f"{pose}{name}")
            for name in names
        ),
    )


def test_the_same_camera_by_name_or_number():
    by_name = {"n": named("n", ["left.jpg", "top.jpg"]), "a": named("a", ["top.png", "left.png"])}
    found = same_cameras(by_name, "n")["a"]
    assert found == {"top.png": "top.jpg", "left.png": "left.jpg"}
    by_number = {"n": named("n", ["n_01.jpg", "n_2.jpg"]), "a": named("a", ["a_2.jpg", "a_1.jpg"])}
    assert same_cameras(by_number, "n")["a"] == {"a_2.jpg": "n_2.jpg", "a_1.jpg": "n_01.jpg"}


def test_names_that_do_not_tell_which_camera_it_was():
    poses = {"n": named("n", ["IMG_1.jpg", "IMG_2.jpg"]), "a": named("a", ["IMG_7.jpg"])}
    with pytest.raises(CaptureError, match=r"pose 'a'.*IMG_7.*name them alike"):
        same_cameras(poses, "n")
    twice = {"n": named("n", ["a_1.jpg", "b_1.jpg"]), "a": named("a", ["c_1.jpg"])}
    with pytest.raises(CaptureError, match="same number"):
        same_cameras(twice, "n")


def test_what_all_cameras_look_at():
    found = looked_at([None, *renamed(CAMERAS, "x")])
    assert np.linalg.norm(found) < 0.5
    axis = Camera("a", (9, 9), 9.0, np.zeros(2), 0.0, np.eye(3), np.zeros(3))
    turned = replace(
        axis, rotation=np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]]), translation=np.zeros(3)
    )
    np.testing.assert_allclose(looked_at([axis, turned]), 0, atol=1e-12)
