"""Slider weights that bring points of a face to positions: dragging a face.

After Lewis and Anjyo, Direct Manipulation Blendshapes (2010), on bent paths: the pose is that of
`Rig.pose` at the handles only, with the derivatives of bend curves and of the products that drive
correctives, and within bounds. Sliders that the handles do not need stay where they were.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.blas_threads import one_blas_thread
from elastomorph.errors import ParameterError
from elastomorph.numbers import as_number, as_numbers
from elastomorph.rig.handles import Handle, HandledPoints, Place, asked
from elastomorph.rig.nearest import Box, nearest
from elastomorph.rig.sliders import Sliders, Weights

if TYPE_CHECKING:
    from elastomorph.rig.rig import Rig

Floats = NDArray[np.float64]

Bounds = tuple[float, float] | Mapping[str, tuple[float, float]]
"""Least and greatest weight of every slider, or of some by name; the others have 0 and 1."""

PRIOR = 1e-8
# A first search at a strong prior settles which sliders move; without it a weak one creeps along
# the faces that reach the handles.
_FIRST_PRIOR = 1e-4
# The ridge is this part of the prior, yet never so little that weights are not determined.
_RIDGE, _LEAST_RIDGE = 1e-3, 1e-12
# A handle that is nearer than this part of the farthest a slider moves one has been reached.
_REACHED = 1e-3


@dataclass(frozen=True)
class Solved:
    """Weights that bring handles as near to their positions as the sliders can.

    Attributes:
        weights: Of each slider, for `Rig.pose`.
        distances: How far each handle is left from its position, in the unit of the vertices.
        within: A handle no farther than this has reached its position: a thousandth of the
            farthest that one slider moves one of them.
    """

    weights: Mapping[str, float]
    distances: Mapping[Handle, float]
    within: float

    @property
    def reached(self) -> bool:
        """Whether every handle has reached its position."""
        return all(distance <= self.within for distance in self.distances.values())

    def __str__(self) -> str:
        moved = ", ".join(f"{n} {w:.2f}" for n, w in self.weights.items() if round(w, 2))
        count = len(self.distances)
        left = {h: d for h, d in self.distances.items() if d > self.within}
        said = f"{count - len(left)} of {count} handles reached"
        if left:
            worst = max(left, key=lambda handle: left[handle])
            said += f", {worst!r} left {left[worst]:.3g} away"
        return f"{said}; {moved or 'every slider at 0'}"


def solve(
    rig: Rig,
    handles: Mapping[Handle, ArrayLike],
    weights: Weights | None,
    bounds: Bounds,
    prior: float,
    landmarks: Mapping[str, Place] | None,
) -> Solved:
    """The weights that `Rig.solve` finds."""
    mix, goals = asked(handles, landmarks, len(rig.neutral.vertices))
    low, high = limits(rig.sliders, bounds)
    at = np.zeros(len(low)) if weights is None else rig.sliders.row(weights)
    strength = as_number(prior, "the prior", least=0)
    start = np.clip(at, low, high)
    with one_blas_thread():
        points = HandledPoints.of(rig, mix)
        search = _Search(goals, points.reach or 1.0, Box(low, high, start, strength, 0.0, _REACHED))
        found, left = search.on(points, start)
        if (left > search.within).any() and points.stall(start):
            # Nothing leads away from there: straight paths say which sliders are needed.
            straight = search.on(points.straight, start)[0]
            other, nearer = search.on(points, np.clip(points.paced(straight), low, high))
            if nearer @ nearer < left @ left:
                found, left = other, nearer
    return Solved(
        dict(zip(rig.names, found.tolist(), strict=True)),
        dict(zip(handles, left.tolist(), strict=True)),
        search.within,
    )


class _Search(NamedTuple):
    """The search for (H, 3) positions of points in a box, at no less than its prior."""

    goals: Floats
    scale: float  # Of residuals: the farthest that one slider moves one of them
    box: Box

    @property
    def within(self) -> float:
        """The distance at which a goal is reached."""
        return _REACHED * self.scale

    def on(self, points: HandledPoints, row: Floats) -> tuple[Floats, Floats]:
        """The (sliders,) weights found from some on, and (H,) distances left."""

        def residuals(row: Floats) -> tuple[Floats, Floats, Floats]:
            moving = points.at(row)
            left = (moving.positions - self.goals).ravel() / self.scale
            return left, moving.rates / self.scale, moving.curved(left) / self.scale

        prior = self.box.prior
        for cost in sorted({max(prior, _FIRST_PRIOR), prior}, reverse=True):
            ridge = max(_RIDGE * cost, _LEAST_RIDGE)
            row = nearest(residuals, self.box._replace(prior=cost, ridge=ridge), row)
        return row, np.linalg.norm(points.at(row).positions - self.goals, axis=1)


def limits(sliders: Sliders, bounds: Bounds) -> tuple[Floats, Floats]:
    """(sliders,) least and greatest weights."""
    both = np.tile([0.0, 1.0], (len(sliders.names), 1))
    if isinstance(bounds, Mapping):
        for name, pair in bounds.items():
            sliders.require(name, sliders.names)
            both[sliders.names.index(name)] = _pair(pair, f"the bounds of {name!r}")
    else:
        both[:] = _pair(bounds, "bounds")
    return both[:, 0].copy(), both[:, 1].copy()


def _pair(bounds: ArrayLike, what: str) -> Floats:
    pair = as_numbers(bounds, what)
    if pair.shape != (2,) or not pair[0] <= pair[1] or not np.isfinite(pair).all():
        raise ParameterError(
            f"{what} must be two finite numbers, the least and the greatest, found {bounds!r}"
        )
    return pair
