"""What a report says of a comparison that the comparison itself does not know."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from elastomorph.model.morph import Morph
from elastomorph.paths import Method

__all__ = ["SPACE", "About", "Lengths", "listed", "percent", "share_of", "significant"]

SPACE = "\u00a0"
"""Between a number and its unit, which belong on one line."""


@dataclass(frozen=True, eq=False)
class About:
    """Where a recording came from and how it was compared.

    Attributes:
        name: What the report is about, such as ``built-in head`` or the name of a file.
        source: What the frames are, in a sentence.
        unit: Unit of the coordinates, such as ``cm``; an empty string where nobody knows it.
        call: The command or the call that makes this report again.
        curves: Where the curves come from, in a sentence.
        methods: The methods by their labels, with all settings; those left out are described by
            what their paths say of themselves.
        timing_known: Whether the frames were recorded at their times. Where a motion is only known
            as a way, such as that of a rigid part, errors at given times mean nothing.
        remarks: Further findings, in sentences.
    """

    name: str = "a recorded motion"
    source: str = ""
    unit: str = ""
    call: str = ""
    curves: str = "traced along the edges of the polygons, every vertex on one curve"
    methods: Mapping[str, Method | Morph] = field(default_factory=dict)
    timing_known: bool = True
    remarks: tuple[str, ...] = ()

    @property
    def truth(self) -> str:
        """What the methods are compared with, in a word or two."""
        return "recorded" if self.timing_known else "known way"


@dataclass(frozen=True)
class Lengths:
    """Writes fractions of D as lengths.

    Attributes:
        diameter: D in the unit of the vertices; None for several motions, each with its own D.
        unit: Its name, or an empty string.
    """

    diameter: float | None
    unit: str = ""

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

    @property
    def several(self) -> bool:
        """Whether the errors are means over several motions."""
        return self.diameter is None


def percent(fraction: float) -> str:
    """A fraction of D, such as "1.37 % of D"."""
    return f"{significant(100 * fraction)}{SPACE}% of D"


def significant(value: float) -> str:
    """Three significant digits, never in powers of ten for what people measure on faces."""
    if abs(value) >= 999.5:
        return f"{value:,.0f}"
    return f"{value:#.3g}".rstrip(".") if value else "0"


def share_of(fraction: float) -> str:
    """A share, such as "23 %"."""
    return f"{100 * fraction:.0f}{SPACE}%"


def listed(words: Sequence[str]) -> str:
    """Words as in "a, b and c"."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
