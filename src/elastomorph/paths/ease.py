"""The straight line at the pace of the load: V₀ + p(t)/p(1)·Δ, for the load t^R V₀ + t^R·Δ.

It is what a beam of infinite rigidity does, and the yardstick beside every beam: an improvement
that `ease` shares is one of timing alone.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from elastomorph.curves import CurveNetwork
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.paths.method import Method
from elastomorph.physics import Load

__all__ = ["law_bend", "prepare", "straight_path"]


def prepare(
    neutral: Mesh, method: Method, curves: CurveNetwork | None = None
) -> Callable[[Mesh], Morph]:
    """A function from target to path; one bend, Δ itself (none for a linear load)."""
    return straight_path(neutral, law_bend(method.external_load), method.label)


def law_bend(load: Load) -> BendCurve:
    """The bend curve p(t)/p(1) - t of Δ."""
    coefficients = np.concatenate([[0.0], load.limit_law])
    coefficients[1] -= 1.0
    return BendCurve.polynomial(coefficients)


def straight_path(neutral: Mesh, bend: BendCurve, label: str) -> Callable[[Mesh], Morph]:
    """A function from target to the path V₀ + (t + b(t))·Δ."""
    bends = int(bend.coefficients.any())

    def to(target: Mesh) -> Morph:
        delta = (target.vertices - neutral.vertices)[None]
        return Morph(neutral, target, delta[:bends], (bend,)[:bends], method=label, limit_law=bend)

    return to
