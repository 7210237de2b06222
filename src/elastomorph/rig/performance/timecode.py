"""Timecodes: hours, minutes, seconds and a frame number that starts again each second.

A timecode that says 30 may count real seconds, or pictures of a 29.97 fps camera. *Drop-frame*
timecode keeps up with the clock by leaving out numbers, never pictures: at 29.97 fps the numbers
00 and 01 of each minute but the tenth, at 59.94 fps 00 to 03.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["BASES", "Timecode", "TimecodeClock", "parse_timecode"]

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


@dataclass(frozen=True)
class Timecode:
    """One timecode as it is written.

    Attributes:
        second: Whole seconds since midnight.
        frame: Number of the frame in its second; a fraction is a sub-frame.
        semicolon: Whether a semicolon stands before the frame, the sign of drop-frame.
    """

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
    """How timecodes count.

    Attributes:
        base: Frame numbers in a second of timecode.
        drop: Whether numbers are left out to keep up with the clock.
        rate: Frames in a second of the clock.
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
