"""A live session: packets come in, the pose of one phone goes out, and everything is counted.

A network may lose packets, deliver them twice, and change their order. Of each phone the newest
frame is shown, so what comes after a later one is only counted. The number of a frame may also
leap, where a phone was told another time, or where somebody else sends under its id. So a leap is
believed after a silence, or when nothing else has come for a moment.

Takes are recorded from the stream in the columns of Live Link Face (.csv).

How a live session stands, in numbers and in a line for people.
"""

from __future__ import annotations

import errno
import heapq
import itertools
import os
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Collection, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from io import FileIO
from itertools import count
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ElastomorphError
from elastomorph.io.atomic import replacing_path
from elastomorph.io.timecode import BASES, TimecodeClock
from elastomorph.live.packets import COLUMNS, NAMES, FacePacket, PacketError, decode
from elastomorph.rig.performance import Match, head_angles, match

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


_HELD = 0.25  # seconds that frames wait for late ones before they are written
_LONGEST_PAUSE = 60.0  # seconds; a longer one is between two takes
_LIVE_LINK_BASE = 60
_FROM_PACKET = [NAMES.index(name) for name in COLUMNS]
_HEADER = ",".join(["Timecode", "BlendShapeCount", *COLUMNS])
_NO_FACE = f"0{',' * len(COLUMNS)}"


class Recorder:
    """Records one phone at a time, each recording into a file of its own.

    A file appears when its recording ends: until then it has a temporary name beside it. Frames
    are kept as they were sent, sorted, each once; what is later than a quarter of a second is left
    out. In memory are only those that wait. Where no more can be written, as on a full disk, the
    file holds the whole lines until then.

    Args:
        path: The first file; later ones are ``take-2.csv`` and so on. A face cannot be recorded
            again, so none of them replaces a file.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.wanted = False
        self.problem = ""
        self.frames = 0
        self.files: list[tuple[Path, int]] = []
        """Those that were written, and how many frames are in each."""
        self._file: FileIO | None = None
        self._lines = self._bytes = 0  # written whole
        self._open = ExitStack()
        self._final = path
        self._device = ""
        self._waiting: list[tuple[float, int, FacePacket]] = []
        self._turn = itertools.count()
        self._newest = self._written = float("-inf")

    def start(self) -> None:
        """Record from the next frame on."""
        self.wanted, self.problem = True, ""

    def stop(self) -> None:
        """End the recording, if there is one: its file is then there."""
        self.wanted = False
        self._finish()

    def take(self, packet: FacePacket, order: Order, position: float) -> None:
        """Record a frame, unless it was there already or is of another phone or stream."""
        if not self.wanted or order in ("twice", "apart"):
            return
        if self._file is not None and packet.device != self._device:
            return
        pause = (position - self._newest) / packet.per_second
        try:
            if self._file is not None and (order == "again" or pause > _LONGEST_PAUSE):
                self._finish()
            if self._file is None:
                self._begin(packet.device)
            if position <= self._written:
                return
            self._newest = max(self._newest, position)
            self.frames += 1
            heapq.heappush(self._waiting, (position, next(self._turn), packet))
            self._write(self._newest - _HELD * packet.per_second)
        except (ElastomorphError, OSError) as error:
            self._give_up(error)

    @property
    def file(self) -> Path | None:
        """The file that is being recorded."""
        return None if self._file is None else self._final

    def _begin(self, device: str) -> None:
        self._final = next_file(self.path)
        place = self._open.enter_context(replacing_path(self._final))
        self._file = self._open.enter_context(FileIO(place, "w"))
        self._device, self.frames, self._lines, self._bytes = device, 0, 0, 0
        self._put(self._file, _HEADER)
        self._newest = self._written = float("-inf")

    def _write(self, until: float) -> None:
        while self._file is not None and self._waiting and self._waiting[0][0] <= until:
            self._written, _, packet = heapq.heappop(self._waiting)
            self._put(self._file, _row(packet))
            self._lines += 1

    def _put(self, file: FileIO, line: str) -> None:
        """Write a line, at once: what waited in a buffer would be lost where the disk is full."""
        content = f"{line}\n".encode()
        if file.write(content) < len(content):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        self._bytes += len(content)

    def _finish(self) -> None:
        try:
            self._write(float("inf"))
            self._close()
        except (ElastomorphError, OSError) as error:
            self._give_up(error)

    def _close(self) -> None:
        if self._file is not None:
            os.fsync(self._file.fileno())
            self._file = None
            self._open.close()
            self.files.append((self._final, self._lines))

    def _give_up(self, error: Exception) -> None:
        """End with what was written; the stream goes on."""
        self.wanted = False
        self._waiting.clear()
        self.problem = (isinstance(error, OSError) and error.strerror) or str(error)
        try:
            if self._file is not None and self._lines > 0:
                self._file.truncate(self._bytes)
                self._close()
                self.problem += f"; the {self._lines:,} frames until then are in {self._final.name}"
            self._open.__exit__(*sys.exc_info())
        except (ElastomorphError, OSError) as last:
            self.problem = str(last)
        self._file, self._open = None, ExitStack()


def next_file(path: Path) -> Path:
    """Where a recording goes: ``take.csv``, or ``take-2.csv`` and so on where that is there."""
    file, number = path, 1
    while file.exists():
        number += 1
        file = path.with_stem(f"{path.stem}-{number}")
    return file


def _row(packet: FacePacket) -> str:
    """A line of a take: the timecode, how many weights, and these."""
    base = round(packet.per_second)
    count = packet.count
    if base not in BASES:
        base, count = _LIVE_LINK_BASE, count * _LIVE_LINK_BASE / packet.per_second
    # The numbering without drop-frame: what is counted are frames.
    timecode = TimecodeClock(base, False, float(base)).text(count, 3)
    if not packet.weights:
        return f"{timecode},{_NO_FACE}"
    weights = (f"{packet.weights[place]:.10f}" for place in _FROM_PACKET)
    return f"{timecode},{len(COLUMNS)},{','.join(weights)}"


Order = Literal["new", "late", "twice", "again", "apart"]
"""What a packet is beside those before: the newest, later than a newer one, one that was there, the
first of a stream that begins anew, or one of another stream, which is left out."""

MOST_PHONES = 8
_GONE = 10.0  # seconds of silence after which a phone gives way to another
_BELIEVED = 0.25  # seconds that frames far from those before must come without any of these
_DAY = 86_400
_LATEST = 2.0  # seconds that a packet may be late, and that may be missing as lost ones
_REMEMBERED = 256
_STEPS = 31
_RECENT = 2.0


@dataclass
class Phone:
    """One phone, by the id it sends.

    Attributes:
        number: By which people choose it.
        device: Its id.
        subject: Its name, as it was sent last.
        address: Where its packets came from last.
        packet: Its newest frame.
        weights: Those of the newest frame in which a face was seen.
        position: The frame count of that, which goes on past midnight.
        arrived: When it came, in seconds.
        packets: How many came.
        missing: How many never came, of those that the numbering lets expect.
        late: How many came after a newer one.
        twice: How many came again.
        apart: How many were far from those before, and not believed.
    """

    number: int
    device: str
    subject: str
    address: str
    packet: FacePacket | None = None
    weights: tuple[float, ...] = ()
    position: float = 0.0
    arrived: float = 0.0
    packets: int = 0
    missing: int = 0
    late: int = 0
    twice: int = 0
    apart: int = 0
    _rival: tuple[float, FacePacket] | None = None
    _steps: deque[int] = field(default_factory=lambda: deque(maxlen=_STEPS))
    _seen: deque[float] = field(default_factory=lambda: deque(maxlen=_REMEMBERED))
    _arrivals: deque[float] = field(default_factory=lambda: deque(maxlen=_REMEMBERED))

    def take(self, packet: FacePacket, now: float) -> tuple[Order, float]:
        """Count a packet in; what it is beside those before, and its frame count past midnight."""
        self.packets += 1
        self.subject = packet.subject
        self._arrivals.append(now)
        before = self.packet
        if before is None:
            return self._newest(packet, packet.count, now, "new")
        ahead = _ahead(before, packet)
        if ahead is None or _leaps(ahead, packet):
            quiet = now - self.arrived > SILENT
            if not (quiet or self._is_believed(packet, now)):
                self.apart += 1
                return "apart", packet.count
            if ahead is None or ahead < 0 or not quiet:
                self._seen.clear()
                return self._newest(packet, packet.count, now, "again")
        self._rival = None
        position = self.position + ahead
        if ahead > 0:
            self._count_missing(ahead, packet.per_second)
            return self._newest(packet, position, now, "new")
        self.arrived = now
        if position in self._seen:
            self.twice += 1
            return "twice", position
        self._seen.append(position)
        self.late += 1
        self.missing = max(0, self.missing - 1)
        return "late", position

    def standing(self, now: float, shown: bool) -> PhoneStatus:
        """How it stands with its packets."""
        recent = [when for when in self._arrivals if when > now - _RECENT]
        rate = (len(recent) - 1) / (recent[-1] - recent[0]) if len(set(recent)) > 1 else 0.0
        return PhoneStatus(
            self.number,
            self.subject,
            self.address,
            shown,
            rate,
            max(0.0, now - self.arrived),
            self.packet is not None and bool(self.packet.weights),
            self.packets,
            self.missing,
            self.late,
            self.twice,
            self.apart,
        )

    def _newest(
        self, packet: FacePacket, position: float, now: float, order: Order
    ) -> tuple[Order, float]:
        self.packet, self.position, self.arrived, self._rival = packet, position, now, None
        self.weights = packet.weights or self.weights
        self._seen.append(position)
        return order, position

    def _is_believed(self, packet: FacePacket, now: float) -> bool:
        """Whether a packet far from those before is one of a stream that has gone on for long."""
        since, last = self._rival or (now, packet)
        ahead = _ahead(last, packet)
        if ahead is None or _leaps(ahead, packet):
            since = now
        self._rival = since, packet
        return now - since >= _BELIEVED

    def _count_missing(self, ahead: float, per_second: float) -> None:
        """Frames left out, by what is usual: a phone may send every second one."""
        step = max(1, round(ahead))
        self._steps.append(step)
        usual = sorted(self._steps)[(len(self._steps) - 1) // 2]
        if ahead <= _LATEST * per_second:
            self.missing += max(0, round(step / usual) - 1)


def _ahead(before: FacePacket, packet: FacePacket) -> float | None:
    """Frames from one packet to another, past midnight too; None if they are of another rate."""
    if before.rate != packet.rate:
        return None
    day = packet.per_second * _DAY
    return (packet.count - before.count + day / 2) % day - day / 2


def _leaps(ahead: float, packet: FacePacket) -> bool:
    """Whether so many frames are more than are lost or late in one stream."""
    return abs(ahead) > _LATEST * packet.per_second


class Phones:
    """Those that have sent something, and the one that is shown."""

    def __init__(self, wanted: str | None = None) -> None:
        self.wanted = wanted
        self.shown: Phone | None = None
        self.beyond = 0
        """Packets of phones that are more than can be kept apart."""
        self._known: dict[str, Phone] = {}
        self._numbers = count()

    def known(self) -> list[Phone]:
        """All of them, in the order in which they began."""
        return list(self._known.values())

    def of(self, packet: FacePacket, address: str, now: float) -> Phone | None:
        """The phone that sent a packet; the first, or the one wanted, is shown from then on."""
        key = packet.device or packet.subject
        is_wanted = self.wanted in (None, packet.subject, packet.device)
        phone = self._known.get(key)
        if phone is None:
            if len(self._known) >= MOST_PHONES and not self._make_room(
                now, self.shown is None and is_wanted
            ):
                self.beyond += 1
                return None
            phone = Phone(next(self._numbers), packet.device, packet.subject, address)
            self._known[key] = phone
        phone.address = address
        if self.shown is None and is_wanted:
            self.shown = phone
        return phone

    def _make_room(self, now: float, at_once: bool) -> bool:
        """Forget the phone that has been silent for longest; False while all of them send."""
        others = {key: phone for key, phone in self._known.items() if phone is not self.shown}
        key, silent = min(others.items(), key=lambda item: item[1].arrived)
        if not at_once and now - silent.arrived <= _GONE:
            return False
        del self._known[key]
        return True

    def choose(self, number: int) -> bool:
        """Show the phone of a number; False where there is none."""
        for phone in self._known.values():
            if phone.number == number:
                self.shown = phone
                return True
        return False


_DELAYS = 600  # the last ten seconds at 60 frames a second
_FIGURES = 5


class Pose(NamedTuple):
    """Weights of all sliders, the number of the pose, and when its packet came, in seconds.

    With them the angles of the head, as `elastomorph.Performance.head`.
    """

    number: int
    arrived: float
    weights: list[float]
    head: list[float]


class Session:
    """What is known of a stream; the receiver and every page use it from threads of their own.

    Args:
        sliders: Names of the rig's sliders.
        subject: Name or id of the phone to show; the first that sends by default.
        record: The file to record to; the session does not record without one.
        clock: Seconds, rising.

    Attributes:
        match: Which weights drive which sliders.
        drawn: Frames that pages have drawn.
        closed: Whether it has ended.
    """

    def __init__(
        self,
        sliders: Sequence[str],
        subject: str | None = None,
        record: Path | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.match: Match = match(NAMES, sliders)
        self.drawn = 0
        self.closed = False
        self._clock = clock
        self._changed = threading.Condition()
        self._phones = Phones(subject)
        self._refused = 0
        self._problem = ""
        self._neutral: NDArray[np.float64] | None = None
        self._number = 0
        self._arrived = 0.0
        self._delays: deque[float] = deque(maxlen=_DELAYS)
        self._recorder = None if record is None else Recorder(record)
        if self._recorder is not None:
            self._recorder.start()

    def take(self, content: bytes, address: str) -> None:
        """Take what came from an address, whatever it is."""
        now = self._clock()
        try:
            packet = decode(content)
        except PacketError as error:
            with self._changed:
                self._refused += 1
                self._problem = f"from {address}: {error}"
            return
        with self._changed:
            phone = self._phones.of(packet, address, now)
            if phone is None:
                return
            order, position = phone.take(packet, now)
            shown = phone is self._phones.shown
            # A recording stays with the phone that it began with.
            if self._recorder is not None and (shown or self._recorder.file is not None):
                self._recorder.take(packet, order, position)
            if shown and order in ("new", "again") and packet.weights:
                self._show(now)

    def newest(self, after: int, wait: float) -> Pose | None:
        """The newest pose, as soon as there is one with a number above ``after``."""
        with self._changed:
            self._changed.wait_for(lambda: self._number > after or self.closed, wait)
            phone = self._phones.shown
            if self._number <= after or phone is None or not phone.weights:
                return None
            weights = np.array(phone.weights)
            neutral, number, arrived = self._neutral, self._number, self._arrived
        turned = weights if neutral is None else weights - neutral
        if neutral is not None:
            weights = np.maximum(0.0, turned)
        driven = self.match.drive(weights[None])[0]
        angles = head_angles(NAMES, turned[None])[0]
        shown, head = (np.round(each, _FIGURES).tolist() for each in (driven, angles))
        return Pose(number, arrived, shown, head)

    def status(self) -> Status:
        """How things stand."""
        now = self._clock()
        with self._changed:
            shown, recorder = self._phones.shown, self._recorder
            return Status(
                tuple(phone.standing(now, phone is shown) for phone in self._phones.known()),
                self._phones.wanted,
                self._refused,
                self._problem,
                self._phones.beyond,
                None if recorder is None else Recording.of(recorder),
                self._neutral is not None,
                Delay.of(self._delays),
            )

    def was_drawn(self, arrived: float) -> None:
        """A page has drawn the pose of a packet that came at a time."""
        with self._changed:
            self.drawn += 1
            self._delays.append(self._clock() - arrived)

    def set_neutral(self, own: bool) -> None:
        """Subtract the present weights from all that come, or nothing any more."""
        with self._changed:
            phone = self._phones.shown
            weights = () if phone is None else phone.weights
            self._neutral = np.array(weights) if own and weights else None
            self._show(self._clock())

    def choose(self, number: int) -> None:
        """Show another phone."""
        with self._changed:
            if self._phones.choose(number):
                self._neutral = None
                self._show(self._clock())

    def record(self, wanted: bool) -> None:
        """Begin or end a recording, if there is a file for it."""
        with self._changed:
            if self._recorder is not None:
                (self._recorder.start if wanted else self._recorder.stop)()

    def close(self) -> None:
        """End: what was recorded is then in its file."""
        with self._changed:
            self.closed = True
            if self._recorder is not None:
                self._recorder.stop()
            self._changed.notify_all()

    def outcome(self) -> Outcome:
        """What there was until now."""
        files = [] if self._recorder is None else self._recorder.files
        recorded = tuple((str(file), frames) for file, frames in files)
        return Outcome(self.status(), self.drawn, recorded)

    def _show(self, now: float) -> None:
        self._number += 1
        self._arrived = now
        self._changed.notify_all()
