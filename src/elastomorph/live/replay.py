"""Sends a recorded take as a phone would: for people without one, for tests and for measuring."""

from __future__ import annotations

import random
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.live.packets import NAMES, FacePacket, encode
from elastomorph.rig.performance import Performance, match
from elastomorph.viewer.listening import LOOPBACK

_PER_SECOND = 60
_DEVICE = "elastomorph replay"


@dataclass(frozen=True)
class Weather:
    """What a network does to packets, each as a probability or in seconds.

    Attributes:
        lost: Part that never arrives.
        shuffled: Part that arrives after the next one.
        jitter: Seconds by which packets are late, at most.
    """

    lost: float = 0.0
    shuffled: float = 0.0
    jitter: float = 0.0


CALM = Weather()


def packets_of(
    take: Performance, subject: str = "replay", first: float = 0.0, device: str = _DEVICE
) -> Iterator[tuple[float, FacePacket]]:
    """The packets of a take and when to send them, in seconds; it begins again at its end.

    Args:
        take: The take; its weights are found by their names.
        subject: Name to send them under.
        first: Seconds since midnight of the first frame.
        device: Id of the phone.

    Raises:
        ParameterError: It has no weight of ARKit.
    """
    weights = _as_sent(take)
    times = take.times - take.times[0]
    period = float(times[-1]) + 1 / take.rate
    turn = 0
    while True:
        for when, row in zip(times.tolist(), weights.tolist(), strict=True):
            seconds = turn * period + when
            # As exact as takes are: single precision would round what is closer to 1 up to it.
            count = round((first + seconds) * _PER_SECOND, 3)
            frame = int(count)
            part = round(count - frame, 3)
            frame %= _PER_SECOND * 86_400
            yield seconds, FacePacket(device, subject, frame, part, (_PER_SECOND, 1), tuple(row))
        turn += 1


def _as_sent(take: Performance) -> NDArray[np.float64]:
    """(T, 61) the weights of a take in the order of packets."""
    found = match(take.names, NAMES)
    if not found.drives:
        raise ParameterError(f"{take.source or 'the take'} has no weight by a name of ARKit")
    table = found.drive(take.weights)
    places = {name.casefold(): place for place, name in enumerate(take.names)}
    for column, name in enumerate(NAMES):
        if name.casefold() in places and name not in found.drives:
            table[:, column] = take.weights[:, places[name.casefold()]]
    return table


class Replay:
    """Sends while it is entered with ``with``, at the rate of the take.

    Args:
        take: What to send.
        port: To which port.
        host: Of which machine.
        subject: Name to send it under.
        weather: What happens to the packets on their way.
        seed: Of what is left to chance.
        pace: How many times as fast as it was recorded.
        device: Id of the phone.
    """

    def __init__(
        self,
        take: Performance,
        port: int,
        host: str = LOOPBACK,
        *,
        subject: str = "replay",
        weather: Weather = CALM,
        seed: int = 0,
        pace: float = 1.0,
        device: str = _DEVICE,
    ) -> None:
        now = time.localtime()
        first = (now.tm_hour * 60 + now.tm_min) * 60 + now.tm_sec
        self._packets = packets_of(take, subject, first, device)
        self._where = (host, port)
        self._weather, self._pace = weather, pace
        self._chance = random.Random(seed)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self.sent = self.lost = self.shuffled = 0

    def __enter__(self) -> Replay:
        self._thread.start()
        return self

    def __exit__(self, *error: object) -> None:
        self._ended.set()
        self._thread.join()

    def _run(self) -> None:
        kept: bytes | None = None
        begun = time.monotonic()
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            for seconds, packet in self._packets:
                late = self._chance.uniform(0, self._weather.jitter)
                if self._ended.wait(
                    max(0.0, begun + seconds / self._pace + late - time.monotonic())
                ):
                    return
                if self._chance.random() < self._weather.lost:
                    self.lost += 1
                    continue
                content = encode(packet)
                if kept is None and self._chance.random() < self._weather.shuffled:
                    kept = content
                    self.shuffled += 1
                    continue
                for one in (content, kept):
                    if one is not None:
                        # Where nobody listens, some systems say so; a phone goes on all the same.
                        with suppress(OSError):
                            sender.sendto(one, self._where)
                        self.sent += 1
                kept = None
