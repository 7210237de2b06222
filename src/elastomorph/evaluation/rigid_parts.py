"""Ground truth inside a rig: parts that move rigidly, such as teeth, must have moved on an arc."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork
from elastomorph.model.geometry import Screw, connected_parts, fit_rigid
from elastomorph.model.mesh import FaceLabels, Mesh, require_same_topology
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence

__all__ = ["RigidParts", "find_rigid_parts"]


@dataclass(frozen=True, eq=False)
class RigidParts:
    """Components of a mesh that one rigid motion carries from neutral to target.

    Attributes:
        vertices: (N,) their vertices in the whole mesh, rising.
        components: How many there are.
        screw: The motion.
        residual: Largest distance of a target vertex from it, as a fraction of D.
        truth: The parts alone, on the screw at constant speed. Where they are at which time is
            not known, so only errors with free timing say something about a method.
    """

    vertices: NDArray[np.int64]
    components: int
    screw: Screw
    residual: float
    truth: MeshSequence

    def curves(self, network: CurveNetwork) -> CurveNetwork:
        """The curves of the whole mesh that lie on the parts."""
        new_index = np.full(network.vertex_count, -1)
        new_index[self.vertices] = np.arange(len(self.vertices))
        return network.restricted(self.vertices).relabelled(new_index, len(self.vertices))

    def restricted(self, morph: Morph) -> Morph:
        """What a path of the whole mesh does to the parts alone."""
        truth = self.truth
        return replace(
            morph, neutral=truth.mesh, target=truth.target, bends=morph.bends[:, self.vertices]
        )


def find_rigid_parts(
    neutral: Mesh,
    target: Mesh,
    *,
    tolerance: float = 1e-3,
    least_turn: float = 5.0,
    frames: int = 11,
) -> RigidParts | None:
    """Find the components that turn rigidly, together.

    Args:
        neutral: The mesh at t = 0.
        target: The mesh at t = 1.
        tolerance: Largest distance from a rigid motion, as a fraction of D.
        least_turn: Smallest angle of interest, in degrees.
        frames: Frames of the truth.

    Returns:
        The largest set of components with one common motion, or none.

    Raises:
        TopologyError: Neutral and target differ in vertices or polygons.
    """
    require_same_topology(neutral, target)
    scale = neutral.diameter or 1.0
    rigid: list[NDArray[np.int64]] = []
    for vertices in connected_parts(len(neutral.vertices), neutral.edges):
        if len(vertices) >= 4:
            screw, residual = fit_rigid(neutral.vertices[vertices], target.vertices[vertices])
            turns = np.degrees(screw.angle) >= least_turn
            if turns and residual.max() <= tolerance * scale:
                rigid.append(vertices)
    if not rigid:
        return None
    together = np.sort(np.concatenate(rigid))
    screw, residual = fit_rigid(neutral.vertices[together], target.vertices[together])
    if residual.max() > 2 * tolerance * scale:
        largest = max(rigid, key=len)
        rigid, together = [largest], np.sort(largest)
        screw, residual = fit_rigid(neutral.vertices[together], target.vertices[together])
    return RigidParts(
        together,
        len(rigid),
        screw,
        float(residual.max()) / scale,
        _truth(neutral, target, together, screw, frames),
    )


def _truth(
    neutral: Mesh, target: Mesh, vertices: NDArray[np.int64], screw: Screw, frames: int
) -> MeshSequence:
    new_index = np.full(len(neutral.vertices), -1)
    new_index[vertices] = np.arange(len(vertices))
    kept = [number for number, face in enumerate(neutral.faces) if (new_index[face] >= 0).all()]
    faces = [new_index[neutral.faces[number]] for number in kept]
    start, end = neutral.vertices[vertices], target.vertices[vertices]
    left_over = end - screw.at(1.0, start)
    times = np.linspace(0.0, 1.0, frames)
    positions = np.stack([screw.at(float(t), start) + t * left_over for t in times])
    positions[-1] = end
    materials, groups = (_of(labels, kept) for labels in (neutral.materials, neutral.groups))
    return MeshSequence(Mesh(start, faces, materials=materials, groups=groups), positions, times)


def _of(labels: FaceLabels | None, faces: Sequence[int]) -> FaceLabels | None:
    """The labels of some of the polygons."""
    return None if labels is None else FaceLabels(labels.names, labels.of_face[list(faces)])
