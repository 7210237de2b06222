"""``finite-element``: the beam of every curve, by Hermite elements and implicit steps.

Elastic beams as they are textbook finite elements (scikit-fem): cubic between vertices, with the
value and the slope of w at each as unknowns. In the weak form of Eq. 3,

    m ∫ ẅ v du + c ∫ ẇ v du + k ∫ w″ v″ du = ∫ f v du        for every cubic v

Fourth order in u at the vertices; Newmark steps in t, second order. Closed curves are periodic.
Open ones have no slope at their ends, half an interval beyond the last vertices, as cosine modes
have it; that no force acts there is natural to the weak form.

Ours, where a textbook leaves it open: the force is that of the closed form, as the cubic with its
values and slopes. All elements of a curve are of one length, or the force of the stiffest modes,
ten thousand times that of the softest, would leak into them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.numbers import is_whole
from elastomorph.rivals.curve_problem import CurveProblem, Discrete, SteppedBeams


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
