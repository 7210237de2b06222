"""Matches of features, with and without known cameras."""

import numpy as np
import pytest
from spotted import cameras, egg, seen

from elastomorph.capturing.cameras.features import (
    Features,
    Guide,
    compared,
    guided,
    neighbours,
    off_lines,
    strongest,
)

EGG = egg()
CAMERAS = cameras()


def test_matches_are_mutual_near_and_distinct():
    looks = np.eye(5, dtype=np.float32)
    np.testing.assert_array_equal(compared(looks, looks[[3, 1]]), [[1, 1], [3, 0]])
    # Two alike in the second photograph: no telling which.
    np.testing.assert_array_equal(compared(looks, looks[[3, 3, 1]]), [[1, 2]])
    halfway = (looks[:2] + looks[1:3]) / np.sqrt(2)
    assert len(compared(halfway, looks)) == 0
    assert compared(looks[:1], looks).shape == (0, 2)


def test_the_strongest_are_the_largest_in_their_order():
    shapes = np.array([[1.0, 0, 0, 1], [3, 0, 0, 3], [0, 2, -2, 0]], dtype=np.float32)
    features = Features(np.zeros((3, 2)), shapes, np.zeros((3, 128), dtype=np.uint8))
    np.testing.assert_allclose(features.sizes, [1, 3, 2])
    np.testing.assert_array_equal(strongest(features, 2), [1, 2])


def test_the_same_points_lie_on_epipolar_lines():
    one, other = CAMERAS[3], CAMERAS[5]
    first, second = (c.distorted(c.project(EGG.points)[0]) for c in (one, other))
    np.testing.assert_allclose(off_lines(one, other, first, second), 0, atol=1e-9)
    # Across the line: the cameras stand beside each other, so up.
    moved = second + np.array([0.0, 13.0])
    off = off_lines(one, other, first, moved) * other.focal
    assert np.median(off) == pytest.approx(13, rel=0.1)


def test_known_cameras_guide_to_more_matches_of_which_none_is_wrong():
    one, other = CAMERAS[4], CAMERAS[6]
    random = np.random.default_rng(4)
    coarse = EGG.points[random.choice(len(EGG.points), 200, replace=False)]
    near = []
    for k, camera in enumerate((one, other)):
        towards = camera.position - coarse
        near.append((camera, seen(camera, EGG, k), coarse[(coarse * towards).sum(axis=1) > 0]))
    first, second = (Guide(*each) for each in near)
    found = guided(first, second)
    plain = compared(near[0][1].unit, near[1][1].unit)
    assert len(found) >= 0.85 * len(plain) > 200
    back = guided(second, first)[:, ::-1]
    np.testing.assert_array_equal(found, back[np.argsort(back[:, 0])])
    off = off_lines(one, other, near[0][1].places[found[:, 0]], near[1][1].places[found[:, 1]])
    assert (off * other.focal < 1.31).all()


def test_neighbours_see_from_alike_directions():
    pairs = neighbours([CAMERAS[0], None, *CAMERAS[2:]], np.zeros(3), widest=30.0)
    assert (2, 3) in pairs
    assert (0, 11) not in pairs
    assert all(1 not in pair and pair[0] < pair[1] for pair in pairs)
