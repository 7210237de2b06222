"""The neutral is brought to the template by clicks, and to its true size by a known distance."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from small_captures import template

import elastomorph as em
from needs import extra

for module in ("pycolmap", "cv2", "embreex"):
    extra(module, "capture")

from elastomorph.capturing.cameras.models import SolvedPose  # noqa: E402
from elastomorph.capturing.geometry import Camera, Similarity  # noqa: E402
from elastomorph.capturing.landmarks import LANDMARKS, Landmarks  # noqa: E402
from elastomorph.capturing.work.makers import Makers  # noqa: E402
from elastomorph.capturing.work.request import distance_of, require_known  # noqa: E402
from elastomorph.capturing.work.template import Template  # noqa: E402

SHAPE = Template.of(template())
VERTICES = {name: 9 * k for k, name in enumerate(LANDMARKS)}
# From the frame of the template to that of the cameras.
THERE = Similarity(0.3, Rotation.from_rotvec([0.2, 0.1, -0.4]).as_matrix(), np.array([1.0, 2, 3]))
POINTS = {name: THERE(SHAPE.work.vertices[own]) for name, own in VERTICES.items()}


def cameras() -> tuple[Camera, ...]:
    middle = np.mean(list(POINTS.values()), axis=0)
    found = []
    for k, angle in enumerate((-0.4, 0.0, 0.4)):
        rotation = Rotation.from_rotvec([0, angle, 0]).as_matrix()
        away = np.array([0.0, 0.0, 12.0]) - rotation @ middle
        found.append(
            Camera(f"{k}.jpg", (800, 600), 900.0, np.array([400.0, 300]), -0.05, rotation, away)
        )
    return tuple(found)


def clicked() -> dict[str, dict[str, tuple[float, float]]]:
    clicks = {}
    for camera in cameras():
        pixels = {name: camera.distorted(camera.project(p)[0]) for name, p in POINTS.items()}
        clicks[camera.name] = {name: (float(x), float(y)) for name, (x, y) in pixels.items()}
    return clicks


SOLVED = SolvedPose(cameras(), np.zeros((0, 3)), np.zeros((0, 128), dtype=np.float32), {})


def test_clicks_bring_the_cameras_into_the_frame_of_the_template() -> None:
    found = Makers().placed(SOLVED, SHAPE, Landmarks(VERTICES, {"neutral": clicked()}), "neutral")
    np.testing.assert_allclose(found.similarity(THERE(np.eye(3))), np.eye(3), atol=1e-6)
    assert max(found.residuals.values()) < 1e-6
    for name, point in found.points.items():
        np.testing.assert_allclose(point, SHAPE.work.vertices[VERTICES[name]], atol=1e-6)


def test_a_known_distance_gives_the_true_size_where_the_face_is() -> None:
    points = Landmarks(VERTICES, {"neutral": clicked()})
    plain = Makers().placed(SOLVED, SHAPE, points, "neutral")
    before = float(np.linalg.norm(plain.points["chin"] - plain.points["nose_tip"]))
    known = distance_of(f"chin, nose_tip={1.2 * before}")
    found = Makers().placed(SOLVED, SHAPE, replace(points, distances=(known,)), "neutral")
    assert np.linalg.norm(found.points["chin"] - found.points["nose_tip"]) == pytest.approx(
        1.2 * before
    )
    middle, other = (np.mean(list(own.points.values()), axis=0) for own in (plain, found))
    np.testing.assert_allclose(other, middle, atol=1e-6)
    np.testing.assert_allclose(found.similarity.rotation, plain.similarity.rotation, atol=1e-9)
    assert distance_of(("chin", "nose_tip", 1.2 * before)) == known


def test_the_distance_of_a_camera_gives_the_size_too() -> None:
    points = Landmarks(VERTICES, {"neutral": clicked()})
    plain = Makers().placed(SOLVED, SHAPE, points, "neutral")
    one, other = (camera.moved(plain.similarity).position for camera in SOLVED.cameras[:2])
    names = [camera.name for camera in SOLVED.cameras[:2]]
    for given in (
        (names[0], "chin", 0.9 * float(np.linalg.norm(one - plain.points["chin"]))),
        (*names, 0.9 * float(np.linalg.norm(one - other))),
    ):
        found = Makers().placed(SOLVED, SHAPE, replace(points, distances=(given,)), "neutral")
        assert found.similarity.scale == pytest.approx(0.9 * plain.similarity.scale)
    require_known(given, {}, [Path(name) for name in names], "file")
    with pytest.raises(em.CaptureError, match=r"file: 9\.jpg, from which a dist.* is in"):
        require_known(("9.jpg", names[0], 3.0), {}, [Path(names[0])], "file")


def test_clicks_that_are_not_of_one_point_are_refused() -> None:
    clicks = clicked()
    x, y = clicks["1.jpg"]["chin"]
    clicks["1.jpg"]["chin"] = (x, y + 80)
    with pytest.raises(em.CaptureError, match=r"the clicks of chin are .* px from any one point"):
        Makers().placed(SOLVED, SHAPE, Landmarks(VERTICES, {"neutral": clicks}), "neutral")
