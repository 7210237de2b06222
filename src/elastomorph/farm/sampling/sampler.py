"""Faces by number: codes of all columns of any rows, the same however the work is split.

A recipe is made ready for a rig once; then random lanes become codes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.farm.sampling.columns import LEVELS, Codes, Columns
from elastomorph.farm.sampling.controls import (
    Anatomy,
    Controls,
    Excluding,
    KeyedError,
    places_of,
    slider_columns,
)
from elastomorph.farm.sampling.lanes import Lanes, random_lanes, stride_of, whole_numbers
from elastomorph.farm.sampling.mixtures import Drawing
from elastomorph.farm.sampling.recipe import (
    Recipe,
    Single,
    read_recipe,
    recipe_from,
    recipe_from_text,
    scene_singles,
)
from elastomorph.numbers import is_whole
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


_BLOCK = 2048
"""Faces drawn at once: what they take stays in the cache of a core."""

_MOST_FACES = 2**48


class FaceSampler:
    """Faces of a rig by number: what face i is depends on the recipe, the seed and i alone.

    Args:
        rig: The rig.
        recipe: What the faces are: a recipe, the path of a .toml file, or the same as a mapping.
            None: each slider on or off by itself, six of them on average, and shapes of ARKit
            within what a face can do.
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
        if not isinstance(rig, Rig):
            raise ParameterError(
                f"faces are of a Rig, as em.read_rig('rig.glb') gives it, found {rig!r}"
            )
        own = as_recipe(recipe)
        if seed is not None:
            if not is_whole(seed) or not 0 <= seed < 2**64:
                raise ParameterError(f"a seed is a whole number from 0 to 2^64 - 1, found {seed!r}")
            own = replace(own, seed=int(seed))
        self.recipe = own
        self._prepared = Prepared.of(own, rig)
        self._stride = stride_of(self._prepared.lanes)
        self.columns = self._prepared.columns
        self.count = self._prepared.count
        self.tables = self._prepared.tables

    @classmethod
    def restored(cls, rig: Rig, text: str, tables: Mapping[str, NDArray[Any]]) -> FaceSampler:
        """The sampler whose `recipe.text()` and `tables` were kept with its faces.

        Raises:
            ParameterError: They do not suit the rig, or are none.
        """
        return cls(rig, replace(recipe_from_text(text), tables=tables))

    def codes(self, start: int, stop: int) -> Codes:
        """(stop - start, C) uint16: the faces from number `start` to before `stop`.

        Raises:
            ParameterError: They are no range of faces, or more than there are.
        """
        self._require_range(start, stop)
        codes = np.empty((stop - start, len(self.columns)), dtype=np.uint16)
        for first in range(start, stop, _BLOCK):
            last = min(first + _BLOCK, stop)
            lanes = random_lanes(self.recipe.seed, first, last, self._stride)
            self._prepared.draw(first, lanes, codes[first - start : last - start])
        return codes

    def values(self, start: int, stop: int) -> NDArray[np.float64]:
        """(stop - start, C) float64: what the codes stand for.

        Raises:
            ParameterError: As for `codes`.
        """
        return self.columns.decode(self.codes(start, stop))

    def describe(self) -> str:
        """What the faces are, for people; how many sliders are on is counted in some of them."""
        own, sliders = self.recipe, self._prepared.sliders
        count = "any number of" if self.count is None else f"{self.count:,}"
        tables = dict.fromkeys(name.partition(".")[0] for name in self.columns.names[sliders:])
        beside = f", {', '.join(tables)}" if tables else ""
        lines = [f"{count} faces of {sliders} sliders{beside}; seed {own.seed}"]
        counted = self._prepared.on(random_lanes(own.seed, 0, _BLOCK, self._stride))
        total = sum(mixture.share for mixture in own.mixtures)
        for mixture, drawing, on in zip(
            own.mixtures, self._prepared.drawings, counted, strict=True
        ):
            lines.append(
                f"  {100 * mixture.share / total:.3g} % {mixture.kind}: of {len(drawing.chosen)} "
                f"sliders {on.mean():.1f} are on by more than a tenth, at most {on.max()}"
                f"{drawing.said}"
            )
        if anatomy := str(self._prepared.anatomy or ""):
            lines.append(f"  {anatomy}")
        for exclusion in own.exclusions:
            rule = "only the largest" if exclusion.one else f"together at most {exclusion.most:g}"
            lines.append(f"  {', '.join(exclusion.sliders)}: {rule}")
        return "\n".join(lines)

    def __repr__(self) -> str:
        kinds = ", ".join(mixture.kind for mixture in self.recipe.mixtures)
        return f"FaceSampler({len(self.columns)} columns, {kinds}, seed {self.recipe.seed})"

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


def as_recipe(recipe: Recipe | Mapping[str, Any] | str | Path | None) -> Recipe:
    """The recipe that a caller gave in one of these ways."""
    if recipe is None:
        return Recipe(anatomy=True)
    if isinstance(recipe, Recipe):
        return recipe
    if isinstance(recipe, Mapping):
        return recipe_from(recipe)
    if isinstance(recipe, str | Path):
        return read_recipe(recipe)
    raise ParameterError(f"a recipe is a .toml file or a mapping of tables, found {recipe!r}")
