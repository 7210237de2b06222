"""Components, and those that turn as a whole."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from elastomorph.model.geometry import connected_parts
from elastomorph.paths.rotations import common_turns
from elastomorph.paths.rotations.quaternions import rotation_vectors

POINTS = np.random.default_rng(7).normal(size=(30, 3))
TURN = Rotation.from_rotvec([0.4, -0.9, 1.7])


def common_turn(start: np.ndarray, end: np.ndarray, diameter: float) -> np.ndarray | None:
    """Of one part, beside parts that stay, are a point, and turn for themselves."""
    still, loose = np.random.default_rng(0).normal(size=(2, 6, 3))
    first = np.concatenate([still, start, loose[:1], loose])
    last = np.concatenate([still, end, loose[:1] + 1.0, -loose])
    numbers = np.split(np.arange(len(first)), [6, 6 + len(start), 7 + len(start)])
    turns, whole = common_turns(first, last, numbers, diameter)
    np.testing.assert_allclose(turns[[0, 2]], [[1, 0, 0, 0]] * 2, atol=1e-12)
    assert whole[[0, 2]].all()
    return turns[1] if whole[1] else None


def vector(quaternion: np.ndarray | None) -> np.ndarray:
    assert quaternion is not None
    return rotation_vectors(quaternion[None])[0]


def test_parts_are_the_connected_components() -> None:
    """In the order of their first vertices, a loose vertex on its own."""
    parts = connected_parts(7, np.array([[0, 4], [4, 2], [3, 6], [6, 3]]))
    assert [part.tolist() for part in parts] == [[0, 2, 4], [1], [3, 6], [5]]
    assert [part.tolist() for part in connected_parts(2, np.zeros((0, 2), int))] == [[0], [1]]


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_a_rigid_motion_is_found(scale: float) -> None:
    moved = scale * (TURN.apply(POINTS) + [5, 6, 7])
    np.testing.assert_allclose(
        vector(common_turn(scale * POINTS, moved, scale)), TURN.as_rotvec(), atol=1e-7
    )


def test_a_rigid_motion_with_noise_is_found_up_to_the_tolerance() -> None:
    """A thousandth of D, but never more than 2 % of the radius of the part."""
    noise = np.random.default_rng(8).uniform(-1, 1, POINTS.shape)
    radius = np.linalg.norm(POINTS - POINTS.mean(axis=0), axis=1).max()
    moved = TURN.apply(POINTS)
    assert common_turn(POINTS, moved + 0.002 * noise, 10.0) is not None
    assert common_turn(POINTS, moved + 0.02 * noise, 10.0) is None
    assert common_turn(POINTS, moved + 0.03 * radius * noise, 1e4 * radius) is None


def test_an_affine_map_turns_by_its_polar_factor() -> None:
    stretch = np.array([[1.5, 0.2, 0.0], [0.2, 0.7, -0.1], [0.0, -0.1, 1.1]])
    moved = TURN.apply(POINTS @ stretch) - [3, 0, 1]
    np.testing.assert_allclose(vector(common_turn(POINTS, moved, 1.0)), TURN.as_rotvec(), atol=1e-7)
    np.testing.assert_allclose(vector(common_turn(POINTS, POINTS @ stretch, 1.0)), 0, atol=1e-9)


@pytest.mark.parametrize("flat", [[1, 1, 0], [1, 0, 0], [0, 0, 0]])
def test_flat_thin_and_vanished_parts_have_a_turn_too(flat: list[int]) -> None:
    """A part in a plane, on a line or at a point, and one that shrinks to a point."""
    points = POINTS * flat
    found = common_turn(points, TURN.apply(points) + 1.0, 1.0)
    assert found is not None
    centred = points - points.mean(axis=0)
    carried = Rotation.from_quat(np.roll(found, -1)).apply(centred)
    np.testing.assert_allclose(carried, TURN.apply(centred), atol=1e-7)
    np.testing.assert_allclose(vector(common_turn(points, 0 * points + 2.0, 1.0)), 0, atol=1e-12)


def test_a_part_that_bends_has_no_common_turn() -> None:
    bent = POINTS.copy()
    bent[:15] = TURN.apply(bent[:15])
    assert common_turn(POINTS, bent, 1.0) is None


def test_no_parts_have_no_turns() -> None:
    turns, whole = common_turns(POINTS, POINTS, [], 1.0)
    assert turns.shape == (0, 4)
    assert whole.shape == (0,)
