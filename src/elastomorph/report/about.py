"""What a report says of a comparison that the comparison itself does not know."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from elastomorph.model.morph import Morph
from elastomorph.paths import Method

__all__ = ["About"]


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
