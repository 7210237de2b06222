"""The sliders of a rig as a recipe speaks of them: by name, by pattern, by group, within limits.

Names also tell what the shapes of ARKit do not do together on a face. Where each slider is drawn by
itself, eyes look two ways at once, antagonists pull together, and `mouthClose`, which shuts the
lips of an open jaw, acts on a shut one. Nobody makes such faces. A rig whose sliders no table knows
has no such rules.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from elastomorph.character.document import Where, nearest
from elastomorph.errors import ParameterError
from elastomorph.farm.sampling.columns import LEVELS, Codes, Column, Columns
from elastomorph.farm.sampling.keys import key
from elastomorph.rig.naming import shape_of, side_pairs
from elastomorph.rig.sliders import Sliders

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


Places = NDArray[np.intp]


class KeyedError(ParameterError):
    """A value of a recipe that does not suit the rig, and the key that has it."""

    def __init__(self, where: Where, problem: str) -> None:
        self.where = where
        super().__init__(problem)


def places_of(sliders: Sliders, words: Iterable[str], where: Where) -> list[int]:
    """Columns of the sliders that words name, rising: names, patterns such as eye*, or groups."""
    columns = {name: i for i, name in enumerate(sliders.names)}
    found: set[int] = set()
    for word in dict.fromkeys(words):
        own = columns.keys() & ({word} if word in columns else sliders.groups.get(word, ()))
        chosen = [columns[name] for name in own]
        chosen = chosen or [i for name, i in columns.items() if fnmatchcase(name, word)]
        if not chosen:
            hint = nearest(word, (*sliders.names, *sliders.groups))
            raise KeyedError(where, f"the rig has no slider, group or pattern {word!r}: {hint}")
        found.update(chosen)
    return sorted(found)


@dataclass(frozen=True)
class Controls:
    """Sliders within limits.

    Attributes:
        sliders: Of the rig.
        columns: One for each, with its limits.
        others: Columns that no mixture moves: the identity.
        folder: Where the files of the recipe are.
        anatomy: What shapes of ARKit must not do together, where the recipe asks for it.
    """

    sliders: Sliders
    columns: Columns
    others: frozenset[int] = frozenset()
    folder: Path = Path()
    anatomy: Anatomy | None = None

    def chosen(self, words: tuple[str, ...], where: Where) -> Places:
        """Columns of the sliders that a mixture moves: those named or all, never the identity."""
        named = places_of(self.sliders, words, where) if words else range(len(self.columns))
        found = [place for place in named if place not in self.others]
        if not found:
            raise KeyedError(where, "only sliders of the identity are left, which no mixture moves")
        return np.array(found, dtype=np.intp)

    @cached_property
    def pairs(self) -> list[tuple[int, int]]:
        """Columns of the left and the right half of one shape."""
        coupled = self.anatomy.coupled if self.anatomy is not None else set()
        return [pair for pair in side_pairs(self.sliders.names) if coupled.isdisjoint(pair)]


# Rules between the sliders of a face: limits of each, and what excludes what.

Span = tuple[float, float]

FARTHEST = 1000.0
"""The largest weight that a slider may have, on either side of 0."""


def slider_columns(
    sliders: Sliders, limits: Mapping[str, Span], own: Mapping[int, Span]
) -> Columns:
    """A column for each slider, within its limits.

    What a slider's own name says goes before what its group or a pattern says, and that before what
    is its own by default, which is 0 to 1 for most.

    Raises:
        KeyedError: The rig has none of that name, or two groups or patterns differ.
    """
    names = sliders.names
    spans: dict[int, Span] = {}
    by: dict[int, str] = {}
    for name in sorted(limits, key=names.__contains__):
        where, span = ("limits", name), limits[name]
        for place in places_of(sliders, [name], where):
            if name not in names and spans.setdefault(place, span) != span:
                raise KeyedError(
                    where,
                    f"{by[place]!r} and {name!r} give {names[place]!r} different limits; give it "
                    "limits of its own",
                )
            spans[place], by[place] = span, name
    spans = {**own, **spans}
    return Columns(
        tuple(Column.within(name, *spans.get(i, (0.0, 1.0))) for i, name in enumerate(names))
    )


@dataclass(frozen=True, kw_only=True)
class Exclusion:
    """What sliders are not at the same time."""

    sliders: tuple[str, ...] = key(
        (), "texts", "names, patterns or groups", '["mouthPress*", "jawOpen"]', needed=True
    )
    most: float | None = key(
        None, "number", "most that their weights may sum to; they are scaled down together", "1.0",
        least=0,
    )  # fmt: skip
    one: bool = key(False, "flag", "only the largest of them stays", "true")

    def prepared(self, controls: Controls) -> Excluding:
        """The rule for the sliders of a rig.

        Raises:
            KeyedError: It does not suit the rig, or can never hold.
        """
        places = places_of(controls.sliders, self.sliders, ("sliders",))
        if self.one == (self.most is not None):
            raise KeyedError((), "an exclusion has either 'most', a number, or 'one = true'")
        if len(places) < 2 and self.one:
            raise KeyedError(("sliders",), "one slider alone excludes nothing; name two or more")
        columns = [controls.columns[place] for place in places]
        least = [abs(min(max(0.0, column.low), column.high)) for column in columns]
        names = ", ".join(c.name for c, at in zip(columns, least, strict=True) if at > 0)
        if self.one and sum(at > 0 for at in least) > 1:
            raise KeyedError(
                ("one",), f"the limits of {names} leave out 0, so each of them always stays"
            )
        if self.most is not None and sum(least) > self.most:
            raise KeyedError(
                ("most",),
                f"the limits of {names} alone add up to {sum(least):g}, so their sum is never at "
                f"most {self.most:g}",
            )
        return Excluding(
            np.array(places, dtype=np.intp),
            np.array([column.rest for column in columns]),
            np.array([(column.high - column.low) / LEVELS for column in columns]),
            None if self.most is None else self.most - sum(least),
        )


@dataclass(frozen=True, eq=False)
class Excluding:
    """An exclusion of some columns; how far they are from rest counts, on either side of it.

    It brings sliders nearer to rest and never farther, so that what another has done stays true.
    """

    places: NDArray[np.intp]
    rest: NDArray[np.int64]
    step: NDArray[np.float64]
    most: float | None  # of what is beyond rest; None where only the largest stays

    def apply(self, codes: Codes) -> None:
        """Make the rule hold in (n, C) codes."""
        far = codes[:, self.places] - self.rest
        size = np.abs(far) * self.step
        if self.most is None:
            largest = size.argmax(axis=1)
            kept = np.where(np.arange(len(self.places)) == largest[:, None], far, 0)
            codes[:, self.places] = (self.rest + kept).astype(np.uint16)
            return
        total = np.zeros(len(codes))
        for column in size.T:  # in one order, so that all processors round alike
            total += column
        rows = np.flatnonzero(total > self.most)
        part = np.trunc(far[rows] * (self.most / total[rows])[:, None])
        codes[np.ix_(rows, self.places)] = (self.rest + part).astype(np.uint16)
