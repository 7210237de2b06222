"""Poses brought into the neutral's frame by what does not move."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from elastomorph.capturing.cameras.frames import brought, near_still, paired, still_vertices
from elastomorph.capturing.cameras.models import SolvedPose
from elastomorph.capturing.geometry import Similarity
from elastomorph.errors import CaptureError

TURNED = Similarity(
    2.5, Rotation.from_rotvec([0.3, -0.2, 0.1]).as_matrix(), np.array([1.0, -2.0, 0.5])
)


def a_head(seed: int = 0, count: int = 900) -> SolvedPose:
    """Points of a sphere of radius 10, each with a look of its own."""
    random = np.random.default_rng(seed)
    points = random.normal(size=(count, 3))
    points *= 10 / np.linalg.norm(points, axis=1, keepdims=True)
    looks = random.normal(size=(count, 128))
    looks /= np.linalg.norm(looks, axis=1, keepdims=True)
    return SolvedPose((), points, looks.astype(np.float32), {})


def posed(head: SolvedPose, moved: np.ndarray, by: np.ndarray, noise: float = 0.003) -> SolvedPose:
    """The head with some points moved, seen in another order, frame and unit and by noisy looks."""
    random = np.random.default_rng(7)
    points = head.points + noise * random.normal(size=head.points.shape)
    points[moved] += by
    looks = head.descriptors + 0.02 * random.normal(size=head.descriptors.shape)
    looks /= np.linalg.norm(looks, axis=1, keepdims=True)
    order = random.permutation(len(points))[: int(0.8 * len(points))]
    return SolvedPose((), TURNED.inverse()(points[order]), looks[order].astype(np.float32), {})


def error(found: Similarity, head: SolvedPose) -> float:
    """Farthest that a point of the head is from where the true similarity has it."""
    again = found(TURNED.inverse()(head.points))
    return float(np.linalg.norm(again - head.points, axis=1).max())


def test_pairs_are_mutual_and_distinct():
    looks = np.eye(6, dtype=np.float32)
    other = looks[[4, 2, 0]]
    np.testing.assert_array_equal(paired(looks, other), [[0, 2], [2, 1], [4, 0]])
    twice = looks[[0, 0, 1]]  # The first is there twice: no telling which
    np.testing.assert_array_equal(paired(looks, twice), [[1, 2]])
    assert paired(looks[:1], other).shape == (0, 2)


def test_a_pose_with_an_open_jaw_comes_into_the_frame_of_the_neutral():
    head = a_head()
    jaw = head.points[:, 1] < -2
    frame = brought(head, posed(head, jaw, np.array([0, -3.0, -1.0])), "jaw")
    assert error(frame.similarity, head) < 0.003
    assert not jaw[frame.pairs[frame.agreeing, 0]].any()
    assert frame.rms == pytest.approx(0.003 * np.sqrt(3), rel=0.15)


def test_the_part_that_is_still_decides_and_not_the_larger_part():
    head = a_head()
    above = head.points[:, 1] > 2
    # All that is below turned together, as shoulders do: more of the head than what is above.
    pose = posed(head, ~above, np.array([2.0, 0.0, 1.0]))
    assert error(brought(head, pose, "turned").similarity, head) > 1
    assert error(brought(head, pose, "turned", still=above).similarity, head) < 0.006


def test_what_moves_a_little_does_not_pull():
    head = a_head()
    cheeks = head.points[:, 1] < 0
    frame = brought(head, posed(head, cheeks, np.array([0.0, 0.04, 0.0]), noise=0.002), "smile")
    assert error(frame.similarity, head) < 0.012


def test_skin_that_moves_about_as_little_as_points_are_off_does_not_pull():
    """A brow, a quarter of what counts, is raised by three times the noise of a coordinate."""
    noise = 0.004
    head = a_head(1, count=2000)
    brow = (head.points[:, 1] > 0) & (head.points[:, 2] > 4)
    pose = posed(head, brow, noise * np.array([0, 3.0, 1.0]), noise)
    frame = brought(head, pose, "raised", still=head.points[:, 1] > -2)
    assert error(frame.similarity, head) < 0.5 * noise


def test_one_unit_is_kept_where_cameras_stayed():
    head = a_head()
    pose = posed(head, np.zeros(900, dtype=bool), np.zeros(3))
    same_unit = SolvedPose((), pose.points * TURNED.scale, pose.descriptors, {})
    assert brought(head, same_unit, "a", rigid=True).similarity.scale == 1


def test_another_subject_is_refused():
    with pytest.raises(CaptureError, match="pose 'smile': its head does not match the neutral's"):
        brought(a_head(0), a_head(1), "smile")


def test_a_head_of_which_nothing_agrees_is_refused():
    head = a_head()
    random = np.random.default_rng(3)
    scattered = SolvedPose((), random.normal(size=(900, 3)), head.descriptors, {})
    with pytest.raises(CaptureError, match="does not match"):
        brought(head, scattered, "smile")


def test_still_is_above_the_nose_however_the_template_is_turned():
    turn = TURNED.rotation
    vertices = np.array([[0, 3.0, 1], [0, 0, 2], [0, -2, 1], [1, 5, 0], [1, -4, 0]]) @ turn.T
    marks = {"left_eye_inner": 0, "nose_tip": 1, "upper_lip": 2}
    np.testing.assert_array_equal(
        still_vertices(vertices, marks), [True, False, False, True, False]
    )
    with pytest.raises(CaptureError, match="lacks landmarks"):
        still_vertices(vertices, {"nose_tip": 1})


def test_points_near_the_still_part():
    vertices = np.array([[0.0, 0, 0], [0, 100, 0]])
    points = np.array([[0.5, 0, 0], [0.5, 100, 0], [5.0, 100, 0]])
    still = np.array([False, True])
    np.testing.assert_array_equal(near_still(points, vertices, still), [False, True, False])
