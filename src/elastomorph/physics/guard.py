"""Refuse materials at which a time law is singular; warn of laws that run backwards or too far."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ResonanceError, TimeLawWarning, warn
from elastomorph.physics.equation import HIGHEST_ORDER, Load, Material
from elastomorph.physics.response import mean_response, modal_response

_Modes = Sequence[tuple[str, NDArray[np.float64]]]

# A law that throws the face ten times past its target is of no use to anybody, and it happens
# only within a few percent of a singular material.
_RESONANT = 10.0
_WELL_BEHAVED = 0.01
_POWERS = np.linspace(0.0, 1.0, 129) ** np.arange(1, HIGHEST_ORDER + 2)[:, None]


def excursion(laws: NDArray[np.float64]) -> NDArray[np.float64]:
    """How far (…, K) coefficients of t … t^K leave [0, 1] or run back; infinite if singular."""
    with np.errstate(invalid="ignore", over="ignore"):
        values = laws @ _POWERS[: laws.shape[-1]]
        high = np.maximum.accumulate(values, axis=-1)
        worst = np.maximum((high - values).max(axis=-1), values.max(axis=-1) - 1.0)
    return np.where(np.isfinite(worst), worst, np.inf)


def allowed_excursion(load: Load) -> float:
    """The excursion that calls for no warning: 1 %, or what the user's own load asks for."""
    return max(_WELL_BEHAVED, 1.01 * float(excursion(load.limit_law)))


def guard_laws(stiffness: _Modes, closure: str, load: Load, material: Material) -> None:
    """Raise or warn if a law of these modes is singular or ill behaved.

    Modes are given as (…, N) B of n = 1 … N under what they belong to ("closed curves", "surface").
    Either message names the mode, its B and the nearest damping at which every law is well behaved.

    Raises:
        ResonanceError: A law leaves [0, 1] by more than ten times the way to the target.

    Warns:
        TimeLawWarning: A law leaves [0, 1] or runs back by more than 1 %, and more than the load.
    """
    kind, mode, value, worst = _worst(stiffness, closure, load, material)
    name = "the mean (mode 0)" if mode == 0 else f"mode {mode} of the {kind}"
    if worst <= allowed_excursion(load):
        return
    safe = _nearest_safe_damping(stiffness, closure, load, material)
    remedy = (
        f"the nearest safe damping is {safe:.6g}"
        if np.isfinite(safe)
        else "no damping helps: change the mass, the rigidity or the closure"
    )
    if worst > _RESONANT:
        raise ResonanceError(
            f"{name} (B = {value:.6g}) is resonant at mass {material.mass:g}, damping "
            f"{material.damping:g}, rigidity {material.rigidity:g} with a load of order "
            f"{load.order}: {remedy}",
            mode=mode,
            stiffness=value,
            safe_damping=safe,
        )
    warn(
        f"{name} (B = {value:.6g}) moves backwards or overshoots by {worst:.1%} of the way "
        f"to the target at damping {material.damping:g}: {remedy}",
        TimeLawWarning,
    )


def _worst(
    stiffness: _Modes, closure: str, load: Load, material: Material
) -> tuple[str, int, float, float]:
    """Kind, number, B and excursion of the law that leaves [0, 1] farthest."""
    mean = float(excursion(mean_response(closure, load, material)))
    found = ("", 0, 0.0, mean)
    for kind, values in stiffness:
        if values.size:
            excursions = excursion(modal_response(values, load, material))
            place = np.unravel_index(int(excursions.argmax()), values.shape)
            if excursions[place] > found[3]:
                found = (kind, int(place[-1]) + 1, float(values[place]), float(excursions[place]))
    return found


def _nearest_safe_damping(stiffness: _Modes, closure: str, load: Load, material: Material) -> float:
    """The nearest damping, by ratio, at which no law leaves [0, 1] by more than is allowed.

    Either side of a resonance the excursion grows towards it, so the way to a safe damping may be
    up or down. Found with the digits it is shown with.
    """
    for distance in np.geomspace(1.001, 1e6, 500):
        for factor in (1.0 / distance, distance):
            damping = float(f"{material.damping * factor:.6g}")
            if not 0.0 < damping < np.inf:
                continue
            changed = Material(material.mass, damping, material.rigidity)
            if _worst(stiffness, closure, load, changed)[3] <= allowed_excursion(load):
                return damping
    return float("nan")
