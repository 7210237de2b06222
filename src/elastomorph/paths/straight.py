"""Straight lines, which differ in their pace: even, slow at both ends, or that of a load."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import factorial, pi

import numpy as np
from numpy.typing import NDArray

import elastomorph.paths.options as options
from elastomorph.curves import CurveNetwork
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.paths.method import Method, Prepared
from elastomorph.physics import Load

# What methods share that move by a load p(t): ease, beams and plates.

# A bend below this part of the displacement is rounding noise of transforms and solves.
_NOISE = 1e-13


@dataclass(frozen=True)
class Loaded(Method):
    """A method that moves by a load p(t): t^R, or any polynomial.

    Attributes:
        order: R of the load t^R, from 1 to 20.
        load: Any polynomial load instead of t^R.
    """

    order: int = options.order()
    load: Load | None = options.load()

    @property
    def external_load(self) -> Load:
        """p(t): the load given, or t^R."""
        return Load.power(self.order) if self.load is None else self.load

    @property
    def limit_bend(self) -> BendCurve:
        """The bend curve p(t)/p(1) - t of Δ."""
        coefficients = np.concatenate([[0.0], self.external_load.limit_law])
        coefficients[1] -= 1.0
        return BendCurve.polynomial(coefficients)

    @property
    def label(self) -> str:
        """As `Method.label`, with the load always."""
        load = f"R={self.order}"
        if self.load is not None:
            load = f"load {','.join(f'{p:g}' for p in self.load.coefficients)}"
        return " ".join([self.name, load, *self._differences])

    def modal_path(
        self, neutral: Mesh, bends_of: Callable[[NDArray[np.float64]], NDArray[np.float64]]
    ) -> Prepared:
        """A function from target to path, with (K, V, 3) bends of t², t³, … from (V, 3) Δ."""
        limit, label = self.limit_bend, self.label

        def to(target: Mesh) -> Morph:
            delta = target.vertices - neutral.vertices
            bends = bends_of(delta)
            noise = _NOISE * float(np.abs(delta).max(initial=0.0))
            kept = [power for power, bend in enumerate(bends) if np.abs(bend).max() > noise]
            if len(kept) < len(bends):
                bends = bends[kept]
            powers = tuple(BendCurve.power(power + 2) for power in kept)
            return Morph(neutral, target, bends, powers, method=label, limit_law=limit)

        return to


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
