"""Eq. 3 for one curve between two shapes, in closed form and step by step.

What finite differences and finite elements share: the force and the initial velocity of the
closed form, and the average-acceleration Newmark scheme in t (implicit, unconditionally stable,
second order). The elastic operator is their own, so each agrees with the closed form only as far as
both are right.
"""

from __future__ import annotations

from abc import abstractmethod
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.sequence import MeshSequence
from elastomorph.physics.beam import ModeTransform
from elastomorph.physics.equation import Load, Material
from elastomorph.physics.response import mean_response, modal_response
from elastomorph.rivals.rival import Faces, Rival

__all__ = ["CurveProblem", "Discrete", "Motion", "SteppedBeams", "newmark"]


@dataclass(frozen=True, eq=False)
class CurveProblem:
    """Curves of one kind and size between known shapes: Eqs. 3-5 with their closed-form solution.

    Attributes:
        start: (M, C) coordinates at t = 0, one column for each of x, y, z of each curve.
        end: (M, C) coordinates at t = 1.
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
        """(T, M, C) the closed-form solution (Eqs. 31-33 and any other load)."""
        values = polynomial.polyval(times, self.laws().T)
        return self.start + self.transform.inverse(values.T[..., None] * self._delta)

    def initial_velocity(self) -> NDArray[np.floating | np.complexfloating]:
        """(N, C) modes of ẇ at t = 0 of the closed-form solution."""
        return np.asarray(self.laws()[:, 1, None] * self._delta)

    def force(self) -> list[NDArray[np.floating | np.complexfloating]]:
        """Modes (N, C) of the coefficients of 1, t, …, t^K of the external force f(u, t)."""
        m, c = self.material.mass, self.material.damping
        laws = self.laws()
        stiffness = self.transform.stiffness(self.material.rigidity)
        rows = stiffness[:, None] * laws
        velocity = polynomial.polyder(laws, axis=1)
        acceleration = polynomial.polyder(laws, m=2, axis=1)
        rows[:, : velocity.shape[1]] += c * velocity
        rows[:, : acceleration.shape[1]] += m * acceleration
        force = [row[:, None] * self._delta for row in rows.T]
        force[0] = force[0] + stiffness[:, None] * self.transform.forward(self.start)
        return force

    def series(
        self, modes: NDArray[np.floating | np.complexfloating], u: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(U, C) values and slopes at any u of the series with these modes."""
        size, numbers = len(self.start), np.arange(self.transform.count)
        if not self.closed:
            # The cosines of an orthonormal transform.
            weights = np.sqrt(np.where(numbers > 0, 2.0, 1.0) / size)
            scaled = weights.reshape(-1, 1) * modes.real
            phase = np.pi * numbers * u[:, None]
            return np.cos(phase) @ scaled, -(np.pi * numbers * np.sin(phase)) @ scaled
        # Each harmonic stands for itself and its conjugate, but the mean and the last of an even
        # number of vertices, which are their own.
        twice = np.where((numbers > 0) & (2 * numbers < size), 2.0, 1.0).reshape(-1, 1)
        waves = np.exp(2j * np.pi * numbers * u[:, None])
        scaled = modes * twice / size
        return (waves @ scaled).real, ((2j * np.pi * numbers * waves) @ scaled).real

    @property
    def _delta(self) -> NDArray[np.floating | np.complexfloating]:
        return self.transform.forward(self.end - self.start)


@dataclass(frozen=True, eq=False)
class Discrete:
    """A curve problem with finitely many unknowns: mass ẍ + damping ẋ + elastic x = force."""

    mass: Any  # (N, N) sparse, of unit density
    elastic: Any  # (N, N) sparse, rigidity included
    force: list[NDArray[np.float64]]  # (N, C) coefficients of 1, t, …, t^K
    start: NDArray[np.float64]  # (N, C) unknowns at t = 0
    velocity: NDArray[np.float64]  # (N, C) their velocity at t = 0
    shown: NDArray[np.int64]  # (M,) which unknowns are the coordinates of vertices


@dataclass(frozen=True, eq=False)
class Motion:
    """Coordinates and velocities of the vertices at one time."""

    place: NDArray[np.float64]  # (M, C)
    velocity: NDArray[np.float64]  # (M, C)


def newmark(discrete: Discrete, material: Material, steps: int) -> Iterator[Motion]:
    """The vertices at 0, 1/steps, …, 1, by the average-acceleration scheme."""
    from scipy.sparse import csc_array
    from scipy.sparse.linalg import splu

    m, c = material.mass, material.damping
    step = 1.0 / steps
    mass, elastic, shown = discrete.mass, discrete.elastic, discrete.shown
    factor = splu(csc_array(elastic + (4 * m / step**2 + 2 * c / step) * mass))
    place, velocity = discrete.start, discrete.velocity
    at_rest = discrete.force[0] - elastic @ place
    acceleration = (splu(csc_array(mass)).solve(at_rest) - c * velocity) / m
    yield Motion(place[shown], velocity[shown])
    for number in range(1, steps + 1):
        powers = (number * step) ** np.arange(len(discrete.force))
        applied = np.tensordot(powers, np.stack(discrete.force), axes=1)
        inertia = m * (4 / step**2 * place + 4 / step * velocity + acceleration)
        known = applied + mass @ (inertia + c * (2 / step * place + velocity))
        new_place = factor.solve(known)
        new_velocity = 2 / step * (new_place - place) - velocity
        acceleration = 2 / step * (new_velocity - velocity) - acceleration
        place, velocity = new_place, new_velocity
        yield Motion(place[shown], velocity[shown])


@dataclass(frozen=True)
class SteppedBeams(Rival):
    """Every curve a beam, step by step from the neutral to the target.

    Each curve's displacement is solved for, so the neutral is met exactly. Curves of one kind and
    size are solved together. A vertex on no curve follows the limit law p(t)/p(1).

    Attributes:
        order: R of the load t^R.
        steps: Time steps from the neutral to the target; between them places and velocities have
            cubics.
        material: m, c, k.
        closure: Time law of the mean of a curve.
    """

    order: int = 2
    steps: int = 100
    material: Material = field(default_factory=Material)
    closure: str = "limit"

    @property
    def limit_law(self) -> BendCurve:
        """That of a perfectly stiff beam."""
        return BendCurve.power(self.order)

    @abstractmethod
    def discrete(self, problem: CurveProblem) -> Discrete:
        """A problem with finitely many unknowns."""

    def faces(
        self, recording: MeshSequence, curves: CurveNetwork, times: NDArray[np.float64]
    ) -> Faces:
        """The face at each time."""
        start, end = recording.frames
        load = Load.power(self.order)
        alike: dict[tuple[bool, int], list[NDArray[np.int64]]] = defaultdict(list)
        for curve in curves:
            alike[curve.closed, len(curve)].append(np.asarray(curve.vertices, dtype=np.int64))
        groups, motions = [], []
        for (closed, size), members in alike.items():
            vertices = np.stack(members, axis=1)
            delta = (end - start)[vertices].reshape(size, -1)
            still = np.zeros_like(delta)
            problem = CurveProblem(still, delta, closed, self.material, load, self.closure)
            groups.append(vertices)
            motions.append(newmark(self.discrete(problem), self.material, self.steps))
        loose = curves.curve_of < 0
        before = after = [next(motion) for motion in motions]
        done = 0
        for time in times:
            while done < self.steps and (done == 0 or time > done / self.steps):
                before, after, done = after, [next(motion) for motion in motions], done + 1
            face = start.copy()
            face[loose] += time**self.order * (end - start)[loose]
            part = float(time) * self.steps - (done - 1)
            for vertices, first, last in zip(groups, before, after, strict=True):
                places = _cubic(first, last, part, 1.0 / self.steps)
                face[vertices] += places.reshape(*vertices.shape, 3)
            yield face


def _cubic(first: Motion, last: Motion, part: float, step: float) -> NDArray[np.float64]:
    """(M, C) the cubic with the places and velocities of both ends of a step."""
    rise = last.place - first.place
    swing = step * ((1 - part) * first.velocity - part * last.velocity) - (1 - 2 * part) * rise
    return np.asarray(first.place + part * rise + part * (1 - part) * swing)
