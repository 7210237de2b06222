"""What the shapes of ARKit do not do together on a face, told by their names.

Where each slider is drawn by itself, eyes look two ways at once, antagonists pull together, and
`mouthClose`, which shuts the lips of an open jaw, acts on a shut one. Nobody makes such faces. A
rig whose sliders no table knows has no such rules.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from elastomorph.farm.sampling.columns import LEVELS, Codes, Column
from elastomorph.rig.performance.naming import shape_of

_GAZE = (
    ("eyeLookOutLeft", "eyeLookInRight"),
    ("eyeLookOutRight", "eyeLookInLeft"),
    ("eyeLookUpLeft", "eyeLookUpRight"),
    ("eyeLookDownLeft", "eyeLookDownRight"),
)
"""What both eyes do together: to the left, to the right, up, down. The second does as the first."""

_APART = (
    ("eyeLookOutLeft", "eyeLookOutRight"),
    ("eyeLookUpLeft", "eyeLookDownLeft"),
    ("jawLeft", "jawRight"),
    ("mouthLeft", "mouthRight"),
    ("jawOpen", "cheekPuff"),
    ("mouthPucker", "mouthFunnel"),
    *(
        (first.format(side), second.format(side))
        for side in ("Left", "Right")
        for first, second in (
            ("eyeWide{}", "eyeBlink{}"),
            ("eyeWide{}", "eyeSquint{}"),
            ("browDown{}", "browOuterUp{}"),
            ("browDown{}", "browInnerUp{}"),
            ("browDown{}", "browInnerUp"),
            ("mouthSmile{}", "mouthFrown{}"),
            ("mouthStretch{}", "mouthPucker"),
            ("mouthStretch{}", "mouthFunnel"),
            ("mouthUpperUp{}", "mouthRollUpper"),
            ("mouthLowerDown{}", "mouthRollLower"),
            ("mouthPress{}", "jawOpen"),
            ("cheekPuff{}", "jawOpen"),
        )
    ),
)
"""Antagonists: of two, only the larger stays."""

_WITHIN = (("mouthClose", "jawOpen"),)
"""The first is at most the second: where it is drawn larger, the second comes along."""


class _Pair(NamedTuple):
    """Columns of two sliders."""

    first: int
    second: int


@dataclass(frozen=True, eq=False)
class Anatomy:
    """The rules that the sliders of one rig have.

    Attributes:
        columns: Of the sliders.
        gaze: Sliders of which the second has the weight of the first.
        apart: Antagonists.
        within: Sliders of which the first is at most the second.
    """

    columns: Sequence[Column]
    gaze: Sequence[_Pair]
    apart: Sequence[_Pair]
    within: Sequence[_Pair]

    @classmethod
    def of(cls, columns: Sequence[Column], others: frozenset[int]) -> Anatomy:
        """The rules for sliders by their names; `others` are of the identity and have none.

        Only sliders that rest at 0 and go to one side are known to pull as their names say.
        """
        places = {
            shape_of(column.name): place
            for place, column in reversed(list(enumerate(columns)))
            if place not in others and column.low == 0 < column.high
        }

        def pairs(names: Sequence[tuple[str, str]]) -> list[_Pair]:
            return [
                _Pair(places[first], places[second])
                for first, second in names
                if first in places and second in places
            ]

        return cls(columns, pairs(_GAZE), pairs(_APART), pairs(_WITHIN))

    @property
    def coupled(self) -> set[int]:
        """Columns of the gaze: their sides are not alike but look to one place."""
        return {place for pair in self.gaze for place in pair}

    def open(self, codes: Codes) -> None:
        """Bring along what others need: the only rule that moves a slider away from rest."""
        for first, second in self.within:
            codes[:, second] = np.maximum(codes[:, second], self._seen(codes, first, second))

    def close(self, codes: Codes) -> None:
        """Make all rules hold in (n, C) codes; nothing moves away from rest but coupled eyes."""
        for first, second in self.apart:
            larger = codes[:, first] >= self._seen(codes, second, first)
            codes[larger, second] = 0
            codes[~larger, first] = 0
        for first, second in self.within:
            codes[:, first] = np.minimum(codes[:, first], self._seen(codes, second, first))
        for first, second in self.gaze:
            codes[:, second] = self._seen(codes, first, second)

    def _seen(self, codes: Codes, place: int, by: int) -> Codes:
        """The weights of a column as codes of another, whose range may be another."""
        own, other = self.columns[place].high, self.columns[by].high
        weights: Codes = codes[:, place]
        if own != other:
            weights = np.minimum(np.floor(weights * (own / other)), LEVELS).astype(np.uint16)
        return weights

    def __str__(self) -> str:
        """Such as "eyes look one way, 21 pairs of antagonists apart, mouthClose within jawOpen"."""
        names = [(self.columns[a].name, self.columns[b].name) for a, b in self.within]
        said = ["eyes look one way"] if self.gaze else []
        said += [f"{len(self.apart)} pairs of antagonists apart"] if self.apart else []
        return ", ".join(said + [f"{a} within {b}" for a, b in names])
