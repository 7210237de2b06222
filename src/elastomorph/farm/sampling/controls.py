"""The sliders of a rig as a recipe speaks of them: by name, by pattern, by group, within limits."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.character.document import Where, nearest
from elastomorph.errors import ParameterError
from elastomorph.farm.sampling.anatomy import Anatomy
from elastomorph.farm.sampling.columns import Columns
from elastomorph.rig.performance.naming import side_pairs
from elastomorph.rig.sliders import Sliders

Places = NDArray[np.intp]


class KeyedError(ParameterError):
    """A value of a recipe that does not suit the rig, and the key that has it."""

    def __init__(self, where: Where, problem: str) -> None:
        self.where = where
        super().__init__(problem)


def places_of(sliders: Sliders, words: Iterable[str], where: Where) -> list[int]:
    """Columns of the sliders that words name, rising: names, patterns such as eye*, or groups."""
    found: set[int] = set()
    for word in words:
        own = set(sliders.groups.get(word, ())) if word not in sliders.names else {word}
        chosen = [i for i, name in enumerate(sliders.names) if name in own]
        chosen = chosen or [i for i, name in enumerate(sliders.names) if fnmatchcase(name, word)]
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
