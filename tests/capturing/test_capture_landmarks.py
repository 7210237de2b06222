"""Landmarks: their file, points from clicks, and doubt where left and right are exchanged."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from elastomorph.capturing.geometry import Camera, Similarity
from elastomorph.capturing.landmarks import (
    LANDMARKS,
    Landmarks,
    fit_landmarks,
    read_landmarks,
    triangulated,
    write_landmarks,
)
from elastomorph.errors import CaptureError, FormatError

RANDOM = np.random.default_rng(4)
FACE = dict(zip(LANDMARKS, RANDOM.normal(size=(15, 3)) * 5, strict=True))


def cameras(count: int = 4) -> dict[str, Camera]:
    found = {}
    for index in range(count):
        turn = Rotation.from_euler("y", 25 * index - 40, degrees=True).as_matrix()
        found[f"{index}.jpg"] = Camera(
            f"{index}.jpg",
            (800, 600),
            900.0,
            np.array([401.0, 296]),
            -0.06,
            turn,
            np.array([0, 0, 60.0]),
        )
    return found


def test_what_is_written_is_read(tmp_path: Path):
    path = tmp_path / "landmarks.json"
    wanted = Landmarks(
        {"chin": 7}, {"neutral": {"a.jpg": {"chin": (1.5, 2.25)}}}, {"s.ply": {"chin": (1.0, 2, 3)}}
    )
    write_landmarks(path, wanted)
    found = read_landmarks(path)
    assert (found.vertices, found.photographs, found.points) == (
        wanted.vertices,
        wanted.photographs,
        wanted.points,
    )


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("[1]", "no file of landmarks"),
        ("{", "not JSON"),
        ('{"version": 2}', "no file of landmarks"),
        ('{"version": 1, "vertices": {"chin": -1}}', "chin is -1, expected a vertex"),
        ('{"version": 1, "vertices": {"chin": true}}', "expected a vertex"),
        ('{"version": 1, "points": {"a.ply": {"chin": [1, 2]}}}', "expected 3 numbers"),
        ('{"version": 1, "points": {"a.ply": {"chin": [1, 2, NaN]}}}', "expected 3 numbers"),
        ('{"version": 1, "photographs": {"n": {"a": {"chin": "x"}}}}', "expected 2 numbers"),
        ('{"version": 1, "photographs": {"n": []}}', "n is list"),
    ],
)
def test_other_content_is_refused(tmp_path: Path, content: str, said: str):
    path = tmp_path / "landmarks.json"
    path.write_text(content)
    with pytest.raises(FormatError, match=said):
        read_landmarks(path)


def test_points_come_back_from_their_clicks():
    """Through lens distortion, and with a photograph that has no camera passed over."""
    seen = cameras()
    clicks = {
        name: {
            mark: tuple(camera.distorted(camera.project(place)[0])) for mark, place in FACE.items()
        }
        for name, camera in seen.items()
    }
    clicks["unknown.jpg"] = {"chin": (5.0, 5.0)}
    points, residuals = triangulated(clicks, seen)
    for mark, place in FACE.items():
        np.testing.assert_allclose(points[mark], place, atol=1e-8)
        assert residuals[mark] < 1e-6
    alone, _ = triangulated({"0.jpg": clicks["0.jpg"]}, seen)
    assert alone == {}


def test_a_wrong_click_shows_in_its_residual():
    seen = cameras()
    clicks = {
        name: {"chin": tuple(camera.distorted(camera.project(FACE["chin"])[0]))}
        for name, camera in seen.items()
    }
    x, y = clicks["1.jpg"]["chin"]
    clicks["1.jpg"]["chin"] = (x, y + 40)
    _, residuals = triangulated(clicks, seen)
    assert residuals["chin"] > 5


def test_landmarks_place_the_template():
    moving = Similarity(0.1, Rotation.from_rotvec([1, 1, 0]).as_matrix(), np.array([5.0, 6, 7]))
    there = {name: moving(place) + RANDOM.normal(size=3) * 1e-3 for name, place in FACE.items()}
    found = fit_landmarks(FACE, there, "scan.ply")
    assert found.scale == pytest.approx(0.1, rel=1e-2)


def test_left_and_right_exchanged_or_one_astray_is_said():
    face = {name: np.array(place) for name, place in json.loads(FRONT).items()}
    swapped = {
        name.replace("left", "?").replace("right", "left").replace("?", "right"): place
        for name, place in face.items()
    }
    with pytest.raises(CaptureError, match="left and right"):
        fit_landmarks(face, swapped, "scan.ply")
    with pytest.raises(CaptureError, match="left and right"):
        fit_landmarks(face, {name: place * [-1, 1, 1] for name, place in face.items()}, "scan.ply")
    astray = dict(face)
    astray["chin"] = face["chin"] + [0, 8, 0]
    with pytest.raises(CaptureError, match=r"chin is .* away"):
        fit_landmarks(face, astray, "scan.ply")
    with pytest.raises(CaptureError, match="at least 4"):
        fit_landmarks(face, {"chin": face["chin"]}, "scan.ply")


# Of a face in cm, x to the subject's left.
FRONT = """{"nose_tip": [0, 0, 9], "right_eye_outer": [-4.5, 4, 4], "right_eye_inner": [-1.6, 4, 5],
"left_eye_inner": [1.6, 4, 5], "left_eye_outer": [4.5, 4, 4], "nose_bridge": [0, 4.5, 6.5],
"mouth_right": [-2.5, -3.5, 6], "mouth_left": [2.5, -3.5, 6], "upper_lip": [0, -2.5, 7.5],
"chin": [0, -8, 6], "right_jaw": [-6, -4, -2], "left_jaw": [6, -4, -2]}"""
