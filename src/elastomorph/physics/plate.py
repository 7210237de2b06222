"""The plate: a whole surface obeys the equation of motion of the paper, instead of its curves.

    m ẅ + c ẇ + k ∇⁴w = e₀ + e₁ p(t),    w(0) = w₀,  w(1) = w₁

with ∇² the Laplace-Beltrami operator of the neutral. In the modes L v = μ M v of the surface it is
Eq. 3 with B = k μ², so each mode follows the law φ of `modal_response`, and the mean of each
connected piece follows a closure. Loads up to t⁶ need no modes: `rational_laws` turns the sum over
all of them into sparse solves, such as one with K - 2cM for R = 2. Other loads are expanded in the
lowest modes; what these do not span follows the limit law p(t)/p(1). `Pencil` is the symmetric
sparse eigenproblem: its shifted solves, its counts and its lowest modes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.model.cholesky import symmetric_factor
from elastomorph.physics.equation import Load, Material
from elastomorph.physics.response import (
    allowed_excursion,
    excursion,
    guard_laws,
    mean_and_limit,
    modal_response,
    rational_laws,
)

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


# Up to this order all modes at once cost R - 1 pairs of solves and lose no digit that shows.
_SOLVED_ORDER = 6
_USUAL_MODES = 64
# Rigidities that differ by more than this leave too few digits of the softer parts.
_CONTRAST = 1e6
_GUARDED_MODES = 48

Correction = Callable[[NDArray[np.float64]], NDArray[np.float64]]


@dataclass(frozen=True, eq=False)
class PlateModes:
    """The time law of every mode of a surface.

    Attributes:
        operator: K on the free vertices.
        free: (F,) indices of the vertices that obey the equation of motion; the others follow the
            limit law.
        correction: From (F, 3) displacements without means to the (R, F, 3) coefficients of
            t … t^R by which their motion differs from the limit law; nothing where it does not.
        mean_law: (K,) coefficients of t … t^K of the mean of each connected piece.
        limit_law: (K,) coefficients of p(t)/p(1).
    """

    operator: PlateOperator
    free: NDArray[np.int64]
    correction: Correction | None
    mean_law: NDArray[np.float64]
    limit_law: NDArray[np.float64]

    @classmethod
    def prepare(
        cls,
        laplacian: csc_array,
        mass: NDArray[np.float64],
        piece_of: NDArray[np.integer],
        material: Material,
        load: Load,
        *,
        closure: str = "limit",
        rigidity: NDArray[np.float64] | None = None,
        pinned: NDArray[np.bool_] | None = None,
        harmonics: int | None = None,
    ) -> PlateModes:
        """Factor the operators of a surface for a material and a load.

        Args:
            laplacian: (V, V) L, symmetric positive semi-definite, constants on each piece its
                kernel; scaled so that the whole surface has area 1.
            mass: (V,) diagonal of M, above 0, with sum 1.
            piece_of: (V,) connected piece of each vertex.
            material: m, c, k.
            load: p(t).
            closure: Time law of the mean of each piece, see `mean_response`.
            rigidity: (V,) factors of k, above 0 and within a ratio of a million; 1 by default.
            pinned: (V,) vertices that follow the limit law exactly. Their pull on the others is
                then of the form e₀ + e₁p, absorbed by the force. A piece with one has no mode 0.
            harmonics: Modes above this number, counted over the whole surface from the softest,
                follow the limit law; by default all are solved up to order 6, and 64 beyond.
        """
        mean, limit = mean_and_limit(closure, load, material)
        moving = laplacian.diagonal() > 0
        free = np.flatnonzero(moving if pinned is None else moving & ~np.asarray(pinned, bool))
        stiff = material.rigidity * _factors(rigidity, len(mass))
        operator = plate_operator(laplacian, mass, piece_of, stiff, free)
        _guard(operator, closure, load, material)

        every = harmonics is None or harmonics >= operator.pencil.mode_count
        correction: Correction | None
        if load.order == 1 or not len(free):
            correction = None
        elif every and load.order <= _SOLVED_ORDER:
            correction = _solved(operator, load, material)
        else:
            count = harmonics if harmonics is not None else _USUAL_MODES
            correction = _modal(operator, count, load, material)
        return cls(operator, free, correction, mean, limit)

    def bends(self, delta: NDArray[np.float64]) -> NDArray[np.float64]:
        """(K - 1, V, 3) bends of one (V, 3) displacement field, as of `BeamModes.bends`."""
        bends = np.multiply.outer(self.limit_law[1:], delta)
        if len(bends) and len(self.free):
            pencil = self.operator.pencil
            own = delta[self.free]
            means = pencil.mean(own)
            coefficients = self.correction(own - means)[1:] if self.correction else ()
            for bend, law in zip(bends, (self.mean_law - self.limit_law)[1:], strict=True):
                bend[self.free] += law * means
            for bend, coefficient in zip(bends, coefficients, strict=False):
                # The means of a solution are rounding, and the softest thing there is.
                bend[self.free] += coefficient - pencil.mean(coefficient)
        return bends


def _factors(rigidity: NDArray[np.float64] | None, count: int) -> NDArray[np.float64]:
    if rigidity is None:
        return np.ones(count)
    factors = np.asarray(rigidity, dtype=np.float64)
    if factors.shape != (count,):
        raise ParameterError(
            f"rigidity must be one number or one for each of {count:,} vertices, found shape "
            f"{factors.shape}"
        )
    wrong = ~(np.isfinite(factors) & (factors > 0))
    if wrong.any():
        first = int(wrong.argmax())
        raise ParameterError(
            f"rigidity must be finite and above 0, found {factors[first]:g} at vertex {first}"
        )
    if factors.max() > _CONTRAST * factors.min():
        raise ParameterError(
            f"rigidity must stay within a ratio of {_CONTRAST:g}, found {factors.min():g} to "
            f"{factors.max():g}"
        )
    return factors


def _solved(operator: PlateOperator, load: Load, material: Material) -> Correction:
    """Every mode at once, by one resolvent for each root of the denominator of φ."""
    roots, weights_of = rational_laws(load, material)
    resolvents = [operator.resolvent(root) for root in roots]

    def correct(rest: NDArray[np.float64]) -> NDArray[np.float64]:
        total = np.zeros((load.order, *rest.shape))
        state: NDArray[Any] = rest
        for root, resolvent, weights in zip(roots, resolvents, weights_of.T, strict=True):
            state = resolvent(state)
            if root.imag <= 0:  # real, or the second of a conjugate pair
                state = state.real
            total += np.multiply.outer(weights, state).real
        return total

    return correct


def _modal(operator: PlateOperator, count: int, load: Load, material: Material) -> Correction:
    """The lowest modes one by one."""
    stiffness, modes = operator.lowest(count)
    laws = modal_response(stiffness, load, material) - load.limit_law
    weighted = operator.pencil.mass[:, None] * modes

    def correct(rest: NDArray[np.float64]) -> NDArray[np.float64]:
        amplitudes = weighted.T @ rest
        return np.stack([modes @ (law[:, None] * amplitudes) for law in laws.T])

    return correct


def _guard(operator: PlateOperator, closure: str, load: Load, material: Material) -> None:
    """Refuse resonances, with no more modes than the laws can be ill behaved for."""
    grid = np.geomspace(1e-6, 1e12, 1500) * (material.damping + material.mass)
    bad = excursion(modal_response(grid, load, material)) > allowed_excursion(load)
    modes = np.zeros(0)
    bound = float(grid[0])
    if bad.any() and operator.pencil.mode_count:
        bound = float(grid[min(int(np.flatnonzero(bad)[-1]) + 1, grid.size - 1)])
        count = operator.count_below(bound)
        if 0 < count <= _GUARDED_MODES:
            modes = operator.lowest(count)[0]
        elif count:
            modes = _around_roots(operator, load, material)
    # Whatever lies above is taken as dense, so that no damping is called safe for modes unseen.
    above = max(bound, float(modes[-1]) * (1 + 1e-9) if modes.size else 0.0)
    guard_laws(
        [("surface", np.concatenate([modes, above * np.geomspace(1.0, 1e9, 120)]))],
        closure,
        load,
        material,
    )


def _around_roots(operator: PlateOperator, load: Load, material: Material) -> NDArray[np.float64]:
    """B of the modes nearest to where φ is singular, after stand-ins for the softer ones."""
    found = []
    for root in rational_laws(load, material)[0]:
        near = max(root.real, 0.05 * abs(root))
        found.append(operator.nearest(near * (1 + 1e-9), 12)[0])
    nearest = np.unique(np.concatenate(found))
    softer = operator.count_below(nearest[0] * (1 - 1e-9))
    softest = min(operator.lowest(1)[0][0], nearest[0])
    # Spread over the range they lie in, they keep the numbers right, and no damping is called safe
    # that would make one of them resonant.
    return np.concatenate([np.geomspace(softest, nearest[0], softer, endpoint=False), nearest])


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
