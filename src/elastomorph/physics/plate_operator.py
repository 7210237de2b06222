"""The elastic operator of a plate, K = L M⁻¹ᐟ² diag(r) M⁻¹ᐟ² L, alike everywhere or painted.

With D the flexural rigidity, w ↦ ½ wᵀK w = ½ ∫ D (Δw)² is the bending energy of a thin plate in
terms of the discrete Laplacian M⁻¹L, so K is symmetric, positive semi-definite, and zero exactly
on the functions that L maps to zero.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from elastomorph.physics.pencil import Pencil

if TYPE_CHECKING:
    from scipy.sparse import csc_array

__all__ = ["PaintedPlate", "PlateOperator", "UniformPlate", "plate_operator"]

Resolvent = Callable[[NDArray[Any]], NDArray[Any]]
Modes = tuple[NDArray[np.float64], NDArray[np.float64]]

# A root this small against the operator is zero; its factor would be singular on the kernel only.
_LEAST_SHIFT = 1e-8


class PlateOperator(Protocol):
    """K v = B M v: its resolvents, its modes, and how many there are."""

    @property
    def pencil(self) -> Pencil:
        """The eigenproblem that is solved."""

    def resolvent(self, beta: complex) -> Resolvent:
        """y ↦ (K - βM)⁻¹ M y for (V, 3) y without means."""

    def count_below(self, stiffness: float) -> int:
        """Number of modes with 0 < B < stiffness."""

    def lowest(self, count: int) -> Modes:
        """(N,) ascending B and (V, N) modes."""

    def nearest(self, stiffness: float, count: int) -> Modes:
        """(N,) ascending B and (V, N) modes with B around a value."""


def plate_operator(
    laplacian: csc_array,
    mass: NDArray[np.float64],
    piece_of: NDArray[np.integer],
    rigidity: NDArray[np.float64],
    free: NDArray[np.int64],
) -> PlateOperator:
    """The operator on the free vertices, the others clamped to the limit law.

    Args:
        laplacian: (V, V) L.
        mass: (V,) the diagonal of M.
        piece_of: (V,) connected piece of each vertex.
        rigidity: (V,) D > 0.
        free: (F,) indices of the vertices that obey the equation of motion.
    """
    from scipy.sparse import csc_array, diags_array

    columns = csc_array(laplacian[:, free])
    inner = csc_array(columns[free])
    pieces = np.asarray(piece_of)[free]
    uniform = bool((rigidity == rigidity[0]).all())
    if uniform and columns.nnz == inner.nnz:
        return UniformPlate(Pencil(inner, mass[free], pieces, 1.0), float(rigidity[0]))
    clamped = np.ones(len(mass), dtype=bool)
    clamped[free] = False
    pieces = np.where(np.isin(pieces, np.asarray(piece_of)[clamped]), -1, pieces)
    bending = diags_array(np.sqrt(rigidity / mass)) @ columns
    matrix = csc_array(bending.T @ bending)
    return PaintedPlate(Pencil(matrix, mass[free], pieces, float(rigidity.mean())), bending)


@dataclass(frozen=True, eq=False)
class UniformPlate:
    """One rigidity everywhere, nothing clamped: K = k L M⁻¹ L has the modes of L, B = k μ².

    Attributes:
        pencil: L v = μ M v.
        rigidity: k.
    """

    pencil: Pencil
    rigidity: float

    @cached_property
    def _factors(self) -> dict[complex, Resolvent]:
        return {}

    def resolvent(self, beta: complex) -> Resolvent:
        """K - βM = k (L - sM) M⁻¹ (L + sM), s² = β/k: two solves with the sparser Laplacian."""
        s = complex(np.sqrt(complex(beta) / self.rigidity))
        if abs(s) < _LEAST_SHIFT:
            s = complex(_LEAST_SHIFT)
        below, above = self._solve(s), self._solve(-s)
        mass = self.pencil.mass[:, None]

        def apply(y: NDArray[Any]) -> NDArray[Any]:
            return above(mass * below(mass * y)) / self.rigidity

        return apply

    def _solve(self, shift: complex) -> Resolvent:
        """(L - shift·M)⁻¹, one factor for a shift and its conjugate."""
        upper = complex(shift.real, abs(shift.imag))
        if upper not in self._factors:
            self._factors[upper] = self.pencil.factor(upper)
        solve = self._factors[upper]
        if shift.imag >= 0:
            return solve
        return lambda b: np.conj(solve(np.conj(b)))

    def count_below(self, stiffness: float) -> int:
        """Number of modes with 0 < B < stiffness."""
        return self.pencil.count_below(float(np.sqrt(stiffness / self.rigidity)))

    def lowest(self, count: int) -> Modes:
        """(N,) ascending B and (V, N) modes."""
        values, vectors = self.pencil.lowest(count)
        return self.rigidity * values**2, vectors

    def nearest(self, stiffness: float, count: int) -> Modes:
        """(N,) ascending B and (V, N) modes with √B around that of a value."""
        values, vectors = self.pencil.nearest(float(np.sqrt(stiffness / self.rigidity)), count)
        return self.rigidity * values**2, vectors


@dataclass(frozen=True, eq=False)
class PaintedPlate:
    """A rigidity for each vertex, or clamped vertices: K itself, denser than L.

    Attributes:
        pencil: K v = B M v on the free vertices.
        bending: (V, F) G with K = GᵀG, to apply K without the rounding of the product.
    """

    pencil: Pencil
    bending: csc_array

    def resolvent(self, beta: complex) -> Resolvent:
        """y ↦ (K - βM)⁻¹ M y, refined by the residual."""
        least = _LEAST_SHIFT**2 * self.pencil.unit
        shift = complex(beta) if abs(beta) >= least else complex(least)
        upper = complex(shift.real, abs(shift.imag))
        factor = self.pencil.factor(upper)
        mass = self.pencil.mass[:, None]

        def apply(y: NDArray[Any]) -> NDArray[Any]:
            b = mass * (np.conj(y) if shift.imag < 0 else y)
            x = factor(b)
            for _ in range(2):
                x = x + factor(b - self.bending.T @ (self.bending @ x) + upper * (mass * x))
            return np.conj(x) if shift.imag < 0 else x

        return apply

    def count_below(self, stiffness: float) -> int:
        """Number of modes with 0 < B < stiffness."""
        return self.pencil.count_below(stiffness)

    def lowest(self, count: int) -> Modes:
        """(N,) ascending B and (V, N) modes."""
        return self.pencil.lowest(count)

    def nearest(self, stiffness: float, count: int) -> Modes:
        """(N,) ascending B and (V, N) modes with B around a value."""
        return self.pencil.nearest(stiffness, count)
