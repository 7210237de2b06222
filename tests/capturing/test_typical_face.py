"""Which way a face looks, by its landmarks, and which of them are not those of one."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import elastomorph as em
from elastomorph.capturing.landmarks import _TYPICAL, require_sides, typical_face
from elastomorph.capturing.work.template import Template
from elastomorph.errors import CaptureError
from small_head import head, landmarks

OTHER = {"left": "right", "right": "left"}


def exchanged(places):
    return {
        "_".join(OTHER.get(word, word) for word in name.split("_")): place
        for name, place in places.items()
    }


def test_which_way_a_face_looks():
    """The typical face itself, anywhere; a list of names on wrong points is no face."""
    points = {
        "nose_tip": (0.0, 0.15, 0.68),
        "left_eye_outer": (0.85, 0.79, -0.13),
        "right_eye_outer": (-0.85, 0.79, -0.13),
        "chin": (0.0, -1.28, 0.16),
        "mouth_left": (0.48, -0.51, 0.14),
    }
    turn = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
    here = {name: 7 * turn @ np.array(at) + [1.0, 2, 3] for name, at in points.items()}
    found = typical_face(here, "here")
    assert found.scale == pytest.approx(7)
    np.testing.assert_allclose(found.rotation, turn, atol=1e-9)
    with pytest.raises(CaptureError, match="here: the landmarks are those of a mirrored face"):
        typical_face({name: at * [1, -1, 1] for name, at in here.items()}, "here")
    wrong = dict(zip(here, [here[name] for name in reversed(here)], strict=True))
    with pytest.raises(CaptureError, match="here: the landmarks do not lie as on a face"):
        typical_face(wrong, "here")
    with pytest.raises(CaptureError, match="here: 1 landmarks, expected at least 4"):
        typical_face({"chin": here["chin"]}, "here")


@pytest.mark.parametrize("angle", [-80, -40, 0, 55])
def test_clicks_of_the_other_side_are_told_in_one_photograph(angle):
    """From the side nothing is certain, and of a few points nothing is."""
    turn = Rotation.from_euler("YX", [angle, 20], degrees=True).as_matrix()
    seen = {
        name: tuple(300 + 90 * (turn @ place)[:2] * [1, -1])
        for name, place in _TYPICAL.items()
        if angle == 0 or name not in ("left_jaw", "right_jaw")
    }
    require_sides(seen, "here")
    if abs(angle) < 60:
        with pytest.raises(CaptureError, match="here: left and right of the landmarks are exch"):
            require_sides(exchanged(seen), "here")
    require_sides(dict(list(exchanged(seen).items())[:5]), "here")


def test_a_template_that_is_inside_out_is_turned():
    ours = Template.of(head())
    face = typical_face({name: head().vertices[own] for name, own in landmarks().items()}, "ours")
    assert ours.facing(face) is ours
    turned = Template.of(em.Mesh(head().vertices, head().faces.triangles()[:, ::-1]))
    assert turned.facing(face).mesh is turned.mesh
    np.testing.assert_array_equal(turned.facing(face).triangles, turned.triangles[:, ::-1])
