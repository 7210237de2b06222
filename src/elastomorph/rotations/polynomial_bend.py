"""A path that is costly to evaluate, as a polynomial through a few of its moments."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import factorial

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

__all__ = ["PolynomialBend", "moments_needed"]

# The interpolation error of a turning unit vector; a bake keeps 1e-4 of D.
_ACCURACY = 1e-9


@dataclass(frozen=True, eq=False)
class PolynomialBend:
    """t(1 - t)·q(t) with a polynomial q in Chebyshev form: zero at both ends, as every bend is.

    Attributes:
        coefficients: (N, V, 3) of T_j(2t - 1) in q.
    """

    coefficients: NDArray[np.float64]

    @classmethod
    def through(cls, bend: Callable[[float], NDArray[np.float64]], count: int) -> PolynomialBend:
        """The polynomial that agrees with a bend at Chebyshev nodes.

        Args:
            bend: (V, 3) offset from the straight line at a time strictly between 0 and 1.
            count: Number of nodes.
        """
        nodes = (1.0 - np.cos(np.pi * (np.arange(count) + 0.5) / count)) / 2.0
        values = np.stack([bend(float(t)) / (t * (1.0 - t)) for t in nodes])
        basis = chebyshev.chebvander(2.0 * nodes - 1.0, count - 1)
        return cls(np.tensordot(np.linalg.inv(basis), values, axes=1))

    def at(self, t: float) -> NDArray[np.float64]:
        """(V, 3) offset from the straight line."""
        basis = chebyshev.chebvander(np.array([2.0 * t - 1.0]), len(self.coefficients) - 1)[0]
        return np.asarray(np.tensordot(t * (1.0 - t) * basis, self.coefficients, axes=1))


def moments_needed(angle: float) -> int:
    """How many nodes follow a turn by an angle (radians) to 1e-9.

    Interpolation of e^{iθt} by degree n is off by about 2(θ/4)^{n+1}/(n+1)!.
    """
    count = 2
    while 2.0 * (angle / 4.0) ** count / factorial(count) > _ACCURACY:
        count += 1
    # t(1 - t) takes two degrees, and the stretch multiplies the turn by one more.
    return count + 1
