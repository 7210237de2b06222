"""The straight line with a slow start and stop: V₀ + (1 - cos πt)/2·Δ."""

from __future__ import annotations

from dataclasses import dataclass
from math import factorial, pi

import numpy as np

from elastomorph.curves import CurveNetwork
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh
from elastomorph.paths.ease import straight_path
from elastomorph.paths.method import Method, Prepared

__all__ = ["Cosine", "cosine_bend"]

# The Taylor series of the cosine on [0, π] is exact to double precision from here on.
_DEGREE = 30


@dataclass(frozen=True)
class Cosine(Method):
    """The straight line with a slow start and stop; one bend, Δ itself."""

    name = "cosine"
    path = "straight line, slow start and slow stop, (1 − cos πt)/2"

    def prepare(self, neutral: Mesh, curves: CurveNetwork | None = None) -> Prepared:
        """A function from target to path."""
        return straight_path(neutral, cosine_bend(), self.label)


def cosine_bend() -> BendCurve:
    """The bend curve (1 - cos πt)/2 - t, as a polynomial equal to it in double precision."""
    coefficients = np.zeros(_DEGREE + 1)
    for power in range(2, _DEGREE + 1, 2):
        coefficients[power] = -((-1) ** (power // 2)) * pi**power / (2 * factorial(power))
    coefficients[1] = -1.0
    return BendCurve.polynomial(coefficients)
