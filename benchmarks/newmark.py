"""Eq. 3 integrated numerically: the proof of the closed form, and its numerical competitor.

Finite differences in u, the average-acceleration Newmark scheme (implicit, unconditionally stable,
second order) in t. The force and the initial velocity are those of the analytical solution, the
elastic operator is not: it is the discrete fourth difference, so the two solutions agree only as
far as both are right.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray
from scipy.sparse import csc_array, eye_array
from scipy.sparse.linalg import splu

from elastomorph.physics.beam import ModeTransform
from elastomorph.physics.equation import Load, Material
from elastomorph.physics.response import mean_response, modal_response

__all__ = ["CurveProblem", "integrate"]


@dataclass(frozen=True, eq=False)
class CurveProblem:
    """One curve between two known shapes: Eqs. 3-5 with their closed-form solution.

    Attributes:
        start: (M, 3) curve at t = 0.
        end: (M, 3) curve at t = 1.
        closed: Whether the last vertex is joined to the first.
        material: m, c, k.
        load: p(t).
        closure: Time law of mode 0.
    """

    start: NDArray[np.float64]
    end: NDArray[np.float64]
    closed: bool
    material: Material
    load: Load
    closure: str = "limit"

    @property
    def transform(self) -> ModeTransform:
        """The modes of the curve."""
        return ModeTransform(len(self.start), self.closed)

    def laws(self) -> NDArray[np.float64]:
        """(N, K + 1) coefficients of 1, t, …, t^K of each mode's time law."""
        count, order = self.transform.count, self.load.order
        laws = np.zeros((count, order + 2))
        laws[0, 1:] = mean_response(self.closure, self.load, self.material)
        stiffness = self.transform.stiffness(self.material.rigidity)[1:]
        laws[1:, 1 : order + 1] = modal_response(stiffness, self.load, self.material)
        return laws

    def solution(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """(T, M, 3) the closed-form solution (Eqs. 31-33 and any other load)."""
        delta = self.transform.forward(self.end - self.start)
        values = polynomial.polyval(times, self.laws().T)
        return self.start + self.transform.inverse(values.T[..., None] * delta)

    def initial_velocity(self) -> NDArray[np.float64]:
        """(M, 3) ẇ at t = 0 of the closed-form solution."""
        delta = self.transform.forward(self.end - self.start)
        return self.transform.inverse(self.laws()[:, 1, None] * delta)

    def force(self) -> NDArray[np.float64]:
        """(K + 1, M, 3) coefficients of 1, t, …, t^K of the external force f(u, t)."""
        m, c = self.material.mass, self.material.damping
        laws = self.laws()
        stiffness = self.transform.stiffness(self.material.rigidity)
        rows = stiffness[:, None] * laws
        velocity = polynomial.polyder(laws, axis=1)
        acceleration = polynomial.polyder(laws, m=2, axis=1)
        rows[:, : velocity.shape[1]] += c * velocity
        rows[:, : acceleration.shape[1]] += m * acceleration
        delta = self.transform.forward(self.end - self.start)
        rest = self.transform.forward(self.start)
        force = np.stack([self.transform.inverse(row[:, None] * delta) for row in rows.T])
        force[0] += self.transform.inverse(stiffness[:, None] * rest)
        return force


def integrate(problem: CurveProblem, steps: int) -> NDArray[np.float64]:
    """Integrate the equation of motion from t = 0 to t = 1.

    Args:
        problem: The curve, its material and its load.
        steps: Number of equal time steps, at least 1.

    Returns:
        (steps + 1, M, 3) the curve after each step.
    """
    m, c = problem.material.mass, problem.material.damping
    size = len(problem.start)
    step = 1.0 / steps
    elastic = _fourth_difference(size, problem.closed) * problem.material.rigidity
    force = problem.force()
    factor = splu(
        csc_array(elastic + (4 * m / step**2 + 2 * c / step) * eye_array(size, format="csc"))
    )

    path = np.empty((steps + 1, size, 3))
    path[0] = problem.start
    velocity = problem.initial_velocity()
    acceleration = (force[0] - c * velocity - elastic @ path[0]) / m
    for number in range(1, steps + 1):
        applied = np.tensordot((number * step) ** np.arange(len(force)), force, axes=1)
        known = (
            applied
            + m * (4 / step**2 * path[number - 1] + 4 / step * velocity + acceleration)
            + c * (2 / step * path[number - 1] + velocity)
        )
        path[number] = factor.solve(known)
        previous_velocity = velocity
        velocity = 2 / step * (path[number] - path[number - 1]) - velocity
        acceleration = 2 / step * (velocity - previous_velocity) - acceleration
    return path


def _fourth_difference(size: int, closed: bool) -> csc_array:
    """∂⁴/∂u⁴ to second order, periodic or with the half-sample mirrored ends of cosine modes."""
    here = np.arange(size)
    before, after = (here - 1) % size, (here + 1) % size
    if not closed:
        before[0], after[-1] = 0, size - 1
    rows = np.concatenate([here, here, here])
    columns = np.concatenate([before, here, after])
    values = np.repeat([1.0, -2.0, 1.0], size)
    laplacian = csc_array((values, (rows, columns)), shape=(size, size)) * float(size) ** 2
    return csc_array(laplacian @ laplacian)
