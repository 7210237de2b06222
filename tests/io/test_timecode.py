"""Timecodes counted by hand, and counted back."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from elastomorph.io.performance.timecode import BASES, Timecode, TimecodeClock, parse_timecode

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
