"""A path through scanned in-betweens: any number of shapes, each reached at its own time.

One bend for each in-between Y_i at t_i, D_i = Y_i - V₀ - t_i·Δ, driven by a cardinal curve b_i:
1 at t_i and 0 at the time of every other shape. With natural cubic splines the path

    V(t) = V₀ + t·Δ + Σ_i b_i(t)·D_i

is the natural cubic spline of every vertex through all shapes, the curve of least ∫ ‖V″‖² dt:
splines are linear in what they pass through, and the spline through a straight line is that line.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.bend_curve import BendCurve
from elastomorph.errors import MeshError, ParameterError
from elastomorph.mesh import Mesh, require_same_topology
from elastomorph.morph import Morph

__all__ = ["SPLINES", "cardinal_curves", "inner_curvatures", "through"]

SPLINES = ("spline", "linear")

# Shapes closer in time than this are one shape twice.
_SAME_TIME = 1e-9
# A bend below this part of the largest coordinate is rounding of the straight path.
_NOISE = 8 * float(np.finfo(np.float64).eps)


def through(
    neutral: Mesh,
    target: Mesh,
    inbetweens: Mapping[float, Mesh],
    *,
    method: str = "spline",
) -> Morph:
    """The path from a neutral to a target through shapes at given times.

    Every in-between is reached to rounding, both ends to the last bit. Bend i belongs to the
    in-between of the i-th smallest time. Without in-betweens the path is the straight line.

    Args:
        neutral: The mesh at t = 0.
        target: The mesh at t = 1.
        inbetweens: Meshes of the same topology by their times, each within (0, 1).
        method: ``spline``: natural cubic splines, smooth in velocity and acceleration. ``linear``:
            straight from shape to shape, as in-betweens of rigs are today.

    Returns:
        A morph with one bend for each in-between.

    Raises:
        TopologyError: A mesh has other vertices or polygons than the neutral.
        ParameterError: A time is not within (0, 1) or comes twice (within 1e-9), or the method is
            unknown.
        MeshError: An in-between is not a Mesh.
    """
    if method not in SPLINES:
        raise ParameterError(f"method must be one of {', '.join(SPLINES)}, found {method!r}")
    require_same_topology(neutral, target)
    shapes = _in_order(inbetweens)
    for time, mesh in shapes:
        if not isinstance(mesh, Mesh):
            raise MeshError(
                f"the in-between at t = {time:g} must be a Mesh, found {type(mesh).__name__}"
            )
        require_same_topology(neutral, mesh)
    straight = Morph(neutral, target, np.zeros((0, *neutral.vertices.shape)), ())
    bends = np.empty((len(shapes), *neutral.vertices.shape))
    for bend, (time, mesh) in zip(bends, shapes, strict=True):
        np.subtract(mesh.vertices, straight.at(time), out=bend)
        bend[np.abs(bend).max(axis=1) <= _NOISE * np.abs(mesh.vertices).max()] = 0.0
    curves = cardinal_curves([time for time, _ in shapes], method)
    return Morph(neutral, target, bends, curves, method=_label(shapes, method))


def cardinal_curves(times: Sequence[float], method: str = "spline") -> tuple[BendCurve, ...]:
    """The bend curves b_i with b_i(t_j) = 1 where i = j, else 0, and b_i(0) = b_i(1) = 0.

    Args:
        times: n rising times within (0, 1).
        method: ``spline`` or ``linear``, see `through`.

    Returns:
        n curves, each with pieces between the times.

    Raises:
        ParameterError: The times do not rise from above 0 to below 1.
    """
    breaks = np.concatenate([[0.0], np.asarray(times, dtype=np.float64), [1.0]])
    gaps = np.diff(breaks)
    if not (gaps > 0).all():
        raise ParameterError("the times of in-betweens must rise, from above 0 to below 1")
    count = len(breaks) - 2
    values = np.zeros((count, count + 2))
    values[:, 1:-1] = np.eye(count)
    second = np.zeros_like(values)
    if method == "spline":
        second[:, 1:-1] = inner_curvatures(breaks).T
    start, end = second[:, :-1], second[:, 1:]
    coefficients = np.stack(
        [
            values[:, :-1],
            np.diff(values) / gaps - gaps * (2.0 * start + end) / 6.0,
            start / 2.0,
            (end - start) / (6.0 * gaps),
        ],
        axis=2,
    )
    kept = coefficients if method == "spline" else coefficients[:, :, :2]
    return tuple(BendCurve(breaks, rows) for rows in kept)


def inner_curvatures(breaks: ArrayLike) -> NDArray[np.float64]:
    """What turns the values of a natural cubic spline into its second derivatives.

    The second derivatives M are zero at both ends and continuous between the pieces:

        h_{i-1} M_{i-1} + 2(h_{i-1} + h_i) M_i + h_i M_{i+1}
            = 6 ((y_{i+1} - y_i)/h_i - (y_i - y_{i-1})/h_{i-1})

    Args:
        breaks: (…, n + 2) rising times; the values at the first and the last are zero.

    Returns:
        (…, n, n) matrices; times the n values between the ends they give the n second derivatives.
    """
    gaps = np.diff(np.asarray(breaks, dtype=np.float64))
    before, after = gaps[..., :-1], gaps[..., 1:]
    count = before.shape[-1]
    here = np.arange(count)
    bending: NDArray[np.float64] = np.zeros((*before.shape, count))
    jumps: NDArray[np.float64] = np.zeros_like(bending)
    bending[..., here, here] = 2.0 * (before + after)
    jumps[..., here, here] = -6.0 / before - 6.0 / after
    inner = after[..., :-1]
    for row, column in ((here[:-1], here[1:]), (here[1:], here[:-1])):
        bending[..., row, column] = inner
        jumps[..., row, column] = 6.0 / inner
    return np.asarray(np.linalg.solve(bending, jumps), dtype=np.float64)


def _in_order(inbetweens: Mapping[float, Mesh]) -> list[tuple[float, Mesh]]:
    """The shapes by rising time."""
    if not isinstance(inbetweens, Mapping):
        raise ParameterError(
            f"in-betweens are a mapping from times to meshes, found {type(inbetweens).__name__}"
        )
    found: list[tuple[float, Mesh]] = []
    for time, mesh in inbetweens.items():
        try:
            number = float(time)
        except (TypeError, ValueError):
            raise ParameterError(
                f"the time of an in-between must be a number, found {time!r}"
            ) from None
        if not _SAME_TIME < number < 1.0 - _SAME_TIME:
            raise ParameterError(
                f"the time of an in-between must be between 0 (the neutral) and 1 (the target), "
                f"found {number:g}"
            )
        found.append((number, mesh))
    found.sort(key=lambda shape: shape[0])
    for (earlier, _), (later, _) in pairwise(found):
        if later - earlier <= _SAME_TIME:
            raise ParameterError(f"two in-betweens are at t = {later:g}; keep one of them")
    return found


def _label(shapes: Sequence[tuple[float, Mesh]], method: str) -> str:
    if not shapes:
        return "linear"
    when = ",".join(f"{time:.3g}" for time, _ in shapes)
    return f"through {when}" if method == "spline" else f"through {when} {method}"
