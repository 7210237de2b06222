"""Rotations of covariances and of parts are those that made them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from elastomorph.model.geometry import connected_parts
from elastomorph.paths.rotations import common_turns
from elastomorph.paths.rotations.vertex_rotations import (
    aligned_with,
    nearest_quaternions,
    rotated,
    rotation_vectors,
)


def matrices(quaternions: NDArray[np.float64]) -> NDArray[np.float64]:
    return Rotation.from_quat(np.roll(quaternions, -1, axis=1)).as_matrix()


def test_the_nearest_rotation_is_the_polar_factor_of_kabsch() -> None:
    """Maximising tr(RC) over rotations, against the singular value decomposition."""
    covariances = np.random.default_rng(1).normal(size=(200, 3, 3))
    left, _, right = np.linalg.svd(covariances)
    sign = np.sign(np.linalg.det(left @ right))
    left[:, :, 2] *= sign[:, None]
    expected = (left @ right).transpose(0, 2, 1)
    found = matrices(nearest_quaternions(covariances))
    np.testing.assert_allclose(found, expected, atol=1e-8)


@pytest.mark.parametrize("rank", [1, 2, 3])
@pytest.mark.parametrize("degrees", [0.0, 1e-5, 30.0, 170.0])
def test_rotated_vectors_give_their_rotation(rank: int, degrees: float) -> None:
    """Vectors of any rank are carried exactly; a plane of them determines the rotation."""
    rng = np.random.default_rng(rank)
    before = rng.normal(size=(20, rank)) @ rng.normal(size=(rank, 3))
    turn = Rotation.from_rotvec(np.radians(degrees) * np.array([2.0, -1.0, 2.0]) / 3.0)
    after = turn.apply(before)
    found = nearest_quaternions((before.T @ after)[None])
    np.testing.assert_allclose(before @ matrices(found)[0].T, after, atol=1e-7)
    if rank > 1:
        np.testing.assert_allclose(rotation_vectors(found)[0], turn.as_rotvec(), atol=1e-7)
    else:
        assert np.linalg.norm(rotation_vectors(found)) <= np.radians(degrees) + 1e-7


@pytest.mark.parametrize("size", [0.0, 1e-150, 1e150])
def test_nothing_known_is_no_turn(size: float) -> None:
    """No edges, or edges of any size that do not turn, are the identity."""
    found = nearest_quaternions(size * np.eye(3)[None])
    np.testing.assert_allclose(found, [[1, 0, 0, 0]], atol=1e-12)


def test_well_and_badly_determined_rotations_are_as_good_as_a_full_decomposition() -> None:
    """From directions that differ to ones that hardly do, at every size; tr(RC) is no smaller."""
    rng = np.random.default_rng(11)
    sizes = 10.0 ** rng.uniform(-9, 0, size=(2000, 3))
    frames = Rotation.random(4000, random_state=3).as_matrix().reshape(2, -1, 3, 3)
    signs = np.where(rng.random(2000) < 0.3, -1.0, 1.0)
    sizes[:, 2] *= signs
    c = 1e3 * frames[0] @ (sizes[:, :, None] * frames[1])
    left, s, right = np.linalg.svd(c)
    s[:, 2] *= np.sign(np.linalg.det(left @ right))
    found = matrices(nearest_quaternions(c))
    reached = np.einsum("nij,nji->n", found, c)
    np.testing.assert_allclose(reached, s.sum(axis=1), rtol=1e-9)


def test_points_are_turned_as_by_matrices() -> None:
    quaternions = np.roll(Rotation.random(20, random_state=2).as_quat(), 1, axis=1)
    points = np.random.default_rng(2).normal(size=(20, 3))
    expected = np.einsum("nij,nj->ni", matrices(quaternions), points)
    np.testing.assert_allclose(rotated(quaternions, points), expected, atol=1e-12)


def test_a_symmetric_stretch_is_no_turn() -> None:
    rng = np.random.default_rng(4)
    root = rng.normal(size=(50, 3, 3))
    found = nearest_quaternions(root @ root.transpose(0, 2, 1))
    np.testing.assert_allclose(rotation_vectors(found), 0.0, atol=1e-9)


def test_vectors_are_those_of_scipy() -> None:
    turns = Rotation.random(300, random_state=5)
    quaternions = np.roll(turns.as_quat(canonical=True), 1, axis=1)
    np.testing.assert_allclose(rotation_vectors(quaternions), turns.as_rotvec(), atol=1e-12)


def test_small_vectors_keep_their_digits() -> None:
    vector = np.array([[3e-12, -4e-12, 0.0]])
    quaternion = np.concatenate([[[1.0]], vector / 2], axis=1)
    np.testing.assert_allclose(rotation_vectors(quaternion), vector, rtol=1e-12)


def test_beside_a_neighbour_a_turn_may_exceed_half_a_turn_but_not_240_degrees() -> None:
    """200° about x beside one of 170° stays 200°, not -160°; 300° is -60° all the same."""

    def about_x(degrees: float) -> NDArray[np.float64]:
        half = np.radians(degrees) / 2
        return np.array([[np.cos(half), np.sin(half), 0.0, 0.0]])

    def beside(degrees: float) -> float:
        turn = aligned_with(about_x(degrees), 3.0 * about_x(170.0))
        return float(np.degrees(rotation_vectors(turn)[0, 0]))

    assert beside(-160.0) == pytest.approx(200.0)
    assert beside(-60.0) == pytest.approx(-60.0)
    assert beside(20.0) == pytest.approx(20.0)
    assert beside(200.0) == pytest.approx(200.0)


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


@pytest.mark.parametrize("noise", [0.0, 1e-9, 1e-6])
def test_a_part_that_shrinks_to_a_line_turns_as_little_as_the_line(noise: float) -> None:
    """Across the line is noise: the smallest turn that carries one line to the other is left."""
    rng = np.random.default_rng(2)
    before = rng.normal(size=(40, 3))
    direction = Rotation.from_rotvec([0.0, 0.0, 0.7]).apply([1.0, 0.0, 0.0])
    after = before[:, :1] * direction + noise * rng.normal(size=before.shape)
    turns, as_one = common_turns(before, after, [np.arange(40)], 1e3)
    assert as_one.all()
    np.testing.assert_allclose(rotation_vectors(turns)[0], [0, 0, 0.7], atol=1e-5)


@pytest.mark.parametrize("noise", [0.0, 1e-4])
@pytest.mark.parametrize("grows", [False, True])
def test_a_part_that_shrinks_to_a_point_does_not_turn(noise: float, grows: bool) -> None:
    """Even where the noise that is left of it is as large as its edges are short."""
    rng = np.random.default_rng(3)
    whole, point = rng.normal(size=(40, 3)), noise * rng.normal(size=(40, 3))
    ends = (point, whole) if grows else (whole, point)
    turns, as_one = common_turns(*ends, [np.arange(40)], 1e3)
    assert as_one.all()
    np.testing.assert_array_equal(turns, [[1, 0, 0, 0]])


@pytest.mark.parametrize(("size", "turns"), [(0.0009, False), (0.0011, True)])
def test_a_thousandth_is_where_a_part_is_a_point(size: float, turns: bool) -> None:
    whole = np.random.default_rng(4).normal(size=(40, 3))
    small = size * Rotation.from_rotvec([0.0, 0.8, 0.0]).apply(whole)
    found, _ = common_turns(whole, small, [np.arange(40)], 1e3)
    np.testing.assert_allclose(rotation_vectors(found)[0], [0, 0.8 * turns, 0], atol=1e-9)
