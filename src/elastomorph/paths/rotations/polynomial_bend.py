"""A bend known at a few moments is known at all: polynomials through Chebyshev nodes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import factorial

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.paths.bake import bake_polynomial, bend_basis

__all__ = ["PolynomialBend", "at_nodes", "moments_needed"]

# The interpolation error of a turning unit vector; a bake keeps 1e-4 of D.
_ACCURACY = 1e-9


@dataclass(frozen=True, eq=False)
class PolynomialBend:
    """t(1 - t)·q(t) with a polynomial q in Chebyshev form: zero at both ends, as every bend is.

    Attributes:
        coefficients: (N, M, 3) of T_j(2t - 1) in q, of the vertices that bend.
        bent: (V,) which of all vertices these are.
    """

    coefficients: NDArray[np.float64]
    bent: NDArray[np.bool_]

    @classmethod
    def through(
        cls, bend: Callable[[float], NDArray[np.float64]], count: int, bent: NDArray[np.bool_]
    ) -> PolynomialBend:
        """The polynomial that agrees with a bend at Chebyshev nodes.

        Args:
            bend: (M, 3) offset from the straight line at a time strictly between 0 and 1.
            count: Number of nodes.
            bent: (V,) which vertices bend.
        """
        return cls(at_nodes(bend, count), bent)

    def at(self, t: float) -> NDArray[np.float64]:
        """(V, 3) offset from the straight line."""
        basis = bend_basis(np.array([t]), len(self.coefficients) - 1)[0]
        offsets = np.zeros((len(self.bent), 3))
        offsets[self.bent] = np.tensordot(basis, self.coefficients, axes=1)
        return offsets

    def baked(self, neutral: Mesh, target: Mesh, *, tolerance: float, method: str) -> Morph:
        """The morph with the fewest bends, see `elastomorph.paths.bake.bake`."""
        return bake_polynomial(
            self.coefficients, self.bent, neutral, target, tolerance=tolerance, method=method
        )


def at_nodes(bend: Callable[[float], NDArray[np.float64]], count: int) -> NDArray[np.float64]:
    """(count, M, 3) Chebyshev coefficients of q in t(1 - t)·q(t), from as many moments.

    Args:
        bend: (M, 3) what vanishes at both ends, at a time strictly between 0 and 1.
        count: Number of nodes.
    """
    nodes = (1.0 - np.cos(np.pi * (np.arange(count) + 0.5) / count)) / 2.0
    values = np.stack([bend(float(t)) / (t * (1.0 - t)) for t in nodes])
    basis = chebyshev.chebvander(2.0 * nodes - 1.0, count - 1)
    return np.tensordot(np.linalg.inv(basis), values, axes=1)


def moments_needed(angle: float) -> int:
    """How many nodes follow a turn by an angle (radians) to 1e-9.

    Interpolation of e^{iθt} by degree n is off by about 2(θ/4)^{n+1}/(n+1)!.
    """
    count = 2
    while 2.0 * (angle / 4.0) ** count / factorial(count) > _ACCURACY:
        count += 1
    # t(1 - t) takes two degrees, and the stretch multiplies the turn by one more.
    return count + 1
