"""Faces by number: codes of all columns of any rows, the same however the work is split."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.farm.sampling.columns import Codes
from elastomorph.farm.sampling.lanes import random_lanes, stride_of
from elastomorph.farm.sampling.prepared import Prepared
from elastomorph.farm.sampling.reading_recipes import read_recipe, recipe_from, recipe_from_text
from elastomorph.farm.sampling.recipe import Recipe
from elastomorph.numbers import is_whole
from elastomorph.rig.rig import Rig

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
