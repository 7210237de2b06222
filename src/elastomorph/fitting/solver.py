"""The best material and load, and how far each constant may be from it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from elastomorph.fitting.modal_sums import EXCURSION, Objective

CONFIDENCE = 0.95
# Captures that differ by less than a millionth of the movement are the same capture.
_PRECISION = 1e-12
_GRID = 14
_APART = 1.0
_LARGEST_STEP = 1.0
_BISECTIONS = 12


class Optimum(NamedTuple):
    """A point, (R + 1,) as in `elastomorph.fitting.modal_sums`, with its misfit and penalty."""

    point: NDArray[np.float64]
    cost: float


def minimised(objective: Objective, start: NDArray[np.float64], free: NDArray[np.bool_]) -> Optimum:
    """The optimum nearest to a start, with some parameters fixed."""
    from scipy.optimize import least_squares

    low, high = objective.bounds
    point = np.clip(start, low, high)
    if not free.any():
        return Optimum(point, objective.cost(point))

    def residuals(values: NDArray[np.float64]) -> NDArray[np.float64]:
        moved = point.copy()
        moved[free] = values
        return objective.residuals(moved)

    solved = least_squares(
        residuals,
        point[free],
        bounds=(low[free], high[free]),
        xtol=1e-12,
        ftol=1e-14,
        gtol=1e-15,
        max_nfev=200,
    )
    found = point.copy()
    found[free] = solved.x
    return Optimum(found, objective.cost(found))


def best_load(objective: Objective) -> Optimum:
    """The best load for curves so stiff that all follow it: p(t)/p(1) is linear in p."""
    if objective.degree == 1:
        return Optimum(objective.bounds[0], objective.cost(objective.bounds[0]))
    sums = objective.sums
    changes = np.zeros((sums.aims.shape[1], objective.degree - 1))
    changes[0] = -1.0
    changes[np.arange(1, objective.degree), np.arange(objective.degree - 1)] = 1.0
    linear = np.zeros_like(sums.aims)
    linear[:, 0] = 1.0
    rows = (sums.factors @ changes).reshape(-1, objective.degree - 1)
    shares = np.linalg.lstsq(rows, -sums.residuals(linear).ravel(), rcond=None)[0]
    start = np.concatenate([objective.bounds[0][:2], shares])
    return minimised(objective, start, np.arange(len(start)) >= 2)


def solve(
    objective: Objective, *, starts: int = 8, near: Sequence[NDArray[np.float64]] = ()
) -> Optimum:
    """The best point from the stiff limit, from `near`, and the best of a grid of materials."""
    stiff = best_load(objective)
    free = objective.free
    if not free[:2].any():
        return stiff
    points = [stiff.point, *near, *_grid(objective, stiff.point, starts)]
    found = [stiff] + [minimised(objective, point, free) for point in points]
    inside = [one for one in found if objective.excursion(one.point) <= EXCURSION]
    return min(inside or found, key=lambda one: one.cost)


def _grid(
    objective: Objective, stiff: NDArray[np.float64], count: int
) -> list[NDArray[np.float64]]:
    """The best materials of a grid around the stiffness of the modes, none close to another."""
    b = objective.sums.stiffness[1:]
    if not (count and b.size):
        return []
    steps = np.log(np.geomspace(1e-3 * b.min(), 3.0 * b.max(), _GRID))
    points = [
        np.concatenate([[damping, mass], stiff[2:]])
        for damping in steps
        for mass in (steps if objective.free[1] else stiff[1:2])
    ]
    chosen: list[NDArray[np.float64]] = []
    for point in sorted(points, key=objective.cost):
        if all(np.abs(point[:2] - other[:2]).max() > _APART for other in chosen):
            chosen.append(point)
        if len(chosen) == count:
            break
    return chosen


def slack(objective: Objective, optimum: Optimum) -> float:
    """How much worse than the best is still as good, at 95 % and for independent residuals.

    misfit ≤ least misfit · (1 + F₁,ν / ν) with ν numbers more than parameters: the likelihood
    ratio of normal errors of unknown size.
    """
    from scipy.special import fdtri

    freedom = _degrees_of_freedom(objective)
    misfit = objective.misfit(optimum.point)
    return max(misfit * float(fdtri(1, freedom, CONFIDENCE)) / freedom, _PRECISION)


def interval(objective: Objective, optimum: Optimum, index: int) -> tuple[float, float]:
    """Where one parameter may be while the others adapt (profile likelihood), maybe infinite."""
    if not objective.free[index]:
        return -np.inf, np.inf
    free = objective.free.copy()
    free[index] = False
    limit = optimum.cost + slack(objective, optimum)
    border = [bound[index] for bound in objective.bounds]
    ends = []
    for sign, bound in zip((-1.0, 1.0), border, strict=True):
        inside, point, step = float(optimum.point[index]), optimum.point, 1e-3
        outside, bisected = np.nan, 0
        while bisected < _BISECTIONS:
            trial = point.copy()
            if not np.isnan(outside):
                trial[index] = 0.5 * (inside + outside)
                bisected += 1
            elif inside == bound:
                break
            else:
                trial[index] = np.clip(inside + sign * step, *border)
            others = minimised(objective, trial, free)
            if others.cost > limit:
                outside = float(trial[index])
            else:
                inside, point = float(trial[index]), others.point
                step = min(2.0 * step, _LARGEST_STEP)
        ends.append(sign * np.inf if np.isnan(outside) else outside)
    return ends[0], ends[1]


def load_intervals(
    objective: Objective, optimum: Optimum, free: NDArray[np.bool_]
) -> tuple[tuple[float, float], ...]:
    """Intervals of p₁ … p_R from the Jacobian at the optimum, with some parameters fixed.

    Infinite where a coefficient is not determined.
    """
    from scipy.special import stdtrit

    degree = objective.degree
    if degree == 1:
        return ((1.0, 1.0),)
    scale = np.sqrt(objective.sums.total)
    chosen = np.flatnonzero(free)
    columns = []
    for number in chosen:
        step = np.zeros(len(free))
        step[number] = 1e-6
        sides = [
            objective.sums.residuals(objective.laws(optimum.point + s * step)) for s in (1, -1)
        ]
        columns.append((sides[0] - sides[1]).ravel() / (2e-6 * scale))
    _, singular, right = np.linalg.svd(np.stack(columns, axis=1), full_matrices=False)
    freedom = _degrees_of_freedom(objective)
    variance = objective.misfit(optimum.point) / freedom
    reach = float(stdtrit(freedom, 0.5 + 0.5 * CONFIDENCE))
    loads = np.zeros((degree, len(chosen)))
    shares = chosen >= 2
    loads[1:, shares] = np.eye(degree - 1)
    loads[0, shares] = -1.0
    with np.errstate(divide="ignore", invalid="ignore"):
        spread = (loads @ right.T) / np.where(singular > 1e-10 * singular[0], singular, 0.0)
    spread = np.nan_to_num(spread, nan=0.0, posinf=np.inf, neginf=-np.inf)
    half = reach * np.sqrt(variance * (spread**2).sum(axis=1))
    values = np.concatenate([[1.0 - optimum.point[2:].sum()], optimum.point[2:]])
    return tuple((float(v - h), float(v + h)) for v, h in zip(values, half, strict=True))


def _degrees_of_freedom(objective: Objective) -> int:
    """Numbers measured beyond those fitted."""
    return max(3 * objective.sums.count - int(objective.free.sum()), 1)
