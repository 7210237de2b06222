"""Poses followed by the neutral's photographs: known deformations of painted surfaces."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from painted import grid, paint, photograph, ring

from elastomorph.capturing.geometry import Similarity, Surface
from elastomorph.capturing.tracking import Matches, Reference, follow
from elastomorph.errors import CaptureError

pytest.importorskip("cv2")
pytest.importorskip("embreex")

REST, TRIANGLES = grid(15)
SIZE = (260, 260)
# A length on the surface that a pixel shows: D of 2.8 in about 0.36 · 2.8 · 260 pixels.
PIXEL = 1 / (0.36 * SIZE[0])


def bulged(amount: float) -> np.ndarray:
    """The square with a bulge that also slides sideways."""
    x, y, z = REST.T
    bump = np.exp(-6 * ((x - 0.1) ** 2 + (y + 0.15) ** 2))
    return np.stack([x + 0.5 * amount * bump, y - 0.3 * amount * bump, z + amount * bump], 1)


@cache
def neutral() -> Reference:
    surface = Surface(REST, TRIANGLES)
    shots = [photograph(camera, surface, REST, paint()) for camera in ring(SIZE, 8)]
    return Reference(REST, TRIANGLES, shots)


@cache
def posed(amount: float) -> tuple:
    surface = Surface(bulged(amount), TRIANGLES)
    cameras = ring(SIZE, 8, seed=8)
    return tuple(photograph(camera, surface, REST, paint(), seed=9) for camera in cameras)


def some_matches(amount: float, count: int = 60) -> Matches:
    random = np.random.default_rng(4)
    which = random.choice(len(REST), count, replace=False)
    found = bulged(amount)[which] + random.normal(0, 0.2 * PIXEL, (count, 3))
    found[:3] += 0.5
    return Matches(REST[which], found)


def test_a_known_deformation_is_found_to_a_tenth_of_a_pixel():
    truth = bulged(0.25)
    found = follow(neutral(), posed(0.25), matches=some_matches(0.25))
    inner = (np.abs(REST[:, :2]) < 0.85).all(axis=1)
    off = np.linalg.norm(found.vertices - truth, axis=1)[inner] / PIXEL
    assert np.linalg.norm(truth - REST, axis=1).max() > 20 * PIXEL
    assert np.median(off) < 0.1
    assert off.max() < 1
    assert found.views[inner].min() >= 4


def test_a_pose_is_followed_from_another_one_without_matches():
    found = follow(neutral(), posed(0.1), start=bulged(0.07))
    off = np.linalg.norm(found.vertices - bulged(0.1), axis=1) / PIXEL
    inner = (np.abs(REST[:, :2]) < 0.85).all(axis=1)
    assert np.median(off[inner]) < 0.1


def test_another_frame_and_another_unit_change_nothing():
    turn = Similarity(37.0, np.array([[0, 0, 1.0], [1, 0, 0], [0, 1, 0]]), np.array([5.0, 3, -70]))
    moved = [replace(view, camera=view.camera.moved(turn)) for view in neutral().views]
    pose = [replace(view, camera=view.camera.moved(turn)) for view in posed(0.1)]
    there = follow(Reference(turn(REST), TRIANGLES, moved), pose, start=turn(bulged(0.07)))
    here = follow(neutral(), posed(0.1), start=bulged(0.07))
    np.testing.assert_allclose(
        turn.inverse()(there.vertices), here.vertices, atol=0.02 * PIXEL, rtol=0
    )


@pytest.mark.parametrize(
    ("views", "matches", "words"),
    [(2, 60, "at least 3 photographs, found 2"), (8, 5, "5 points of the skin")],
)
def test_what_cannot_be_followed_is_said(views, matches, words):
    with pytest.raises(CaptureError, match=words):
        follow(neutral(), posed(0.25)[:views], matches=some_matches(0.25, matches))


def test_another_person_is_said():
    surface = Surface(REST, TRIANGLES)
    other = [photograph(each, surface, REST, paint(5)) for each in ring(SIZE, 6, seed=8)]
    with pytest.raises(CaptureError, match=r"only \d+% of the skin .* one person"):
        follow(neutral(), other)
