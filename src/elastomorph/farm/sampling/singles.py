"""Columns that are drawn each by itself: time, identity, head, camera, light."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from elastomorph.errors import ParameterError
from elastomorph.farm.sampling.columns import LEVELS, TIME, Codes, Column
from elastomorph.farm.sampling.controls import Controls, KeyedError
from elastomorph.farm.sampling.keys import key
from elastomorph.farm.sampling.lanes import codes_of, normal
from elastomorph.farm.sampling.rules import FARTHEST, Span
from elastomorph.rig.timing import NAMES, by_name


@dataclass(frozen=True, eq=False)
class Single:
    """A column, and the code of each lane; None where each lane is its own code."""

    column: Column
    table: Codes | None = None


@dataclass(frozen=True, kw_only=True)
class Timing:
    """A common time of the paths of a face: its weights are then the ζ of `Rig.blend`."""

    range: Span = key(
        (0.0, 1.0), "span", "from where to where on the paths", "[0, 1]", least=-10, most=10
    )
    law: str = key(
        "linear", "text", f"how a uniform number becomes t: {', '.join(NAMES)}", '"minimum-jerk"'
    )

    def single(self) -> Single:
        """The column of times.

        Raises:
            KeyedError: There is no such law.
        """
        try:
            law = by_name(self.law)
        except ParameterError as error:
            raise KeyedError(("law",), str(error)) from None
        low, high = self.range
        times = low + (high - low) * law.at(np.arange(LEVELS + 1) / LEVELS)
        column = Column.within(TIME, float(times.min()), float(times.max()))
        return Single(column, codes_of(column, times))


@dataclass(frozen=True, kw_only=True)
class Identity:
    """Sliders that say who it is: no mixture moves them, each has its own number."""

    sliders: tuple[str, ...] = key(
        (), "texts", "names, patterns or groups", '["identity*"]', needed=True
    )
    range: Span = key(
        (-3.0, 3.0),
        "span",
        "their limits, where [limits] has none",
        "[-2, 2]",
        least=-FARTHEST,
        most=FARTHEST,
    )
    law: str = key(
        "normal", "text", "normal, cut off at the limits, or uniform", '"uniform"',
        choices=("normal", "uniform"),
    )  # fmt: skip
    mean: float = key(0.0, "number", "of the normal law", "0.5")
    deviation: float = key(1.0, "number", "of the normal law", "0.7", above=0, most=FARTHEST)

    def singles(self, controls: Controls) -> Iterator[tuple[int, Single]]:
        """The place and the law of each slider.

        Raises:
            KeyedError: The mean is out of their limits, or there is one of a law that has none.
        """
        if self.law == "uniform" and (self.mean, self.deviation) != (0.0, 1.0):
            raise KeyedError(
                ("law",), "'mean' and 'deviation' are of the normal law, not of the uniform one"
            )
        for place in sorted(controls.others):
            column = controls.columns[place]
            if self.law == "uniform":
                yield place, Single(column)
                continue
            try:
                values = normal(column.low, column.high, self.mean, self.deviation)
            except ParameterError as error:
                raise KeyedError(("mean",), f"of {column.name!r} {error}") from None
            yield place, Single(column, codes_of(column, values))


def scene_singles(scene: Mapping[str, Span]) -> list[Single]:
    """Head, camera, light and background: each uniform in its range."""
    return [Single(Column(name, *span)) for name, span in scene.items()]
