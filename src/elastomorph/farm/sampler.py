"""Faces by number: codes of all columns of any rows, the same however the work is split."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.farm.columns import LEVELS, Codes, Columns
from elastomorph.farm.controls import Controls, KeyedError, places_of
from elastomorph.farm.lanes import Lanes, random_lanes, stride_of, whole_numbers
from elastomorph.farm.mixtures import Drawing
from elastomorph.farm.reading_recipes import read_recipe, recipe_from, recipe_from_text
from elastomorph.farm.recipe import Recipe
from elastomorph.farm.rules import slider_columns
from elastomorph.farm.singles import scene_singles
from elastomorph.numbers import is_whole
from elastomorph.rig.rig import Rig

Tables = Mapping[str, NDArray[Any]]

_BLOCK = 2048
"""Faces drawn at once: what they take stays in the cache of a core."""

_MOST_FACES = 2**48
_ON = LEVELS // 10
_CHOICE = 2
"""Lanes that say which mixture a face is of."""


class FaceSampler:
    """Faces of a rig by number: what face i is depends on the recipe, the seed and i alone.

    Args:
        rig: The rig.
        recipe: What the faces are: a recipe, the path of a .toml file, or the same as a mapping.
            None: each slider on or off by itself, six of them on average.
        seed: 0 to 2⁶⁴ - 1, instead of that of the recipe.

    Attributes:
        recipe: The recipe, with its seed.
        columns: What each face has: a weight of each slider in the order of ``rig.names``, then
            what else the recipe asks for.
        tables: Arrays of what the recipe read from files, by name.
        count: How many faces there are; None where any number can be drawn.

    Raises:
        FileError: The recipe, or a file that it names, cannot be read.
        FormatError: It is no recipe, or does not suit the rig; the message names line and key.
        ParameterError: Likewise of a recipe that is no file; or the rig or seed is none.
    """

    def __init__(
        self,
        rig: Rig,
        recipe: Recipe | Mapping[str, Any] | str | Path | None = None,
        *,
        seed: int | None = None,
    ) -> None:
        self._begin(rig, recipe, seed, None)

    @classmethod
    def restored(cls, rig: Rig, text: str, tables: Tables) -> FaceSampler:
        """The sampler whose `recipe.text()` and `tables` were kept with its faces.

        Raises:
            ParameterError: They do not suit the rig, or are none.
        """
        sampler = cls.__new__(cls)
        sampler._begin(rig, recipe_from_text(text), None, tables)
        return sampler

    def codes(self, start: int, stop: int) -> Codes:
        """(stop - start, C) uint16: the faces from number `start` to before `stop`.

        Raises:
            ParameterError: They are no range of faces, or more than there are.
        """
        self._require_range(start, stop)
        codes = np.empty((stop - start, len(self.columns)), dtype=np.uint16)
        for first in range(start, stop, _BLOCK):
            last = min(first + _BLOCK, stop)
            self._draw(first, last, codes[first - start : last - start])
        return codes

    def values(self, start: int, stop: int) -> NDArray[np.float64]:
        """(stop - start, C) float64: what the codes stand for.

        Raises:
            ParameterError: As for `codes`.
        """
        return self.columns.decode(self.codes(start, stop))

    def describe(self) -> str:
        """What the faces are, for people; how many sliders are on is counted in some of them."""
        own = self.recipe
        count = "any number of" if self.count is None else f"{self.count:,}"
        added = [column.name for column in self.columns[self._sliders :]]
        beside = f", {', '.join(added)}" if added else ""
        lines = [f"{count} faces of {self._sliders} sliders{beside}; seed {own.seed}"]
        lanes = random_lanes(own.seed, 0, _BLOCK, self._stride)[:, self._first :]
        rest = self.columns.rest[: self._sliders]
        total = sum(mixture.share for mixture in own.mixtures)
        for mixture, drawing in zip(own.mixtures, self._drawings, strict=True):
            way = np.abs(drawing.codes(lanes, None).astype(np.int32) - rest)
            on = (way > _ON).sum(axis=1)
            lines.append(
                f"  {mixture.share / total:.3g} of them {mixture.kind}: of {len(drawing.chosen)} "
                f"sliders {on.mean():.1f} are on by more than a tenth, at most {on.max()}"
            )
        for exclusion in own.exclusions:
            rule = "only the largest" if exclusion.one else f"together at most {exclusion.most:g}"
            lines.append(f"  {', '.join(exclusion.sliders)}: {rule}")
        return "\n".join(lines)

    def __repr__(self) -> str:
        kinds = ", ".join(mixture.kind for mixture in self.recipe.mixtures)
        return f"FaceSampler({len(self.columns)} columns, {kinds}, seed {self.recipe.seed})"

    def _begin(
        self,
        rig: Rig,
        recipe: Recipe | Mapping[str, Any] | str | Path | None,
        seed: int | None,
        tables: Tables | None,
    ) -> None:
        if not isinstance(rig, Rig):
            raise ParameterError(
                f"faces are of a Rig, as em.read_rig('rig.glb') gives it, found {rig!r}"
            )
        own = _as_recipe(recipe)
        if seed is not None:
            if not is_whole(seed) or not 0 <= seed < 2**64:
                raise ParameterError(f"a seed is a whole number from 0 to 2^64 - 1, found {seed!r}")
            own = replace(own, seed=int(seed))
        self.recipe = own
        controls = self._controls(rig)
        self._sliders = len(rig.names)
        self._drawings = [
            self._drawing(number, controls, tables) for number in range(len(own.mixtures))
        ]
        self.tables: dict[str, NDArray[Any]] = {
            f"mixture-{number}-{name}": table
            for number, drawing in enumerate(self._drawings)
            for name, table in drawing.tables.items()
        }
        self.count = self._drawings[0].count if len(self._drawings) == 1 else None
        self._excluding = []
        for number, exclusion in enumerate(own.exclusions):
            with own.naming("exclude", number):
                self._excluding.append(exclusion.prepared(controls))
        self._prepare_singles(controls)
        shares = np.cumsum([mixture.share for mixture in own.mixtures])
        bounds = np.rint(shares / shares[-1] * 2.0**32)
        never = np.flatnonzero(np.diff(bounds, prepend=0) == 0)
        if never.size:
            with own.naming("mixture", int(never[0])):
                raise KeyedError(("share",), "it is so small beside the others that no face has it")
        self._bounds = bounds[:-1].astype(np.uint64)
        self._first = _CHOICE + len(self._singles)
        self._stride = stride_of(self._first + max(drawing.lanes for drawing in self._drawings))

    def _controls(self, rig: Rig) -> Controls:
        own = self.recipe
        others: list[int] = []
        if own.identity is not None:
            with own.naming("identity"):
                others = places_of(rig.sliders, own.identity.sliders, ("sliders",))
        ranges = dict.fromkeys(others, own.identity.range) if own.identity is not None else {}
        with own.naming():
            for name, vertex in own.landmarks.items():
                if vertex >= len(rig.neutral.vertices):
                    raise KeyedError(
                        ("landmarks", name),
                        f"there is no vertex {vertex:,}; the rig has {len(rig.neutral.vertices):,}",
                    )
            columns = slider_columns(rig.sliders, own.limits, ranges)
        return Controls(rig.sliders, columns, frozenset(others), own.document.path.parent)

    def _drawing(self, number: int, controls: Controls, tables: Tables | None) -> Drawing:
        start = f"mixture-{number}-"
        kept = tables and {
            name.removeprefix(start): own for name, own in tables.items() if name.startswith(start)
        }
        with self.recipe.naming("mixture", number):
            return self.recipe.mixtures[number].prepared(controls, kept)

    def _prepare_singles(self, controls: Controls) -> None:
        """What is drawn by itself: its column and table; the identity's are columns of sliders."""
        own = self.recipe
        added = [own.timing.single()] if own.timing is not None else []
        added += scene_singles(own.scene)
        names = [single.column.name for single in added]
        for name in names:
            if name in controls.columns.names:
                raise ParameterError(
                    f"the rig has a slider {name!r}, which is the name of a column of its own; "
                    "rename it"
                )
        with own.naming("identity"):
            identity = list(own.identity.singles(controls)) if own.identity is not None else []
        self._singles = [*identity, *enumerate(added, start=self._sliders)]
        self.columns = Columns(
            (*controls.columns, *(single.column for single in added)), controls.others
        )

    def _draw(self, start: int, stop: int, out: Codes) -> None:
        """Fill (n, C) codes of a few faces."""
        lanes = random_lanes(self.recipe.seed, start, stop, self._stride)
        sliders = out[:, : self._sliders]
        self._draw_mixtures(start, lanes, sliders)
        for number, (place, single) in enumerate(self._singles, start=_CHOICE):
            own = lanes[:, number]
            out[:, place] = own if single.table is None else single.table[own]
        for excluding in self._excluding:
            excluding.apply(sliders)

    def _draw_mixtures(self, start: int, lanes: Lanes, out: Codes) -> None:
        own = lanes[:, self._first :]
        if len(self._drawings) == 1:
            rows = None if self.count is None else np.arange(start, start + len(lanes))
            out[:] = self._drawings[0].codes(own, rows)
            return
        choice = np.searchsorted(self._bounds, whole_numbers(lanes[:, :_CHOICE]), side="right")
        for number, drawing in enumerate(self._drawings):
            chosen = np.flatnonzero(choice == number)
            out[chosen] = drawing.codes(own[chosen], None)

    def _require_range(self, start: int, stop: int) -> None:
        if not (is_whole(start) and is_whole(stop) and 0 <= start <= stop <= _MOST_FACES):
            raise ParameterError(
                f"faces are numbered from 0: start ≤ stop in whole numbers, found {start!r} and "
                f"{stop!r}"
            )
        if self.count is not None and stop > self.count:
            raise ParameterError(
                f"the recipe has {self.count:,} faces, and {stop:,} were asked for"
            )


def _as_recipe(recipe: Recipe | Mapping[str, Any] | str | Path | None) -> Recipe:
    if recipe is None:
        return Recipe()
    if isinstance(recipe, Recipe):
        return recipe
    if isinstance(recipe, Mapping):
        return recipe_from(recipe)
    if isinstance(recipe, str | Path):
        return read_recipe(recipe)
    raise ParameterError(f"a recipe is a .toml file or a mapping of tables, found {recipe!r}")
