"""Timecodes counted by hand, and counted back."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from elastomorph.errors import ParameterError
from elastomorph.io.timecode import (
    BASES,
    TakeTiming,
    Timecode,
    TimecodeClock,
    TimingError,
    parse_timecode,
    take_timing,
)

DROP_30 = TimecodeClock(30, True, 30000 / 1001)
DROP_60 = TimecodeClock(60, True, 60000 / 1001)


def count(clock: TimecodeClock, text: str) -> float:
    found = parse_timecode(text)
    assert found is not None
    return float(clock.count(np.array([found.second]), np.array([found.frame]))[0])


@pytest.mark.parametrize(
    ("text", "frames"),
    [
        ("00:00:00;00", 0),
        ("00:00:59;29", 1799),  # the first minute is a tenth: nothing is left out before it ends
        ("00:01:00;02", 1800),  # 00 and 01 of the next are left out
        ("00:01:59;29", 1800 + 1798 - 1),
        ("00:02:00;02", 1800 + 1798),
        ("00:09:59;29", 17981),  # ten minutes have 18,000 - 9 · 2 frames
        ("00:10:00;00", 17982),
        ("00:11:00;02", 17982 + 1800),
        ("01:00:00;00", 6 * 17982),
        ("23:59:59;29", 24 * 6 * 17982 - 1),
    ],
)
def test_drop_frame_by_hand(text: str, frames: int) -> None:
    """An hour of drop-frame is 108,000 numbers less 54 times two."""
    assert count(DROP_30, text) == frames
    assert DROP_30.text(frames) == text


def test_drop_frame_of_sixty_leaves_out_four() -> None:
    assert count(DROP_60, "00:01:00;04") - count(DROP_60, "00:00:59;59") == 1
    assert count(DROP_60, "00:10:00;00") == 2 * 17982
    assert DROP_60.day == 2 * DROP_30.day == 2 * 2_589_408


def test_drop_frame_keeps_up_with_the_clock() -> None:
    """After an hour it is 3.6 ms behind; without leaving out, 3.6 s."""
    assert count(DROP_30, "01:00:00;00") / DROP_30.rate == pytest.approx(3600 - 0.0036, abs=1e-4)
    plain = TimecodeClock(30, False, 30000 / 1001)
    assert count(plain, "01:00:00:00") / plain.rate == pytest.approx(3603.6)


@given(st.sampled_from([(base, drop) for base in BASES for drop in (False, True)]), st.integers(0))
def test_text_is_the_inverse_of_count(kind: tuple[int, bool], number: int) -> None:
    """And no number that drop-frame leaves out is ever written."""
    base, drop = kind
    drop &= base in (30, 60, 120)
    clock = TimecodeClock(base, drop, float(base))
    text = clock.text(number)
    assert count(clock, text) == number % clock.day
    found = parse_timecode(text)
    assert found is not None
    if drop and found.second % 60 == 0 and found.second // 60 % 10:
        assert found.frame >= clock.left_out


def test_sub_frames_are_fractions_of_a_frame() -> None:
    assert parse_timecode("13:13:04:31.652") == Timecode(47584, 31.652, False)
    clock = TimecodeClock(60, False, 60.0)
    assert clock.text(count(clock, "13:13:04:31.652"), 3) == "13:13:04:31.652"
    assert clock.text(59.9996, 3) == "00:00:01:00.000"
    assert clock.text(clock.day - 0.0001, 3) == "00:00:00:00.000"


@pytest.mark.parametrize(
    "text",
    ["", "1:2:3", "24:00:00:00", "00:60:00:00", "00:00:60:00", "00:00:00:0x", "-1:00:00:00",
     "00:00:00:00:00", "00:00:00.00", "0:0:0:1e3", "٠٠:00:00:00", "00:00:00:1234"],
)  # fmt: skip
def test_what_is_no_timecode(text: str) -> None:
    assert parse_timecode(text) is None


def codes(*texts: str) -> list[Timecode]:
    found = [parse_timecode(text) for text in texts]
    assert all(found)
    return [code for code in found if code is not None]


def counted(clock: TimecodeClock, numbers: range) -> list[Timecode]:
    """The timecodes of frames since midnight."""
    return codes(*(clock.text(number) for number in numbers))


def timed(*texts: str, rate: float | None = None) -> TakeTiming:
    return take_timing(codes(*texts), rate)


@settings(deadline=None)
@given(
    st.sampled_from([(b, r) for b, rates in BASES.items() for r in rates[:1]]),
    st.integers(0, 20_000_000),
    st.integers(1, 4),
    st.booleans(),
)
def test_the_rate_is_found_from_the_numbering(
    kind: tuple[int, float], start: int, step: int, told: bool
) -> None:
    """Three seconds of any rate, recorded at all frames or every second, third or fourth."""
    base, rate = kind
    clock = TimecodeClock(base, False, rate)
    numbers = range(start % clock.day, start % clock.day + 3 * base, step)
    found = take_timing(counted(clock, numbers), rate if told else None)
    assert found.clock == clock
    assert found.rate == pytest.approx(base / step)
    np.testing.assert_allclose(found.times, np.arange(len(numbers)) * step / base, atol=1e-9)
    assert not found.dropped


@given(st.sampled_from([30, 60, 120]), st.integers(0, 1439))
def test_drop_frame_with_semicolons_is_even_in_time(base: int, minute: int) -> None:
    """Over a full minute the pictures keep their distance of 1001/30000 s, and none is missing."""
    clock = TimecodeClock(base, True, base * 1000 / 1001)
    left_out = clock.left_out * (minute - minute // 10)
    start = minute * 60 * base - left_out - 40
    found = take_timing(counted(clock, range(start, start + 80)))
    assert found.clock == clock
    assert not found.dropped
    np.testing.assert_allclose(np.diff(found.times), 1001 / (base * 1000), rtol=1e-6)


def test_drop_frame_without_semicolons_is_seen_at_the_minute() -> None:
    found = timed("10:00:59:28", "10:00:59:29", "10:01:00:02", "10:01:00:03")
    assert found.clock.drop
    assert found.rate == pytest.approx(30000 / 1001)
    np.testing.assert_allclose(found.times, np.arange(4) * 1001 / 30000)


def test_a_tenth_minute_or_a_number_that_is_there_rules_drop_frame_out() -> None:
    tenth = timed("10:09:59:28", "10:09:59:29", "10:10:00:02", "10:10:00:03")
    assert not tenth.clock.drop
    assert tenth.dropped == ("10:10:00:00", "10:10:00:01")
    there = timed("10:00:59;28", "10:00:59;29", "10:01:00;00", "10:01:00;01")
    assert not there.clock.drop
    assert there.rate == 30


def test_a_dropped_frame_keeps_its_time() -> None:
    """At 25 fps, frames 24, 00 and 03 of 1 s, 2 s: two are missing, 80 + 40 ms pass."""
    found = timed("00:00:01:23", "00:00:01:24", "00:00:02:00", "00:00:02:03", "00:00:02:04")
    assert found.clock.base == 25
    np.testing.assert_allclose(found.times, [0, 0.04, 0.08, 0.2, 0.24], atol=1e-12)
    assert found.dropped == ("00:00:02:01", "00:00:02:02")
    np.testing.assert_allclose(found.dropped_times, [0.12, 0.16], atol=1e-12)


def test_sub_frames_are_part_of_the_time() -> None:
    """Live Link Face at 30 fps counts in sixtieths, every second one."""
    found = timed("13:59:59:57.500", "13:59:59:59.500", "14:00:00:01.400", "14:00:00:03.500")
    assert found.clock == TimecodeClock(60, False, 60.0)
    assert found.rate == 30
    np.testing.assert_allclose(found.times, np.array([0, 2, 3.9, 6]) / 60, atol=1e-9)


def test_a_take_past_midnight_goes_on() -> None:
    found = timed("23:59:59:28", "23:59:59:29", "00:00:00:00", "00:00:00:01", "00:00:01:01")
    assert found.clock.base == 30
    np.testing.assert_allclose(found.times, np.array([0, 1, 2, 3, 33]) / 30, atol=1e-9)
    assert len(found.dropped) == 29
    assert found.dropped[0] == "00:00:00:02"


def test_two_midnights() -> None:
    """A frame every eight hours never goes back and never ends."""
    found = timed(*["00:00:00:00", "08:00:00:00", "16:00:00:00"] * 3)
    np.testing.assert_allclose(found.times, np.arange(9) * 8 * 3600)
    assert not found.dropped


def test_frames_that_come_again_are_left_out() -> None:
    found = timed("00:00:00:58", "00:00:00:59", "00:00:00:59", "00:00:01:00")
    assert found.kept.tolist() == [0, 1, 3]
    np.testing.assert_allclose(found.times, np.arange(3) / 60)
    assert not found.dropped


def test_without_a_full_second_it_counts_in_sixtieths() -> None:
    np.testing.assert_allclose(timed("00:00:00:00", "00:00:00:01").times, [0, 1 / 60])
    assert timed("00:00:00:07").times.tolist() == [0]
    assert timed("00:00:00:07").rate == 60
    assert timed("00:00:00:71", "00:00:00:72").clock.base == 100


def test_the_rate_may_be_told() -> None:
    """29.97 without drop-frame looks just as 30; nothing but knowing tells them apart."""
    told = timed("00:00:00:00", "00:00:00:01", rate=29.97)
    assert told.clock == TimecodeClock(30, False, 30000 / 1001)
    film = timed("00:00:00:00", "00:00:00:01", rate=23.976)
    assert film.rate == 24000 / 1001
    real = timed("00:00:59;29", "00:01:00;02", rate=30)
    np.testing.assert_allclose(real.times, [0, 1 / 30])
    with pytest.raises(ParameterError, match=r"27 frames a second.*23\.976, 24, 25"):
        timed("00:00:00:00", rate=27)
    with pytest.raises(TimingError, match="beyond 24 frames") as caught:
        timed("00:00:00:00", "00:00:00:24", rate=24)
    assert caught.value.frame == 1


@pytest.mark.parametrize(
    ("texts", "frame", "message"),
    [
        (["00:00:05:00", "00:00:05:01", "00:00:04:00"], 2, "goes back"),
        (["00:00:05:00", "00:00:05:01", "03:00:05:01"], 2, "two takes"),
        (["00:00:00:33", "00:00:00:966"], 1, "not milliseconds"),
    ],
)
def test_what_is_no_one_take(texts: list[str], frame: int, message: str) -> None:
    with pytest.raises(TimingError, match=message) as caught:
        timed(*texts)
    assert caught.value.frame == frame
