"""Movements found in takes whose movements are known."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from elastomorph.errors import MeshError, ParameterError
from elastomorph.evaluation import Movement, find_movements, resting_pose
from elastomorph.evaluation.segments import activity

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
    for setting in ({"least_rise": 0}, {"edge": 0.5}, {"smoothing": -1}, {"shortest": 1}):
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
