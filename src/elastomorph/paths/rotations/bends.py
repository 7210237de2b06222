"""How far turning paths lie off the straight line: on arcs, of edges that turn, as polynomials.

All are written as the bend beside V₀ + tΔ, so they are zero at both ends, and where nothing turns,
to the last bit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import factorial

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from elastomorph.paths.bake import bend_basis, chebyshev_nodes

# Edges that are turned together, so that what is computed of them stays in the cache.
_BLOCK = 8192


@dataclass(frozen=True, eq=False)
class ArcBend:
    """The circular arcs with given chords and turning angles, less their chords.

    A turn by θ about a carries x₀ to x₁ = x₀ + d; with d = d∥ + d⊥ along and across a the path is

        x(t) = x₀ + t d∥ + sin(tθ/2)/sin(θ/2) · Rot(a, (t - 1)θ/2) d⊥,

    because (e^{itθ} - 1)/(e^{iθ} - 1) = sin(tθ/2)/sin(θ/2)·e^{i(t-1)θ/2} in the plane across a.
    Less the chord, with u = 2t - 1:

        x(t) - x₀ - t d = ½ (sin(uθ/2)/sin(θ/2) - u) d⊥ - sin(tθ/2) sin((1-t)θ/2)/sin(θ/2) a × d⊥

    Kept are (N,) θ/2, below π, (N, 3) d⊥ and a × d⊥.
    """

    half: NDArray[np.float64]
    across: NDArray[np.float64]
    turned: NDArray[np.float64]

    @classmethod
    def of(cls, chords: NDArray[np.float64], vectors: NDArray[np.float64]) -> ArcBend:
        """Of (N, 3) chords d and (N, 3) or (3,) rotation vectors θa, shorter than a full turn."""
        angle, axis = _split(np.broadcast_to(vectors, chords.shape))
        turned = np.cross(axis, chords)
        return cls(angle / 2.0, np.cross(turned, axis), turned)

    def at(self, t: float) -> NDArray[np.float64]:
        """(N, 3) offset from the chord."""
        whole = np.sinc(self.half / np.pi)
        u = 2.0 * t - 1.0
        along = 0.5 * u * (np.sinc(u * self.half / np.pi) / whole - 1.0)
        bulge = np.sinc(t * self.half / np.pi) * np.sinc((1.0 - t) * self.half / np.pi)
        bulge *= -t * (1.0 - t) * self.half / whole
        return along[:, None] * self.across + bulge[:, None] * self.turned


@dataclass(frozen=True, eq=False)
class EdgeBend:
    """Edges that turn steadily while they are stretched, less their straight way.

    Where the neighbourhood is deformed by F = R·S, the edge e₀ with e₁ = F e₀ takes the path
    exp(t log R)((1 - t)I + tS) e₀ (Alexa, Cohen-Or and Levin, SIGGRAPH 2000), which is

        e(t) = (1 - t) Rot(tθ) e₀ + t Rot((t - 1)θ) e₁

    and so needs the rotation only, not S; it ends at e₁ whatever the rotation.

    Kept are (N,) θ, (N, 3) e₀ and e₁ across a, a × e₀ and a × e₁.
    """

    angle: NDArray[np.float64]
    start: NDArray[np.float64]
    end: NDArray[np.float64]
    start_turned: NDArray[np.float64]
    end_turned: NDArray[np.float64]

    @classmethod
    def of(
        cls, starts: NDArray[np.float64], ends: NDArray[np.float64], vectors: NDArray[np.float64]
    ) -> EdgeBend:
        """Of (N, 3) edges at both ends and their (N, 3) or (3,) rotation vectors θa."""
        angle, axis = _split(np.broadcast_to(vectors, starts.shape))
        start_turned, end_turned = np.cross(axis, starts), np.cross(axis, ends)
        start, end = np.cross(start_turned, axis), np.cross(end_turned, axis)
        return cls(angle, start, end, start_turned, end_turned)

    def at(self, t: float) -> NDArray[np.float64]:
        """(N, 3) offset of each edge from (1 - t) e₀ + t e₁."""
        bend = np.empty_like(self.start)
        for first in range(0, len(bend), _BLOCK):
            some = slice(first, first + _BLOCK)
            forth, back = t * self.angle[some, None], (1.0 - t) * self.angle[some, None]
            own = (1.0 - t) * (np.cos(forth) - 1.0) * self.start[some]
            own += (1.0 - t) * np.sin(forth) * self.start_turned[some]
            own += t * (np.cos(back) - 1.0) * self.end[some]
            own -= t * np.sin(back) * self.end_turned[some]
            bend[some] = own
        return bend

    def missed(self, starts: NDArray[np.float64], ends: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) where the turn alone would carry each edge, less where it ends."""
        angle = self.angle[:, None]
        turned = (np.cos(angle) - 1.0) * self.start + np.sin(angle) * self.start_turned
        return np.asarray(starts + turned - ends)


def _split(vectors: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Angles and unit axes (zeros where nothing turns)."""
    angle = np.linalg.norm(vectors, axis=-1)
    return angle, vectors / np.where(angle > 0, angle, 1.0)[..., None]


# The interpolation error of a turning unit vector; a bake keeps 1e-4 of D.
_ACCURACY = 1e-9


@dataclass(frozen=True, eq=False)
class PolynomialBend:
    """t(1 - t)·q(t) with a polynomial q in Chebyshev form: zero at both ends, as every bend is.

    (N, M, 3) coefficients of T_j(2t - 1) in q are those of the vertices that (V,) `bent` names.
    """

    coefficients: NDArray[np.float64]
    bent: NDArray[np.bool_]

    def at(self, t: float) -> NDArray[np.float64]:
        """(V, 3) offset from the straight line."""
        basis = bend_basis(np.array([t]), len(self.coefficients) - 1)[0]
        offsets = np.zeros((len(self.bent), 3))
        offsets[self.bent] = np.tensordot(basis, self.coefficients, axes=1)
        return offsets


def at_nodes(bend: Callable[[float], NDArray[np.float64]], count: int) -> NDArray[np.float64]:
    """(count, M, 3) Chebyshev coefficients of q, from as many moments of (M, 3) t(1 - t)·q(t)."""
    nodes = chebyshev_nodes(count)
    values = np.stack([bend(float(t)) / (t * (1.0 - t)) for t in nodes])
    basis = chebyshev.chebvander(2.0 * nodes - 1.0, count - 1)
    return np.tensordot(np.linalg.inv(basis), values, axes=1)


def moments_needed(angle: float) -> int:
    """How many nodes follow a turn by an angle (radians) to 1e-9.

    Interpolation of e^{iθt} by degree n is off by about 2(θ/4)^{n+1}/(n+1)!.
    """
    count = 2
    while 2.0 * (angle / 4.0) ** count / factorial(count) > _ACCURACY:
        count += 1
    # t(1 - t) takes two degrees, and the stretch multiplies the turn by one more.
    return count + 1
