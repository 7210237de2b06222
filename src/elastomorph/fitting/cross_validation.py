"""Motions fitted together, then each time without one of them; and every curve alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork
from elastomorph.fitting.modal_sums import LawSums, ModalSums, Objective
from elastomorph.fitting.results import CurveFit, Ratio
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

# Starts of a fit without one motion, besides the optimum of them all.
_FOLD_STARTS = 2
_UNKNOWN = Ratio(None, 0.0, float("inf"))
_STILL = 1e-18


@dataclass(frozen=True, eq=False)
class Solution:
    """One degree fitted to some motions; `stiff` is the best load for curves that all follow it."""

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

    @property
    def rms(self) -> float:
        """RMS distance to the motions that were fitted."""
        sums = self.objective.sums
        return float(np.sqrt(sums.misfit(self.laws) / sums.count))

    @property
    def bic(self) -> float:
        """n ln(misfit) + parameters · ln n; what is exact to six digits is exact."""
        sums = self.objective.sums
        misfit = max(sums.misfit(self.laws) / sums.total, 1e-12)
        parameters = int(self.objective.free.sum())
        return float(sums.frames * np.log(misfit) + parameters * np.log(sums.frames))


@dataclass(frozen=True, eq=False)
class Validated:
    """One degree fitted to all motions, and to all but one: no folds of a single motion.

    `left_out_rms` is the RMS distance of each motion to the solution without it; NaN for one alone.
    """

    whole: Solution
    folds: tuple[Solution, ...]
    left_out_rms: float


def solved(
    parts: Sequence[LawSums],
    degree: int,
    closure: str,
    starts: int,
    near: Sequence[NDArray[np.float64]] = (),
) -> Solution:
    """All motions together."""
    sums = LawSums.together(parts)
    objective = Objective(sums, degree, closure)
    stiff = best_load(Objective(sums, degree, "limit"))
    return Solution(objective, solve(objective, starts=starts, near=near), stiff)


def validated(parts: Sequence[LawSums], degree: int, closure: str, starts: int) -> Validated:
    """All motions together, and without each of them."""
    whole = solved(parts, degree, closure, starts)
    if len(parts) < 2:
        return Validated(whole, (), float("nan"))
    others = [[*parts[:i], *parts[i + 1 :]] for i in range(len(parts))]
    fewer, near = min(starts, _FOLD_STARTS), [whole.optimum.point]
    folds = tuple(solved(fewer_parts, degree, closure, fewer, near) for fewer_parts in others)
    squared = sum(part.misfit(fold.laws) for part, fold in zip(parts, folds, strict=True))
    return Validated(whole, folds, float(np.sqrt(squared / sum(part.count for part in parts))))


@dataclass(frozen=True, eq=False)
class Constants:
    """What a solution says of material and load, and how surely.

    Ratios that nothing bounds from below are at the stiff end of their range in the solution; there
    is no material where neither ratio matters.
    """

    solution: Solution
    damping: Ratio
    mass: Ratio
    load_intervals: tuple[tuple[float, float], ...]
    material: Material | None


def constants(fitted: Validated) -> Constants:
    """Intervals of a solution; constants that may be as small as you like are made so."""
    whole = fitted.whole
    objective, optimum = whole.objective, whole.optimum
    allowed = optimum.cost + slack(objective, optimum)
    free = objective.free.copy()
    ends = [interval(objective, optimum, index) for index in (0, 1)]
    stiff = objective.bounds[0]
    for index in (1, 0):
        if np.isinf(ends[index][0]):
            smallest, others = optimum.point.copy(), free.copy()
            smallest[index], others[index] = stiff[index], False
            simpler = minimised(objective, smallest, others)
            if simpler.cost <= allowed:
                optimum, free = simpler, others
    ratios = []
    for index, (low, high) in enumerate(ends):
        known = np.isfinite(low) and np.isfinite(high)
        refits = [float(np.exp(fold.optimum.point[index])) for fold in fitted.folds]
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


def fit_curves(
    sums: Sequence[Sequence[ModalSums]],
    curves: CurveNetwork,
    degree: int,
    closure: str,
    starts: int,
    diameter: float,
    say: Callable[[str], None],
) -> tuple[CurveFit, ...]:
    """Each curve fitted alone: do all parts of a face have one material and one load?

    Of each motion, the sums of each curve are given.
    """
    found = []
    for number, curve in enumerate(curves):
        name = curve.name or str(number)
        say(f"curve {name} ({number + 1} of {len(curves)})")
        motions = [parts[number] for parts in sums]
        moving = [
            p for p in motions if p.displacement.sum() > _STILL * diameter**2 and len(p.times)
        ]
        if not moving:
            found.append(CurveFit(name, None, _UNKNOWN, _UNKNOWN, 0.0, 0.0, float("nan")))
            continue
        fitted = validated([LawSums.of(p, degree + 1) for p in moving], degree, closure, starts)
        known = constants(fitted)
        together = fitted.whole.objective.sums
        linear = np.zeros_like(together.aims)
        linear[:, 0] = 1.0
        found.append(
            CurveFit(
                name,
                known.solution.load,
                known.damping,
                known.mass,
                known.solution.rms / diameter,
                float(np.sqrt(together.misfit(linear) / together.count)) / diameter,
                fitted.left_out_rms / diameter,
            )
        )
    return tuple(found)
