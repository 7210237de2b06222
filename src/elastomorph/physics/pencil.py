"""A symmetric sparse eigenproblem A v = λ M v: shifted solves, counts and the lowest modes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.model.cholesky import symmetric_factor

if TYPE_CHECKING:
    from scipy.sparse import csc_array

Solve = Callable[[NDArray[Any]], NDArray[Any]]
Modes = tuple[NDArray[np.float64], NDArray[np.float64]]

# Below this many rows, all modes at once by a dense solver are cheaper than a few by iteration.
_DENSE = 600
# Modes found around one shift; Lanczos slows down with the square of it.
_SLICE = 64
# How often modes that iteration missed are looked for; of many alike, it may miss some again.
_TRIES = 8


@dataclass(frozen=True, eq=False)
class Pencil:
    """A positive semi-definite and M diagonal, with a kernel of constants on known pieces.

    Attributes:
        matrix: (V, V) A.
        mass: (V,) the diagonal of M, above 0.
        piece_of: (V,) number of the piece on which constants are in the kernel, -1 for none.
        unit: An eigenvalue of the size of the lowest ones, above 0.
    """

    matrix: csc_array
    mass: NDArray[np.float64]
    piece_of: NDArray[np.integer]
    unit: float

    @cached_property
    def kernel_size(self) -> int:
        """Number of pieces whose constants are in the kernel."""
        return int(np.unique(self.piece_of[self.piece_of >= 0]).size)

    @property
    def mode_count(self) -> int:
        """Number of modes with λ > 0."""
        return len(self.mass) - self.kernel_size

    def mean(self, values: NDArray[Any]) -> NDArray[Any]:
        """(V, …) the mean of (V, …) values over each piece, 0 where there is none."""
        weights, divisor = self._averaging
        flat = values.reshape(len(values), -1)
        means = (weights @ flat) / divisor[:, None]
        return np.asarray(weights.T @ means / self.mass[:, None]).reshape(values.shape)

    def factor(self, shift: complex) -> Solve:
        """A function that solves (A - shift·M) x = b for (V, …) b, real or complex."""
        factor = self._decompose(shift)
        is_complex = complex(shift).imag != 0

        def solve(b: NDArray[Any]) -> NDArray[Any]:
            if is_complex:
                return np.asarray(factor.solve(b.astype(np.complex128)))
            if np.iscomplexobj(b):
                return np.asarray(
                    factor.solve(np.ascontiguousarray(b.real))
                    + 1j * factor.solve(np.ascontiguousarray(b.imag))
                )
            return np.asarray(factor.solve(np.ascontiguousarray(b)))

        return solve

    def count_below(self, value: float) -> int:
        """Number of modes with 0 < λ < value, by Sylvester's law of inertia.

        A - value·M has as many negative pivots as there are eigenvalues below.
        """
        factor = self._decompose(value)
        # Rounding may lift the kernel of a stiff operator above a small value.
        return max(int(np.count_nonzero(factor.U.diagonal() < 0)) - self.kernel_size, 0)

    def nearest(self, value: float, count: int) -> Modes:
        """(N,) ascending λ nearest to a value that is none, and (V, N) modes with v^T M v = 1."""
        if len(self.mass) <= _DENSE or 3 * count >= len(self.mass):
            values, vectors = self._dense
            order = np.sort(np.argsort(np.abs(values - value), kind="stable")[:count])
            return values[order], vectors[:, order]
        from scipy.sparse import diags_array
        from scipy.sparse.linalg import LinearOperator, eigsh

        solve, shape = self.factor(value), self.matrix.shape

        def project(b: NDArray[Any]) -> NDArray[Any]:
            x = solve(b)
            return np.asarray(x - self.mean(x))

        start = np.random.default_rng(0).standard_normal(len(self.mass))
        values, vectors = eigsh(
            self.matrix,
            k=count,
            M=diags_array(self.mass, format="csc"),
            sigma=value,
            OPinv=LinearOperator(shape, matvec=project, dtype=np.float64),
            v0=start - self.mean(start),
            ncv=min(max(2 * count + 10, 30), len(self.mass) - 1),
        )
        order = np.argsort(values)
        return values[order], vectors[:, order]

    def lowest(self, count: int) -> Modes:
        """(N,) ascending λ > 0, at most `count`, and (V, N) modes with V^T M V = 1.

        Found slice by slice of the spectrum, each checked against the number of modes that
        Sylvester's law says it has.
        """
        count = min(count, self.mode_count)
        if len(self.mass) <= _DENSE or count == 0:
            return self.nearest(-self.unit, count)
        values, vectors, edge = self._lowest_slice(min(count, _SLICE))
        all_values, all_vectors = [values], [vectors]
        found = len(values)
        while found < count:
            upper, inside = self._next_edge(edge, found)
            if inside <= 0:
                raise _miscounted(upper, found + inside, found + 1)
            values, vectors = self._slice(edge, upper, inside)
            all_values.append(values)
            all_vectors.append(vectors)
            found, edge = found + inside, upper
        values, vectors = np.concatenate(all_values), np.concatenate(all_vectors, axis=1)
        if len(all_values) > 1:
            root = np.sqrt(self.mass)[:, None]
            vectors = np.linalg.qr(vectors * root)[0] / root
        return values[:count], vectors[:, :count]

    def _lowest_slice(self, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
        """The first modes, none of them missed, and a value just above them."""
        asked = count
        for _ in range(_TRIES):
            values, vectors = self.nearest(-self.unit, asked)
            edge = float(values[-1]) * (1 + 1e-9)
            missed = self.count_below(edge) - len(values)
            if missed <= 0:
                return values, vectors, edge
            asked += missed
            if asked > self.mode_count:
                break
        raise _miscounted(edge, len(values) + missed, len(values))

    def _next_edge(self, edge: float, below: int) -> tuple[float, int]:
        """The upper end of the slice that starts at an edge, and the modes it has."""
        width = edge * 0.5 * _SLICE / max(below, _SLICE)
        for _ in range(60):
            inside = self.count_below(edge + width) - below
            if inside > _SLICE:
                width *= 0.7
            elif inside < _SLICE // 4 and below + inside < self.mode_count:
                width *= 1.8
            else:
                break
        return edge + width, inside

    def _slice(self, lower: float, upper: float, inside: int) -> Modes:
        """The modes between two values, as many as there are."""
        asked = inside + 4
        for _ in range(_TRIES):
            values, vectors = self.nearest(0.5 * (lower + upper), min(asked, self.mode_count))
            within = (values >= lower) & (values < upper)
            if np.count_nonzero(within) >= inside:
                return values[within], vectors[:, within]
            asked *= 2
        raise _miscounted(upper, inside, int(np.count_nonzero(within)), above=lower)

    @cached_property
    def _dense(self) -> Modes:
        from scipy.linalg import eigh

        root = np.sqrt(self.mass)
        values, vectors = eigh(self.matrix.toarray() / np.outer(root, root))
        kernel = self.kernel_size
        return values[kernel:], vectors[:, kernel:] / root[:, None]

    @cached_property
    def _averaging(self) -> tuple[csc_array, NDArray[np.float64]]:
        """(C, V) mass of each vertex in its piece, and (C,) the mass of the pieces."""
        from scipy.sparse import csc_array

        within = np.flatnonzero(self.piece_of >= 0)
        numbers = np.unique(self.piece_of[within], return_inverse=True)[1].ravel()
        shape = (self.kernel_size, len(self.mass))
        weights = csc_array((self.mass[within], (numbers, within)), shape=shape)
        return weights, np.asarray(weights.sum(axis=1)).ravel()

    def _decompose(self, shift: complex) -> Any:
        from scipy.sparse import csc_array, diags_array

        number = complex(shift)
        sigma = number if number.imag else number.real
        shifted = csc_array(self.matrix - diags_array(sigma * self.mass))
        try:
            return symmetric_factor(shifted)
        except RuntimeError:
            raise ParameterError(
                f"the operator of the surface is singular at {sigma:g}: it is an eigenvalue"
            ) from None


def _miscounted(below: float, counted: int, found: int, above: float = 0.0) -> ParameterError:
    return ParameterError(
        f"the modes of the surface cannot be computed: {counted:,} were counted between {above:g} "
        f"and {below:g}, {found:,} found; look for polygons without an area with 'elastomorph "
        "doctor', or move the face on beams"
    )
