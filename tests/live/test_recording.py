"""What is recorded is a take of Live Link Face, whatever came between."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from elastomorph.io.performance import read_performance
from elastomorph.live.packets import COLUMNS, NAMES, decode, encode
from elastomorph.live.replay import packets_of
from elastomorph.live.session import Phone, Recorder
from elastomorph.rig.performance import Performance
from streams import packet, weights

ANY_FOLDER = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=40)


def record(file: Path, frames: list[int], **of: object) -> Recorder:
    """Records packets of these frames."""
    recorder, phone = Recorder(file), Phone(0, "one", "iPhone", "here")
    recorder.start()
    now, before = 0.0, frames[0]
    for frame in frames:
        now += 2 if abs(frame - before) > 120 else 1 / 60  # a leap comes after a silence
        one, before = packet(frame, **of), frame  # type: ignore[arg-type]
        recorder.take(one, *phone.take(one, now))
    recorder.stop()
    return recorder


def test_a_take_comes_back(tmp_path: Path) -> None:
    file = tmp_path / "take.csv"
    recorder = record(file, list(range(100, 300)))
    assert recorder.files == [(file, 200)]
    take = read_performance(file)
    assert take.names == COLUMNS
    assert take.rate == 60
    assert np.allclose(take.times, np.arange(200) / 60)
    jaw = take.weights[:, COLUMNS.index("JawOpen")]
    assert np.array_equal(jaw, [frame % 64 / 64 for frame in range(100, 300)])
    assert take.timecodes[0] == "00:00:01:40.000"


def test_each_weight_is_in_its_column(tmp_path: Path) -> None:
    face = tuple((place + 1) / 64 for place in range(len(NAMES)))
    record(tmp_path / "take.csv", [1, 2], face=face)
    take = read_performance(tmp_path / "take.csv")
    by_name = dict(zip(take.names, take.weights[0], strict=True))
    assert by_name == dict(zip(NAMES, face, strict=True))


@ANY_FOLDER
@given(st.permutations(range(12)), st.lists(st.integers(0, 11), max_size=4))
def test_shuffled_frames_are_sorted_and_each_is_there_once(
    tmp_path: Path, order: list[int], again: list[int]
) -> None:
    frames = [0, *(1 + frame for frame in [*order, *again]), 13]
    record(tmp_path / "take.csv", frames)
    take = read_performance(tmp_path / "take.csv")
    assert np.allclose(take.times * 60, range(14))


def test_lost_frames_are_known_as_dropped(tmp_path: Path) -> None:
    record(tmp_path / "take.csv", [f for f in range(60) if f not in (20, 21, 40)])
    assert len(read_performance(tmp_path / "take.csv").dropped) == 3


def test_frames_without_a_face_are_left_out_by_readers(tmp_path: Path) -> None:
    file = tmp_path / "take.csv"
    recorder, phone = Recorder(file), Phone(0, "one", "iPhone", "here")
    recorder.start()
    for frame in range(10):
        one = packet(frame, face=() if frame in (4, 5) else None)
        recorder.take(one, *phone.take(one, frame / 60))
    recorder.stop()
    assert recorder.frames == 10
    assert len(read_performance(file)) == 8


EARLY, LATER = list(range(60)), list(range(9_000, 9_060))


@pytest.mark.parametrize("frames", [LATER + EARLY, EARLY + LATER])
def test_a_stream_that_begins_anew_and_a_long_pause_are_two_takes(
    tmp_path: Path, frames: list[int]
) -> None:
    recorder = record(tmp_path / "take.csv", frames)
    assert [file.name for file, _ in recorder.files] == ["take.csv", "take-2.csv"]
    for file, count in recorder.files:
        assert count == len(read_performance(file)) == 60


def test_no_file_is_replaced(tmp_path: Path) -> None:
    """A face cannot be recorded again, and the command is given again by its last line."""
    old = [tmp_path / name for name in ("take.csv", "take-3.csv")]
    for file in old:
        file.write_text("old")
    recorder, phone = Recorder(tmp_path / "take.csv"), Phone(0, "one", "iPhone", "here")
    for first in (0, 100):
        recorder.start()
        for frame in range(first, first + 30):
            recorder.take(packet(frame), *phone.take(packet(frame), frame / 60))
        assert recorder.file is not None
        assert not recorder.file.exists()
        recorder.stop()
    assert [file.name for file, _ in recorder.files] == ["take-2.csv", "take-4.csv"]
    assert {file.read_text() for file in old} == {"old"}


def test_nothing_is_left_where_nothing_was_recorded(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "take.csv")
    recorder.start()
    recorder.stop()
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    recorder = record(tmp_path / "folder" / "take.csv", [1])
    assert not recorder.problem
    recorder = record(tmp_path / "gone" / "take.csv", [1, 2, 3])
    assert "does not exist" in recorder.problem
    assert not recorder.wanted


def test_what_came_until_the_disk_was_full_is_kept(tmp_path: Path) -> None:
    """In whole lines; the next recording goes into another file."""
    resource = pytest.importorskip("resource")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, limits[1]))
    try:
        recorder = record(tmp_path / "take.csv", list(range(60)))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    ((file, frames),) = recorder.files
    assert recorder.problem.endswith(f"; the {frames} frames until then are in take.csv")
    assert recorder.file is None
    assert not recorder.wanted
    assert 10 < frames == len(read_performance(file)) < 60
    assert [each.name for each in tmp_path.iterdir()] == ["take.csv"]


def test_rates_that_no_timecode_has_become_sixtieths(tmp_path: Path) -> None:
    record(tmp_path / "take.csv", list(range(0, 45)), rate=(15, 1))
    take = read_performance(tmp_path / "take.csv")
    assert np.allclose(take.times, np.arange(45) / 15, atol=1e-4)


def test_another_phone_is_not_mixed_in(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "take.csv")
    recorder.start()
    phones = [Phone(number, str(number), "iPhone", "here") for number in range(2)]
    for frame in range(30):
        for own in phones:
            one = packet(frame, device=own.device, face=weights(JawOpen=float(own.number)))
            recorder.take(one, *own.take(one, frame / 60))
    recorder.stop()
    take = read_performance(tmp_path / "take.csv")
    assert len(take) == 30
    assert not take.weights.any()


def test_what_is_replayed_is_recorded(tmp_path: Path) -> None:
    """A take goes out as packets, over its end, and comes back with its weights and times."""
    rows = np.random.default_rng(3).uniform(0, 1, (20, len(COLUMNS))).astype(np.float32)
    take = Performance(COLUMNS, np.arange(20) / 30, rows, 30.0)
    recorder, phone = Recorder(tmp_path / "take.csv"), Phone(0, "one", "iPhone", "here")
    recorder.start()
    for (seconds, sent), _ in zip(packets_of(take, first=86_399.5), range(50), strict=False):
        one = decode(encode(sent))
        recorder.take(one, *phone.take(one, seconds))
    recorder.stop()
    back = read_performance(tmp_path / "take.csv")
    assert np.allclose(back.times, np.arange(50) / 30, atol=1e-4)
    assert np.allclose(back.weights, rows[np.arange(50) % 20], atol=1e-9)
