"""What moves a curve: m, c and k of Eq. 3, and the load p(t) of Eq. 5."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.numbers import as_number, is_whole

HIGHEST_ORDER = 20


@dataclass(frozen=True)
class Material:
    """Mass, damping and flexural rigidity of m ẅ + c ẇ + k ∂⁴w/∂u⁴ = f (Eq. 3).

    Only the ratios c/k, m/k and m/c change a path. Time runs from 0 (neutral) to 1 (target) and u
    from 0 to 1 along a curve, so the numbers have no unit of their own.

    Attributes:
        mass: m > 0.
        damping: c > 0.
        rigidity: k = E·I > 0.

    Raises:
        ParameterError: A constant is not a finite number above 0.
    """

    mass: float = 1.0
    damping: float = 1.0
    rigidity: float = 1.0

    def __post_init__(self) -> None:
        for name in ("mass", "damping", "rigidity"):
            object.__setattr__(self, name, as_number(getattr(self, name), name, above=0))


@dataclass(frozen=True)
class Load:
    """A polynomial p(t) = p₁t + p₂t² + … + p_R t^R with p(1) ≠ 0.

    Its constant part needs no name: it is absorbed by e₀. ``Load.power(R)`` is the paper's t^R.

    Attributes:
        coefficients: (p₁, …, p_R).

    Raises:
        ParameterError: No coefficient, one that is not finite, more than 20, or p(1) = 0.
    """

    coefficients: tuple[float, ...]

    def __init__(self, coefficients: Sequence[float]) -> None:
        try:
            values = [float(p) for p in coefficients]
        except (TypeError, ValueError):
            raise ParameterError(f"a load needs numbers, found {coefficients!r}") from None
        if not all(math.isfinite(p) for p in values):
            raise ParameterError(f"a load needs finite coefficients, found {values}")
        while values and values[-1] == 0:
            values.pop()
        if not 1 <= len(values) <= HIGHEST_ORDER:
            raise ParameterError(
                f"a load needs 1 to {HIGHEST_ORDER} coefficients of t, t², …, found {len(values)}"
            )
        total = math.fsum(values)
        if abs(total) <= 1e-12 * max(map(abs, values)):
            raise ParameterError(
                f"the load {values} is 0 at t = 1, so it cannot tell the target from the neutral"
            )
        object.__setattr__(self, "coefficients", tuple(values))

    @classmethod
    def power(cls, order: int) -> Load:
        """The paper's load t^R: R = 1 linear, 2 quadratic, 3 cubic.

        Raises:
            ParameterError: R is not a whole number from 1 to 20.
        """
        if not is_whole(order) or not 1 <= order <= HIGHEST_ORDER:
            raise ParameterError(
                f"the order R must be a whole number from 1 to {HIGHEST_ORDER}, found {order!r}"
            )
        return cls([0.0] * (int(order) - 1) + [1.0])

    @property
    def order(self) -> int:
        """R, the degree of p."""
        return len(self.coefficients)

    @property
    def limit_law(self) -> NDArray[np.float64]:
        """(R,) coefficients of t … t^R of p(t)/p(1): the law that every stiff mode tends to."""
        p = np.array(self.coefficients)
        return p / math.fsum(self.coefficients)
