"""A path through scanned in-betweens: any number of shapes, each reached at its own time.

One bend for each in-between Y_i at t_i, D_i = Y_i - V₀ - t_i·Δ, driven by a cardinal curve b_i:
1 at t_i and 0 at the time of every other shape,

    V(t) = V₀ + t·Δ + Σ_i b_i(t)·D_i

Three laws say how b_i rises and falls between the times of its neighbours. With the hat
h_i(t) = min((t - t_{i-1})/(t_i - t_{i-1}), (t_{i+1} - t)/(t_{i+1} - t_i)), cut off below 0:

- ``piecewise``: b_i = h_i, straight from shape to shape.
- ``smooth``: b_i = h_i²(3 - 2h_i). No speed jumps, and no weight leaves [0, 1].
- ``spline``: natural cubic splines, the path of least ∫ ‖V″‖² dt through all shapes: splines are
  linear in what they pass through, and the spline through a straight line is that line. One near
  an end swings: a single in-between at t = 0.1 gets weights up to 2.34.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

import elastomorph.paths.options as options
from elastomorph.curves import CurveNetwork
from elastomorph.errors import ParameterError, warn
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh, require_mesh, require_same_topology
from elastomorph.model.morph import Morph
from elastomorph.paths.method import Method, Prepared

LAWS = ("smooth", "spline", "piecewise")

# What `piecewise` was called before it had company.
_OLD_NAMES = {"linear": "piecewise"}

# Shapes closer in time than this are one shape twice.
_SAME_TIME = 1e-9
# Where a weight exceeds this, the path goes farther than the in-between it belongs to.
OVERSHOOT = 1.2
# A bend below this part of the largest coordinate is rounding of the straight path.
_NOISE = 8 * float(np.finfo(np.float64).eps)


@dataclass(frozen=True)
class Through(Method):
    """A path through shapes at given times, each reached to rounding, both ends to the last bit.

    Attributes:
        inbetweens: Meshes of the same topology by their times, each within (0, 1).
        law: How the path runs between them, one of `LAWS`; ``smooth`` by default through one
            in-between and ``spline`` through more.
    """

    name = "through"
    path = "through shapes on the way"

    inbetweens: Mapping[float, Mesh] = field(hash=False)
    law: str | None = options.option(
        None,
        "text",
        "smooth, spline, or piecewise from shape to shape",
        '"spline"',
        lambda value, _: None if value is None else law_for(value, 0),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "inbetweens", dict(_in_order(self.inbetweens)))

    @property
    def label(self) -> str:
        """``through``, the times, and the law where it is not the usual one."""
        if not self.inbetweens:
            return "linear"
        label = f"through {','.join(f'{time:.3g}' for time in self.inbetweens)}"
        usual = law_for(None, len(self.inbetweens))
        return label if self.law in (None, usual) else f"{label} {self.law}"

    def prepare(self, neutral: Mesh, curves: CurveNetwork | None = None) -> Prepared:
        """A function from target to path, with one bend for each in-between."""
        for time, mesh in self.inbetweens.items():
            require_mesh(mesh, f"the in-between at t = {time:g}")
            require_same_topology(neutral, mesh)
        times = tuple(self.inbetweens)
        laws = cardinal_curves(times, law_for(self.law, len(times)))

        def to(target: Mesh) -> Morph:
            straight = Morph(neutral, target, np.zeros((0, *neutral.vertices.shape)), ())
            bends = np.empty((len(times), *neutral.vertices.shape))
            for bend, curve, (time, mesh) in zip(bends, laws, self.inbetweens.items(), strict=True):
                np.subtract(mesh.vertices, straight.at(time), out=bend)
                bend[np.abs(bend).max(axis=1) <= _NOISE * np.abs(mesh.vertices).max()] = 0.0
                if bend.any():
                    _warn_of_overshoot(time, curve)
            return Morph(neutral, target, bends, laws, method=self.label)

        return to


def through(
    neutral: Mesh,
    target: Mesh,
    inbetweens: Mapping[float, Mesh],
    *,
    method: str | None = None,
) -> Morph:
    """The path from a neutral to a target through shapes at given times.

    Every in-between is reached to rounding, both ends to the last bit. Bend i belongs to the
    in-between of the i-th smallest time. Without in-betweens the path is the straight line.

    Args:
        neutral: The mesh at t = 0.
        target: The mesh at t = 1.
        inbetweens: Meshes of the same topology by their times, each within (0, 1).
        method: The law between the shapes. ``smooth``: smooth in velocity, weights within [0, 1].
            ``spline``: natural cubic splines, smooth in acceleration too. ``piecewise``: straight
            from shape to shape, as in-betweens of rigs are today; ``linear`` is the same. By
            default ``smooth`` through one in-between and ``spline`` through more.

    Returns:
        A morph with one bend for each in-between.

    Raises:
        TopologyError: A mesh has other vertices or polygons than the neutral.
        ParameterError: A time is not within (0, 1) or comes twice (within 1e-9), or the method is
            unknown.
        MeshError: An in-between is not a Mesh.

    Warns:
        ElastomorphWarning: A weight exceeds 1.2, so that the path goes farther than the in-between.
    """
    require_same_topology(neutral, target)
    return Through(inbetweens, method).prepare(neutral)(target)


def law_for(method: str | None, count: int) -> str:
    """The law between shapes that a text asks for, ``linear`` too; by default that of their number.

    The spline through a single shape swings; two and more stop each other from swinging, and no
    acceleration jumps.
    """
    if method is None:
        return "smooth" if count == 1 else "spline"
    law = _OLD_NAMES.get(method, method)
    if law not in LAWS:
        raise ParameterError(f"method must be one of {', '.join(LAWS)}, found {method!r}")
    return law


def cardinal_curves(times: Sequence[float], law: str = "spline") -> tuple[BendCurve, ...]:
    """The bend curves b_i with b_i(t_j) = 1 where i = j, else 0, and b_i(0) = b_i(1) = 0."""
    breaks = np.concatenate([[0.0], np.asarray(times, dtype=np.float64), [1.0]])
    gaps = np.diff(breaks)
    if not (gaps > 0).all():
        raise ParameterError("the times of in-betweens must rise, from above 0 to below 1")
    count = len(breaks) - 2
    values = np.zeros((count, count + 2))
    values[:, 1:-1] = np.eye(count)
    rises = np.diff(values)
    pieces = [values[:, :-1], rises / gaps]
    if law == "smooth":
        still = np.zeros_like(rises)
        pieces = [values[:, :-1], still, 3.0 * rises / gaps**2, -2.0 * rises / gaps**3]
    elif law == "spline":
        second = np.zeros_like(values)
        second[:, 1:-1] = inner_curvatures(breaks).T
        start, end = second[:, :-1], second[:, 1:]
        pieces[1] = pieces[1] - gaps * (2.0 * start + end) / 6.0
        pieces += [start / 2.0, (end - start) / (6.0 * gaps)]
    return tuple(BendCurve(breaks, rows) for rows in np.stack(pieces, axis=2))


def inner_curvatures(breaks: ArrayLike) -> NDArray[np.float64]:
    """What turns the values of a natural cubic spline into its second derivatives.

    The second derivatives M are zero at both ends and continuous between the pieces:

        h_{i-1} M_{i-1} + 2(h_{i-1} + h_i) M_i + h_i M_{i+1}
            = 6 ((y_{i+1} - y_i)/h_i - (y_i - y_{i-1})/h_{i-1})

    (…, n, n) matrices from (…, n + 2) rising times; times the n values between the ends, which are
    zero themselves, they give the n second derivatives.
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


def _warn_of_overshoot(time: float, curve: BendCurve) -> None:
    when, weight = curve.peak
    if abs(weight) > OVERSHOOT:
        warn(
            f"the path overshoots: at t = {when:.3g} the in-between at t = {time:g} has the "
            f"weight {weight:.2f}; with method='smooth' none leaves the range from 0 to 1"
        )
