"""The beam of every curve (Eq. 3), step by step: ``finite-difference`` and ``finite-element``.

What both share: the force and the initial velocity of the closed form, and the average-acceleration
Newmark scheme in t (implicit, unconditionally stable, second order). The elastic operator is their
own, so each agrees with the closed form only as far as both are right.

``finite-difference`` is the paper's own alternative (Sec. 3: "numerical methods such as the finite
difference method are very effective", but heavy). The fourth difference in u, second order;
periodic on closed curves, mirrored at the ends of open ones, as cosine modes are. Ours, where the
source leaves it open: each curve is sampled between its vertices too, because a difference over
vertices alone is off by a factor of six for the wave that changes sign from vertex to vertex.

``finite-element`` is the textbook's (scikit-fem): cubic between vertices, with the value and the
slope of w at each as unknowns. In the weak form of Eq. 3,

    m ∫ ẅ v du + c ∫ ẇ v du + k ∫ w″ v″ du = ∫ f v du        for every cubic v

Fourth order in u at the vertices. Closed curves are periodic. Open ones have no slope at their
ends, half an interval beyond the last vertices, as cosine modes have it; that no force acts there
is natural to the weak form. Ours, where a textbook leaves it open: the force is that of the closed
form, as the cubic with its values and slopes. All elements of a curve are of one length, or the
force of the stiffest modes, ten thousand times that of the softest, would leak into them.
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
from elastomorph.errors import ParameterError
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.sequence import MeshSequence
from elastomorph.numbers import is_whole
from elastomorph.physics.beam import ModeTransform
from elastomorph.physics.equation import Load, Material
from elastomorph.physics.response import mean_response, modal_response
from elastomorph.rivals.rival import Faces, Rival


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


@dataclass(frozen=True)
class FiniteElement(SteppedBeams):
    """The beam of every curve, step by step, by Hermite elements.

    Attributes:
        points: Elements from each vertex of a curve to the next, an even number.
    """

    name = "finite-element"
    source = "Hermite beams, scikit-fem; Newmark 1959"
    package = "skfem"

    points: int = 2

    def __post_init__(self) -> None:
        # Otherwise no vertex of an open curve is a point, and half a point off is first order.
        if not is_whole(self.points) or self.points < 1 or self.points % 2 != 0:
            raise ParameterError(f"points must be an even number from 2, found {self.points!r}")

    def discrete(self, problem: CurveProblem) -> Discrete:
        """The problem with a value and a slope at each vertex, and between them."""
        return by_elements(problem, self.points)


def by_elements(problem: CurveProblem, points: int = 2) -> Discrete:
    """The problem with so many elements from each vertex to the next, an even number."""
    from scipy.sparse import eye_array

    count = len(problem.start)
    nodes = np.linspace(0.0, 1.0, points * count + 1)
    first = 0 if problem.closed else points // 2
    mass, stiffness, value_of, slope_of = _matrices(nodes)
    unknown = np.arange(2 * len(nodes))
    if problem.closed:  # the last node is the first
        unknown[[value_of[-1], slope_of[-1]]] = unknown[[value_of[0], slope_of[0]]]
    kept = np.unique(unknown)
    if not problem.closed:  # no slope at the ends
        kept = np.setdiff1d(kept, slope_of[[0, -1]])
    columns = np.searchsorted(kept, unknown)
    columns[~np.isin(unknown, kept)] = len(kept)
    chosen = eye_array(len(kept) + 1, format="csr")[columns][:, : len(kept)]
    mass, stiffness = chosen.T @ mass @ chosen, chosen.T @ stiffness @ chosen

    def unknowns(modes: NDArray[np.floating | np.complexfloating]) -> NDArray[np.float64]:
        every = np.empty((2 * len(nodes), modes.shape[1]))
        every[value_of], every[slope_of] = problem.series(modes, nodes)
        return every[kept]

    return Discrete(
        mass,
        problem.material.rigidity * stiffness,
        [mass @ unknowns(modes) for modes in problem.force()],
        unknowns(problem.transform.forward(problem.start)),
        unknowns(problem.initial_velocity()),
        columns[value_of[first : first + points * count : points]],
    )


def _matrices(nodes: NDArray[np.float64]) -> tuple[Any, Any, Any, Any]:
    """∫ w v and ∫ w″ v″ of cubics between nodes, and which unknowns are values and slopes."""
    from skfem import Basis, BilinearForm, ElementLineHermite, MeshLine
    from skfem.helpers import dd, ddot

    basis = Basis(MeshLine(nodes), ElementLineHermite())
    product = BilinearForm(lambda w, v, _: w * v)
    bending = BilinearForm(lambda w, v, _: ddot(dd(w), dd(v)))
    values, slopes = basis.nodal_dofs
    return product.assemble(basis), bending.assemble(basis), values, slopes
