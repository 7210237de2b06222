"""How far a run is, and sizes and times for people."""

from __future__ import annotations

import time
from dataclasses import dataclass, field

from elastomorph.farm.making.unit import Made


@dataclass
class Progress:
    """How far a run is. Its text is for people."""

    faces: int  # To be made in all
    done: int  # Finished, before this run and in it
    bytes: int = 0  # Written in this run
    before: int = field(default=0)  # Finished before this run
    start: float = field(default_factory=time.monotonic)

    def __post_init__(self) -> None:
        self.before = self.done

    def add(self, made: Made) -> None:
        """Count a unit."""
        self.done += made.faces
        self.bytes += made.bytes

    @property
    def rate(self) -> float:
        """Faces a second in this run."""
        return (self.done - self.before) / max(time.monotonic() - self.start, 1e-9)

    def __str__(self) -> str:
        left = (self.faces - self.done) / self.rate if self.rate else float("inf")
        per_face = self.bytes / max(self.done - self.before, 1)
        return (
            f"{self.done:,} of {self.faces:,} faces, {rate_text(self.rate)} a second, "
            f"{size_text(self.bytes)} written, {time_text(left)} and "
            f"{size_text((self.faces - self.done) * per_face)} to go"
        )


def size_text(size: float) -> str:
    """Bytes."""
    units = ("bytes", "kB", "MB", "GB", "TB", "PB")
    power = next((p for p in range(len(units) - 1) if size < 1000 ** (p + 1)), len(units) - 1)
    return f"{size / 1000**power:,.{min(power, 1)}f} {units[power]}"


def rate_text(rate: float) -> str:
    """So many a second."""
    return f"{rate:,.0f}" if rate >= 10 else f"{rate:.2g}"


def time_text(seconds: float) -> str:
    """A time."""
    if seconds == float("inf"):
        return "unknown time"
    if seconds < 120:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:,.1f} h"
