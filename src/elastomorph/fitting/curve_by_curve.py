"""Every curve fitted alone: do all parts of a face have one material and one load?"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from elastomorph.curves import CurveNetwork
from elastomorph.fitting.folds import Repetitions, constants
from elastomorph.fitting.modal_sums import ModalSums
from elastomorph.fitting.results import CurveFit, Ratio

__all__ = ["fit_curves"]

_UNKNOWN = Ratio(None, 0.0, float("inf"))
_STILL = 1e-18


def fit_curves(
    sums: Sequence[Sequence[ModalSums]],
    curves: CurveNetwork,
    degree: int,
    closure: str,
    starts: int,
    diameter: float,
    say: Callable[[str], None],
) -> tuple[CurveFit, ...]:
    """Fit each curve with loads of one degree.

    Args:
        sums: For each motion, the sums of each curve.
        curves: The curves.
        degree: Degree of the loads.
        closure: Time law of the means.
        starts: Starts of each fit.
        diameter: D.
        say: Called with the name of each curve.
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
        repetitions = Repetitions.of(moving, degree + 1)
        whole = repetitions.solved(degree, closure, starts)
        folds = repetitions.folds(whole, starts)
        known = constants(whole, folds)
        together = whole.objective.sums
        linear = np.zeros_like(together.aims)
        linear[:, 0] = 1.0
        fitted = together.misfit(known.solution.laws)
        found.append(
            CurveFit(
                name,
                known.solution.load,
                known.damping,
                known.mass,
                float(np.sqrt(fitted / together.count)) / diameter,
                float(np.sqrt(together.misfit(linear) / together.count)) / diameter,
                repetitions.left_out_rms(folds) / diameter,
            )
        )
    return tuple(found)
