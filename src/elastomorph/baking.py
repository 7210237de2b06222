"""Store any path as Δ and bends: least squares on powers of t, with the error stated."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from elastomorph.bend_curve import BendCurve
from elastomorph.blas_threads import one_blas_thread
from elastomorph.errors import BakeError, MeshError
from elastomorph.mesh import Mesh
from elastomorph.morph import Morph

__all__ = ["bake"]

_MOST_BENDS = 15


# Many small products: threads of BLAS would wait for each other after every one.
@one_blas_thread()
def bake(
    path: Callable[[float], NDArray[np.float64]],
    neutral: Mesh,
    target: Mesh,
    *,
    tolerance: float = 1e-4,
    method: str = "baked",
) -> Morph:
    """The morph with the fewest bends whose path stays within a tolerance of a given one.

    The path less its straight part is fitted by t(1 - t)·q(t) on Chebyshev nodes, the degree of q
    raised until the error, measured between the nodes, is small enough; the fit is then written in
    the bend curves t^k - t.

    Args:
        path: Vertex positions (V, 3) for a time in [0, 1]; the vertices of neutral and target at
            the ends.
        neutral: The mesh at t = 0.
        target: The mesh at t = 1.
        tolerance: Largest distance allowed, as a fraction of ``neutral.diameter``.
        method: Name of the path, kept with the morph.

    Raises:
        MeshError: The path does not start at the neutral or does not end at the target.
        BakeError: The tolerance is not reached with 15 bends.
    """
    scale = neutral.diameter or 1.0
    delta = target.vertices - neutral.vertices
    for time, mesh in ((0.0, neutral), (1.0, target)):
        gap = float(np.linalg.norm(path(time) - mesh.vertices, axis=1).max()) / scale
        if gap > tolerance:
            raise MeshError(f"the path is {gap:.3g} of D away from its end at t = {time:g}")

    def bent(times: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.stack([path(float(t)) - neutral.vertices - t * delta for t in times])

    count = _MOST_BENDS + 2
    nodes = (1 - np.cos(np.pi * (np.arange(count) + 0.5) / count)) / 2
    # Between the nodes and close to the ends, where a polynomial fit is worst.
    checks = (1 - np.cos(np.pi * np.arange(1, 2 * count) / (2 * count))) / 2
    wanted, expected = bent(nodes), bent(checks)
    bends = np.zeros((0, *neutral.vertices.shape))
    error = _largest(expected) / scale
    best = error
    for degree in range(_MOST_BENDS):
        if error <= tolerance:
            break
        basis = _basis(nodes, degree)
        fit = np.linalg.lstsq(basis, wanted.reshape(count, -1), rcond=None)[0]
        bends = (_powers(degree).T @ fit).reshape(degree + 1, *neutral.vertices.shape)
        curves = np.stack([checks**k - checks for k in range(2, degree + 3)], axis=1)
        error = _largest(expected - np.tensordot(curves, bends, axes=1)) / scale
        best = min(best, error)
    if error > tolerance:
        raise BakeError(
            f"{_MOST_BENDS} bends leave an error of {best:.3g} of D, more than {tolerance:g}: "
            "allow a larger tolerance, or add in-betweens where the path turns sharply"
        )
    powers = tuple(BendCurve.power(k) for k in range(2, len(bends) + 2))
    return Morph(neutral, target, bends, powers, method=method, bake_error=error)


def _basis(times: NDArray[np.float64], degree: int) -> NDArray[np.float64]:
    """(T, degree + 1) values of t(1 - t)·T_j(2t - 1): well conditioned, zero at both ends."""
    return (times * (1 - times))[:, None] * chebyshev.chebvander(2 * times - 1, degree)


def _powers(degree: int) -> NDArray[np.float64]:
    """(degree + 1, degree + 1) coefficients of the basis functions in t^k - t, k = 2 … degree + 2.

    A polynomial without constant term that is zero at 1 has the same coefficients of t², t³, … in
    powers of t and in t^k - t.
    """
    rows = np.zeros((degree + 1, degree + 1))
    for j in range(degree + 1):
        in_t = np.polynomial.Chebyshev.basis(j, domain=[0, 1]).convert(
            kind=np.polynomial.Polynomial
        )
        coefficients = (np.polynomial.Polynomial([0.0, 1.0, -1.0]) * in_t).coef
        rows[j, : len(coefficients) - 2] = coefficients[2:]
    return rows


def _largest(offsets: NDArray[np.float64]) -> float:
    return float(np.sqrt(np.einsum("tvi,tvi->tv", offsets, offsets).max()))
