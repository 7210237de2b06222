"""Fit motions together, then each time without one of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.fitting.modal_sums import LawSums, ModalSums
from elastomorph.fitting.objective import Objective
from elastomorph.fitting.results import Ratio
from elastomorph.fitting.solver import (
    Optimum,
    best_load,
    interval,
    load_intervals,
    minimised,
    slack,
    solve,
)
from elastomorph.paths import Method
from elastomorph.physics import Load, Material

__all__ = ["Constants", "Repetitions", "Solution", "constants"]

# Starts of a fit without one motion, besides the optimum of them all.
_FOLD_STARTS = 2


@dataclass(frozen=True, eq=False)
class Solution:
    """One degree fitted to some motions.

    Attributes:
        objective: What was made small.
        optimum: Where it is smallest.
        stiff: The best load for curves that all follow it.
    """

    objective: Objective
    optimum: Optimum
    stiff: Optimum

    @property
    def load(self) -> Load:
        """p(t) with p(1) = 1."""
        return self.objective.load(self.optimum.point)

    @property
    def method(self) -> Method:
        """The beam."""
        return Method(
            "beam",
            material=self.objective.material(self.optimum.point),
            load=self.load,
            closure=self.objective.closure,
        )

    @property
    def ease(self) -> Method:
        """The straight line at the best pace of this degree."""
        return Method("ease", load=self.objective.load(self.stiff.point))

    @property
    def laws(self) -> NDArray[np.float64]:
        """(G, K) coefficients of the law of each B."""
        return self.objective.laws(self.optimum.point)


@dataclass(frozen=True, eq=False)
class Constants:
    """What a solution says of material and load, and how surely.

    Attributes:
        solution: Ratios that nothing bounds from below are at the stiff end of their range.
        damping: c/k.
        mass: m/k.
        load_intervals: Of p₁ … p_R.
        material: None where neither ratio matters.
    """

    solution: Solution
    damping: Ratio
    mass: Ratio
    load_intervals: tuple[tuple[float, float], ...]
    material: Material | None


@dataclass(frozen=True, eq=False)
class Repetitions:
    """The sums of each motion.

    Attributes:
        parts: One for each motion.
    """

    parts: tuple[LawSums, ...]

    @classmethod
    def of(cls, motions: Sequence[ModalSums], powers: int) -> Repetitions:
        """For laws of t … t^powers."""
        return cls(tuple(LawSums.of(sums, powers) for sums in motions))

    @property
    def rms_moved(self) -> float:
        """RMS distance of the motions from their first frames."""
        total = sum(part.total for part in self.parts)
        return float(np.sqrt(total / sum(part.count for part in self.parts)))

    def solved(
        self,
        degree: int,
        closure: str,
        starts: int,
        near: Sequence[NDArray[np.float64]] = (),
    ) -> Solution:
        """All motions together."""
        sums = LawSums.together(self.parts)
        objective = Objective(sums, degree, closure)
        stiff = best_load(Objective(sums, degree, "limit"))
        return Solution(objective, solve(objective, starts=starts, near=near), stiff)

    def folds(self, whole: Solution, starts: int) -> list[Solution]:
        """One solution without each motion; none for a single motion."""
        if len(self.parts) < 2:
            return []
        degree, closure = whole.objective.degree, whole.objective.closure
        near = [whole.optimum.point]
        return [
            self.without(i).solved(degree, closure, min(starts, _FOLD_STARTS), near)
            for i in range(len(self.parts))
        ]

    def without(self, left_out: int) -> Repetitions:
        """All motions but one."""
        return Repetitions(self.parts[:left_out] + self.parts[left_out + 1 :])

    def left_out_rms(self, folds: Sequence[Solution]) -> float:
        """RMS distance of each motion to the solution without it; NaN for a single motion."""
        if not folds:
            return float("nan")
        squared = sum(p.misfit(fold.laws) for p, fold in zip(self.parts, folds, strict=True))
        return float(np.sqrt(squared / sum(part.count for part in self.parts)))


def constants(whole: Solution, folds: Sequence[Solution]) -> Constants:
    """Intervals of a solution; constants that may be as small as you like are made so."""
    objective, optimum = whole.objective, whole.optimum
    allowed = optimum.cost + slack(objective, optimum)
    free = objective.free.copy()
    ends = [interval(objective, optimum, index) for index in (0, 1)]
    stiff = objective.bounds[0]
    for index in (1, 0):
        if np.isinf(ends[index][0]):
            held = optimum.point.copy()
            held[index] = stiff[index]
            others = free.copy()
            others[index] = False
            simpler = minimised(objective, held, others)
            if simpler.cost <= allowed:
                optimum, free = simpler, others
    ratios = []
    for index, (low, high) in enumerate(ends):
        known = np.isfinite(low) and np.isfinite(high)
        refits = [float(np.exp(fold.optimum.point[index])) for fold in folds]
        ratios.append(
            Ratio(
                float(np.exp(optimum.point[index])) if known else None,
                float(np.exp(low)),
                float(np.exp(high)),
                (min(refits), max(refits)) if refits and known else None,
            )
        )
    needless = objective.closure == "limit" and (optimum.point[:2] == stiff[:2]).all()
    return Constants(
        Solution(objective, optimum, whole.stiff),
        ratios[0],
        ratios[1],
        load_intervals(objective, optimum, free),
        None if needless else objective.material(optimum.point),
    )
