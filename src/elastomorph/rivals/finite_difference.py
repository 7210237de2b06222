"""``finite-difference``: the beam of every curve, by finite differences and implicit steps.

The paper's own alternative (Sec. 3: "numerical methods such as the finite difference method are
very effective", but heavy). The fourth difference in u, second order; periodic on closed curves,
mirrored at the ends of open ones, as cosine modes are; Newmark steps in t, second order.

Ours, where the source leaves it open: the force is that of the closed form, and each curve is
sampled between its vertices too, because a difference over vertices alone is off by a factor of
six for the wave that changes sign from vertex to vertex.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.numbers import is_whole
from elastomorph.rivals.curve_problem import CurveProblem, Discrete, SteppedBeams, newmark


@dataclass(frozen=True)
class FiniteDifference(SteppedBeams):
    """The beam of every curve, step by step, by finite differences.

    Attributes:
        points: Samples for each vertex of a curve, an odd number.
    """

    name = "finite-difference"
    source = "the paper, Sec. 3; Newmark 1959"

    points: int = 5

    def __post_init__(self) -> None:
        # Otherwise no vertex of an open curve is a point, and half a point off is first order.
        if not is_whole(self.points) or self.points < 1 or self.points % 2 != 1:
            raise ParameterError(f"points must be an odd number from 1, found {self.points!r}")

    def discrete(self, problem: CurveProblem) -> Discrete:
        """The problem with so many points for each vertex."""
        return by_differences(problem, self.points)


def integrate(problem: CurveProblem, steps: int) -> NDArray[np.float64]:
    """(steps + 1, M, C) the curve after each of equal time steps from t = 0 to t = 1."""
    motions = newmark(by_differences(problem), problem.material, steps)
    return np.stack([motion.place for motion in motions])


def by_differences(problem: CurveProblem, points: int = 1) -> Discrete:
    """The problem with so many points for each vertex, an odd number."""
    from scipy.sparse import eye_array

    size = points * len(problem.start)
    places = (np.arange(size) + (0.0 if problem.closed else 0.5)) / size
    first = 0 if problem.closed else points // 2
    elastic = _fourth_difference(size, problem.closed) * problem.material.rigidity

    def values(modes: NDArray[np.floating | np.complexfloating]) -> NDArray[np.float64]:
        return problem.series(modes, places)[0]

    return Discrete(
        eye_array(size, format="csc"),
        elastic,
        [values(modes) for modes in problem.force()],
        values(problem.transform.forward(problem.start)),
        values(problem.initial_velocity()),
        np.arange(first, size, points),
    )


def _fourth_difference(size: int, closed: bool) -> Any:
    """∂⁴/∂u⁴ to second order, periodic or with the half-sample mirrored ends of cosine modes."""
    from scipy.sparse import csc_array

    here = np.arange(size)
    before, after = (here - 1) % size, (here + 1) % size
    if not closed:
        before[0], after[-1] = 0, size - 1
    rows = np.concatenate([here, here, here])
    columns = np.concatenate([before, here, after])
    values = np.repeat([1.0, -2.0, 1.0], size)
    laplacian = csc_array((values, (rows, columns)), shape=(size, size)) * float(size) ** 2
    return laplacian @ laplacian
