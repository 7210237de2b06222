"""Weights over time: resampled, cut, and played on a rig, which is the rig posed frame by frame."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from small_rigs import small_rig

import elastomorph as em
from elastomorph.errors import ParameterError
from elastomorph.io.performance import read_livelink
from elastomorph.rig import Rig
from elastomorph.rig.performance import Performance, match, play, slider_weights


def ramp(times: list[float], rate: float = 30) -> Performance:
    """Two weights that rise with time: t and 1 - 2t."""
    when = np.array(times)
    return Performance(["up", "down"], when, np.stack([when, 1 - 2 * when], axis=1), rate)


@given(
    st.lists(st.integers(1, 50), min_size=1, max_size=30), st.floats(0.5, 240), st.floats(0, 1e4)
)
def test_a_ramp_stays_a_ramp(gaps: list[int], rate: float, start: float) -> None:
    """Linear weights are resampled exactly, whatever frames are missing."""
    times = start + np.cumsum([0, *gaps]) / 30
    found = ramp(times.tolist()).resampled(rate)
    inside = np.minimum(found.times, times[-1])
    np.testing.assert_allclose(found.weights[:, 0], inside, rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(found.weights[:, 1], 1 - 2 * inside, rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(np.diff(found.times), 1 / rate, rtol=1e-6, atol=1e-9)
    assert found.times[0] == times[0]
    assert times[-1] - 0.96 / rate < found.times[-1] < times[-1] + 0.06 / rate
    assert found.rate == rate


def test_a_dropped_frame_is_bridged_in_time() -> None:
    """Frames at 0, 1, 3 and 4: the third comes from its neighbours, the fourth keeps its time."""
    take = Performance(["x"], np.array([0, 1, 3, 4]) / 30, [[0], [1], [0], [5]], 30)
    found = take.resampled(30)
    np.testing.assert_allclose(found.times * 30, [0, 1, 2, 3, 4])
    np.testing.assert_allclose(found.weights[:, 0], [0, 1, 0.5, 0, 5], atol=1e-12)


@given(arrays(float, (7, 2), elements=st.floats(-1, 2)))
def test_resampling_at_its_own_rate_changes_nothing(weights: np.ndarray) -> None:
    take = Performance(["a", "b"], np.arange(7) / 24, weights, 24)
    found = take.resampled(24)
    np.testing.assert_allclose(found.times, take.times, atol=1e-12)
    np.testing.assert_allclose(found.weights, take.weights, atol=1e-12)
    twice = take.resampled(48).resampled(24)
    np.testing.assert_allclose(twice.weights, take.weights, atol=1e-12)


def test_a_camera_that_runs_a_little_fast_loses_no_frame() -> None:
    """30 frames at 30.004 fps are 30 frames at 30; at 32 fps they are fewer."""
    assert len(ramp((np.arange(30) / 30.004).tolist()).resampled(30)) == 30
    assert len(ramp((np.arange(30) / 32).tolist()).resampled(30)) == 28  # 29 · 30/32 = 27.2 steps


def test_one_frame_is_a_performance() -> None:
    one = ramp([2.5])
    assert one.duration == 0
    assert one.resampled(60).weights.tolist() == [[2.5, -4.0]]
    assert one.at([0.0, 9.0]).tolist() == [[2.5, -4.0]] * 2


def test_before_and_after_weights_hold() -> None:
    assert ramp([1.0, 2.0]).at([0, 1.5, 7])[:, 0].tolist() == [1, 1.5, 2]


def test_one_time_gives_one_row_of_weights():
    """As `Morph.at` and `Timing.at`: a number in, (N,) out; what is no row of times is refused."""
    for one in (ramp([1.0, 2.0]), ramp([1.0])):
        for time in (0.5, 1, 1.25, np.float32(1.5), 9.0):
            row = one.at(time)
            assert row.shape == (len(one.names),)
            assert row.tolist() == one.at([time])[0].tolist()
            row += 1  # a copy, which the caller may change
        assert one.at([]).shape == (0, len(one.names))
    for wrong in ([[0.5]], np.nan, [np.inf], "now", None):
        with pytest.raises(ParameterError):
            ramp([1.0]).at(wrong)


def test_part_keeps_times_timecodes_and_what_is_missing() -> None:
    take = Performance(
        ["x"], [0, 1, 3, 5], [[0], [1], [3], [5]], 1, timecodes=["0", "1", "3", "5"],
        dropped=["2", "4"], dropped_times=[2, 4], duplicates=["1"], source="take.csv",
    )  # fmt: skip
    part = take.part(1, 3.5)
    assert part.times.tolist() == [1, 3]
    assert part.weights.tolist() == [[1], [3]]
    assert part.timecodes == ("1", "3")
    assert part.dropped == ("2",)
    assert part.dropped_times.tolist() == [2]
    assert part.source == "take.csv"
    assert take.part().dropped == ("2", "4")
    assert len(take.part(stop=0)) == 1
    with pytest.raises(ParameterError, match=r"between 1\.5 and 2 s.*from 0 to 5 s"):
        take.part(1.5, 2)
    with pytest.raises(ParameterError, match="no frame"):
        take.part(3, 1)


def test_it_cannot_be_changed() -> None:
    weights = np.zeros((2, 1))
    take = Performance(["x"], [0, 1], weights, 30)
    weights[0] = 9
    assert not take.weights.any()
    with pytest.raises(ValueError, match="read-only"):
        take.weights[0] = 1
    with pytest.raises(AttributeError):
        take.rate = 3  # type: ignore[misc]


def test_rotations_are_known_by_name() -> None:
    assert Performance(["HeadYaw", "jawOpen"], [0], [[0, 0]], 30).rotations == ("HeadYaw",)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((["x"], [], np.empty((0, 1)), 30), "T ≥ 1"),
        ((["x"], [0], [[1, 2]], 30), "1 names"),
        ((["x"], [0], [1], 30), "2 dimension"),
        ((["x"], [0, 0], [[1], [2]], 30), "rise, but 0 s"),
        ((["x"], [1, 0], [[1], [2]], 30), "rise, but 1 s"),
        ((["x"], [0], [[np.nan]], 30), "finite"),
        ((["x"], [np.inf], [[0]], 30), "finite"),
        ((["x"], [0], [["a"]], 30), "must be numbers"),
        ((["x", "x"], [0], [[1, 2]], 30), "'x' is there twice"),
        ((["x"], [0], [[1]], 0), "rate"),
        ((["x"], [0], [[1]], np.nan), "rate"),
    ],
)
def test_what_is_no_performance(arguments: tuple[object, ...], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        Performance(*arguments)  # type: ignore[arg-type]


def test_timecodes_and_dropped_must_fit() -> None:
    with pytest.raises(ParameterError, match="1 timecodes"):
        Performance(["x"], [0], [[1]], 30, timecodes=["a", "b"])
    with pytest.raises(ParameterError, match="1 dropped_times"):
        Performance(["x"], [0], [[1]], 30, dropped=["a"])


@pytest.mark.parametrize("rate", [0, -1, np.nan, np.inf])
def test_a_rate_is_above_0(rate: float) -> None:
    with pytest.raises(ParameterError, match="above 0"):
        ramp([0, 1]).resampled(rate)


def test_a_rate_that_would_fill_the_memory_is_refused() -> None:
    with pytest.raises(ParameterError, match="lower rate"):
        ramp([0, 1e6]).resampled(1000)


RECORDED = ["HeadYaw", "MouthClose", "BrowInnerUp", "TongueOut", "JawOpen"]


def take() -> Performance:
    weights = np.random.default_rng(1).uniform(-0.2, 1.3, (9, len(RECORDED)))
    return Performance(RECORDED, np.arange(9) / 30, weights, 30)


@pytest.mark.parametrize("block", [None, 1, 4])
def test_every_frame_is_the_pose_by_hand(block: int | None) -> None:
    """Also outside 0 and 1, where paths go on along their tangents."""
    rig, performance = small_rig(), take()
    count = 0
    for row, face in zip(
        performance.weights, play(rig, performance, dtype=np.float64, block=block), strict=True
    ):
        recorded = dict(zip(RECORDED, row, strict=True))
        by_hand = rig.pose(
            {
                "jawOpen": recorded["JawOpen"],
                "mouthClose": recorded["MouthClose"],
                "browInnerUp_L": recorded["BrowInnerUp"],
                "browInnerUp_R": recorded["BrowInnerUp"],
            }
        )
        np.testing.assert_allclose(face, by_hand, atol=1e-12)
        count += 1
    assert count == len(performance)


def test_clipped_weights_stay_within_0_and_1() -> None:
    rig, performance = small_rig(), take()
    free = slider_weights(rig, performance)
    kept = slider_weights(rig, performance, clip=True)
    assert free.min() < 0
    assert free.max() > 1
    np.testing.assert_array_equal(kept, np.clip(free, 0, 1))
    faces = [face.copy() for face in play(rig, performance, clip=True, dtype=np.float64)]
    np.testing.assert_allclose(faces, rig.batch(kept, dtype=np.float64), atol=1e-12)


def test_nothing_matched_is_the_neutral() -> None:
    rig = small_rig()
    still = Performance(["HeadYaw", "other"], [0, 1], [[1, 1], [2, 2]], 1)
    for face in play(rig, still):
        np.testing.assert_array_equal(face, rig.neutral.vertices)


def test_the_match_must_be_of_this_rig_and_recording() -> None:
    rig = small_rig()
    other = match(["JawOpen"], rig.names)
    with pytest.raises(ParameterError, match="another recording or rig"):
        slider_weights(rig, take(), other)
    with pytest.raises(ParameterError, match="another recording or rig"):
        next(iter(play(rig, take(), match(RECORDED, ["jawOpen"]))))


@pytest.mark.realdata
def test_a_real_take_on_real_shapes(data_dir: Path) -> None:
    """On straight paths every frame is V₀ + Σ w Δ, with both brows by the one weight recorded."""
    meshes = data_dir / "ict-facekit"
    neutral = em.read(meshes / "generic_neutral_mesh.obj")
    names = ["browInnerUp_L", "browInnerUp_R", "jawOpen", "mouthSmile_R"]
    targets = {name: em.read(meshes / f"{name}.obj") for name in names}
    rig = Rig(neutral, {n: em.interpolate(neutral, t, "linear") for n, t in targets.items()})
    performance = read_livelink(data_dir / "livelink" / "rom_3.csv").part(75.8, 75.9)
    columns = ["BrowInnerUp", "BrowInnerUp", "JawOpen", "MouthSmileRight"]
    recorded = performance.weights[:, [performance.names.index(name) for name in columns]]
    assert recorded[:, 2].max() > 0.9
    deltas = np.stack([target.vertices - neutral.vertices for target in targets.values()])
    for weights, face in zip(recorded, play(rig, performance), strict=True):
        by_hand = neutral.vertices + np.einsum("j,jvk->vk", weights, deltas)
        np.testing.assert_allclose(face, by_hand, atol=1e-5)
