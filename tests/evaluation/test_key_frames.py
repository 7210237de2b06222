"""The search for key frames, against an independent and exhaustive one."""

from __future__ import annotations

from itertools import combinations
from math import comb, inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from elastomorph.evaluation.inbetweens import (
    Choice,
    LargestError,
    MeanSquare,
    best_frames,
    cardinal_weights,
)
from elastomorph.paths.through import LAWS, cardinal_curves

FRAMES, VERTICES = 11, 12
STARTS, COUNTS = np.array([0, 3, 8]), np.array([3, 5, 4])


def times(seed: int) -> np.ndarray:
    steps = np.random.default_rng(seed).uniform(0.5, 1.5, FRAMES - 1)
    return np.concatenate([[0.0], np.cumsum(steps) / steps.sum()])


def offsets(seed: int) -> np.ndarray:
    """Motions from 0 to 0, each axis of each vertex a wave of its own."""
    rng = np.random.default_rng(seed)
    waves = rng.normal(size=(4, VERTICES, 3))
    t = times(seed)
    basis = np.stack([np.sin(np.pi * k * t) / k for k in range(1, 5)], axis=1)
    return np.tensordot(basis, waves, axes=1) + 0.05 * (
        rng.normal(size=(FRAMES, VERTICES, 3)) * (t * (1 - t))[:, None, None]
    )


def distances(seed: int, frames: tuple[int, ...]) -> np.ndarray:
    """(T, N) from the spline of scipy through the frames."""
    t, values = times(seed), offsets(seed)
    keys = [0, *frames, FRAMES - 1]
    spline = CubicSpline(t[keys], np.where(np.isin(keys, frames)[:, None, None], values[keys], 0),
                         bc_type="natural")  # fmt: skip
    return np.linalg.norm(spline(t) - values, axis=2)


def largest(seed: int, frames: tuple[int, ...]) -> float:
    return float(distances(seed, frames).max())


def largest_mean(seed: int, frames: tuple[int, ...]) -> float:
    groups = np.split(distances(seed, frames), STARTS[1:], axis=1)
    return max(float(group.mean(axis=1).max()) for group in groups)


def root_mean_square(seed: int, frames: tuple[int, ...]) -> float:
    return float(np.sqrt((distances(seed, frames) ** 2).mean()))


def judge(name: str, seed: int) -> LargestError | MeanSquare:
    if name == "mean square":
        return MeanSquare(offsets(seed), times(seed))
    if name == "groups":
        return LargestError(offsets(seed), times(seed), STARTS, COUNTS)
    each = np.arange(VERTICES)
    return LargestError(offsets(seed), times(seed), each, np.ones_like(each))


MEASURED = {"vertices": largest, "groups": largest_mean, "mean square": root_mean_square}


@pytest.mark.parametrize("name", MEASURED)
@pytest.mark.parametrize("seed", range(4))
def test_the_best_of_all_choices_is_found(name: str, seed: int) -> None:
    measured = MEASURED[name]
    for choice in best_frames(judge(name, seed), 3, effort=inf):
        size = len(choice.frames)
        every = {
            frames: measured(seed, frames) for frames in combinations(range(1, FRAMES - 1), size)
        }
        assert choice.certain
        assert choice.error == pytest.approx(min(every.values()), rel=1e-9)
        assert every[choice.frames] == pytest.approx(choice.error, rel=1e-9)


@pytest.mark.parametrize("name", MEASURED)
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("effort", [0, 300, 700])
def test_without_comparing_all_no_exchange_of_one_frame_helps(
    name: str, seed: int, effort: float
) -> None:
    measured = MEASURED[name]
    best = best_frames(judge(name, seed), 4, effort=inf)
    quick = best_frames(judge(name, seed), 4, effort=effort)
    assert quick[0] == best[0]
    for ours, known in zip(quick[1:], best[1:], strict=True):
        assert ours.error >= known.error * (1 - 1e-9)
        assert measured(seed, ours.frames) == pytest.approx(ours.error, rel=1e-9)
        for i in range(len(ours.frames)):
            for other in set(range(1, FRAMES - 1)) - set(ours.frames):
                exchanged = sorted((*ours.frames[:i], other, *ours.frames[i + 1 :]))
                assert measured(seed, tuple(exchanged)) >= ours.error * (1 - 1e-9)
    for size, choice in enumerate(quick[1:], start=2):
        assert choice.certain == (comb(FRAMES - 2, size) * FRAMES <= effort)


@pytest.mark.parametrize("name", MEASURED)
def test_a_judge_keeps_what_is_known_where_nothing_is_better(name: str) -> None:
    known = Choice((3,), 1e-9)
    every = np.arange(1, FRAMES - 1)[:, None]
    assert judge(name, 0).best(every, known) is known
    assert judge(name, 0).best(every[:0], known) is known


@pytest.mark.parametrize("name", MEASURED)
def test_all_frames_leave_no_error(name: str) -> None:
    last = best_frames(judge(name, 1), FRAMES - 2)[-1]
    assert last.frames == tuple(range(1, FRAMES - 1))
    assert last.error == pytest.approx(0, abs=1e-7)


def test_what_is_being_chosen_is_told() -> None:
    said: list[str] = []
    best_frames(judge("vertices", 0), 2, progress=said.append)
    assert said == [f"choosing 1 of {FRAMES - 2} frames", f"choosing 2 of {FRAMES - 2} frames"]


@pytest.mark.parametrize("law", LAWS)
@given(
    st.lists(
        st.lists(st.integers(1, 99), min_size=3, max_size=3, unique=True), min_size=1, max_size=5
    )
)
@settings(max_examples=40, deadline=None)
def test_many_choices_at_once_are_the_curves_one_by_one(law: str, choices: list[list[int]]) -> None:
    keys = np.sort(np.array(choices), axis=1) / 100
    grid = np.linspace(0, 1, 101)
    for row, values in zip(keys, cardinal_weights(keys, grid, law), strict=True):
        for curve, column in zip(cardinal_curves(row.tolist(), law), values.T, strict=True):
            np.testing.assert_allclose(column, curve(grid), atol=1e-9 * np.abs(column).max())


def hump(height: float) -> np.ndarray:
    """(5, 2, 3): two vertices that rest, but for the second in the middle frame."""
    offsets = np.zeros((5, 2, 3))
    offsets[2, 1] = [0, 0.6 * height, 0.8 * height]
    return offsets


@pytest.mark.parametrize("frame", [1, 3])
def test_a_frame_that_rests_leaves_the_hump(frame: int) -> None:
    """By hand: the spline through a shape of no offset is straight, so all of the hump is left."""
    times, choices = np.linspace(0, 1, 5), np.array([[frame]])
    nothing = Choice((), np.inf)
    each, pair = np.array([0, 1]), np.array([0])
    found = LargestError(hump(2.0), times, each, np.ones(2, int)).best(choices, nothing)
    assert found == Choice((frame,), pytest.approx(2.0))
    found = LargestError(hump(2.0), times, pair, np.array([2])).best(choices, nothing)
    assert found == Choice((frame,), pytest.approx(1.0))
    found = MeanSquare(hump(2.0), times).best(choices, nothing)
    assert found == Choice((frame,), pytest.approx((2.0**2 / 10) ** 0.5))


def test_the_frame_of_the_hump_swings_beside_it() -> None:
    """By hand: b(1/4) = 3/4 - 4/64 of the cardinal spline at ½ is all error at frames 1 and 3."""
    times, choices = np.linspace(0, 1, 5), np.array([[2]])
    judge = LargestError(hump(2.0), times, np.array([0, 1]), np.ones(2, int))
    assert judge.best(choices, Choice((), np.inf)).error == pytest.approx(2.0 * 11 / 16)
    square = MeanSquare(hump(2.0), times).best(choices, Choice((), np.inf)).error ** 2
    assert square == pytest.approx(2 * (2.0 * 11 / 16) ** 2 / 10)
