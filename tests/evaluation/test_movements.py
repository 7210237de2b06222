"""Movements found in takes whose movements are known."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

import elastomorph as em
from elastomorph.errors import MeshError, ParameterError
from elastomorph.evaluation import Movement, find_movements, resting_pose
from elastomorph.evaluation.evaluation import every_method
from elastomorph.evaluation.movements import (
    JudgedMovement,
    activity,
    evaluate_movements,
    mean_lines,
)
from elastomorph.io.sequences import read_recording
from elastomorph.io.vertex_lists import read_curves

PLAIN = {"smoothing": 0.0}


def take(level: NDArray[np.float64]) -> NDArray[np.float64]:
    """(T, 4, 3) a square of D = 10 of which every marker is `level` of D from its rest."""
    square = np.array([[0.0, 0, 0], [6, 0, 0], [6, 8, 0], [0, 8, 0]])
    return square + 10 * level[:, None, None] * np.array([0.0, 0.6, 0.8])


def ramp(rest: int, rise: int, hold: int, fall: int, height: float) -> NDArray[np.float64]:
    """Rest, a straight rise, an apex that is held, a straight fall."""
    return np.concatenate(
        [
            np.zeros(rest),
            np.linspace(0, height, rise, endpoint=False),
            np.full(hold, height),
            np.linspace(height, 0, fall, endpoint=False),
        ]
    )


def test_activity_is_the_rms_distance_over_d() -> None:
    """Computed by hand: two of four markers are off by 3 and 4, D is 10."""
    rest = take(np.zeros(1))[0]
    moved = rest.copy()
    moved[0, 2] = 3
    moved[2, 2] = -4
    level = activity(np.stack([rest, moved]), rest)
    np.testing.assert_allclose(level, [0, 0.25])


def test_onset_and_offset_of_a_ramp() -> None:
    """Cut at 12 % and 88 % of the rise: frames known to the number."""
    level = np.concatenate([ramp(40, 20, 30, 40, 0.1), np.zeros(60)])
    assert find_movements(take(level), edge=0.12, **PLAIN) == [
        Movement(42, 58, "onset"),  # 0.005 a frame from frame 40 on: 0.01 at 42, 0.09 at 58
        Movement(94, 126, "offset"),  # 0.0025 a frame from frame 90 on: 0.09 at 94, 0.01 at 126
    ]


def test_a_reversed_take_swaps_onset_and_offset() -> None:
    """Time has no preferred direction."""
    rng = np.random.default_rng(3)
    level = np.concatenate([ramp(50, 15, 20, 25, 0.08), ramp(40, 30, 25, 12, 0.05), np.zeros(45)])
    frames = take(level) + rng.normal(scale=1e-3, size=(len(level), 4, 3))
    forth, back = find_movements(frames), find_movements(frames[::-1])
    last = len(level) - 1
    swapped = [
        Movement(last - m.stop, last - m.start, "offset" if m.kind == "onset" else "onset")
        for m in reversed(back)
    ]
    assert len(forth) == 4
    assert forth == swapped


def test_a_movement_cut_off_by_the_take_is_left_out() -> None:
    """Its rest, and so its beginning or end, was never recorded."""
    starts_high = np.concatenate([ramp(0, 0, 20, 20, 0.1), np.zeros(60)])
    ends_high = np.concatenate([np.zeros(60), ramp(0, 20, 20, 0, 0.1)])
    assert [m.kind for m in find_movements(take(starts_high), **PLAIN)] == ["offset"]
    assert [m.kind for m in find_movements(take(ends_high), **PLAIN)] == ["onset"]
    # Smoothing must not pull a low apex at the end of a take down to rest.
    assert [m.kind for m in find_movements(take(0.08 * starts_high))] == ["offset"]
    assert [m.kind for m in find_movements(take(0.08 * ends_high))] == ["onset"]


def test_small_and_short_movements_are_left_out() -> None:
    """Below the least rise, or within too few frames."""
    small = np.concatenate([ramp(60, 20, 20, 20, 0.004), np.zeros(60)])
    assert find_movements(take(small), **PLAIN) == []
    assert len(find_movements(take(small), least_rise=0.002, **PLAIN)) == 2
    short = np.concatenate([ramp(60, 3, 20, 20, 0.1), np.zeros(60)])
    assert [m.kind for m in find_movements(take(short), **PLAIN)] == ["offset"]
    assert find_movements(take(np.zeros(50))) == []


def line(*points: tuple[int, float]) -> NDArray[np.float64]:
    """Straight from (frame, level) to (frame, level)."""
    frames, levels = zip(*points, strict=True)
    return np.interp(np.arange(frames[-1] + 1), frames, levels)


# Up to 0.10, back to 0.063, on to 0.12 at once; then down in two goes, back up by 0.04 between.
SPEECH = line(
    (0, 0), (40, 0), (60, 0.1), (70, 0.063), (90, 0.12), (120, 0.12), (140, 0.05), (150, 0.09),
    (180, 0), (260, 0),
)  # fmt: skip


def test_a_movement_that_turns_back_is_split_at_the_turn() -> None:
    """The onset turns back by 0.037 of 0.12, the offset by 0.04 of it: 31 % and 33 %."""
    found = find_movements(take(SPEECH), edge=0.0, **PLAIN)
    assert found == [
        Movement(40, 60, "onset"),
        Movement(60, 70, "offset"),
        Movement(70, 90, "onset"),
        Movement(120, 140, "offset"),
        Movement(140, 150, "onset"),
        Movement(150, 180, "offset"),
    ]
    whole = [Movement(40, 90, "onset"), Movement(120, 180, "offset")]
    assert find_movements(take(SPEECH), edge=0.0, turn=0.34, **PLAIN) == whole
    assert len(find_movements(take(SPEECH), edge=0.0, turn=0.32, **PLAIN)) == 4


def test_the_parts_of_a_split_have_their_edges_cut_off() -> None:
    """12 % at either end of each: 20 frames lose 2, 10 frames lose 1."""
    found = find_movements(take(SPEECH), edge=0.12, **PLAIN)
    assert [(m.start, m.stop) for m in found[:3]] == [(42, 58), (61, 69), (72, 88)]


def test_a_turn_smaller_than_a_movement_splits_without_being_one() -> None:
    """It turns back by 0.004 of a rise of 0.01, and a movement reaches 0.005 at least."""
    level = line((0, 0), (40, 0), (60, 0.01), (70, 0.006), (90, 0.012), (120, 0.012), (140, 0),
                 (220, 0))  # fmt: skip
    found = find_movements(take(level), edge=0.0, **PLAIN)
    assert [(m.start, m.stop) for m in found] == [(40, 60), (70, 90), (120, 140)]


def turned_back(level: NDArray[np.float64], move: Movement) -> float:
    """How far a movement turns back, as a share of its rise."""
    own = level[move.start : move.stop + 1]
    rising = own if move.kind == "onset" else -own
    back = max(max(rising[: i + 1]) - rising[i] for i in range(len(rising)))
    return float(back / (rising[-1] - rising[0]))


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("turn", [0.05, 0.25, 0.6])
def test_no_movement_turns_back_farther_than_allowed(seed: int, turn: float) -> None:
    """On walks at random; played backwards, the same movements swap their kinds."""
    rng = np.random.default_rng(seed)
    walk = gaussian_filter1d(rng.normal(size=600).cumsum(), 4)
    level = np.concatenate([np.zeros(700), 0.2 * np.abs(walk) / np.abs(walk).max(), np.zeros(60)])
    found = find_movements(take(level), turn=turn, **PLAIN)
    assert found
    for move in found:
        # Measured on what is left of the rise without 5 % at either end.
        assert turned_back(level, move) <= turn / 0.9 * (1 + 1e-9)
    last = len(level) - 1
    back = find_movements(take(level[::-1]), turn=turn, **PLAIN)
    assert {(last - m.stop, last - m.start, m.kind) for m in back} == {
        (m.start, m.stop, "offset" if m.kind == "onset" else "onset") for m in found
    }


def test_the_resting_pose_is_the_one_held_longest() -> None:
    """Even if the face rests for just over half of the take."""
    level = np.concatenate([ramp(25, 10, 30, 10, 0.2), np.zeros(30)])
    rest = take(np.zeros(1))[0]
    np.testing.assert_allclose(resting_pose(take(level)), rest, atol=1e-12)
    noisy = take(level) + np.random.default_rng(1).normal(scale=0.1, size=(len(level), 4, 3))
    plain = np.linalg.norm(np.median(noisy, axis=0) - rest)
    assert np.linalg.norm(resting_pose(noisy) - rest) < 0.6 * plain


def test_a_slow_drift_of_the_rest_is_no_movement() -> None:
    """Only the quietest of the frames within reach counts as rest."""
    before = np.concatenate([np.zeros(30), np.full(120, 0.004)])
    level = np.concatenate([before, np.linspace(0.004, 0.05, 20), np.full(20, 0.05)])
    level = np.concatenate([level, level[::-1]])
    found = find_movements(take(level), rest=take(np.zeros(1))[0], **PLAIN)
    assert [(m.start >= 145, m.stop <= 234) for m in found] == [(True, True), (True, True)]
    far = find_movements(take(level), rest=take(np.zeros(1))[0], reach=200, **PLAIN)
    assert far[0].start < 30
    assert far[1].stop >= 350


def test_settings_and_takes_that_make_no_sense_are_refused() -> None:
    """By name."""
    still = take(np.zeros(5))
    for setting in ({"least_rise": 0}, {"edge": 0.5}, {"smoothing": -1}, {"shortest": 1},
                    {"turn": 0}, {"turn": 1.1}):  # fmt: skip
        with pytest.raises(ParameterError, match=f"{next(iter(setting))} must be"):
            find_movements(still, **setting)  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="reach must be 1 or more, found 0"):
        find_movements(still, reach=0)
    with pytest.raises(MeshError, match=r"shape \(T, N, 3\)"):
        find_movements(np.zeros((5, 3)))
    still[3, 1, 2] = np.nan
    with pytest.raises(MeshError, match="frame 3"):
        find_movements(still)
    with pytest.raises(MeshError, match="D is 0"):
        find_movements(np.zeros((5, 4, 3)))


@pytest.mark.realdata
@pytest.mark.parametrize("name", ["jaw", "eyebrows"])
def test_movements_of_a_real_take(data_dir: Path, name: str) -> None:
    """They alternate, do not overlap, and lead away from rest and back."""
    with np.load(data_dir / "animface" / f"{name}.npz", allow_pickle=False) as file:
        frames = file["stab"].astype(float)
    found = find_movements(frames)
    assert [m.kind for m in found[:2]] == ["onset", "offset"]
    assert sum(m.kind == "onset" for m in found) >= 3
    assert sum(m.kind == "offset" for m in found) >= 3
    level = activity(frames, resting_pose(frames))
    for movement, following in zip(found, [*found[1:], None], strict=True):
        rise = level[movement.stop] - level[movement.start]
        assert rise > 0.004 if movement.kind == "onset" else rise < -0.004
        if following is not None:
            assert movement.stop <= following.start
            assert movement.kind != following.kind


@pytest.mark.realdata
def test_movements_of_the_jaw_take_are_split_where_they_turn(data_dir: Path) -> None:
    """Two of its movements turn back by 21 % and 18 %: they are split where less is allowed."""
    with np.load(data_dir / "animface" / "jaw.npz", allow_pickle=False) as file:
        frames = file["stab"].astype(float)
    level = gaussian_filter1d(activity(frames, resting_pose(frames)), 3.0, mode="nearest")
    found = find_movements(frames)
    turning = [move for move in found if turned_back(level, move) > 0.1 / 0.9]
    assert [round(turned_back(level, move), 2) for move in turning] == [0.21, 0.18]
    parts = find_movements(frames, turn=0.1)
    assert max(turned_back(level, move) for move in parts) <= 0.1 / 0.9
    assert [move for move in found if move in parts] == [m for m in found if m not in turning]
    for whole in turning:
        inside = [m for m in parts if whole.start - 3 <= m.start and m.stop <= whole.stop + 3]
        assert inside
        assert whole not in inside


CURVES = Path(__file__).parents[2] / "benchmarks" / "animface_curves.json"


def smooth_take() -> em.MeshSequence:
    """Twice from rest to an apex and back, along a straight line, in smooth steps."""
    rise = (1 - np.cos(np.pi * np.arange(31) / 30)) / 2
    level = np.concatenate([np.zeros(40), rise, np.ones(20), rise[::-1], np.zeros(40)] * 2)
    rest = np.random.default_rng(0).normal(size=(6, 3))
    moved = np.random.default_rng(1).normal(size=(6, 3)) * 0.3
    return em.MeshSequence(em.Mesh(rest), rest + level[:, None, None] * moved)


def test_two_onsets_and_two_offsets_are_judged_alike() -> None:
    """The movements are the same forwards and backwards, so are their errors."""
    take = smooth_take()
    network = em.CurveNetwork([em.Curve(np.arange(6), False)], 6)
    judged = evaluate_movements(take, network, lambda _: ["linear", "cosine"])
    assert [one.movement.kind for one in judged] == ["onset", "offset"] * 2
    errors = [one.evaluation["linear"].lme * one.evaluation.diameter for one in judged]
    np.testing.assert_allclose(errors, errors[0], rtol=1e-6)
    means = mean_lines(judged)
    assert list(means) == ["Mean over 2 onsets", "Mean over 2 offsets", "Mean over 4 movements"]
    first, second = (judged[i].evaluation["linear"].lme for i in (0, 2))
    assert means["Mean over 2 onsets"][0].lme == pytest.approx((first + second) / 2)
    assert means["Mean over 4 movements"][0].path_lme < 1e-9


def test_a_still_take_is_refused() -> None:
    rest = np.random.default_rng(0).normal(size=(6, 3))
    take = em.MeshSequence(em.Mesh(rest), np.stack([rest] * 90))
    network = em.CurveNetwork([em.Curve(np.arange(6), False)], 6)
    with pytest.raises(em.ParameterError, match="no movement"):
        evaluate_movements(take, network, lambda _: ["linear"])


@pytest.fixture(scope="module")
def captured(data_dir: Path) -> list[JudgedMovement]:
    """Every movement of two takes, by every method."""
    found = []
    for name in ("jaw", "eyebrows"):
        take = read_recording(data_dir / "animface" / f"{name}.npz")
        network = em.CurveNetwork(read_curves(CURVES, len(take.names), take.names), len(take.names))
        found += evaluate_movements(take.motion, network, partial(every_method, curves=network))
    return found


@pytest.mark.slow
@pytest.mark.realdata
def test_in_betweens_pay_on_real_captures(captured: list[JudgedMovement]) -> None:
    """One and two suggested in-betweens divide the mean LME of linear by 2 and 3 at least.

    Free timing never makes an error larger: it is one of many timings, and so are recorded times.
    """
    kinds = [one.movement.kind for one in captured]
    assert kinds.count("onset") >= 4
    assert kinds.count("offset") >= 4
    for one in captured:
        for result in one.evaluation.results:
            assert result.path_lme <= result.lme * (1 + 1e-12)
            assert result.path_lae <= result.lae * (1 + 1e-12)
    linear, one_key, two_keys = (
        np.mean([one.evaluation[label].lme for one in captured])
        for label in ("linear", "through 1", "through 2")
    )
    assert linear / one_key > 2.0
    assert linear / two_keys > 3.0


@pytest.mark.slow
@pytest.mark.realdata
def test_the_path_of_auto_is_never_worse_than_the_straight_line(
    captured: list[JudgedMovement],
) -> None:
    """By more than 0.02 % of D, on any recorded movement."""
    for one in captured:
        auto, straight = one.evaluation["auto"], one.evaluation["linear"]
        assert auto.path_lme <= straight.path_lme + 2e-4
