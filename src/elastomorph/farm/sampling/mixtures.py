"""Kinds of mixture: from random lanes to codes of sliders, many faces at once."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from elastomorph.farm.sampling.columns import LEVELS, Codes, Columns
from elastomorph.farm.sampling.controls import Controls, KeyedError, Places
from elastomorph.farm.sampling.keys import key
from elastomorph.farm.sampling.lanes import Lanes, below
from elastomorph.farm.sampling.laws import gamma, sizes

Rows = NDArray[np.int64]
Tables = Mapping[str, NDArray[Any]]

_MOST_IN_GRID = 2**31
_CHANCES = LEVELS + 1


class Drawing(ABC):
    """A mixture made ready for a rig.

    Attributes:
        lanes: How many lanes of a face it uses.
        count: How many faces it has, where they are numbered; None where they are drawn.
        tables: Arrays that it read from files, by name.
        said: What else there is to say of it on this rig, for people.
    """

    lanes: int
    count: int | None = None
    tables: Tables = {}  # noqa: RUF012  (a default that nobody changes)
    said: str = ""

    def __init__(self, controls: Controls, chosen: Places) -> None:
        self.chosen = chosen
        self.columns = Columns(tuple(controls.columns[int(place)] for place in chosen))
        self._rest = controls.columns.rest
        self._all = len(chosen) == len(self._rest)

    def codes(self, lanes: Lanes, rows: Rows | None) -> Codes:
        """(n, J) codes of all sliders from (n, lanes) bits; those that are not chosen at rest.

        With (n,) rows, the faces of these numbers where faces are numbered.
        """
        own = self.draw(lanes, rows)
        if self._all:
            return own
        codes = np.repeat(self._rest[None], len(own), axis=0)
        codes[:, self.chosen] = own
        return codes

    @abstractmethod
    def draw(self, lanes: Lanes, rows: Rows | None) -> Codes:
        """(n, chosen) codes of the sliders that it moves."""


@dataclass(frozen=True, kw_only=True)
class Mixture(ABC):
    """How the sliders of some of the faces are drawn; one class a kind."""

    kind: ClassVar[str]
    share: float = key(
        1.0, "number", "how many of all faces, beside the others", "0.6", above=0, most=1e9
    )
    sliders: tuple[str, ...] = key(
        (), "texts", "names, patterns or groups that it moves; all by default", '["jaw*", "lids"]'
    )

    def prepared(self, controls: Controls, tables: Tables | None = None) -> Drawing:
        """The mixture for the sliders of a rig, with the tables that were kept or from its files.

        Raises:
            KeyedError: It does not suit the rig.
            FileError: A file that it names cannot be read.
        """
        return self._drawing(controls, controls.chosen(self.sliders, ("sliders",)), tables)

    @abstractmethod
    def _drawing(self, controls: Controls, chosen: Places, tables: Tables | None) -> Drawing: ...


@dataclass(frozen=True, kw_only=True)
class Sparse(Mixture):
    """Each slider on or off by itself."""

    kind = "sparse"
    active: float | None = key(
        None, "number", "how many are on, on average; by default 6, or half of fewer than 12", "6",
        above=0,
    )  # fmt: skip
    power: float = key(
        1.0, "number", "a slider that is on is at u^power of its range, u uniform", "2",
        above=0, most=100,
    )  # fmt: skip
    symmetric: float = key(
        0.7, "number", "share of its faces whose sides are alike", "0.5", least=0, most=1
    )

    def _drawing(self, controls: Controls, chosen: Places, tables: Tables | None) -> Drawing:
        return _Sparse(self, controls, chosen)


class _Sparse(Drawing):
    def __init__(self, mixture: Sparse, controls: Controls, chosen: Places) -> None:
        super().__init__(controls, chosen)
        count = len(chosen)
        active = min(6, count / 2) if mixture.active is None else mixture.active
        chances = round(active / count * _CHANCES)
        if not 0 < chances <= _CHANCES:
            raise KeyedError(
                ("active",),
                f"of {count} sliders {active:g} cannot be on, on average; from "
                f"{count / _CHANCES:.2g} to {count} can",
            )
        self.lanes = 2 * count + 1
        self.last_on = chances - 1
        self.least_unlike = round(mixture.symmetric * _CHANCES)
        place = {int(column): i for i, column in enumerate(chosen)}
        pairs = [(place[a], place[b]) for a, b in controls.pairs if a in place and b in place]
        self.said = f"; {len(pairs)} pairs of sides"
        self.left, self.right = np.array(pairs, dtype=np.intp).reshape(-1, 2).T
        # A table for all sliders that rest at one code; one from 0 of a uniform size needs none.
        self.sizes = [
            (np.flatnonzero(self.columns.rest == rest), sizes(int(rest), mixture.power))
            for rest in np.unique(self.columns.rest)
            if mixture.power != 1 or rest
        ]

    def draw(self, lanes: Lanes, rows: Rows | None) -> Codes:
        count = len(self.chosen)
        size = lanes[:, count : 2 * count] * (lanes[:, :count] <= self.last_on)
        if self.left.size:
            alike = lanes[:, 2 * count, None] < self.least_unlike
            size[:, self.right] = np.where(alike, size[:, self.left], size[:, self.right])
        for places, table in self.sizes:
            if len(places) == count:
                return table[size]
            size[:, places] = table[size[:, places]]
        return size


@dataclass(frozen=True, kw_only=True)
class Uniform(Mixture):
    """Each slider anywhere in its range."""

    kind = "uniform"

    def _drawing(self, controls: Controls, chosen: Places, tables: Tables | None) -> Drawing:
        return _Uniform(controls, chosen)


class _Uniform(Drawing):
    def __init__(self, controls: Controls, chosen: Places) -> None:
        super().__init__(controls, chosen)
        self.lanes = len(chosen)

    def draw(self, lanes: Lanes, rows: Rows | None) -> Codes:
        return lanes[:, : self.lanes]


@dataclass(frozen=True, kw_only=True)
class Dirichlet(Mixture):
    """Weights of one sum, drawn by Dirichlet's law."""

    kind = "dirichlet"
    concentration: float = key(
        1.0, "number", "1: all mixtures alike; less: few sliders each", "0.3", least=0.05, most=1000
    )
    sum: float = key(
        1.0, "number", "of the weights of a face, before limits", "1.5", above=0, most=1e6
    )

    def _drawing(self, controls: Controls, chosen: Places, tables: Tables | None) -> Drawing:
        return _Dirichlet(self, controls, chosen)


class _Dirichlet(Drawing):
    def __init__(self, mixture: Dirichlet, controls: Controls, chosen: Places) -> None:
        super().__init__(controls, chosen)
        most = sum(max(column.high, 0.0) for column in self.columns)
        least = sum(max(column.low, 0.0) for column in self.columns)
        if mixture.sum < least * (1 - 1e-9):
            raise KeyedError(
                ("sum",),
                f"weights whose limits add up to at least {least:g} cannot sum to {mixture.sum:g}",
            )
        if mixture.sum > most * (1 + 1e-9):
            raise KeyedError(
                ("sum",), f"weights whose limits add up to {most:g} cannot sum to {mixture.sum:g}"
            )
        self.lanes = len(chosen)
        self.sum = mixture.sum
        # Numbers of gamma laws over their sum are of Dirichlet's.
        self.quantiles = gamma(mixture.concentration)

    def draw(self, lanes: Lanes, rows: Rows | None) -> Codes:
        parts = self.quantiles[lanes[:, : self.lanes]]
        return self.columns.encode(parts * (self.sum / parts.sum(axis=1, keepdims=True)))


@dataclass(frozen=True, kw_only=True)
class Grid(Mixture):
    """All combinations of levels, but the one of the lowest; alone in a recipe, in their order."""

    kind = "grid"
    levels: int = key(
        6, "whole", "values of each slider, evenly over its range", "6", least=2, most=_CHANCES
    )
    normalize: bool = key(False, "flag", "divide the weights of a face by their sum", "true")

    def _drawing(self, controls: Controls, chosen: Places, tables: Tables | None) -> Drawing:
        return _Grid(self, controls, chosen)


class _Grid(Drawing):
    lanes = 2

    def __init__(self, mixture: Grid, controls: Controls, chosen: Places) -> None:
        # What has one value only has no levels: each face would be there several times.
        chosen = np.array([i for i in chosen if controls.columns[int(i)].varies], dtype=np.intp)
        if not chosen.size:
            raise KeyedError(("sliders",), "their limits leave each of these sliders one value")
        super().__init__(controls, chosen)
        self.base = mixture.levels
        if self.base ** len(chosen) > _MOST_IN_GRID:
            raise KeyedError(
                ("sliders",) if mixture.sliders else (),
                f"{self.base} levels of {len(chosen)} sliders are more than {_MOST_IN_GRID:,} "
                "faces; name fewer sliders or fewer levels",
            )
        if mixture.normalize and any(column.low < 0 for column in self.columns):
            raise KeyedError(("normalize",), "weights below 0 cannot be divided by their sum")
        self.count: int = self.base ** len(chosen) - 1
        self.normalize = mixture.normalize
        self.places = self.base ** np.arange(len(chosen) - 1, -1, -1)
        steps = np.arange(self.base)
        self.steps = np.rint(steps * LEVELS / (self.base - 1)).astype(np.uint16)

    def draw(self, lanes: Lanes, rows: Rows | None) -> Codes:
        numbers = below(lanes, self.count) if rows is None else rows
        codes: Codes = self.steps[(numbers[:, None] + 1) // self.places % self.base]
        if self.normalize:
            values = self.columns.decode(codes)
            codes = self.columns.encode(values / values.sum(axis=1, keepdims=True))
        return codes
