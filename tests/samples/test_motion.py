"""The recorded motion is anatomical: joints turn, and nothing follows a straight line in step."""

from __future__ import annotations

import numpy as np
import pytest

from elastomorph.samples import head, recorded_motion
from sculptor import lids, lips
from sculptor.anatomy import EYE_CENTRE, EYE_RADIUS, JAW_AXIS
from sculptor.layout import MOUTH
from sculptor.motion import FRAMES, JAW_TURN, jaw_angle
from sculptor.weights import jaw_weights

MOTION = recorded_motion()
PIVOT_OFFSET = np.array([0.0, -0.3, 1.0])  # the hinge glides forwards and a little down


def _rigid_motion(before, after):
    """Best rotation and translation from one set of points to another (Kabsch)."""
    a, b = before.mean(axis=0), after.mean(axis=0)
    u, _, vt = np.linalg.svd((before - a).T @ (after - b))
    turn = (u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt).T
    return turn, b - turn @ a


@pytest.fixture(scope="module")
def teeth(whole):
    """Vertices of the lower teeth."""
    return np.flatnonzero(whole.part == "lower_teeth")


def test_eleven_finite_frames_at_even_times():
    assert len(MOTION) == FRAMES == 11
    np.testing.assert_allclose(MOTION.times, np.arange(11) / 10)
    assert np.isfinite(MOTION.frames).all()
    assert MOTION.mesh.faces is head().faces
    assert 25.0 < head().diameter < 40.0


def test_the_first_frame_is_the_neutral_bit_for_bit():
    assert MOTION.frames[0].tobytes() == head().vertices.tobytes()


@pytest.mark.parametrize("frame", range(1, 11))
def test_lower_teeth_turn_rigidly_about_the_stated_axis(frame, teeth):
    before, after = MOTION.frames[0][teeth], MOTION.frames[frame][teeth]
    turn, shift = _rigid_motion(before, after)
    np.testing.assert_allclose(before @ turn.T + shift, after, atol=1e-7)
    np.testing.assert_allclose(turn @ [1.0, 0.0, 0.0], [1.0, 0.0, 0.0], atol=1e-7)
    angle = np.degrees(np.arctan2(turn[2, 1], turn[1, 1]))
    assert angle == pytest.approx(jaw_angle(frame / 10), abs=1e-6)
    # the axis is carried along by the glide of the joint, straight forwards and down
    glide = turn @ JAW_AXIS + shift - JAW_AXIS
    assert 0.0 < glide[2] <= 0.35 + 1e-7
    np.testing.assert_allclose(glide, glide[2] * PIVOT_OFFSET, atol=1e-7)


def test_the_jaw_opens_steadily_by_the_stated_angle():
    angles = np.array([jaw_angle(t) for t in MOTION.times])
    assert angles[0] == 0.0
    assert angles[-1] == pytest.approx(JAW_TURN)
    assert 20.0 <= JAW_TURN <= 25.0
    assert (np.diff(angles) > 0.0).all()


def test_a_chin_vertex_leaves_its_chord_as_a_circular_arc_does(whole):
    """At angle α of θ an arc of radius r is r(cos(α − θ/2) − cos(θ/2)) away from its chord."""
    chin = whole.lay.grid[MOUTH.bottom + 4, 0]
    share = jaw_weights()[chin]
    assert share > 0.98
    path = MOTION.frames[:, chin, 1:].copy()
    angles = np.radians([share * jaw_angle(t) for t in MOTION.times])
    hinge = MOTION.frames[:, whole.part == "lower_teeth"]
    for frame in range(11):
        turn, shift = _rigid_motion(hinge[0], hinge[frame])
        path[frame] -= share * (turn @ JAW_AXIS + shift - JAW_AXIS)[1:]
    radius = np.linalg.norm(path[0] - JAW_AXIS[1:])
    chord = (path[-1] - path[0]) / np.linalg.norm(path[-1] - path[0])
    offset = path - path[0]
    deviation = np.abs(offset[:, 0] * chord[1] - offset[:, 1] * chord[0])
    half = angles[-1] / 2
    np.testing.assert_allclose(
        deviation, radius * (np.cos(angles - half) - np.cos(half)), atol=1e-6
    )
    assert deviation.max() > 0.2


def test_lids_keep_their_distance_from_the_eyeball_and_never_enter_it(whole):
    for rings, sign in ((whole.lay.eye, 1.0), (whole.partner[whole.lay.eye], -1.0)):
        distance = np.linalg.norm(MOTION.frames[:, rings] - EYE_CENTRE * [sign, 1, 1], axis=3)
        turning = distance[:, lids.CREASE + 1 :]
        np.testing.assert_allclose(turning, np.broadcast_to(turning[:1], turning.shape), atol=1e-7)
        assert distance.min() > EYE_RADIUS + 0.02


def test_skull_upper_teeth_and_eyeballs_stay(whole):
    still = np.isin(whole.part, ("upper_teeth", "eye_L", "eye_R"))
    crown = whole.lay.cap.ravel()
    for frame in MOTION.frames:
        np.testing.assert_array_equal(frame[still], MOTION.frames[0][still])
        np.testing.assert_allclose(frame[crown], MOTION.frames[0][crown], atol=0.02)


def test_lips_never_cross(whole):
    last = 2 * lips.STEPS
    for rings in (whole.lay.mouth, whole.partner[whole.lay.mouth]):
        upper = MOTION.frames[:, rings[lips.CONTACT, : lips.STEPS], 1]
        lower = MOTION.frames[:, rings[lips.CONTACT, last : last - lips.STEPS : -1], 1]
        assert (upper - lower).min() > -0.01


def test_it_is_symmetric(whole):
    mirrored = MOTION.frames[:, whole.partner] * [-1.0, 1.0, 1.0]
    np.testing.assert_array_equal(mirrored, MOTION.frames)


def test_parts_move_at_their_own_times(whole):
    """Brows lead and lower lids follow: halfway times differ by more than a tenth."""
    halfway = {}
    for name, vertices in (
        ("brow", whole.lay.eye[1, 2:6]),
        ("chin", whole.lay.grid[MOUTH.bottom + 3, :3]),
        ("lower lid", whole.lay.eye[7, 15:21]),
    ):
        gone = np.linalg.norm(MOTION.frames[:, vertices] - MOTION.frames[0, vertices], axis=2)
        progress = gone.mean(axis=1) / gone[-1].mean()
        halfway[name] = float(np.interp(0.5, progress, MOTION.times))
    assert halfway["brow"] + 0.05 < halfway["chin"]
    assert halfway["chin"] + 0.1 < halfway["lower lid"]


def test_no_straight_line_reproduces_it():
    """Even with the best common timing of all, straight paths are off by over 1 % of D."""
    start, end = MOTION.frames[0], MOTION.frames[-1]
    way = end - start
    worst = 0.0
    for frame in MOTION.frames[1:-1]:
        best = np.sum((frame - start) * way) / np.sum(way**2)
        worst = max(worst, float(np.linalg.norm(frame - start - best * way, axis=1).max()))
    assert worst > 0.01 * head().diameter
