"""Joints and lids turn: distances from their axes and centres stay."""

from __future__ import annotations

import numpy as np
import pytest

from elastomorph.samples import lids
from elastomorph.samples.anatomy import EYE_CENTRE, EYE_RADIUS, JAW_AXIS
from elastomorph.samples.turns import keep_off_eyes, turn_jaw, turn_lids
from elastomorph.samples.weights import jaw_weights


@pytest.mark.parametrize("degrees", [-3.0, 7.0, 24.0])
def test_the_jaw_turns_about_its_axis(neutral, degrees):
    """Every vertex keeps x and its distance from the axis, and turns by its share."""
    turned = turn_jaw(neutral.vertices, degrees)
    before, after = (p[:, 1:] - JAW_AXIS[1:] for p in (neutral.vertices, turned))
    np.testing.assert_array_equal(turned[:, 0], neutral.vertices[:, 0])
    np.testing.assert_allclose(np.hypot(*after.T), np.hypot(*before.T), atol=1e-12)
    angle = np.arctan2(
        before[:, 1] * after[:, 0] - before[:, 0] * after[:, 1], (before * after).sum(axis=1)
    )
    np.testing.assert_allclose(-np.degrees(angle), degrees * jaw_weights(), atol=1e-9)


def test_gliding_moves_the_jaw_forwards_and_down(neutral, whole):
    moved = turn_jaw(neutral.vertices, 0.0, (0.4, 0.1)) - neutral.vertices
    rigid = whole.part == "lower_teeth"
    np.testing.assert_allclose(moved[rigid], [[0.0, -0.1, 0.4]] * int(rigid.sum()), atol=1e-12)


@pytest.mark.parametrize("closing", [(0.86, 0.14), (1.0, 0.0), (-0.3, -0.1), (0.2, 0.5)])
def test_lids_keep_their_distance_from_the_eyeballs_centre(neutral, whole, closing):
    turned = turn_lids(neutral.vertices, {"L": closing, "R": closing})
    for rings, sign in ((whole.lay.eye, 1.0), (whole.partner[whole.lay.eye], -1.0)):
        centre = EYE_CENTRE * [sign, 1.0, 1.0]
        before = np.linalg.norm(neutral.vertices[rings] - centre, axis=2)
        after = np.linalg.norm(turned[rings] - centre, axis=2)
        np.testing.assert_allclose(after, before, atol=1e-12)
        assert after.min() > EYE_RADIUS
    np.testing.assert_array_equal(
        turned[whole.part != "skin"], neutral.vertices[whole.part != "skin"]
    )


@pytest.mark.parametrize("seed", range(3))
def test_lids_that_do_not_turn_keep_every_bit(neutral, whole, seed):
    """Wherever they are: taking the centre off and adding it again may change the last bit."""
    points = neutral.vertices + 1e-3 * np.random.default_rng(seed).standard_normal((1, 3))
    np.testing.assert_array_equal(turn_lids(points, {"L": (0.0, 0.0)}), points)
    turned = turn_lids(points, {"L": (0.5, 0.0), "R": (0.0, 0.5)})
    outline = whole.lay.eye[:3]
    still = np.concatenate([outline, whole.partner[outline]])
    np.testing.assert_array_equal(turned[still], points[still])


def test_a_lid_that_closes_fully_meets_the_other(neutral, whole):
    turned = turn_lids(neutral.vertices, {"L": (0.86, 0.14)})
    edge = turned[whole.lay.eye[lids.MARGIN + 1]] - EYE_CENTRE
    height = np.arctan2(edge[:, 1], edge[:, 2])
    for step in range(1, lids.STEPS):
        assert height[lids.place(step, True)] == pytest.approx(height[lids.place(step, False)])


def test_places_go_along_both_lids_from_corner_to_corner():
    upper = [lids.place(step, True) for step in range(lids.STEPS + 1)]
    lower = [lids.place(step, False) for step in range(lids.STEPS + 1)]
    assert upper[0] == lower[0] == lids.INNER_CORNER
    assert upper[-1] == lower[-1] == lids.OUTER_CORNER
    assert sorted({*upper, *lower}) == list(range(2 * lids.STEPS))


def test_skin_pressed_into_an_eye_is_pushed_out_and_other_skin_stays(neutral, whole):
    np.testing.assert_array_equal(keep_off_eyes(neutral.vertices), neutral.vertices)
    pressed = neutral.vertices.copy()
    pressed[whole.lay.eye[3]] += 0.5 * (EYE_CENTRE - pressed[whole.lay.eye[3]])
    out = keep_off_eyes(pressed)
    assert np.linalg.norm(out[whole.lay.eye[3]] - EYE_CENTRE, axis=1).min() > EYE_RADIUS
