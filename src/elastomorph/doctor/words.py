"""Counts and lists inside sentences."""

from __future__ import annotations

from collections.abc import Iterable, Sized

__all__ = ["counted", "listed", "percent"]


def counted(things: Sized | int, one: str, many: str) -> str:
    """A number and its noun: ``1 edge has``, ``2,000 edges have``."""
    count = things if isinstance(things, int) else len(things)
    return f"{count:,} {one if count == 1 else many}"


def listed(things: Iterable[object], most: int = 5) -> str:
    """The first few things, and dots if there are more."""
    names = [str(thing) for thing in things]
    return ", ".join(names[:most]) + (", …" if len(names) > most else "")


def percent(share: float) -> str:
    """A share in percent with as many digits as say something: ``0.67 %``, ``12 %``."""
    value = 100.0 * share
    if 0.0 < value < 0.0005:
        return "less than 0.001 %"
    digits = 0 if value >= 9.95 else 1 if value >= 0.995 else 2 if value >= 0.0995 else 3
    return f"{value:,.{digits}f} %"
