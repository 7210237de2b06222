"""Sizes and times for people."""

from __future__ import annotations


def size_text(size: float) -> str:
    """Bytes."""
    units = ("bytes", "kB", "MB", "GB", "TB", "PB")
    power = next((p for p in range(len(units) - 1) if size < 1000 ** (p + 1)), len(units) - 1)
    return f"{size / 1000**power:,.{min(power, 1)}f} {units[power]}"


def time_text(seconds: float) -> str:
    """A time."""
    if seconds == float("inf"):
        return "unknown time"
    if seconds < 120:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:,.1f} h"
