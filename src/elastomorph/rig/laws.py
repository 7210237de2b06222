"""Laws of correctives: from the weights of several sliders to the weight of one morph."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.numbers import as_number, as_numbers

Number = TypeVar("Number", np.float64, np.complex128)

PRODUCT = "product"

_HALVINGS = 40  # to the last bit of single precision, as weights are stored


@dataclass(frozen=True)
class Corrective:
    """How sliders drive one morph: its weight, from theirs.

    With w₁ … w_n the weights of the drivers, and c_i = w_i between 0 and 1:

    ============  ==========================================================================
    law           weight
    ============  ==========================================================================
    product       w₁ · … · w_n
    min           the least w_i, 0 where one is below 0
    softmin       ((w₁^-p + … + w_n^-p)/n)^(-1/p) with sharpness p, 0 where one is not above 0
    hinge         max(0, κ₁w₁ + … + κ_n w_n - 1) with gains κ
    allMul        c₁ · … · c_n
    extMul        min c_i · max c_i
    mulAvgExt     2 min c_i · max c_i / (min c_i + max c_i), 0 at rest
    mulAvgAll     n · c₁ · … · c_n / (c₁ + … + c_n), 0 at rest
    ============  ==========================================================================

    The last four are those of Simplex, by its names. ``softmin`` is the mean of order -p: for all
    drivers at w it is w, for p = 1 the harmonic mean, and the larger p, the closer to ``min``.

    Attributes:
        drivers: Names of the sliders.
        law: One of the above.
        numbers: One gain a driver for ``hinge``, the sharpness for ``softmin``, else none.

    Raises:
        ParameterError: There are no drivers, the law is unknown, or the numbers do not fit it.
    """

    drivers: tuple[str, ...]
    law: str = PRODUCT
    numbers: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        names: object = self.drivers
        listed = isinstance(names, tuple | list)
        if not listed or not all(isinstance(name, str) for name in self.drivers):
            raise ParameterError(
                f"drivers are a list of names, such as ['jawOpen', 'mouthClose'], found {names!r}"
            )
        object.__setattr__(self, "drivers", tuple(self.drivers))
        if not self.drivers:
            raise ParameterError("a corrective has no drivers; name at least one")
        if not isinstance(self.law, str) or self.law not in LAWS:
            raise ParameterError(f"the law must be one of {', '.join(LAWS)}, found {self.law!r}")
        given = self.numbers
        empty = isinstance(given, tuple | list) and not given  # which NumPy takes for numbers
        numbers = as_numbers([0.0][:0] if empty else given, f"the numbers of the law {self.law}")
        if not np.isfinite(numbers).all():
            raise ParameterError(f"the numbers of the law {self.law} must be finite")
        object.__setattr__(self, "numbers", tuple(np.atleast_1d(numbers).tolist()))
        wanted = {"hinge": len(self.drivers), "softmin": 1}.get(self.law, 0)
        if numbers.ndim > 1 or len(self.numbers) != wanted:
            says = {"hinge": "one gain a driver", "softmin": "one number, its sharpness"}
            raise ParameterError(
                f"the law {self.law} takes {says.get(self.law, 'no numbers')}, found "
                f"{len(self.numbers)} for {len(self.drivers)} drivers"
            )
        if self.law == "softmin":
            as_number(self.numbers[0], "the sharpness of softmin", above=0)

    @classmethod
    def of(cls, given: Corrective | Sequence[str] | Mapping[str, Any]) -> Corrective:
        """A corrective; of a list of drivers, that of their product.

        A mapping is what `entry` gives.
        """
        if isinstance(given, Corrective):
            return given
        if not isinstance(given, Mapping):
            return cls(given)  # type: ignore[arg-type]
        law = given.get("law", PRODUCT)
        key = _NUMBERS.get(law, "") if isinstance(law, str) else ""
        for other in _NUMBERS.values():
            if other in given and other != key:
                raise ParameterError(f"the law {law} takes no {other}")
        numbers = given.get(key, ())
        if key in given and isinstance(numbers, list | tuple) != (key == "gains"):
            raise ParameterError("gains are a list, one a driver; the sharpness is one number")
        return cls(given.get("drivers", ()), law, numbers)

    def entry(self) -> dict[str, Any]:
        """The corrective as JSON: drivers, and law, gains and sharpness where there are any."""
        entry: dict[str, Any] = {"drivers": [*self.drivers]}
        if self.law != PRODUCT:
            entry["law"] = self.law
        if self.law == "hinge":
            entry["gains"] = [*self.numbers]
        elif self.law == "softmin":
            entry["sharpness"] = self.numbers[0]
        return entry

    def weight(self, weights: NDArray[Number]) -> NDArray[Number]:
        """(...,) weight of the morph from (..., n) weights of the drivers, in their order.

        Complex weights give derivatives by a complex step; where a law has a kink they are those
        of one side.
        """
        return LAWS[self.law](weights, self.numbers)

    def driven_by(
        self, name: str, others: Mapping[str, NDArray[np.float64]], wanted: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """(T,) weight of one driver with which the weight is the (T,) wanted, given the others'.

        Where the others hold it at 0, that is 0. Laws other than the product have it between 0
        and 1.
        """
        if self.law == PRODUCT:
            rest = np.prod([others[d] for d in self.drivers if d != name], axis=0)
            steady = np.abs(rest) > 1e-6
            return np.where(steady, wanted / np.where(steady, rest, 1.0), 0.0)
        low, high = np.zeros((2, *wanted.shape)) + np.array([[0.0], [1.0]])
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            weights = np.stack([others.get(d, middle) for d in self.drivers], axis=-1)
            short = self.weight(weights) < wanted
            low, high = np.where(short, middle, low), np.where(short, high, middle)
        return np.where(wanted == 0, 0.0, (low + high) / 2)

    def reach(self, ranges: Sequence[tuple[float, float]]) -> tuple[float, float]:
        """Bounds of the weight, from the least and the greatest weight of each driver."""
        if self.law == "hinge":
            ends = [
                max(k * low, k * high) for k, (low, high) in zip(self.numbers, ranges, strict=True)
            ]
            return 0.0, max(0.0, sum(ends) - 1.0)
        if self.law != PRODUCT:  # a mean of some kind, or a product of numbers up to 1
            return 0.0, max(0.0, *(high for _, high in ranges))
        least, greatest = ranges[0]
        for low, high in ranges[1:]:
            products = [a * b for a in (least, greatest) for b in (low, high)]
            least, greatest = min(products), max(products)
        return least, greatest


Law = Callable[[NDArray[Any], tuple[float, ...]], NDArray[Any]]


def _at(weights: NDArray[Any], place: NDArray[np.intp]) -> NDArray[Any]:
    return np.take_along_axis(weights, place[..., None], axis=-1)[..., 0]


def _least(weights: NDArray[Any]) -> NDArray[Any]:
    # By real parts: a complex step stands for a direction, and has no order.
    return _at(weights, weights.real.argmin(axis=-1))


def _most(weights: NDArray[Any]) -> NDArray[Any]:
    return _at(weights, weights.real.argmax(axis=-1))


def _positive(values: NDArray[Any]) -> NDArray[Any]:
    # At 0 the derivative is that above: a solver that starts at rest can only go there.
    return np.where(values.real >= 0, values, 0.0)


def _clamped(weights: NDArray[Any]) -> NDArray[Any]:
    return np.where(weights.real < 1, _positive(weights), 1.0)


def _ratio(above: NDArray[Any], below: NDArray[Any]) -> NDArray[Any]:
    return np.asarray(above / np.where(below.real > 0, below, 1.0))


def _softmin(weights: NDArray[Any], numbers: tuple[float, ...]) -> NDArray[Any]:
    least, sharpness = _positive(_least(weights)), numbers[0]
    # Relative to the least, so that no power overflows; where that is 0, the result is.
    some = (least.real > 0)[..., None]
    ratios = np.where(some, least[..., None], 1.0) / np.where(some, weights, 1.0)
    return np.asarray(least * (ratios**sharpness).mean(axis=-1) ** (-1.0 / sharpness))


def _mul_avg_ext(weights: NDArray[Any], _: tuple[float, ...]) -> NDArray[Any]:
    low, high = _least(_clamped(weights)), _most(_clamped(weights))
    return np.asarray(2.0 * low * _ratio(high, low + high))


def _mul_avg_all(weights: NDArray[Any], _: tuple[float, ...]) -> NDArray[Any]:
    clamped = _clamped(weights)
    return _ratio(weights.shape[-1] * clamped.prod(axis=-1), clamped.sum(axis=-1))


LAWS: Final[Mapping[str, Law]] = MappingProxyType(
    {
        PRODUCT: lambda weights, _: weights.prod(axis=-1),
        "min": lambda weights, _: _positive(_least(weights)),
        "softmin": _softmin,
        "hinge": lambda weights, gains: _positive(weights @ np.array(gains) - 1.0),
        "allMul": lambda weights, _: _clamped(weights).prod(axis=-1),
        "extMul": lambda weights, _: _least(_clamped(weights)) * _most(_clamped(weights)),
        "mulAvgExt": _mul_avg_ext,
        "mulAvgAll": _mul_avg_all,
    }
)
"""The laws by name."""

_NUMBERS = {"hinge": "gains", "softmin": "sharpness"}
