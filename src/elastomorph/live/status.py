"""How a live session stands, in numbers and in a line for people."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from elastomorph.live.session import Recorder

SILENT = 1.0
"""Seconds without packets after which a stream is said to have stopped."""


@dataclass(frozen=True)
class PhoneStatus:
    """How it stands with the packets of one phone.

    Attributes:
        number: By which it is chosen.
        name: Its subject name.
        address: Where its packets come from.
        shown: Whether its face is the one shown.
        rate: Packets a second, of late.
        silent: Seconds since the last one.
        face: Whether it sees a face.
        packets: How many came.
        missing: How many never came.
        late: How many came after a newer one.
        twice: How many came again.
        apart: How many were of another stream under the same id, and left out.
    """

    number: int
    name: str
    address: str
    shown: bool
    rate: float
    silent: float
    face: bool
    packets: int
    missing: int
    late: int
    twice: int
    apart: int

    def text(self) -> str:
        """In words."""
        if self.silent > SILENT:
            return f"{self.name}: no packets for {self.silent:.0f} s"
        words = [f"{self.name}: {self.rate:.0f} packets a second"]
        expected = self.packets + self.missing
        if self.missing:
            words.append(f"{100 * self.missing / expected:.1f} % lost")
        words += [f"{count:,} {what}" for count, what in self._odd() if count]
        if not self.face:
            words.append("sees no face")
        return ", ".join(words)

    def outcome(self) -> str:
        """All its packets, in words."""
        words = [f"{self.name}: {self.packets:,} packets"]
        words += [f"{count:,} {what}" for count, what in ((self.missing, "lost"), *self._odd())]
        return ", ".join(words)

    def _odd(self) -> list[tuple[int, str]]:
        odd = [(self.late, "late"), (self.twice, "twice")]
        return [*odd, (self.apart, "of another stream by its id")] if self.apart else odd


@dataclass(frozen=True)
class Recording:
    """Whether it records, in which file, and how many frames; or what went wrong."""

    wanted: bool
    file: str | None
    frames: int
    problem: str

    @classmethod
    def of(cls, recorder: Recorder) -> Recording:
        """How it stands with a recorder."""
        name = None if recorder.file is None else recorder.file.name
        return cls(recorder.wanted, name, recorder.frames, recorder.problem)


@dataclass(frozen=True)
class Delay:
    """Milliseconds from a packet to the drawn frame: the median, and 95 in 100 are not longer."""

    median: float
    most: float

    @classmethod
    def of(cls, seconds: Collection[float]) -> Delay | None:
        """Those of some frames, if there are any."""
        if not seconds:
            return None
        median, most = np.percentile(list(seconds), (50, 95)) * 1000
        return cls(float(median), float(most))

    def text(self) -> str:
        """In words."""
        return f"packet to frame {self.median:.0f} ms (95 % within {self.most:.0f} ms)"


@dataclass(frozen=True)
class Status:
    """How a session stands.

    Attributes:
        phones: Those that send.
        wanted: The one that was asked for, if one was.
        refused: Packets that could not be read.
        problem: What was wrong with the last of these.
        beyond: Packets of more phones than can be kept apart.
        recording: Of a session that may record.
        neutral: Whether a neutral is subtracted.
        delay: From packets to frames, if a page has drawn any.
    """

    phones: tuple[PhoneStatus, ...]
    wanted: str | None
    refused: int
    problem: str
    beyond: int
    recording: Recording | None
    neutral: bool
    delay: Delay | None

    @property
    def shown(self) -> PhoneStatus | None:
        """The phone whose face is shown."""
        return next((phone for phone in self.phones if phone.shown), None)

    def text(self) -> str:
        """In one line."""
        others = [phone.name for phone in self.phones if not phone.shown and phone.silent <= SILENT]
        parts = [self._waiting() if self.shown is None else self.shown.text()]
        if self.delay is not None:
            parts.append(self.delay.text())
        recording = self.recording
        if recording is not None and recording.problem:
            parts.append(f"not recorded: {recording.problem}")
        elif recording is not None and recording.file is not None:
            parts.append(f"recording {recording.file}, {recording.frames:,} frames")
        elif recording is not None and recording.wanted:
            parts.append("recording from the next packet on")
        if others:
            parts.append(f"also sending: {', '.join(others)}")
        if self.beyond:
            parts.append(f"{self.beyond:,} packets of further phones left out")
        if self.refused:
            parts.append(f"{self.refused:,} packets refused, the last {self.problem}")
        return " · ".join(parts)

    def for_page(self) -> dict[str, Any]:
        """What a page shows of it."""
        shown, recording = self.shown, self.recording
        return {
            "words": self.text(),
            "flows": shown is not None and shown.silent <= SILENT,
            "phones": [[phone.number, phone.name, phone.shown] for phone in self.phones],
            "records": recording is not None,
            "recording": recording is not None and recording.wanted,
            "neutral": self.neutral,
        }

    def _waiting(self) -> str:
        if self.wanted is not None and self.phones:
            return f"no packets of {self.wanted!r} yet"
        return "no packets yet"


@dataclass(frozen=True)
class Outcome:
    """What there was in a session.

    Attributes:
        status: How it stands at its end.
        drawn: Frames that pages have drawn.
        recorded: Files, and how many frames are in each.
    """

    status: Status
    drawn: int
    recorded: tuple[tuple[str, int], ...]

    def text(self) -> str:
        """In words, a line each."""
        status = self.status
        lines = [phone.outcome() for phone in status.phones] or ["no packets came"]
        if status.refused:
            lines.append(f"{status.refused:,} packets refused, the last {status.problem}")
        if status.delay is not None:
            lines.append(f"{self.drawn:,} frames drawn, {status.delay.text()}")
        lines += [f"{frames:,} frames → {file}" for file, frames in self.recorded]
        if status.recording is not None and status.recording.problem:
            lines.append(f"not recorded: {status.recording.problem}")
        elif status.recording is not None and not self.recorded:
            lines.append("nothing was recorded")
        return "\n".join(lines)
