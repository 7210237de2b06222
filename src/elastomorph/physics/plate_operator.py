"""The elastic operator of a plate, K = L M⁻¹ᐟ² diag(k) M⁻¹ᐟ² L, for one rigidity or many.

With k the flexural rigidity, w ↦ ½ wᵀK w = ½ ∫ k (∇²w)² is the bending energy of a thin plate in
terms of the discrete Laplacian M⁻¹L, so K is symmetric, positive semi-definite, and zero exactly
on the functions that L maps to zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.physics.pencil import Modes, Pencil, Solve

if TYPE_CHECKING:
    from scipy.sparse import csc_array

# A root this small against the operator is zero; its factor would be singular on the kernel only.
_LEAST_SHIFT = 1e-8


@dataclass(frozen=True, eq=False)
class PlateOperator:
    """K v = B M v: its resolvents, its modes, and how many there are.

    One rigidity and no pinned vertex: K = k L M⁻¹ L has the modes of L v = μ M v, with B = k μ².
    Otherwise K itself, denser than L.

    Attributes:
        pencil: L v = μ M v, or K v = B M v on the free vertices.
        rigidity: k, or its mean.
        bending: (V, F) G with K = GᵀG, to apply K without the rounding of the product; nothing
            where the pencil is that of L.
    """

    pencil: Pencil
    rigidity: float
    bending: csc_array | None = None

    def resolvent(self, beta: complex) -> Solve:
        """y ↦ (K - βM)⁻¹ M y for (V, 3) y without means."""
        mass = self.pencil.mass[:, None]
        bending = self.bending
        if bending is None:
            # K - βM = k (L - sM) M⁻¹ (L + sM), s² = β/k: two solves with the sparser Laplacian.
            s = _at_least(np.sqrt(complex(beta) / self.rigidity), _LEAST_SHIFT)
            below, above = self._solve(s), self._solve(-s)
            return lambda y: above(mass * below(mass * y)) / self.rigidity

        shift = _at_least(beta, _LEAST_SHIFT**2 * self.rigidity)
        solve = self._solve(shift)

        def refined(y: NDArray[Any]) -> NDArray[Any]:
            b = mass * y
            x = solve(b)
            for _ in range(2):
                x = x + solve(b - bending.T @ (bending @ x) + shift * (mass * x))
            return x

        return refined

    @cached_property
    def _factors(self) -> dict[complex, Solve]:
        return {}

    def _solve(self, shift: complex) -> Solve:
        """(A - shift·M)⁻¹ of the pencil, one factor for a shift and its conjugate."""
        upper = complex(shift.real, abs(shift.imag))
        if upper not in self._factors:
            self._factors[upper] = self.pencil.factor(upper)
        solve = self._factors[upper]
        if shift.imag >= 0:
            return solve
        return lambda b: np.conj(solve(np.conj(b)))

    def count_below(self, stiffness: float) -> int:
        """Number of modes with 0 < B < stiffness."""
        return self.pencil.count_below(self._eigenvalue(stiffness))

    def lowest(self, count: int) -> Modes:
        """(N,) ascending B and (V, N) modes."""
        return self._with_stiffness(self.pencil.lowest(count))

    def nearest(self, stiffness: float, count: int) -> Modes:
        """(N,) ascending B and (V, N) modes with B, or √B, nearest to that of a value."""
        return self._with_stiffness(self.pencil.nearest(self._eigenvalue(stiffness), count))

    def _eigenvalue(self, stiffness: float) -> float:
        return stiffness if self.bending is not None else float(np.sqrt(stiffness / self.rigidity))

    def _with_stiffness(self, modes: Modes) -> Modes:
        values, vectors = modes
        return (values if self.bending is not None else self.rigidity * values**2), vectors


def _at_least(shift: complex, least: float) -> complex:
    return complex(shift) if abs(shift) >= least else complex(least)


def plate_operator(
    laplacian: csc_array,
    mass: NDArray[np.float64],
    piece_of: NDArray[np.integer],
    rigidity: NDArray[np.float64],
    free: NDArray[np.int64],
) -> PlateOperator:
    """K on the (F,) free vertices, of (V,) rigidity k > 0, the others pinned to the limit law."""
    from scipy.sparse import csc_array, diags_array

    columns = csc_array(laplacian[:, free])
    inner = csc_array(columns[free])
    pieces = np.asarray(piece_of)[free]
    uniform = bool((rigidity == rigidity[0]).all())
    if uniform and columns.nnz == inner.nnz:
        return PlateOperator(Pencil(inner, mass[free], pieces, 1.0), float(rigidity[0]))
    pinned = np.delete(np.asarray(piece_of), free)
    pieces = np.where(np.isin(pieces, pinned), -1, pieces)
    bending = diags_array(np.sqrt(rigidity / mass)) @ columns
    matrix = csc_array(bending.T @ bending)
    unit = float(rigidity.mean())
    return PlateOperator(Pencil(matrix, mass[free], pieces, unit), unit, bending)
