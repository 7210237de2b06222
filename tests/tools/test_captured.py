"""The judge of registered poses, on cases worked by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from needs import extra

extra("cv2", "capture")
extra("embreex", "capture")

from captured.geometry import closest, similarity, to_segments  # noqa: E402
from captured.judging import REGIONS, Judge, Spread, extent, flags  # noqa: E402
from captured.outcome import Outcome, camera_errors, frame_errors, into_truth, true_positions  # noqa: E402
from photographs.sessions import Session  # noqa: E402
from photographs.subjects import subject  # noqa: E402
from photographs.truth import Truth  # noqa: E402

pytestmark = pytest.mark.photographs

RANDOM = np.random.default_rng(3)
TURN = np.linalg.qr(RANDOM.normal(size=(3, 3)))[0]
TURN *= np.sign(np.linalg.det(TURN))


@pytest.fixture(scope="module")
def truth():
    person = subject("small")
    return Truth.of(Session(count=30, poses=2, seed=2), person)


@pytest.fixture(scope="module")
def judge(truth):
    return Judge(truth, truth.vertices["p00"][truth.of_template])


def test_a_similarity_is_found_again():
    points = RANDOM.normal(size=(9, 3))
    found = similarity(points, 2.5 * points @ TURN.T + [1, 2, 3])
    np.testing.assert_allclose(found.turn, TURN, atol=1e-12)
    np.testing.assert_allclose(found(points), 2.5 * points @ TURN.T + [1, 2, 3], atol=1e-12)


def test_closest_points_are_none_farther_than_any_other():
    corners = RANDOM.normal(size=(60, 3))
    triangles = RANDOM.permutation(60).reshape(20, 3)
    points = 2 * RANDOM.normal(size=(50, 3))
    found = closest(points, corners, triangles)
    on = found.on(corners, triangles)
    np.testing.assert_allclose(np.linalg.norm(on - points, axis=1), found.distances)
    assert (found.weights >= -1e-12).all()
    np.testing.assert_allclose(found.weights.sum(axis=1), 1)
    weights = RANDOM.dirichlet([0.4] * 3, 4000)
    others = np.einsum("wc,tca->twa", weights, corners[triangles]).reshape(-1, 3)
    nearest = np.linalg.norm(points[:, None] - others, axis=2).min(axis=1)
    assert (found.distances <= nearest + 1e-12).all()
    assert (found.distances >= nearest - 0.15).all()


def test_distances_from_segments_are_those_worked_by_hand():
    starts, ends = np.array([[0.0, 0, 0], [5, 0, 0]]), np.array([[1.0, 0, 0], [5, 5, 0]])
    points = np.array([[0.5, 2, 0], [-3, 4, 0], [6, 7, 0], [4, 3, 0]])
    np.testing.assert_allclose(to_segments(points, starts, ends), [2, 5, np.sqrt(5), 1])


def test_the_extent_of_a_box_is_its_diagonal():
    box = RANDOM.uniform(size=(500, 3)) * [3, 4, 12]
    box[:2] = [[0, 0, 0], [3, 4, 12]]
    assert extent(box) == pytest.approx(13)


def test_the_truth_has_no_error(truth, judge):
    figures = judge.pose("p01", truth.vertices["p01"][truth.of_template])
    for name in REGIONS:
        assert figures[name].count > 20
        assert figures[name].largest < 1e-9
    assert judge.surface().largest < 1e-9


def test_a_known_error_is_found(truth, judge):
    """A vertex moved by 1 % of D in the pose is off by 1 %; in both, by nothing but its surface."""
    off = np.zeros_like(judge.neutral)
    off[:, 1] = judge.extent / 100
    found = judge.errors("p01", truth.vertices["p01"][truth.of_template] + off)
    np.testing.assert_allclose(found, 1)
    assert judge.pose("p01", truth.vertices["p01"][truth.of_template] + off)[
        "moving"
    ].mean == pytest.approx(1)


def test_a_template_that_lies_elsewhere_on_the_face_does_no_harm(truth):
    """Vertices in the middle of triangles move with the points that they stand for."""
    rows = np.flatnonzero(truth.materials == 0)[::40]
    own = truth.triangles[rows]
    middle = {name: own_pose[own].mean(axis=1) for name, own_pose in truth.vertices.items()}
    judge = Judge(truth, middle["p00"])
    assert judge.errors("p01", middle["p01"])[judge.skin].max() < 1e-6


def test_regions_are_where_their_names_say(truth, judge):
    regions = judge.regions("p01")
    place, chin = judge.points, truth.vertices["p00"][truth.landmarks["chin"]]
    corner = truth.vertices["p00"][truth.landmarks["mouth_left"]]
    assert np.abs(place[regions["lips"]][:, 1] - corner[1]).max() < 2
    assert not (regions["moving"] & regions["lips"]).any()
    assert np.abs(place[regions["chin"]][:, 1] - chin[1]).max() < 4
    assert (place[judge.front][:, 1] > chin[1] - 1).all()
    moved = np.linalg.norm(judge.of("p01") - place, axis=1)
    assert moved[regions["moving"]].min() > 0.1


def test_a_camera_from_below_shows_what_is_under_the_chin(truth):
    session = Session(count=6, poses=1, rings=(-35.0,), seed=2)
    below = Truth.of(session, subject("small", 2))
    own = below.vertices["p00"][below.of_template]
    seen = Judge(below, own)
    under = seen.chin
    above = Truth.of(replace(session, rings=(30.0,)), subject("small", 2))
    assert (seen.neutral_views[under] > 0).mean() > 0.9
    assert (Judge(above, own).neutral_views[under] > 0).mean() < 0.3


def test_cameras_and_frames_are_judged_up_to_one_similarity(truth):
    """Both poses moved by one similarity are without error; 0.1 cm between them is 0.1 cm."""

    def outcome(shift):
        cameras = {
            pose: {
                name: 0.3 * TURN @ (place + (shift if pose == "p01" else 0)) + [5, 0, 1]
                for name, place in true_positions(truth, pose).items()
            }
            for pose in ("p00", "p01")
        }
        return Outcome({}, {}, cameras, {}, {})

    exact = outcome(np.zeros(3))
    place = true_positions(truth, "p00")
    np.testing.assert_allclose(camera_errors(exact.cameras["p00"], place), 0, atol=1e-9)
    np.testing.assert_allclose(frame_errors(exact, truth, "p01"), 0, atol=1e-9)
    moved = outcome(np.array([0.1, 0, 0]))
    np.testing.assert_allclose(frame_errors(moved, truth, "p01"), 0.1, atol=1e-9)
    into = into_truth(moved, truth)
    np.testing.assert_allclose(into(moved.cameras["p00"]["03.jpg"]), place["03.jpg"], atol=1e-9)


def test_flags_are_counted_among_those_that_are_off():
    errors = np.array([0.1, 0.6, 0.7, 0.2, 9.0])
    confidence = np.array([0.9, 0.1, 0.8, 0.2, 0.9])
    chosen = np.array([True, True, True, True, False])
    assert flags(errors, confidence, chosen) == (0.5, 0.5, 2)
    assert np.isnan(Spread.of(np.array([])).mean)
