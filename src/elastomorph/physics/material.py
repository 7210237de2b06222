"""What the curves are made of: the constants m, c and k of Eq. 3."""

from __future__ import annotations

import math
from dataclasses import dataclass

from elastomorph.errors import ParameterError

__all__ = ["Material"]


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
            value = getattr(self, name)
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if not number or not math.isfinite(value) or value <= 0:
                raise ParameterError(f"{name} must be a finite number above 0, found {value!r}")
            object.__setattr__(self, name, float(value))
