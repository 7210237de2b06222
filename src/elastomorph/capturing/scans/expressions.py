"""A rig's own expressions as the start of a pose: what a face does is known before it is scanned.

Weights 0 ≤ x ≤ 1.5 of the targets Δ_k are found by least squares of what lies across the scan,

    Σ_i w_i (n_i · (p_i + Σ_k x_k Δ_ki − q_i))² + Σ landmarks + ρ ‖x‖² + σ Σ_k x_k,

with points q, normals n and weights w found anew at each step. Unlike the surface alone, targets
know how the skin moves along itself.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry import robust
from elastomorph.capturing.scans.correspondence import ScanPoints
from elastomorph.capturing.scans.nonrigid import Elastic, Held

Points = NDArray[np.float64]

# Reach of the points in parts of the extent, and steps at each.
_REACHES = ((0.05, 5), (0.028, 5), (0.014, 8))
# Vertices by which expressions are fitted.
_ENOUGH, _FEW = 3000, 600
# Of a landmark beside a vertex; of the squares of all weights beside what the largest target does;
# and how much a weight is made smaller for its own sake: few expressions are likelier than many.
_LANDMARK, _RIDGE, _SPARSE = 25.0, 1e-4, 0.005
# Weights of a single target that are tried first, and how near a vertex is that it then explains.
_TRIED, _EXPLAINED = (0.3, 0.6, 1.0), 0.02
# A weight is no larger: what is so far beyond a target is another expression.
_MOST = 1.5
# Reach of landmarks, in parts of the extent.
_AGREES = 0.03
# Turns of averaging among neighbours, so that what is turned stays smooth.
_SMOOTHING = 10


@dataclass(frozen=True, eq=False)
class Fit:
    """A face fitted to a scan.

    Attributes:
        weights: target → its weight.
        sure: of landmarks beside the surface, from 0 to 1.
    """

    weights: dict[str, float]
    sure: float


@dataclass(frozen=True, eq=False)
class Expressions:
    """Targets of a rig on a face.

    Attributes:
        names: K of them.
        deltas: (K, V, 3) from the neutral.
    """

    names: tuple[str, ...]
    deltas: Points

    def transferred(self, goal: Points, elastic: Elastic) -> Expressions:
        """The targets on another face with the same vertices, turned and scaled as it is locally.

        Args:
            goal: (V, 3) the other neutral.
            elastic: the rig's own neutral at rest.
        """
        rest, deformation = elastic.rest, elastic.deformation
        first, second = deformation.edges.T
        before = ((rest[first] - rest[second]) ** 2).sum(axis=1)
        after = ((goal[first] - goal[second]) ** 2).sum(axis=1)
        lengths = np.zeros((len(rest), 2))
        for ends in (first, second):
            np.add.at(lengths, ends, np.stack([before, after], axis=1))
        for _ in range(_SMOOTHING):
            lengths = lengths + deformation.neighbours @ lengths
        scale = np.sqrt(lengths[:, 1] / np.maximum(lengths[:, 0], 1e-300))
        turns = scale[:, None, None] * deformation.rotations(goal, _SMOOTHING)
        return Expressions(self.names, np.einsum("nij,knj->kni", turns, self.deltas))

    def fitted(
        self,
        neutral: Points,
        elastic: Elastic,
        scan: ScanPoints,
        held: Held,
        before: Mapping[str, float],
        shown: NDArray[np.bool_] | None = None,
    ) -> Fit:
        """The weight of each target, from 0 to 1.5, at which the face is nearest to a scan.

        Args:
            neutral: (V, 3) the person's.
            elastic: of the person.
            scan: in the place and size of the template.
            held: landmarks.
            before: weights of the pose before, which may explain most of this one.
            shown: (V,) which vertices a scan may show; all of the skin unless given.
        """
        size, names = elastic.size, self.names
        moved = np.abs(self.deltas).max(axis=(0, 2)) > 1e-4 * size
        asked = np.flatnonzero(elastic.outer & moved & (True if shown is None else shown))
        asked = asked[:: max(1, len(asked) // _ENOUGH)]
        weights, sure = np.zeros(len(names)), 1.0
        if not len(asked):
            return Fit(dict(zip(names, weights.tolist(), strict=True)), sure)
        own, marks = self.deltas[:, asked], self.deltas[:, held.vertices].transpose(1, 2, 0)
        known = np.array([before.get(name, 0.0) for name in names])
        few = asked[:: max(1, len(asked) // _FEW)]
        weights = self._begun(neutral, elastic, scan, few, known)
        for reach, steps in _REACHES:
            for _ in range(steps):
                face = self.posed(neutral, weights)
                found = scan.matches(face[asked], elastic.normals(face)[asked], turn=reach * size)
                trust = found.weights(reach * size)
                across = np.einsum("kni,ni->nk", own, found.normals)
                off = np.einsum("ni,ni->n", found.points - neutral[asked], found.normals)
                missed = held.places - face[held.vertices]
                if reach == _REACHES[-1][0]:
                    left = off - across @ weights
                    sure = held.sure(float(np.sqrt(trust @ left**2 / trust.sum())), missed)
                pull = sure * _LANDMARK * robust(np.linalg.norm(missed, axis=1), _AGREES * size)
                goal = held.places - neutral[held.vertices]
                square = (across.T * trust) @ across
                square += np.einsum("nik,n,nil->kl", marks, pull, marks)
                right = across.T @ (trust * off) + np.einsum("nik,n,ni->k", marks, pull, goal)
                own_part = np.diagonal(square)
                weights = _bounded(
                    square + _RIDGE * own_part.max() * np.eye(len(own)),
                    right - _SPARSE * np.sqrt(own_part * own_part.max()),
                )
        return Fit(dict(zip(names, weights.tolist(), strict=True)), sure)

    def _begun(
        self,
        neutral: Points,
        elastic: Elastic,
        scan: ScanPoints,
        asked: NDArray[np.int64],
        before: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """What explains most of a scan, one target or the pose before: open lips begin so."""
        none = np.zeros(len(self.names))
        single = [x * one for one in np.eye(len(self.names)) for x in _TRIED]
        reach = _EXPLAINED * elastic.size

        def explained(weights: NDArray[np.float64]) -> float:
            face = self.posed(neutral, weights)
            found = scan.matches(face[asked], elastic.normals(face)[asked], turn=reach)
            return float(found.weights(reach).sum())

        return max([none, before, *single], key=explained)

    def posed(self, neutral: Points, weights: NDArray[np.float64]) -> Points:
        """(V, 3) the neutral with (K,) weights of the targets."""
        return neutral + np.tensordot(weights, self.deltas, axes=1)


def _bounded(matrix: Points, right: NDArray[np.float64]) -> NDArray[np.float64]:
    """The x from 0 to the largest weight of least xᵀ M x − 2 rᵀ x for a positive definite M."""
    from scipy.linalg import solve_triangular
    from scipy.optimize import lsq_linear

    lower = np.linalg.cholesky(matrix)
    goal = solve_triangular(lower, right, lower=True)
    found: NDArray[np.float64] = lsq_linear(lower.T, goal, (0, _MOST), method="bvls").x
    return found
