"""Names, weights and correctives: from what a user says to one number a morph."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import ParameterError
from elastomorph.numbers import as_numbers

__all__ = ["Sliders", "Weights", "named_lists"]

Weights = Mapping[str, float] | ArrayLike

Number = TypeVar("Number", np.float64, np.complex128)


@dataclass(frozen=True)
class Sliders:
    """The sliders of a rig, and the morphs they drive.

    A morph without drivers has a slider of its own name. A *corrective* is driven by several: its
    weight is the product of theirs. Where it has a slider of its own, it is one of its drivers.

    Attributes:
        morphs: Names of all morphs, in the order of the rig.
        correctives: Name of each corrective, and its drivers.
        groups: Names of groups, and the sliders in each, for people and files.

    Raises:
        ParameterError: A corrective or group names what does not exist, or a corrective drives
            another one.
    """

    morphs: tuple[str, ...]
    correctives: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    groups: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, drivers in self.correctives.items():
            self.require(name, self.morphs)
            if not drivers:
                raise ParameterError(f"the corrective {name!r} has no drivers; name at least one")
            for driver in drivers:
                self.require(driver, self.morphs)
                if driver != name and driver in self.correctives:
                    raise ParameterError(
                        f"the corrective {name!r} is driven by {driver!r}, which is a corrective "
                        "itself; name the sliders that drive both"
                    )
        for members in self.groups.values():
            for name in members:
                self.require(name, self.morphs)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The sliders in order: every morph but the correctives that others drive entirely."""
        return tuple(name for name in self.morphs if name in self.correctives.get(name, (name,)))

    def row(self, weights: Weights) -> NDArray[np.float64]:
        """(sliders,) weights in the order of the sliders; those that no name was given are 0.

        Args:
            weights: Weights by name, or one for each slider in their order.

        Raises:
            ParameterError: An unknown name, a weight that is not a finite number, or more or fewer
                weights than sliders.
        """
        if not isinstance(weights, Mapping):
            given = as_numbers(weights, "weights", switches=True)
            if given.shape != (len(self.names),):
                raise ParameterError(
                    f"the rig has {len(self.names)} sliders ({', '.join(self.names[:4])}"
                    f"{', …' if len(self.names) > 4 else ''}), so weights in their order must be "
                    f"that many numbers, found {given.shape}"
                )
            return self._finite(given)
        column = self._column
        row = np.zeros(len(column))
        for name, weight in weights.items():
            if name not in column:
                self.require(name, self.names)
            try:
                row[column[name]] = float(weight)
            except (TypeError, ValueError):
                raise ParameterError(
                    f"the weight of {name!r} is {weight!r}, not a number"
                ) from None
        return self._finite(row)

    def table(self, weights: ArrayLike, what: str = "weights") -> NDArray[np.float64]:
        """(S, sliders) float64 from an array.

        Raises:
            ParameterError: Another shape, or a number that is not finite.
        """
        table = as_numbers(weights, what, switches=True)
        if table.ndim != 2 or table.shape[1] != len(self.names):
            raise ParameterError(
                f"{what} must have shape (S, {len(self.names)}), one column for each slider "
                f"({', '.join(self.names[:4])}, …); found {table.shape}"
            )
        return self._finite(table)

    def driver_columns(self) -> list[list[int]]:
        """For each morph, the columns of the sliders whose weights are multiplied."""
        column = self._column
        return [[column[d] for d in self.correctives.get(n, (n,))] for n in self.morphs]

    def drive(self, weights: NDArray[Number]) -> NDArray[Number]:
        """(S, morphs) weight of each morph from (S, sliders), real or complex: products."""
        if not self.correctives:
            return weights
        driven = np.empty((len(weights), len(self.morphs)), dtype=weights.dtype)
        for morph, columns in enumerate(self.driver_columns()):
            driven[:, morph] = weights[:, columns].prod(axis=1)
        return driven

    def spread(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """(S, morphs) time of each morph from (S, sliders); correctives: of their first driver."""
        return times[:, [columns[0] for columns in self.driver_columns()]]

    @cached_property
    def _column(self) -> dict[str, int]:
        return {name: i for i, name in enumerate(self.names)}

    def require(self, name: str, known: tuple[str, ...]) -> None:
        """Check a name.

        Raises:
            ParameterError: It is not among the known ones; the message suggests the nearest.
        """
        if name not in known:
            near = get_close_matches(str(name), known, n=1, cutoff=0.5)
            hint = f"did you mean {near[0]!r}?" if near else f"there are {', '.join(known[:8])}, …"
            raise ParameterError(f"the rig has no slider {name!r}: {hint}")

    def _finite(self, table: NDArray[np.float64]) -> NDArray[np.float64]:
        if not np.isfinite(table).all():
            place = np.argwhere(~np.isfinite(table))[0]
            raise ParameterError(
                f"the weight of {self.names[place[-1]]!r}"
                + (f" in row {place[0]}" if table.ndim == 2 else "")
                + f" is {table[tuple(place)]}; weights and times must be finite numbers"
            )
        return table


def named_lists(named: Mapping[str, Sequence[str]] | None, what: str) -> dict[str, tuple[str, ...]]:
    """Drivers of correctives or members of groups, by name.

    Raises:
        ParameterError: Not a mapping from names to lists of names.
    """
    named = {} if named is None else named
    lists = isinstance(named, Mapping) and not any(isinstance(of, str) for of in named.values())
    try:
        if lists:
            return {name: tuple(of) for name, of in named.items()}
    except TypeError:
        pass
    raise ParameterError(
        f"{what} are a mapping from names to lists of names, such as {{'name': ['a', 'b']}}, "
        f"found {named!r}"
    )
