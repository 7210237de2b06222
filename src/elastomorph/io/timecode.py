"""When each frame of a take was recorded, found from its timecodes.

A timecode is hours, minutes, seconds and a frame number that starts again each second.
A timecode that says 30 may count real seconds, or pictures of a 29.97 fps camera. *Drop-frame*
timecode keeps up with the clock by leaving out numbers, never pictures: at 29.97 fps the numbers
00 and 01 of each minute but the tenth, at 59.94 fps 00 to 03.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError

_LIVE_LINK_BASE = 60
_MOST_DROPPED = 100_000
_SAME_RATE = 5e-4
_WHOLE = 0.02

BASES: dict[int, tuple[float, ...]] = {
    24: (24.0, 24000 / 1001),
    25: (25.0,),
    30: (30.0, 30000 / 1001),
    48: (48.0, 48000 / 1001),
    50: (50.0,),
    60: (60.0, 60000 / 1001),
    100: (100.0,),
    120: (120.0, 120000 / 1001),
    240: (240.0,),
}
"""Numbers in a second of timecode, and the frames in a second of the clock that they may mean."""

_TIMECODE = re.compile(
    r"([0-9]{1,2}):([0-5]?[0-9]):([0-5]?[0-9])([:;])([0-9]{1,3})(\.[0-9]*)?", re.ASCII
)


class Timecode(NamedTuple):
    """Whole seconds since midnight, the frame with its fraction, and whether ; stands before it."""

    second: int
    frame: float
    semicolon: bool


def parse_timecode(text: str) -> Timecode | None:
    """The timecode that a text stands for, ``HH:MM:SS:FF`` or ``HH:MM:SS:FF.fff``, or None."""
    found = _TIMECODE.fullmatch(text.strip())
    if found is None or int(found[1]) > 23:
        return None
    second = (int(found[1]) * 60 + int(found[2])) * 60 + int(found[3])
    fraction = float(f"0{found[6]}") if found[6] and found[6] != "." else 0.0
    return Timecode(second, int(found[5]) + fraction, found[4] == ";")


@dataclass(frozen=True)
class TimecodeClock:
    """How timecodes count: ``base`` numbers in a second of timecode, ``rate`` in one of the clock.

    With ``drop``, numbers are left out to keep up with the clock.
    """

    base: int
    drop: bool
    rate: float

    @property
    def left_out(self) -> int:
        """Numbers that drop-frame leaves out in each minute but the tenth; 0 without drop-frame."""
        return self.base // 15 if self.drop else 0

    @property
    def day(self) -> int:
        """Frames from midnight to midnight."""
        return self.base * 86_400 - self.left_out * (1440 - 144)

    def count(self, seconds: NDArray[np.int64], frames: NDArray[np.float64]) -> NDArray[np.float64]:
        """(T,) frames since midnight, without holes, of (T,) timecodes."""
        minutes = seconds // 60
        left_out = self.left_out * (minutes - minutes // 10)
        return np.asarray(seconds * self.base - left_out, dtype=np.float64) + frames

    def text(self, number: float, digits: int = 0) -> str:
        """The timecode of a frame since midnight, with so many digits of sub-frame."""
        number = round(number % self.day, digits)
        whole = int(number)
        if self.drop:
            ten_minutes = self.base * 600 - 9 * self.left_out
            minute = self.base * 60 - self.left_out
            tens, rest = divmod(whole, ten_minutes)
            passed = 9 * tens + max(0, 1 + (rest - self.base * 60) // minute)
            number += passed * self.left_out
            whole += passed * self.left_out
        seconds, frame = divmod(whole, self.base)
        minutes, second = divmod(seconds, 60)
        separator = ";" if self.drop else ":"
        fraction = f"{number - whole:.{digits}f}"[1:] if digits else ""
        hours = minutes // 60 % 24
        return f"{hours:02d}:{minutes % 60:02d}:{second:02d}{separator}{frame:02d}{fraction}"


class TimingError(ParameterError):
    """Timecodes that are those of no one take, and the index of the frame at which that shows."""

    def __init__(self, problem: str, frame: int) -> None:
        self.frame = frame
        super().__init__(problem)


class TakeTiming(NamedTuple):
    """When each frame of a take was recorded, in seconds since the first.

    The nominal rate of the recording may be every second number or two frames a number. What is
    kept are (T,) indices of the frames that are not the same again.
    """

    clock: TimecodeClock
    rate: float
    kept: NDArray[np.int64]
    times: NDArray[np.float64]
    dropped: tuple[str, ...]
    dropped_times: NDArray[np.float64]


def take_timing(timecodes: Sequence[Timecode], rate: float | None = None) -> TakeTiming:
    """Rate, times and gaps of a take.

    The numbers in a second are found where one second follows another. Drop-frame is taken for
    granted where a semicolon stands or the numbering jumps at full minutes as drop-frame does, if
    no number is there that it leaves out. A take that never comes to the next second counts in
    sixtieths, as Live Link Face does. Past midnight the count goes on. ``rate`` is the frames in a
    second of the clock where it is known better: 29.97 without drop-frame looks just as 30.
    """
    seconds = np.array([timecode.second for timecode in timecodes], dtype=np.int64)
    frames = np.array([timecode.frame for timecode in timecodes])
    base = _base_of(rate) if rate is not None else _base(seconds, frames)
    top = int(np.argmax(frames))
    if frames[top] >= base:
        raise TimingError(
            f"the frame number {frames[top]:g} is beyond {base} frames a second; expected "
            "HH:MM:SS:FF.fff with FF below the frames in a second",
            top,
        )
    semicolon = any(timecode.semicolon for timecode in timecodes)
    drop = _drops_numbers(base, seconds, frames, semicolon)
    real = BASES[base][-1 if drop else 0]
    if rate is not None:
        real = min(BASES[base], key=lambda known: abs(known - rate))
    clock = TimecodeClock(base, drop, real)
    count = clock.count(seconds, frames)
    count += clock.day * np.cumsum(np.diff(count, prepend=count[0]) < -clock.day / 2)
    steps = np.diff(count)
    if (steps < 0).any():
        raise TimingError(
            "the timecode goes back; a take must be in the order of recording, so split the file "
            "where another take begins",
            int(np.argmax(steps < 0)) + 1,
        )
    kept = np.flatnonzero(np.concatenate([[True], steps > 0]))
    count = count[kept]
    steps = np.diff(count)
    step = _whole_step(_usual(steps)) if steps.size else 1.0
    missing = _missing(count, step, kept)
    digits = 3 if (frames % 1).any() else 0
    return TakeTiming(
        clock,
        clock.rate / step,
        kept,
        (count - count[0]) / clock.rate,
        tuple(clock.text(number, digits) for number in missing.tolist()),
        (missing - count[0]) / clock.rate,
    )


def _missing(
    count: NDArray[np.float64], step: float, kept: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Where the frames that were not recorded would have been counted."""
    steps = np.diff(count)
    absent = np.maximum(np.rint(steps / step).astype(np.int64) - 1, 0)
    if absent.sum() > _MOST_DROPPED:
        worst = int(np.argmax(absent))
        raise TimingError(
            f"a gap of {absent[worst]:,} frames comes before this one; that is two takes, so "
            "split the file here",
            int(kept[worst + 1]),
        )
    gaps = np.flatnonzero(absent)
    spread = [
        count[gap] + steps[gap] * np.arange(1, absent[gap] + 1) / (absent[gap] + 1) for gap in gaps
    ]
    return np.concatenate([np.empty(0), *spread])


def _base(seconds: NDArray[np.int64], frames: NDArray[np.float64]) -> int:
    """Numbers in a second: where a second ends, those that it had."""
    top = int(frames.max())
    possible = [base for base in BASES if base > top]
    if not possible:
        raise TimingError(
            f"the frame number {frames.max():g} is higher than any rate has; expected "
            "HH:MM:SS:FF.fff with FF below the frames in a second (not milliseconds)",
            int(frames.argmax()),
        )
    ahead, steps = np.diff(seconds) % 86_400, np.diff(frames)
    within = steps[(ahead == 0) & (steps > 0)]
    rolls = -steps[ahead == 1]
    if not within.size or not rolls.size:
        return _LIVE_LINK_BASE if top < _LIVE_LINK_BASE else possible[0]
    estimate = float(np.median(rolls)) + _usual(within)
    return min(possible, key=lambda base: abs(base - estimate))


def _base_of(rate: float) -> int:
    for base, rates in BASES.items():
        if any(abs(rate - real) <= _SAME_RATE * real for real in rates):
            return base
    known = ", ".join(f"{real:.5g}" for rates in BASES.values() for real in sorted(rates))
    raise ParameterError(f"no timecode counts {rate:g} frames a second; expected one of {known}")


def _drops_numbers(
    base: int, seconds: NDArray[np.int64], frames: NDArray[np.float64], semicolon: bool
) -> bool:
    """Whether the numbering is drop-frame, by its sign or by its jumps at full minutes."""
    if base not in (30, 60, 120):
        return False
    left_out = base // 15
    short = (seconds % 60 == 0) & (seconds // 60 % 10 != 0)
    if (short & (frames < left_out)).any():
        return False
    if semicolon:
        return True
    steps = np.diff(seconds * base + frames)
    turns = short[1:] & (np.diff(seconds) == 1)
    if not turns.any():
        return False
    jumps = steps[turns] - _usual(steps[steps > 0])
    return bool((np.abs(jumps - left_out) < 0.5).all())


def _usual(steps: NDArray[np.float64]) -> float:
    """The median, of two in the middle the lower one: a gap is never usual."""
    return float(np.quantile(steps, 0.5, method="lower"))


def _whole_step(step: float) -> float:
    """Numbers from frame to frame, whole where they are nearly (or one part of a whole)."""
    for near in (float(round(step)), 1 / max(round(1 / step), 1)):
        if near > 0 and abs(step - near) < _WHOLE * near:
            return near
    return step
