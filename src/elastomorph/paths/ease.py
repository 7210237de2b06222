"""The straight line at the pace of the load: V₀ + p(t)/p(1)·Δ, for the load t^R V₀ + t^R·Δ.

It is what a beam of infinite rigidity does, and the yardstick beside every beam: an improvement
that `ease` shares is one of timing alone.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import elastomorph.paths.options as options
from elastomorph.curves import CurveNetwork
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.paths.method import Method, Prepared
from elastomorph.physics import Load

__all__ = ["Ease", "Loaded", "modal_path", "straight_path"]

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
    def label(self) -> str:
        """As `Method.label`, with the load always."""
        load = f"R={self.order}"
        if self.load is not None:
            load = f"load {','.join(f'{p:g}' for p in self.load.coefficients)}"
        return " ".join([self.name, load, *self._differences])


@dataclass(frozen=True)
class Ease(Loaded):
    """The straight line at the pace of the load; one bend, Δ itself (none for a linear load)."""

    name = "ease"
    path = "straight line at the pace p(t)/p(1): the timing of the beam without its physics"

    def prepare(self, neutral: Mesh, curves: CurveNetwork | None = None) -> Prepared:
        """A function from target to path."""
        return straight_path(neutral, _law_bend(self.external_load), self.label)


def straight_path(neutral: Mesh, bend: BendCurve, label: str) -> Prepared:
    """A function from target to the path V₀ + (t + b(t))·Δ."""
    bends = int(bend.coefficients.any())

    def to(target: Mesh) -> Morph:
        delta = (target.vertices - neutral.vertices)[None]
        return Morph(neutral, target, delta[:bends], (bend,)[:bends], method=label, limit_law=bend)

    return to


def modal_path(
    neutral: Mesh, method: Loaded, bends_of: Callable[[NDArray[np.float64]], NDArray[np.float64]]
) -> Prepared:
    """A function from target to path; one bend for each power t², …, t^R (t^(R+1) for some means).

    Args:
        neutral: The mesh at t = 0.
        method: Its load is the limit law of the modes.
        bends_of: (K, V, 3) bends of t², t³, … from (V, 3) Δ.
    """
    limit = _law_bend(method.external_load)

    def to(target: Mesh) -> Morph:
        delta = target.vertices - neutral.vertices
        bends = bends_of(delta)
        noise = _NOISE * float(np.abs(delta).max(initial=0.0))
        kept = [power for power, bend in enumerate(bends) if np.abs(bend).max() > noise]
        if len(kept) < len(bends):
            bends = bends[kept]
        powers = tuple(BendCurve.power(power + 2) for power in kept)
        return Morph(neutral, target, bends, powers, method=method.label, limit_law=limit)

    return to


def _law_bend(load: Load) -> BendCurve:
    """The bend curve p(t)/p(1) - t of Δ."""
    coefficients = np.concatenate([[0.0], load.limit_law])
    coefficients[1] -= 1.0
    return BendCurve.polynomial(coefficients)
