"""A live session: packets come in, the pose of one phone goes out, and everything is counted."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from elastomorph.live.packets import NAMES, PacketError, decode
from elastomorph.live.phones import Phones
from elastomorph.live.recording import Recorder
from elastomorph.live.status import Delay, Outcome, Recording, Status
from elastomorph.rig.performance import Match, head_angles, match

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
