"""Streams for tests: packets with chosen times and weights."""

from __future__ import annotations

import time
from collections.abc import Callable

from elastomorph.live.packets import NAMES, FacePacket


def weights(**named: float) -> tuple[float, ...]:
    """Weights of a packet by their names, the others 0."""
    assert set(named) <= set(NAMES)
    return tuple(named.get(name, 0.0) for name in NAMES)


def packet(
    frame: int,
    *,
    subject: str = "iPhone",
    device: str = "one",
    rate: tuple[int, int] = (60, 1),
    face: tuple[float, ...] | None = None,
) -> FacePacket:
    """A packet of a frame, whose jaw opens with its number unless it shows another face."""
    jaw = weights(JawOpen=frame % 64 / 64)  # exact in single precision
    return FacePacket(device, subject, frame, 0.0, rate, jaw if face is None else face)


def wait(condition: Callable[[], bool], seconds: float = 240) -> None:
    """Waits until something is so."""
    until = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < until, "it did not happen"
        time.sleep(0.01)
