"""The mean squared distance as a function of c/k, m/k and the load, within the well-behaved range.

A point is (ln c/k, ln m/k, p₂, …, p_R) with p₁ = 1 - p₂ - … - p_R: laws do not change when the
load is scaled, so p(1) = 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from elastomorph.fitting.modal_sums import LawSums
from elastomorph.physics import Load, Material, mean_response, modal_response
from elastomorph.physics.guard import excursion

EXCURSION = 0.1
# The penalty begins a little before the border, so that what it stops is still inside.
_PENALISED = 0.099
_STEEPNESS = 100.0
_HUGE = 1e6
_LARGEST_LOAD = 100.0
# Laws of materials this much softer or stiffer than any mode no longer change.
_STIFF = 1e-9
_SOFT = 1e3


@dataclass(frozen=True, eq=False)
class Objective:
    """What a fit makes small for some motions: the load has this degree, the means this closure."""

    sums: LawSums
    degree: int
    closure: str

    @cached_property
    def bounds(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lowest and highest value of each parameter.

        For a material at the lowest every law is the limit law to about eight digits.
        """
        b = self.sums.stiffness[1:]
        least, most = (float(b.min()), float(b.max())) if b.size else (1.0, 1.0)
        rest = np.full(self.degree - 1, _LARGEST_LOAD)
        low = np.concatenate([np.full(2, np.log(_STIFF * least)), -rest])
        return low, np.concatenate([np.full(2, np.log(_SOFT * most)), rest])

    @property
    def free(self) -> NDArray[np.bool_]:
        """(R + 1,) which parameters have any influence on the laws.

        A linear load is linear interpolation whatever the material (but for the means of some
        closures); with a quadratic one the mass drops out of every mode but the means. The laws of
        the means depend on m/c only, so a curve of one vertex has no c/k.
        """
        modes = len(self.sums.stiffness) > 1
        forced = self.closure in ("unforced", "rest")
        means = forced or (self.closure == "compatible" and self.degree >= 2)
        damping = modes and (self.degree >= 2 or forced)
        mass = means or (modes and self.degree >= 3)
        return np.array([damping, mass] + [True] * (self.degree - 1))

    def load(self, point: NDArray[np.float64]) -> Load:
        """p(t) at a point, with p(1) = 1."""
        return Load([1.0 - float(point[2:].sum()), *point[2:].tolist()])

    def material(self, point: NDArray[np.float64]) -> Material:
        """The material at a point, with k = 1."""
        damping, mass = np.exp(point[:2]).tolist()
        return Material(mass, damping, 1.0)

    def laws(self, point: NDArray[np.float64]) -> NDArray[np.float64]:
        """(G, K) coefficients of t … t^K of the law of each B."""
        load, material = self.load(point), self.material(point)
        laws = np.zeros(self.sums.aims.shape)
        with np.errstate(all="ignore"):
            mean = mean_response(self.closure, load, material)
            laws[0, : len(mean)] = mean
            laws[1:, : load.order] = modal_response(self.sums.stiffness[1:], load, material)
        return np.where(np.isnan(laws), _HUGE, np.clip(laws, -_HUGE, _HUGE))

    def excursion(self, point: NDArray[np.float64]) -> float:
        """How far the worst law leaves [0, 1] or runs back."""
        return float(excursion(self.laws(point)).max())

    def misfit(self, point: NDArray[np.float64]) -> float:
        """Squared distance over that of the first frames; the penalty is not in it."""
        return self.sums.misfit(self.laws(point)) / self.sums.total

    def residuals(self, point: NDArray[np.float64]) -> NDArray[np.float64]:
        """What to make small: distances over those of the first frames, and the penalty."""
        laws = self.laws(point)
        own = self.sums.residuals(laws).ravel() / np.sqrt(self.sums.total)
        penalty = _STEEPNESS * np.maximum(np.minimum(excursion(laws), _HUGE) - _PENALISED, 0.0)
        return np.concatenate([own, penalty])

    def cost(self, point: NDArray[np.float64]) -> float:
        """The misfit and the penalty."""
        return float((self.residuals(point) ** 2).sum()) + self.sums.rest / self.sums.total
