"""Phones that send, and in which order their packets are: lost, late, twice, from the start again.

A network may lose packets, deliver them twice, and change their order. Of each phone the newest
frame is shown, so what comes after a later one is only counted. The number of a frame may also
leap, where a phone was told another time, or where somebody else sends under its id. So a leap is
believed after a silence, or when nothing else has come for a moment.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from itertools import count
from typing import Literal

from elastomorph.live.packets import FacePacket
from elastomorph.live.status import SILENT, PhoneStatus

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
