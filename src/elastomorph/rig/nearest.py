"""Least squares with bounds and few moves: the x in a box whose residuals are smallest.

    ½ |r(x)|² + λ Σ |x_j - x⁰_j| + ½ ρ |x - x⁰|²,    low ≤ x ≤ high

The second term leaves at x⁰ exactly what need not move; the third, far smaller, shares out what the
others leave open. Levenberg-Marquardt steps, each the exact minimum of its quadratic model in the
box, which an active set finds: residuals have few parameters, so everything is small and dense.

Where many x reach the same, those of the least sum are at the end of a curved way along which the
residuals stay small. A step that leaves it is brought back by a second-order correction (Nocedal
and Wright, Numerical Optimization, 2006, Sec. 18.3).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# At (J,) parameters: (R,) residuals, their (R, J) derivatives, and (J, J) Σ_i r_i ∇²r_i or what of
# it is known and no direction has less than 0 of.
Residuals = Callable[[Floats], tuple[Floats, Floats, Floats]]

_STEPS = 60
# The search ends with a step of less than this in every parameter, or that promises no more than
# this part of the cost.
_PRECISION, _WORTH = 1e-8, 3e-4
# Damping where the model has held so far, as a part of the largest diagonal element; it is raised
# tenfold, and by ten times more for each time in a row.
_LEAST_DAMPING, _RAISE = 1e-8, 10.0
# Parameters that have more than this part of the most to gain are let go together.
_TOGETHER = 0.3


class Box(NamedTuple):
    """Where parameters may be, where they start, and what it costs to leave there; all (J,)."""

    low: Floats
    high: Floats
    start: Floats
    prior: float  # λ
    ridge: float  # ρ
    # Of residuals; without it those that stay large would blind the search to the others.
    fine: float = np.inf

    def cost(self, x: Floats) -> float:
        """λ Σ |x_j - x⁰_j| + ½ ρ |x - x⁰|²."""
        away = x - self.start
        return self.prior * float(np.abs(away).sum()) + 0.5 * self.ridge * float(away @ away)


class _Trial(NamedTuple):
    x: Floats
    left: Floats
    rows: Floats
    curved: Floats
    cost: float


def nearest(residuals: Residuals, box: Box, near: Floats) -> Floats:
    """The minimum that is downhill from a point in the box; (J,)."""

    def tried(x: Floats) -> _Trial:
        left, rows, curved = residuals(x)
        return _Trial(x, left, rows, curved, _half_square(left) + box.cost(x))

    here = tried(near)
    aim = near
    damping, raised = _LEAST_DAMPING, _RAISE
    for _ in range(_STEPS):
        x, left, rows, curved, cost = here
        model = rows.T @ rows + curved
        largest = float(model.diagonal().max(initial=0.0))
        model += damping * largest * np.eye(len(x))
        # From the aim before: what is at a bound there mostly stays.
        aim = _model_minimum(model, rows.T @ left - model @ x, box, aim)
        moved = aim - x
        modelled = left + rows @ moved
        promised = cost - _half_square(modelled) - box.cost(aim)
        promised -= 0.5 * float(moved @ curved @ moved)
        worth = min(_WORTH * cost, 0.5 * box.fine**2)
        if np.abs(moved).max(initial=0.0) <= _PRECISION or promised <= worth:
            break
        trial = tried(aim)
        if cost - trial.cost <= 0.5 * promised:
            turned = left + trial.left - modelled
            aim = _model_minimum(model, rows.T @ turned - model @ x, box, aim)
            trial = min(trial, tried(aim), key=lambda one: one.cost)
        if trial.cost < cost:
            # The more of what the model promised has come, the longer the next step.
            if cost - trial.cost > 0.5 * promised:
                damping = max(0.1 * damping, _LEAST_DAMPING)
            here, raised = trial, _RAISE
        else:
            damping *= raised
            raised *= _RAISE
    return here.x


def _half_square(residuals: Floats) -> float:
    return 0.5 * float(residuals @ residuals)


def _model_minimum(model: Floats, offset: Floats, box: Box, near: Floats) -> Floats:
    """The minimum over the box of ½ xᵀMx + oᵀx and the other terms, from near it; M is definite.

    Those with much to gain are let go, and all that are free go to their common minimum, or to
    where the first of them meets a bound or its start, and stays.
    """
    from scipy.linalg.lapack import dposv

    low, high, start, prior, ridge, _ = box
    model = model + ridge * np.eye(len(near))
    offset = offset - ridge * start
    x, sides = near.copy(), np.sign(near - start)
    free = (x > low) & (x < high) & (sides != 0)
    enough = 1e-6 * prior + 1e-15 * float(model.diagonal().max(initial=0.0))
    for _ in range(20 * len(x) + 20):
        slope = model @ x + offset
        # On one side of its start the cost of a parameter is smooth.
        least, most = np.where(sides > 0, start, low), np.where(sides > 0, high, start)
        own = free.nonzero()[0]
        while own.size:
            here, pull = x[own], slope[own] + prior * sides[own]
            aim = here - dposv(model[own[:, None], own], pull)[1]
            within = np.minimum(np.maximum(aim, least[own]), most[own])
            met = within != aim
            if not met.any():
                x[own], own = aim, own[:0]
            else:
                parts = (within - here)[met] / (aim - here)[met]
                part = float(parts.min())
                met[met] = parts <= part
                on_the_way = np.minimum(
                    np.maximum(here + part * (aim - here), least[own]), most[own]
                )
                x[own] = np.where(met, within, on_the_way)
                free[own[met]] = False
                own = own[~met]
            slope = model @ x + offset
        up = np.where(x < high, -slope - np.where(x >= start, prior, -prior), 0.0)
        down = np.where(x > low, slope - np.where(x <= start, prior, -prior), 0.0)
        gain = np.where(free, 0.0, np.maximum(up, down))
        most_gain = float(gain.max(initial=0.0))
        if most_gain <= enough:
            break
        chosen = gain >= _TOGETHER * most_gain
        free |= chosen
        away = np.where(up >= down, 1.0, -1.0)
        sides = np.where(chosen, np.where(x == start, away, np.sign(x - start)), sides)
    return x
