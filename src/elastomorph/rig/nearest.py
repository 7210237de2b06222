"""Least squares with bounds and few moves: the x in a box whose residuals are smallest.

    ½ |r(x)|² + λ Σ |x_j - x⁰_j| + ½ ρ |x - x⁰|²,    low ≤ x ≤ high

The second term leaves at x⁰ exactly what need not move; the third, far smaller, shares out what the
others leave open. Levenberg-Marquardt steps, each the exact minimum of its quadratic model in the
box, which an active set finds: residuals have few parameters, so everything is small and dense.
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
_PRECISION, _WORTH = 1e-8, 1e-4
# Damping where the model has held so far, as a part of the largest diagonal element.
_LEAST_DAMPING = 1e-8


class Box(NamedTuple):
    """Where parameters may be, where they start, and what it costs to leave there; all (J,)."""

    low: Floats
    high: Floats
    start: Floats
    prior: float  # λ
    ridge: float  # ρ

    def cost(self, x: Floats) -> float:
        """λ Σ |x_j - x⁰_j| + ½ ρ |x - x⁰|²."""
        away = x - self.start
        return self.prior * float(np.abs(away).sum()) + 0.5 * self.ridge * float(away @ away)


def nearest(residuals: Residuals, box: Box, near: Floats) -> Floats:
    """The minimum that is downhill from a point in the box; (J,)."""
    x = near
    left, rows, curved = residuals(x)
    cost = _half_square(left) + box.cost(x)
    damping = _LEAST_DAMPING
    for _ in range(_STEPS):
        normal, gradient = rows.T @ rows + curved, rows.T @ left
        largest = float(normal.diagonal().max(initial=0.0))
        trial = _model_minimum(normal + damping * largest * np.eye(len(x)), gradient, box, x)
        moved = trial - x
        promised = cost - _half_square(left + rows @ moved) - box.cost(trial)
        promised -= 0.5 * float(moved @ curved @ moved)
        if np.abs(moved).max(initial=0.0) <= _PRECISION or promised <= _WORTH * cost:
            break
        again, *derivatives = residuals(trial)
        now = _half_square(again) + box.cost(trial)
        # The more of what the model promised has come, the longer the next step.
        if now < cost:
            damping *= 0.1 if cost - now > 0.5 * promised else 1.0
            damping = max(damping, _LEAST_DAMPING)
            x, left, cost = trial, again, now
            rows, curved = derivatives
        else:
            damping *= 10.0
    return x


def _half_square(residuals: Floats) -> float:
    return 0.5 * float(residuals @ residuals)


def _model_minimum(normal: Floats, gradient: Floats, box: Box, at: Floats) -> Floats:
    """The minimum over the box of ½ dᵀNd + gᵀd and the prior, with d = x - at; N is definite.

    Those with the most to gain are let go, and all that are free go to their common minimum, or to
    where the first of them meets a bound or its start, and stays.
    """
    from scipy.linalg.lapack import dposv

    low, high, start, prior, ridge = box
    model = normal + ridge * np.eye(len(at))
    offset = gradient - normal @ at - ridge * start
    x, sides = at.copy(), np.sign(at - start)
    free = (x > low) & (x < high) & (sides != 0)
    enough = 1e-6 * prior + 1e-15 * float(model.diagonal().max(initial=0.0))
    # One let go after the other always comes lower; several at the first time save most of them.
    share = 0.3
    for _ in range(20 * len(x) + 20):
        while free.any():
            own = np.flatnonzero(free)
            here, side = x[own], sides[own]
            slope = model[own] @ x + offset[own] + prior * side
            aim = here - dposv(model[own[:, None], own], slope)[1]
            # On one side of its start the cost of a parameter is smooth.
            least = np.where(side > 0, start[own], low[own])
            most = np.where(side > 0, high[own], start[own])
            within = np.minimum(np.maximum(aim, least), most)
            met = within != aim
            if not met.any():
                x[own] = aim
                break
            parts = (within - here)[met] / (aim - here)[met]
            part = float(parts.min())
            met[met] = parts <= part
            on_the_way = np.minimum(np.maximum(here + part * (aim - here), least), most)
            x[own] = np.where(met, within, on_the_way)
            free[own[met]] = False
        slope = model @ x + offset
        up = np.where(x < high, -slope - np.where(x >= start, prior, -prior), 0.0)
        down = np.where(x > low, slope - np.where(x <= start, prior, -prior), 0.0)
        gain = np.where(free, 0.0, np.maximum(up, down))
        most_gain = float(gain.max(initial=0.0))
        if most_gain <= enough:
            break
        chosen = gain >= share * most_gain
        share = 1.0
        free |= chosen
        away = np.where(up >= down, 1.0, -1.0)
        sides = np.where(chosen, np.where(x == start, away, np.sign(x - start)), sides)
    return x
