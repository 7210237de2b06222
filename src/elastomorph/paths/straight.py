"""Straight lines, which differ in their pace: even, slow at both ends, or that of a load."""

from __future__ import annotations

from dataclasses import dataclass
from math import factorial, pi

import numpy as np

from elastomorph.curves import CurveNetwork
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.paths.loaded import Loaded
from elastomorph.paths.method import Method, Prepared

# The Taylor series of the cosine on [0, π] is exact to double precision from here on.
_COSINE_DEGREE = 30


@dataclass(frozen=True)
class Linear(Method):
    """The straight line at an even pace; no bends."""

    name = "linear"
    path = "straight line at an even pace (Eq. 34)"
    pointwise = True

    def prepare(self, neutral: Mesh, curves: CurveNetwork | None = None) -> Prepared:
        """A function from target to path."""
        none = np.zeros((0, *neutral.vertices.shape))
        return lambda target: Morph(neutral, target, none, (), method=self.label)


@dataclass(frozen=True)
class Cosine(Method):
    """The straight line with a slow start and stop; one bend, Δ itself."""

    name = "cosine"
    path = "straight line, slow start and slow stop, (1 − cos πt)/2"
    pointwise = True

    def prepare(self, neutral: Mesh, curves: CurveNetwork | None = None) -> Prepared:
        """A function from target to path."""
        return straight_path(neutral, _cosine_bend(), self.label)


@dataclass(frozen=True)
class Ease(Loaded):
    """The straight line at the pace of the load; one bend, Δ itself (none for a linear load)."""

    name = "ease"
    path = "straight line at the pace p(t)/p(1): the timing of the beam without its physics"
    pointwise = True

    def prepare(self, neutral: Mesh, curves: CurveNetwork | None = None) -> Prepared:
        """A function from target to path."""
        return straight_path(neutral, self.limit_bend, self.label)


def straight_path(neutral: Mesh, bend: BendCurve, label: str) -> Prepared:
    """A function from target to the path V₀ + (t + b(t))·Δ."""
    bends = int(bend.coefficients.any())

    def to(target: Mesh) -> Morph:
        delta = (target.vertices - neutral.vertices)[None]
        return Morph(neutral, target, delta[:bends], (bend,)[:bends], method=label, limit_law=bend)

    return to


def _cosine_bend() -> BendCurve:
    """The bend curve (1 - cos πt)/2 - t, as a polynomial equal to it in double precision."""
    coefficients = np.zeros(_COSINE_DEGREE + 1)
    for power in range(2, _COSINE_DEGREE + 1, 2):
        coefficients[power] = -((-1) ** (power // 2)) * pi**power / (2 * factorial(power))
    coefficients[1] = -1.0
    return BendCurve.polynomial(coefficients)
