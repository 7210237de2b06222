"""The closed-form solution: one polynomial time law for each mode (Eqs. 6-33).

A mode of stiffness B > 0 obeys m g″ + c g′ + B g = e₀ + e₁ p(t). Its polynomial particular
solution for the load alone, a(t) = Σ a_r t^r, has

    a_r = ( p_r - c(r+1) a_{r+1} - m(r+2)(r+1) a_{r+2} ) / B,   r = R … 1,  a_{R+1} = a_{R+2} = 0

(Eq. 22), and the two known shapes fix e₀ and e₁, so that g(t) = g(0) + φ(t)·(g(1) - g(0)) with

    φ(t) = Σ_{r≥1} a_r t^r / Σ_{r≥1} a_r.

The mean of a curve has B = 0: m g″ + c g′ = e₀ + e₁ p(t), whose solution (Eqs. 11-17)

    b_{r+1} = ( p_r - m(r+2)(r+1) b_{r+2} ) / ( c(r+1) ),   r = R … 1

leaves b₁ free. A *closure* names the choice of b₁.
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import ParameterError
from elastomorph.physics.load import Load
from elastomorph.physics.material import Material

__all__ = ["CLOSURES", "Closure", "mean_response", "modal_response"]

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
        gram = _gram(order + 1)
        share = (h @ gram @ (limit - linear)) / (h @ gram @ h)
        return np.asarray(linear + share * h, dtype=np.float64)
    if closure == "unforced":
        b[1] = -2.0 * m * b[2] / c
    elif closure != "rest":
        raise ParameterError(f"closure must be one of {', '.join(CLOSURES)}, found {closure!r}")
    law = b[1 : order + 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(law / law.sum(), dtype=np.float64)


def _gram(size: int) -> NDArray[np.float64]:
    """(size, size) inner products of t, t², … on [0, 1]."""
    powers = np.arange(1, size + 1)
    return np.asarray(1.0 / (powers[:, None] + powers[None, :] + 1.0), dtype=np.float64)
