"""Kinds of mixture: from random lanes to codes of sliders, many faces at once."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from elastomorph.farm.columns import Codes
from elastomorph.farm.controls import Controls, KeyedError
from elastomorph.farm.keys import key
from elastomorph.farm.lanes import Lanes
from elastomorph.farm.laws import sizes

Rows = NDArray[np.int64]


class Drawing(ABC):
    """A mixture made ready for a rig.

    Attributes:
        lanes: How many lanes of a face it uses.
        count: How many faces it has, where they are numbered; None where they are drawn.
    """

    lanes: int
    count: int | None = None

    @abstractmethod
    def codes(self, lanes: Lanes, rows: Rows | None) -> Codes:
        """(n, J) codes of all sliders from (n, lanes) bits; of the rows of the grid, if given."""


@dataclass(frozen=True, kw_only=True)
class Mixture(ABC):
    """How the sliders of some of the faces are drawn; frozen, one class a kind."""

    kind: ClassVar[str]
    share: float = key(1.0, "number", "how many of all faces, beside the others", "0.6", above=0)
    sliders: tuple[str, ...] = key(
        (), "texts", "names, patterns or groups; without them all", '["jaw*", "mouth*"]'
    )

    @abstractmethod
    def prepared(self, controls: Controls) -> Drawing:
        """The mixture for the sliders of a rig; a KeyedError says what does not suit them."""


@dataclass(frozen=True, kw_only=True)
class Sparse(Mixture):
    """Each slider on or off by itself, with a probability."""

    kind = "sparse"
    active: float = key(6.0, "number", "how many sliders are on, on average", "6", above=0)
    power: float = key(
        1.0, "number", "a slider that is on is at u^power of its range, u uniform", "2",
        above=0, most=100,
    )  # fmt: skip
    symmetric: float = key(
        0.7, "number", "how many of its faces have both sides alike", "0.5", least=0, most=1
    )

    def prepared(self, controls: Controls) -> Drawing:
        """See `Mixture`."""
        chosen = controls.chosen(self.sliders, ("sliders",))
        return _Sparse(self, controls, chosen)


class _Sparse(Drawing):
    def __init__(self, mixture: Sparse, controls: Controls, chosen: NDArray[np.intp]) -> None:
        count = len(chosen)
        if mixture.active > count:
            raise KeyedError(
                ("active",), f"{mixture.active:g} sliders cannot be on: it moves {count}"
            )
        self.lanes = 2 * count + 1
        self.chosen = chosen
        self.rest = controls.columns.rest
        self.last_on = max(round(mixture.active / count * 65536), 1) - 1
        self.least_unlike = round(mixture.symmetric * 65536)
        place = {column: i for i, column in enumerate(chosen.tolist())}
        pairs = [(place[a], place[b]) for a, b in controls.pairs if a in place and b in place]
        self.left, self.right = np.array(pairs, dtype=np.intp).reshape(-1, 2).T
        # Most rigs need no table: sliders from 0, of a size that is uniform.
        same = mixture.power == 1
        self.tables = {
            i: sizes(controls.columns[column], mixture.power)
            for i, column in enumerate(chosen.tolist())
            if not same or self.rest[column]
        }

    def codes(self, lanes: Lanes, rows: Rows | None) -> Codes:
        count = len(self.chosen)
        on = lanes[:, :count] <= self.last_on
        size = lanes[:, count : 2 * count] * on
        if self.left.size:
            alike = lanes[:, 2 * count, None] < self.least_unlike
            size[:, self.right] = np.where(alike, size[:, self.left], size[:, self.right])
        for place, table in self.tables.items():
            size[:, place] = table[size[:, place]]
        if count == len(self.rest):
            return size
        codes = np.repeat(self.rest[None], len(lanes), axis=0)
        codes[:, self.chosen] = size
        return codes
