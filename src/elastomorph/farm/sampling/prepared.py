"""A recipe made ready for a rig: from random lanes to codes of all columns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.farm.sampling.anatomy import Anatomy
from elastomorph.farm.sampling.columns import LEVELS, Codes, Columns
from elastomorph.farm.sampling.controls import Controls, KeyedError, places_of
from elastomorph.farm.sampling.lanes import Lanes, whole_numbers
from elastomorph.farm.sampling.mixtures import Drawing
from elastomorph.farm.sampling.recipe import Recipe
from elastomorph.farm.sampling.rules import Excluding, slider_columns
from elastomorph.farm.sampling.singles import Single, scene_singles
from elastomorph.rig.rig import Rig

_CHOICE = 2
"""Lanes that say which mixture a face is of."""

_ON = LEVELS // 10


@dataclass(frozen=True, eq=False)
class Prepared:
    """How the faces of a rig are drawn.

    Attributes:
        sliders: How many columns are sliders; they come first.
        columns: All columns.
        drawings: The mixtures.
        bounds: (drawings - 1,) numbers below 2³² at which the next mixture begins.
        singles: What is drawn by itself, and its column.
        excluding: What the sliders must not do together.
        anatomy: What shapes of ARKit must not, where the recipe asks for it.
    """

    sliders: int
    columns: Columns
    drawings: Sequence[Drawing]
    bounds: NDArray[np.uint64]
    singles: Sequence[tuple[int, Single]]
    excluding: Sequence[Excluding]
    anatomy: Anatomy | None

    @classmethod
    def of(cls, recipe: Recipe, rig: Rig) -> Prepared:
        """A recipe for a rig.

        Raises:
            FormatError: It does not suit the rig; likewise a ParameterError.
            FileError: A file that it names cannot be read.
        """
        controls = _controls(recipe, rig)
        drawings = []
        for number, mixture in enumerate(recipe.mixtures):
            with recipe.naming("mixture", number):
                drawings.append(mixture.prepared(controls, recipe.kept(number)))
        excluding = []
        for number, exclusion in enumerate(recipe.exclusions):
            with recipe.naming("exclude", number):
                excluding.append(exclusion.prepared(controls))
        identity: list[tuple[int, Single]] = []
        if recipe.identity is not None:
            with recipe.naming("identity"):
                identity = list(recipe.identity.singles(controls))
        added = [recipe.timing.single()] if recipe.timing is not None else []
        added += scene_singles(recipe.scene)
        for single in added:
            if single.column.name in rig.names:
                raise ParameterError(
                    f"the rig has a slider {single.column.name!r}, which is the name of a column "
                    "of its own; rename it"
                )
        return cls(
            len(rig.names),
            Columns((*controls.columns, *(single.column for single in added)), controls.others),
            drawings,
            _bounds(recipe),
            [*identity, *enumerate(added, start=len(rig.names))],
            excluding,
            controls.anatomy,
        )

    @cached_property
    def lanes(self) -> int:
        """How many lanes of a face are used."""
        return self._own + max(drawing.lanes for drawing in self.drawings)

    @property
    def count(self) -> int | None:
        """How many faces there are; None where any number can be drawn."""
        return self.drawings[0].count if len(self.drawings) == 1 else None

    @property
    def tables(self) -> dict[str, NDArray[Any]]:
        """What was read from files, by names that `Recipe.kept` understands."""
        return {
            f"mixture-{number}-{name}": table
            for number, drawing in enumerate(self.drawings)
            for name, table in drawing.tables.items()
        }

    def draw(self, start: int, lanes: Lanes, out: Codes) -> None:
        """Fill (n, C) codes of the faces from a number on."""
        sliders = out[:, : self.sliders]
        self._mix(start, lanes, sliders)
        for number, (place, single) in enumerate(self.singles, start=_CHOICE):
            own = lanes[:, number]
            out[:, place] = own if single.table is None else single.table[own]
        if self.anatomy is not None:
            self.anatomy.open(sliders)
        for excluding in self.excluding:
            excluding.apply(sliders)
        if self.anatomy is not None:
            self.anatomy.close(sliders)

    def on(self, lanes: Lanes) -> list[NDArray[np.int64]]:
        """For each mixture, how many sliders are on by more than a tenth in (n,) of its faces."""
        rest = self.columns.rest[: self.sliders].astype(np.int32)
        own = lanes[:, self._own :]
        return [
            (np.abs(drawing.codes(own, None) - rest) > _ON).sum(axis=1) for drawing in self.drawings
        ]

    @property
    def _own(self) -> int:
        """Where the lanes of the mixture begin."""
        return _CHOICE + len(self.singles)

    def _mix(self, start: int, lanes: Lanes, out: Codes) -> None:
        own = lanes[:, self._own :]
        if len(self.drawings) == 1:
            rows = None if self.count is None else np.arange(start, start + len(lanes))
            out[:] = self.drawings[0].codes(own, rows)
            return
        choice = np.searchsorted(self.bounds, whole_numbers(lanes[:, :_CHOICE]), side="right")
        for number, drawing in enumerate(self.drawings):
            chosen = np.flatnonzero(choice == number)
            out[chosen] = drawing.codes(own[chosen], None)


def _controls(recipe: Recipe, rig: Rig) -> Controls:
    if not rig.names:
        raise ParameterError("the rig has no sliders, so all its faces are the neutral")
    others: list[int] = []
    ranges = {}
    if recipe.identity is not None:
        with recipe.naming("identity"):
            others = places_of(rig.sliders, recipe.identity.sliders, ("sliders",))
        ranges = dict.fromkeys(others, recipe.identity.range)
    with recipe.naming():
        for name, vertex in recipe.landmarks.items():
            if vertex >= len(rig.neutral.vertices):
                raise KeyedError(
                    ("landmarks", name),
                    f"there is no vertex {vertex:,}; the rig has {len(rig.neutral.vertices):,}",
                )
        columns = slider_columns(rig.sliders, recipe.limits, ranges)
    anatomy = Anatomy.of(columns.columns, frozenset(others)) if recipe.anatomy else None
    return Controls(rig.sliders, columns, frozenset(others), recipe.document.path.parent, anatomy)


def _bounds(recipe: Recipe) -> NDArray[np.uint64]:
    shares = np.cumsum([mixture.share for mixture in recipe.mixtures])
    bounds = np.rint(shares / shares[-1] * 2.0**32)
    never = np.flatnonzero(np.diff(bounds, prepend=0) == 0)
    if never.size:
        with recipe.naming("mixture", int(never[0])):
            raise KeyedError(("share",), "it is so small beside the others that no face has it")
    return np.asarray(bounds[:-1], dtype=np.uint64)
