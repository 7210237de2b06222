"""The straight line with a slow start and stop: V₀ + (1 - cos πt)/2·Δ."""

from __future__ import annotations

from collections.abc import Callable
from math import factorial, pi

import numpy as np

from elastomorph.curves import CurveNetwork
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.paths.ease import straight_path
from elastomorph.paths.method import Method

__all__ = ["cosine_bend", "prepare"]

# The Taylor series of the cosine on [0, π] is exact to double precision from here on.
_DEGREE = 30


def prepare(
    neutral: Mesh, method: Method, curves: CurveNetwork | None = None
) -> Callable[[Mesh], Morph]:
    """A function from target to path; one bend, Δ itself."""
    return straight_path(neutral, cosine_bend(), method.label)


def cosine_bend() -> BendCurve:
    """The bend curve (1 - cos πt)/2 - t, as a polynomial equal to it in double precision."""
    coefficients = np.zeros(_DEGREE + 1)
    for power in range(2, _DEGREE + 1, 2):
        coefficients[power] = -((-1) ** (power // 2)) * pi**power / (2 * factorial(power))
    coefficients[1] = -1.0
    return BendCurve.polynomial(coefficients)
