"""From what a user asks of a rig, weights of named sliders, to one weight and time a morph."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import ParameterError
from elastomorph.numbers import LARGEST_WEIGHT, as_number, as_numbers, path_times
from elastomorph.rig.laws import Corrective
from elastomorph.rig.naming import nearest_name

Weights = Mapping[str, float] | ArrayLike

Number = TypeVar("Number", np.float64, np.complex128)


@dataclass(frozen=True)
class Sliders:
    """The sliders of a rig, and the morphs they drive.

    A morph without drivers has a slider of its own name. A *corrective* is driven by several, by a
    law. Where it has a slider of its own, it is one of its drivers.
    """

    morphs: tuple[str, ...]  # Names of all morphs, in the order of the rig
    correctives: Mapping[str, Corrective] = field(default_factory=dict)  # by their names
    # Names of groups, and the sliders in each.
    groups: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, corrective in self.correctives.items():
            self.require(name, self.morphs)
            for driver in corrective.drivers:
                self.require(driver, self.morphs)
                if driver != name and driver in self.correctives:
                    raise ParameterError(
                        f"the corrective {name!r} is driven by {driver!r}, which is a corrective "
                        "itself; name the sliders that drive both"
                    )
        for members in self.groups.values():
            for name in members:
                self.require(name, self.morphs)

    def drivers(self, name: str) -> tuple[str, ...]:
        """The sliders that drive a morph: that of its own name, where it is no corrective."""
        return self.correctives[name].drivers if name in self.correctives else (name,)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The sliders in order: every morph but the correctives that others drive entirely."""
        return tuple(name for name in self.morphs if name in self.drivers(name))

    def row(self, weights: Weights) -> NDArray[np.float64]:
        """(sliders,) weights in the order of the sliders; those that no name was given are 0."""
        if not isinstance(weights, Mapping):
            given = as_numbers(weights, "weights", switches=True)
            if given.shape != (len(self.names),):
                raise ParameterError(
                    f"the rig has {len(self.names)} sliders ({', '.join(self.names[:4])}"
                    f"{', …' if len(self.names) > 4 else ''}), so weights in their order must be "
                    f"that many numbers, found {given.shape}"
                )
            return self._usable(given)
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
        return self._usable(row)

    def table(self, weights: ArrayLike) -> NDArray[np.float64]:
        """(S, sliders) float64 from an array."""
        table = as_numbers(weights, "weights", switches=True)
        if table.ndim != 2 or table.shape[1] != len(self.names):
            raise ParameterError(
                f"weights must have shape (S, {len(self.names)}), one column for each slider "
                f"({', '.join(self.names[:4])}, …); found {table.shape}"
            )
        return self._usable(table)

    @cached_property
    def driver_columns(self) -> list[list[int]]:
        """For each morph, the columns of the sliders that drive it."""
        column = self._column
        return [[column[driver] for driver in self.drivers(name)] for name in self.morphs]

    def drive(self, weights: NDArray[Number]) -> NDArray[Number]:
        """(S, morphs) weight of each morph from (S, sliders), real or complex."""
        if not self.correctives:
            return weights
        driven = weights[:, [columns[0] for columns in self.driver_columns]]
        for morph, (name, columns) in enumerate(zip(self.morphs, self.driver_columns, strict=True)):
            if name in self.correctives:
                driven[:, morph] = self.correctives[name].weight(weights[:, columns])
        return driven

    def drive_rates(
        self, row: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(morphs,) weights from (sliders,), and (morphs, sliders) their derivatives."""
        # By a complex step: exact to rounding.
        step = 1e-100
        driven = self.drive(row + 1j * step * np.eye(len(row)))
        times = self.drive(row[None])[0]
        return times, driven.imag.T / step

    def spread(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """(S, morphs) time of each morph from (S, sliders).

        Of correctives it is that of their first driver; by ``min``, the least.
        """
        spread = times[:, [columns[0] for columns in self.driver_columns]]
        for morph, (name, columns) in enumerate(zip(self.morphs, self.driver_columns, strict=True)):
            if name in self.correctives and self.correctives[name].law == "min":
                spread[:, morph] = times[:, columns].min(axis=1)
        return spread

    @cached_property
    def _column(self) -> dict[str, int]:
        return {name: i for i, name in enumerate(self.names)}

    def require(self, name: str, known: tuple[str, ...]) -> None:
        """Check that a name is among the known ones; else suggest the nearest."""
        if name not in known:
            near = nearest_name(str(name), known)
            listed = ", ".join(known[:8]) or "none"
            hint = f"did you mean {near!r}?" if near else f"there are {listed}"
            hint += ", …" * (not near and len(known) > 8)
            raise ParameterError(f"the rig has no slider {name!r}: {hint}")

    def _usable(self, table: NDArray[np.float64]) -> NDArray[np.float64]:
        usable = np.abs(table) <= LARGEST_WEIGHT
        if not usable.all():
            place = np.argwhere(~usable)[0]
            raise ParameterError(
                f"the weight of {self.names[place[-1]]!r}"
                + (f" in row {place[0]}" if table.ndim == 2 else "")
                + f" is {table[tuple(place)]:g}; it must be finite and at most {LARGEST_WEIGHT:g}"
            )
        return table


def named_correctives(
    named: Mapping[str, Corrective | Sequence[str]] | None,
) -> dict[str, Corrective]:
    """Correctives by name; where only drivers are given, products."""
    if isinstance(named, Mapping):
        lists = {n: own for n, own in named.items() if not isinstance(own, Corrective)}
        listed = named_lists(lists, "correctives")
        return {n: Corrective.of(listed.get(n, own)) for n, own in named.items()}
    return {name: Corrective(own) for name, own in named_lists(named, "correctives").items()}


def named_lists(named: Mapping[str, Sequence[str]] | None, what: str) -> dict[str, tuple[str, ...]]:
    """Drivers of correctives or members of groups, by name."""
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


Times = float | Mapping[str, float]

# Weights whose sum is this small a part of them cancel; what is left is rounding.
_NOISE = 1e-12


def named_moments(
    sliders: Sliders, weights: Weights, t: Times, normalize: bool
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(morphs,) ζ and times of one face, from what a caller of `Rig.blend` gave."""
    row = sliders.row(weights)[None]
    moments = np.ones((1, len(sliders.names)))
    if isinstance(t, Mapping):
        given = sliders.row(t)
        chosen = [name in t for name in sliders.names]
        moments[0, chosen] = given[chosen]
    else:
        moments[:] = path_times(as_number(t, "the time"))
    zeta = _normalized(row) if normalize else row
    return sliders.drive(zeta)[0], sliders.spread(moments)[0]


def table_moments(
    sliders: Sliders, weights: ArrayLike, times: ArrayLike | None, normalize: bool
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(S, morphs) ζ and times of many faces, from what a caller of `Rig.batch` gave."""
    table = sliders.table(weights)
    if times is None:
        driven = sliders.drive(table)
        return (driven != 0).astype(float), driven
    moments = path_times(times)
    if moments.shape == (len(table),):
        moments = moments[:, None]
    elif moments.shape not in ((), table.shape):
        raise ParameterError(
            f"times must be one number, ({len(table)},) or {table.shape}, found {moments.shape}"
        )
    moments = np.broadcast_to(moments, table.shape)
    zeta = _normalized(table) if normalize else table
    return sliders.drive(zeta), sliders.spread(moments)


def _normalized(weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Each row over its sum."""
    total = weights.sum(axis=1, keepdims=True)
    none = np.abs(total) <= _NOISE * np.abs(weights).sum(axis=1, keepdims=True)
    if none.any():
        where = f" of face {int(np.argmax(none))}" if len(weights) > 1 else ""
        raise ParameterError(
            f"the weights{where} sum to 0, so they cannot be divided by their sum: leave "
            "normalize out, or give weights whose sum is not 0"
        )
    return np.asarray(weights / total)


MOST = 10_000_000


def weight_combinations(expressions: int, levels: int = 6) -> NDArray[np.float64]:
    """(L^J - 1, J) all rows of weights from {0, 1/(L-1), …, 1} but the one of zeros.

    J expressions, of which the paper has 5, at L levels; the last column changes fastest.
    """
    if expressions < 1 or levels < 2:
        raise ParameterError(
            "combinations need at least 1 expression and 2 levels, found "
            f"{expressions} and {levels}"
        )
    if levels**expressions > MOST:
        raise ParameterError(
            f"{levels} levels of {expressions} expressions are {levels**expressions:,} faces, more "
            f"than {MOST:,}; name fewer expressions or fewer levels"
        )
    steps = np.indices((levels,) * expressions).reshape(expressions, -1).T[1:]
    return np.asarray(steps / (levels - 1.0))


def spread_rows(total: int, count: int) -> NDArray[np.int64]:
    """(min(count, total),) rows spread evenly over all, the first and the last among them."""
    return np.unique(np.linspace(0, total - 1, min(count, total)).round().astype(np.int64))
