"""Time laws as partial sums of resolvents: the whole spectrum at once, without its modes.

For a load of degree R the coefficient of t^r in φ is a ratio of polynomials in B. Multiplied out,
with β_1 … β_{R-1} the roots of the denominator,

    φ_r(B) = p_r/p(1) + Σ_j d_rj / ((B - β_1) … (B - β_j)).

So Σ_n φ_r(B_n) Δ_n = p_r/p(1)·Δ + Σ_j d_rj s_j with (K - β_j M) s_j = M s_{j-1}, s_0 = Δ: one
sparse solve for each root. For the load t² the root is 2c; for t³ the roots are those of
B² - 3Bc - 6Bm + 6c².
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray

from elastomorph.physics.load import Load
from elastomorph.physics.material import Material

__all__ = ["RationalLaws", "rational_laws"]


@dataclass(frozen=True, eq=False)
class RationalLaws:
    """The coefficients of φ as functions of B.

    Attributes:
        roots: (R - 1,) complex β; conjugates stand next to each other, upper half plane first.
        weights: (R, R - 1) complex d, for t … t^R.
        limit: (R,) p_r/p(1).
    """

    roots: NDArray[np.complex128]
    weights: NDArray[np.complex128]
    limit: NDArray[np.float64]


def rational_laws(load: Load, material: Material) -> RationalLaws:
    """The laws of `modal_response` for all B at once.

    Args:
        load: p(t) of degree R.
        material: m and c; k is part of B.
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
            rest, weights[r, j] = _divided(rest, roots[j])
    return RationalLaws(roots, weights, limit)


def _divided(
    numerator: NDArray[np.complex128], root: complex
) -> tuple[NDArray[np.complex128], complex]:
    """Quotient and remainder of a polynomial by x - root."""
    quotient = np.zeros(len(numerator) - 1, dtype=np.complex128)
    carry = 0j
    for power in range(len(numerator) - 1, -1, -1):
        carry = carry * root + numerator[power]
        if power:
            quotient[power - 1] = carry
    return quotient, carry


def _paired(roots: NDArray[np.floating | np.complexfloating]) -> NDArray[np.complex128]:
    """Roots of a real polynomial, each complex one followed by its exact conjugate."""
    roots = np.asarray(roots, dtype=np.complex128)
    ordered: list[complex] = sorted((root for root in roots if root.imag == 0), key=abs)
    for root in sorted((root for root in roots if root.imag > 0), key=abs):
        ordered += [root, root.conjugate()]
    return np.array(ordered, dtype=np.complex128)
