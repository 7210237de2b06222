"""How numbers, lengths and lists are written in sentences."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

SPACE = "\u00a0"
"""Between a number and its unit, which belong on one line."""
NOTHING = 1e-9
"""What rounding leaves of an error of 0, as a fraction of D or a length: it reads as 0."""


@dataclass(frozen=True)
class Lengths:
    """Writes fractions of D as lengths."""

    # D in the unit of the vertices; None for several motions, each with its own D.
    diameter: float | None
    unit: str = ""  # Its name, or an empty string

    def __call__(self, fraction: float) -> str:
        """Such as "0.412 cm (1.37 % of D)"."""
        if self.diameter is None:
            return percent(fraction)
        return f"{self.plain(fraction)} ({percent(fraction)})"

    def plain(self, fraction: float) -> str:
        """Such as "0.412 cm", or a share of D where there is no one D."""
        if self.diameter is None:
            return percent(fraction)
        return f"{significant(fraction * self.diameter)}{SPACE}{self.unit or 'units'}"


def percent(fraction: float) -> str:
    """A fraction of D, such as "1.37 % of D"."""
    return f"{significant(100 * fraction)}{SPACE}% of D"


def significant(value: float) -> str:
    """Three significant digits, never in powers of ten for what people measure on faces."""
    if abs(value) >= 999.5:
        return f"{value:,.0f}"
    return f"{value:#.3g}".rstrip(".") if abs(value) > NOTHING else "0"


def share_of(fraction: float) -> str:
    """A share, such as "23 %"."""
    return f"{100 * fraction:.0f}{SPACE}%"


def listed(words: Sequence[str]) -> str:
    """Words as in "a, b and c"."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def counted(number: int, one: str, several: str = "") -> str:
    """A number of things, such as "1 frame" or "5,071 vertices"."""
    return f"{number:,} {one if number == 1 else several or one + 's'}"
