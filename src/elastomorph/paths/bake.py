"""Store any path as Δ and bends: least squares on powers of t, with the error stated."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial import Chebyshev, Polynomial, chebyshev
from numpy.typing import NDArray

from elastomorph.blas_threads import one_blas_thread
from elastomorph.errors import BakeError, MeshError, ParameterError
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh, require_same_topology
from elastomorph.model.morph import Morph
from elastomorph.numbers import as_number


def chebyshev_nodes(count: int) -> NDArray[np.float64]:
    """(count,) times at which a polynomial of that many coefficients is sampled."""
    return np.asarray((1 - np.cos(np.pi * (np.arange(count) + 0.5) / count)) / 2)


_MOST_BENDS = 15
_COUNT = _MOST_BENDS + 2
_NODES = chebyshev_nodes(_COUNT)
# Between the nodes and close to the ends, where a polynomial fit is worst.
_CHECKS = (1 - np.cos(np.pi * np.arange(1, 2 * _COUNT) / (2 * _COUNT))) / 2
# Vertices whose errors are compared at once.
_BLOCK = 8192


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
        TopologyError: Neutral and target differ in vertices or polygons.
        ParameterError: The path is no function, or gives something else than positions.
        BakeError: The tolerance is not reached with 15 bends.
    """
    require_same_topology(neutral, target)
    if not callable(path):
        raise ParameterError(
            f"the path must be a function from a time to positions, found {type(path).__name__}"
        )
    tolerance = as_number(tolerance, "tolerance", above=0)
    scale = neutral.diameter or 1.0
    delta = target.vertices - neutral.vertices
    for time, mesh in ((0.0, neutral), (1.0, target)):
        end = np.asarray(path(time))
        if end.shape != mesh.vertices.shape or end.dtype.kind not in "iuf":
            raise ParameterError(
                f"the path must give positions of shape {mesh.vertices.shape}, found {end.dtype} "
                f"{end.shape} at t = {time:g}"
            )
        gap = float(np.linalg.norm(end - mesh.vertices, axis=1).max()) / scale
        if gap > tolerance:
            raise MeshError(f"the path is {gap:.3g} of D away from its end at t = {time:g}")
    times = np.concatenate([_NODES, _CHECKS])
    bent = np.empty((len(times), *delta.shape))
    for time, row in zip(times, bent, strict=True):
        row[:] = path(float(time)) - neutral.vertices - time * delta
    each = np.eye(len(times))
    bends, error = _fewest_bends(bent, each[:_COUNT], each[_COUNT:], scale, tolerance)
    return _stored(bends, error, neutral, target, method)


def bake_polynomial(
    coefficients: NDArray[np.float64],
    bent: NDArray[np.bool_],
    neutral: Mesh,
    target: Mesh,
    *,
    tolerance: float,
    method: str,
) -> Morph:
    """`bake` for (N, M, 3) coefficients in `bend_basis` of the M vertices in (V,) `bent`."""
    degree = len(coefficients) - 1
    at_nodes, at_checks = bend_basis(_NODES, degree), bend_basis(_CHECKS, degree)
    found, error = _fewest_bends(
        coefficients, at_nodes, at_checks, neutral.diameter or 1.0, tolerance
    )
    bends = np.zeros((len(found), *neutral.vertices.shape))
    bends[:, bent] = found
    return _stored(bends, error, neutral, target, method)


def bend_basis(times: NDArray[np.float64], degree: int) -> NDArray[np.float64]:
    """(T, degree + 1) values of t(1 - t)·T_j(2t - 1): well conditioned, zero at both ends."""
    return (times * (1 - times))[:, None] * chebyshev.chebvander(2 * times - 1, degree)


def _stored(
    bends: NDArray[np.float64], error: float, neutral: Mesh, target: Mesh, method: str
) -> Morph:
    powers = tuple(BendCurve.power(k) for k in range(2, len(bends) + 2))
    return Morph(neutral, target, bends, powers, method=method, bake_error=error)


def _fewest_bends(
    values: NDArray[np.float64],
    at_nodes: NDArray[np.float64],
    at_checks: NDArray[np.float64],
    scale: float,
    tolerance: float,
) -> tuple[NDArray[np.float64], float]:
    """The fewest bends on t², t³, … and what they leave, as a fraction of D.

    (R, M, 3) values times (17, R) `at_nodes` are the bend at the nodes, times (33, R) `at_checks`
    that at the times at which errors are measured.
    """
    lengths = np.linalg.norm(values, axis=2)
    best = np.inf
    for count in range(_MOST_BENDS + 1):
        weights = np.zeros((0, len(values)))
        if count:
            fit = np.linalg.lstsq(bend_basis(_NODES, count - 1), at_nodes, rcond=None)[0]
            weights = _powers(count - 1).T @ fit
        curves = np.stack([_CHECKS**k - _CHECKS for k in range(1, count + 2)], axis=1)[:, 1:]
        error = largest_sum(at_checks - curves @ weights, values, lengths) / scale
        if error <= tolerance:
            return np.tensordot(weights, values, axes=1), error
        best = min(best, error)
    raise BakeError(
        f"{_MOST_BENDS} bends leave an error of {best:.3g} of D, more than {tolerance:g}: "
        "allow a larger tolerance, or add in-betweens where the path turns sharply"
    )


def _powers(degree: int) -> NDArray[np.float64]:
    """(degree + 1, degree + 1) coefficients of the basis functions in t^k - t, k = 2 … degree + 2.

    A polynomial without constant term that is zero at 1 has the same coefficients of t², t³, … in
    powers of t and in t^k - t.
    """
    rows = np.zeros((degree + 1, degree + 1))
    for j in range(degree + 1):
        in_t = Chebyshev.basis(j, domain=[0, 1]).convert(kind=Polynomial)
        coefficients = (Polynomial([0.0, 1.0, -1.0]) * in_t).coef
        rows[j, : len(coefficients) - 2] = coefficients[2:]
    return rows


def largest_sum(
    rows: NDArray[np.float64], values: NDArray[np.float64], lengths: NDArray[np.float64]
) -> float:
    """The longest of (T, R) rows · (R, M, 3) values; only vertices that can have it are tried."""
    bound = np.abs(rows).max(axis=0) @ lengths
    most = 0.0
    candidates = np.argsort(-bound)[:64]
    while candidates.size:
        for start in range(0, len(candidates), _BLOCK):
            some = values[:, candidates[start : start + _BLOCK]]
            offsets = (rows @ some.reshape(len(some), -1)).reshape(len(rows), -1, 3)
            most = max(most, float(np.sqrt(np.einsum("tvi,tvi->tv", offsets, offsets).max())))
        left = bound > most
        bound[candidates] = 0.0
        candidates = np.flatnonzero(left & (bound > most))
    return most
