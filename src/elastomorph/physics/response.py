"""The closed-form solution: one polynomial time law for each mode (Eqs. 6-33).

A mode of stiffness B > 0 obeys m g″ + c g′ + B g = e₀ + e₁ p(t). Its polynomial particular
solution for the load alone, a(t) = Σ a_r t^r, has

    a_r = ( p_r - c(r+1) a_{r+1} - m(r+2)(r+1) a_{r+2} ) / B,   r = R … 1,  a_{R+1} = a_{R+2} = 0

(Eq. 22), and the two known shapes fix e₀ and e₁, so that g(t) = g(0) + φ(t)·(g(1) - g(0)) with

    φ(t) = Σ_{r≥1} a_r t^r / Σ_{r≥1} a_r.

The mean of a curve has B = 0: m g″ + c g′ = e₀ + e₁ p(t), whose solution (Eqs. 11-17)

    b_{r+1} = ( p_r - m(r+2)(r+1) b_{r+2} ) / ( c(r+1) ),   r = R … 1

leaves b₁ free. A *closure* names the choice of b₁.

The coefficient of t^r in φ is a ratio of polynomials in B. Multiplied out, with β_1 … β_{R-1} the
roots of the denominator,

    φ_r(B) = p_r/p(1) + Σ_j d_rj / ((B - β_1) … (B - β_j)).

So Σ_n φ_r(B_n) Δ_n = p_r/p(1)·Δ + Σ_j d_rj s_j with (K - β_j M) s_j = M s_{j-1}, s_0 = Δ: the whole
spectrum at once, without its modes, for one sparse solve a root. For the load t² the root is 2c;
for t³ the roots are those of B² - 3Bc - 6Bm + 6c².
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import ParameterError, ResonanceError, TimeLawWarning, warn
from elastomorph.physics.equation import HIGHEST_ORDER, Load, Material

Closure = Literal["unforced", "rest", "linear", "compatible", "limit"]
CLOSURES: tuple[str, ...] = get_args(Closure)

_RESCALE = 1e100


def modal_response(stiffness: ArrayLike, load: Load, material: Material) -> NDArray[np.float64]:
    """Coefficients of the time laws φ of modes with stiffness B > 0 (Eqs. 18-30).

    Args:
        stiffness: B of each mode, any shape; infinity gives the limit law.
        load: p(t), of degree R.
        material: m and c; k is part of B.

    Returns:
        (…, R) coefficients of t, t², …, t^R, with sum 1. Not finite where a law is singular.
    """
    b = np.asarray(stiffness, dtype=np.float64)
    m, c = material.mass, material.damping
    order = load.order
    # B·a_r rather than a_r: it stays finite for any B, and the factor cancels in φ.
    a = np.zeros((order + 3, *b.shape))
    scale = np.ones(b.shape)
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        for r in range(order, 0, -1):
            inner = c * (r + 1) * a[r + 1] + m * (r + 2) * (r + 1) * a[r + 2]
            a[r] = load.coefficients[r - 1] * scale - inner / b
            shrink = 1.0 / np.where(np.abs(a[r]) > _RESCALE, np.abs(a[r]), 1.0)
            a *= shrink
            scale *= shrink
        laws = a[1 : order + 1] / a[1 : order + 1].sum(axis=0)
    return np.moveaxis(laws, 0, -1)


def mean_response(closure: str, load: Load, material: Material) -> NDArray[np.float64]:
    """Coefficients of the time law φ₀ of the mean of a curve (Eqs. 11-17).

    Args:
        closure: How the free constant b₁ is chosen. ``unforced``: e₀ = 0. ``rest``: zero initial
            velocity. ``linear``: e₁ = 0, which is also the limit B → 0. ``compatible``: φ₀ closest
            to p(t)/p(1) in L²[0, 1]. ``limit``: φ₀ = p(t)/p(1), what every stiff mode tends to;
            its force is m φ₀″ + c φ₀′.
        load: p(t), of degree R.
        material: m and c.

    Returns:
        (R + 1,) coefficients of t, t², …, t^(R+1), with sum 1. Not finite where singular.

    Raises:
        ParameterError: No such closure.
    """
    order = load.order
    linear: NDArray[np.float64] = np.zeros(order + 1)
    linear[0] = 1.0
    limit = np.append(load.limit_law, 0.0)
    if closure == "linear":
        return linear
    if closure == "limit":
        return limit
    m, c = material.mass, material.damping
    b = np.zeros(order + 3)
    for r in range(order, 0, -1):
        inner = m * (r + 2) * (r + 1) * b[r + 2]
        b[r + 1] = (load.coefficients[r - 1] - inner) / (c * (r + 1))
    if closure == "compatible":
        # φ₀ = t + λ h with h = Σ_{r≥2} b_r (t^r - t): linear in λ, so the best one is a projection.
        h = b[1 : order + 2].copy()
        h[0] = -h[1:].sum()
        powers = np.arange(1, order + 2)
        gram = 1.0 / (powers[:, None] + powers + 1.0)  # inner products of t, t², … on [0, 1]
        share = (h @ gram @ (limit - linear)) / (h @ gram @ h)
        return np.asarray(linear + share * h, dtype=np.float64)
    if closure == "unforced":
        b[1] = -2.0 * m * b[2] / c
    elif closure != "rest":
        raise ParameterError(f"closure must be one of {', '.join(CLOSURES)}, found {closure!r}")
    law = b[1 : order + 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(law / law.sum(), dtype=np.float64)


def mean_and_limit(
    closure: str, load: Load, material: Material
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Both (K,) laws of what has no B: the mean of a curve or piece, and p(t)/p(1).

    K is R, or R + 1 where the law of the mean has that degree.
    """
    mean = mean_response(closure, load, material)
    degree = load.order + 1 if mean[-1] != 0 else load.order
    limit = np.zeros(degree)
    limit[: load.order] = load.limit_law
    return mean[:degree], limit


def rational_laws(
    load: Load, material: Material
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """The laws of `modal_response` for all B at once: (R - 1,) β and (R, R - 1) d of t … t^R.

    Conjugate roots stand next to each other, that of the upper half plane first.
    """
    m, c, order = material.mass, material.damping, load.order
    # Polynomials in B: row r is B^(R-1)·(B a_r), from the recurrence of Eq. 22.
    a = np.zeros((order + 3, order))
    for r in range(order, 0, -1):
        inner = c * (r + 1) * a[r + 1] + m * (r + 2) * (r + 1) * a[r + 2]
        a[r, :-1] = -inner[1:]
        a[r, -1] += load.coefficients[r - 1]
    denominator = a[1 : order + 1].sum(axis=0)
    roots = _paired(polynomial.polyroots(denominator))
    limit = load.limit_law
    weights = np.zeros((order, order - 1), dtype=np.complex128)
    for r in range(order):
        rest = ((a[r + 1] - limit[r] * denominator) / denominator[-1])[:-1].astype(np.complex128)
        for j in range(order - 2, -1, -1):
            rest, remainder = polynomial.polydiv(rest, [-roots[j], 1.0])
            weights[r, j] = remainder[0]
    return roots, weights


def _paired(roots: NDArray[np.floating | np.complexfloating]) -> NDArray[np.complex128]:
    """Roots of a real polynomial, each complex one followed by its exact conjugate."""
    roots = np.asarray(roots, dtype=np.complex128)
    ordered: list[complex] = sorted((root for root in roots if root.imag == 0), key=abs)
    for root in sorted((root for root in roots if root.imag > 0), key=abs):
        ordered += [root, root.conjugate()]
    return np.array(ordered, dtype=np.complex128)


# Refuse materials at which a time law is singular; warn of laws that run backwards or too far.

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
