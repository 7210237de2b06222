"""Hills and the pull of the jaw."""

from __future__ import annotations

import numpy as np

from elastomorph.samples import lips
from elastomorph.samples.layout import MOUTH
from elastomorph.samples.weights import hill, jaw_weights, lid_grip


def test_a_hill_peaks_at_its_centre_and_ends_three_widths_away(neutral, whole):
    weights = hill(2.0, -4.0, 1.0, 0.5)
    assert 0.8 < weights.max() <= 1.0
    top = neutral.vertices[weights.argmax()]
    assert np.hypot(top[0] - 2.0, top[1] + 4.0) < 0.5
    square = (neutral.vertices[:, 0] - 2.0) ** 2 + ((neutral.vertices[:, 1] + 4.0) / 0.5) ** 2
    assert (weights[square >= 9.0] == 0.0).all()
    assert (weights[whole.part != "skin"] == 0.0).all()


def test_the_mandible_turns_fully_and_the_skull_not_at_all(whole):
    weights = jaw_weights()
    assert ((weights >= 0.0) & (weights <= 1.0)).all()
    for part, expected in (
        ("lower_teeth", 1.0),
        ("tongue", 1.0),
        ("upper_teeth", 0.0),
        ("eye_L", 0.0),
    ):
        assert (weights[whole.part == part] == expected).all()
    chin = whole.lay.grid[MOUTH.bottom + 2 : MOUTH.bottom + 4, :4]
    np.testing.assert_allclose(weights[chin], 1.0, atol=0.01)
    np.testing.assert_allclose(weights[whole.lay.grid[:10][whole.lay.grid[:10] >= 0]], 0, atol=0.01)
    np.testing.assert_array_equal(weights[whole.partner], weights)


def test_lips_part_and_share_the_turn_at_their_corner(whole):
    along = jaw_weights()[whole.lay.mouth[lips.CONTACT]]
    assert along[0] < 0.05
    assert along[-1] > 0.95
    assert (np.diff(along) > -1e-3).all()
    assert 0.3 < along[lips.CORNER] < 0.6


def test_lids_do_not_slide(whole):
    grip = lid_grip()
    assert (grip[whole.lay.eye[5:]] == 0.0).all()
    assert (grip[whole.lay.grid[0]] == 1.0).all()
