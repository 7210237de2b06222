"""How a head turns: the signs, the order of the angles, and the point that stays."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import elastomorph as em
from elastomorph.errors import ParameterError
from elastomorph.rig.performance import HeadTurn, angles_of, head_quaternions, head_rotations

QUARTER = np.pi / 2
NOSE, CROWN, LEFT_EAR = np.eye(3)[[2, 1, 0]]
"""A face looks along +Z with +Y up, so that its own left is +X."""


@pytest.mark.parametrize(
    ("angles", "nose", "crown"),
    [
        ((QUARTER, 0, 0), -LEFT_EAR, CROWN),  # to its own right
        ((0, QUARTER, 0), -CROWN, NOSE),  # down
        ((0, 0, QUARTER), NOSE, LEFT_EAR),  # leaned to its own left
        ((QUARTER, QUARTER, 0), -CROWN, -LEFT_EAR),  # down, then to the right about the upright
    ],
)
def test_quarter_turns_go_where_a_head_goes(
    angles: tuple[float, ...], nose: np.ndarray, crown: np.ndarray
) -> None:
    (turned,) = head_rotations([angles])
    np.testing.assert_allclose(turned @ NOSE, nose, atol=1e-15)
    np.testing.assert_allclose(turned @ CROWN, crown, atol=1e-15)


@given(arrays(float, (3,), elements=st.floats(-4, 4)))
def test_it_rolls_then_nods_then_turns(angles: np.ndarray) -> None:
    (yaw, pitch, roll), still = angles, (0.0, 0.0, 0.0)
    apart = head_rotations([(yaw, 0, 0), (0, pitch, 0), (0, 0, roll), still])
    whole = head_rotations([angles])[0]
    np.testing.assert_allclose(whole, apart[0] @ apart[1] @ apart[2], atol=1e-12)
    np.testing.assert_array_equal(apart[3], np.eye(3))


@given(
    arrays(float, (3,), elements=st.floats(-1.5, 1.5)),
    arrays(float, (5, 3), elements=st.floats(-0.6, 0.6)),
)
def test_quaternions_give_the_angles_back(first: np.ndarray, steps: np.ndarray) -> None:
    """Of a head that goes on from where it was, also past where it looks straight down."""
    angles = np.cumsum(np.vstack([first, steps]), axis=0)
    assume((np.abs(np.cos(angles[:, 1])) > 0.01).all())  # there, yaw and roll are one turn
    np.testing.assert_allclose(angles_of(head_quaternions(angles)), angles, atol=1e-7)


@given(arrays(float, (6, 3), elements=st.floats(-4, 4)))
def test_angles_that_come_back_turn_alike(angles: np.ndarray) -> None:
    """Wherever the head jumps to; and each quaternion is on the side of the one before."""
    found = head_quaternions(angles)
    turned = head_rotations(angles_of(found))
    np.testing.assert_allclose(turned, head_rotations(angles), atol=1e-7)
    assert (np.einsum("ij,ij->i", found[1:], found[:-1]) >= 0).all()


def test_quaternions_go_the_short_way_through_whole_turns() -> None:
    """Yaw from 0 to two turns in small steps: no quaternion is far from the one before."""
    yaw = np.linspace(0, 4 * np.pi, 100)
    found = head_quaternions(np.column_stack([yaw, 0 * yaw, 0 * yaw]))
    assert np.linalg.norm(np.diff(found, axis=0), axis=1).max() < 0.1


def test_the_neck_stays_where_it_is() -> None:
    neck = np.array([1.0, 2.0, 3.0])
    turn = HeadTurn(neck, np.array([[0, 0, 0], [QUARTER, 0, 0]]))
    points = np.array([neck, neck + NOSE, neck + CROWN])
    np.testing.assert_allclose(turn.of(points, 0), points)
    np.testing.assert_allclose(turn.of(points, 1), [neck, neck - LEFT_EAR, neck + CROWN])
    np.testing.assert_array_equal(turn.only(np.array([1])).angles, turn.angles[1:])


def test_a_performance_knows_its_head_in_any_capitals() -> None:
    take = em.Performance(["jawOpen", "headPitch", "HEADYAW"], [0, 1], [[1, 2, 3], [4, 5, 6]], 30)
    np.testing.assert_array_equal(take.head, [[3, 2, 0], [6, 5, 0]])
    assert not em.Performance(["jawOpen"], [0], [[1]], 30).head.any()


def test_other_shapes_are_refused() -> None:
    for wrong in ([0.0, 0.0, 0.0], [[0.0, 0.0]], [[0.0, np.nan, 0.0]]):
        with pytest.raises(ParameterError, match=r"shape \(T, 3\)"):
            head_rotations(wrong)
        with pytest.raises(ParameterError, match=r"shape \(T, 3\)"):
            HeadTurn(NOSE, wrong)  # type: ignore[arg-type]
    for neck in ([0.0, 0.0], [np.nan, 0.0, 0.0], "middle"):
        with pytest.raises(ParameterError, match="the neck must be"):
            HeadTurn(neck, [[0.0, 0.0, 0.0]])  # type: ignore[arg-type]


def test_a_turn_of_lists_is_one_of_arrays() -> None:
    turn = HeadTurn([0, 0, 0], [[QUARTER, 0, 0]])  # type: ignore[arg-type]
    np.testing.assert_allclose(turn.of(NOSE, 0), -LEFT_EAR, atol=1e-15)
