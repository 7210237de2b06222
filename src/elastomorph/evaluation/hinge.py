"""How true a jaw turns: teeth and gums against the arc of the hinge that both ends give away."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.evaluation.rigid_parts import RigidParts
from elastomorph.model.geometry import Screw, connected_parts, fit_rigid
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph

__all__ = ["TIMES", "Hinge", "HingeError", "find_hinge", "hinge_errors"]

TIMES = (0.25, 0.5, 0.75)


@dataclass(frozen=True, eq=False)
class Hinge:
    """What turns about one axis, rigidly, from a neutral to a target.

    Attributes:
        neutral: The whole face at rest.
        screw: The motion.
        parts: (N,) vertices of pieces that move as one rigid body, such as teeth; rising.
        along: (M,) vertices that the motion carries as closely, of further pieces that it carries
            for the most part, such as gums; rising.
        residual: How far the target itself is from the motion on all of these, as a fraction of D.
    """

    neutral: Mesh
    screw: Screw
    parts: NDArray[np.int64]
    along: NDArray[np.int64]

    residual: float

    @property
    def vertices(self) -> NDArray[np.int64]:
        """(N + M,) all that turns, rising."""
        return np.union1d(self.parts, self.along)

    def off(self, morph: Morph, time: float) -> NDArray[np.float64]:
        """(N + M,) distance of each of `vertices` from the true arc, as a fraction of D."""
        there = self.screw.at(time, self.neutral.vertices[self.vertices])
        away = np.linalg.norm(morph.at(time)[self.vertices] - there, axis=1)
        return np.asarray(away / (self.neutral.diameter or 1.0))


@dataclass(frozen=True)
class HingeError:
    """Largest distances from the true arc at t = 0.25, 0.5 and 0.75, as fractions of D.

    Attributes:
        label: The method.
        parts: Of the rigid parts.
        along: Of what moves along with them; 0 where there is nothing.
    """

    label: str
    parts: float
    along: float


def find_hinge(neutral: Mesh, target: Mesh, parts: RigidParts, *, tolerance: float = 1e-6) -> Hinge:
    """The hinge of rigid parts, and what else it carries.

    Args:
        neutral: The face at rest.
        target: The face with its jaw open.
        parts: What `find_rigid_parts` found between the two.
        tolerance: What else is carried ends within this fraction of D of the motion, or as near
            to it as the parts do.
    """
    start, end = neutral.vertices, target.vertices
    screw, residual = fit_rigid(start[parts.vertices], end[parts.vertices])
    left_over = np.linalg.norm(screw.at(1.0, start) - end, axis=1)
    allowed = max(float(residual.max()), tolerance * neutral.diameter)
    carried = (left_over <= allowed) & (start != end).any(axis=1)
    carried[parts.vertices] = False
    along = np.zeros_like(carried)
    for piece in connected_parts(len(start), neutral.edges):
        # A gum is carried; a chin that happens to run along is skin, which may do as it likes.
        if 2 * np.count_nonzero(carried[piece]) > len(piece):
            along[piece] = carried[piece]
    turning = np.union1d(parts.vertices, np.flatnonzero(along))
    own = float(left_over[turning].max()) / (neutral.diameter or 1.0)
    return Hinge(neutral, screw, parts.vertices, np.flatnonzero(along), own)


def hinge_errors(hinge: Hinge, morphs: Mapping[str, Morph]) -> list[HingeError]:
    """How far each method leaves the true arc, at even timing.

    Args:
        hinge: What turns.
        morphs: Paths of the whole face by the labels of their methods.
    """
    is_part = np.isin(hinge.vertices, hinge.parts)
    found = []
    for label, morph in morphs.items():
        worst = np.max([hinge.off(morph, time) for time in TIMES], axis=0)
        found.append(
            HingeError(label, float(worst[is_part].max()), float(worst[~is_part].max(initial=0.0)))
        )
    return found
