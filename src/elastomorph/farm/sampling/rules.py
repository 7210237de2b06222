"""Rules between the sliders of a face: limits of each, and what excludes what."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.farm.sampling.columns import LEVELS, Codes, Column, Columns
from elastomorph.farm.sampling.controls import Controls, KeyedError, places_of
from elastomorph.farm.sampling.keys import key
from elastomorph.rig.sliders import Sliders

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
