"""``mass-spring``: the equilibrium of springs whose rest lengths are interpolated.

After Ma, Wang, Fyffe, Chen and Debevec, *A Blendshape Model that Incorporates Physical Interaction*
(Computer Animation and Virtual Worlds 23, 2012), the paper's [16]: springs along edges resist
stretching, springs to second neighbours bending, and

    l(t) = (1 - t) |x₀ᵢ - x₀ⱼ| + t |x₁ᵢ - x₁ⱼ|        x(t) = argmin Σ k (|xᵢ - xⱼ| - l)²

by Gauss-Newton: the squares linearised, conjugate gradients for each step, and Levenberg's damping,
for what lengths do not tell of stays where it is. The authors report 40 s a face of 8,100 vertices
and 65,100 springs (their Table 1).

Ours, where the source leaves it open: springs across have half the stiffness of edges; vertices
that both ends have at the same place are held, in place of anchors inside the body; a connected
part without any is tied to a few of those that are, far from each other, by springs from all its
vertices, together as stiff as one edge a vertex; where nothing is held, the whole is placed nearest
to the even screw between its ends. Each face starts from the straight line, and not from the face
before: lengths alone leave a bent sheet many ways, of which one taken early may not lead to the
target.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork
from elastomorph.model.geometry import component_of, fit_rigid
from elastomorph.model.mesh import Mesh
from elastomorph.model.sequence import MeshSequence
from elastomorph.rivals.rival import Faces, Rival, straight

_MOST_STEPS = 60
_INNER_STEPS = 200


@dataclass(frozen=True)
class MassSpring(Rival):
    """The equilibrium of springs whose rest lengths are interpolated.

    Attributes:
        across: Stiffness of springs to second neighbours; that of edges is 1.
        anchors: How many held vertices a part that hangs on nothing is tied to.
        tolerance: A face is found when a step moves no vertex by more than this part of D.
    """

    name = "mass-spring"
    source = "Ma and others 2012, [16]"
    on_surfaces = True

    across: float = 0.5
    anchors: int = 8
    tolerance: float = 1e-6

    def faces(
        self, recording: MeshSequence, curves: CurveNetwork, times: NDArray[np.float64]
    ) -> Faces:
        """The face at each time."""
        start, end = recording.frames
        held = (start == end).all(axis=1)
        springs = Springs.between(recording.mesh, held, across=self.across, anchors=self.anchors)
        lengths = springs.lengths(start), springs.lengths(end)
        free, smallest = ~held, self.tolerance * recording.mesh.diameter
        screw, _ = fit_rigid(start, end)
        left_over = end - screw.at(1.0, start)
        for time in times:
            face = straight(recording, float(time))
            wanted = (1.0 - time) * lengths[0] + time * lengths[1]
            if free.any():
                face = springs.settled(face, wanted, free, smallest)
            if not held.any():
                turned = screw.at(float(time), start) + time * left_over
                face = fit_rigid(face, turned)[0].at(1.0, face)
            yield face


@dataclass(frozen=True, eq=False)
class Springs:
    """Pairs of vertices and how firmly each keeps its length."""

    pairs: NDArray[np.int64]  # (S, 2)
    stiffness: NDArray[np.float64]  # (S,)

    @classmethod
    def between(
        cls, mesh: Mesh, held: NDArray[np.bool_], *, across: float, anchors: int
    ) -> Springs:
        """Springs of edges and second neighbours, and ties of parts that hang on nothing."""
        edges = mesh.edges.astype(np.int64)
        further = _second_neighbours(edges, len(mesh.vertices))
        tied = _ties(mesh, held, anchors)
        weights = [1.0, across, 1.0 / anchors]
        pairs = [edges, further, tied]
        stiffness = np.concatenate(
            [np.full(len(own), k) for own, k in zip(pairs, weights, strict=True)]
        )
        return cls(np.concatenate(pairs), stiffness)

    def lengths(self, face: NDArray[np.float64]) -> NDArray[np.float64]:
        """(S,) the distance of each pair."""
        return np.asarray(np.linalg.norm(face[self.pairs[:, 1]] - face[self.pairs[:, 0]], axis=1))

    def energy(self, face: NDArray[np.float64], rest: NDArray[np.float64]) -> float:
        """Σ k (|xᵢ - xⱼ| - l)²."""
        return float((self.stiffness * (self.lengths(face) - rest) ** 2).sum())

    def settled(
        self,
        face: NDArray[np.float64],
        rest: NDArray[np.float64],
        free: NDArray[np.bool_],
        smallest: float,
    ) -> NDArray[np.float64]:
        """The equilibrium near a face, with rest lengths (S,); the vertices not free stay."""
        from scipy.sparse import diags_array
        from scipy.sparse.linalg import cg

        damping, energy = 1e-3, self.energy(face, rest)
        for _ in range(_MOST_STEPS):
            slopes, missed = self._linear(face, rest, free)
            matrix = slopes.T @ slopes
            diagonal = matrix.diagonal()
            scale = float(diagonal.max()) or 1.0
            gradient = slopes.T @ missed
            while True:
                added = damping * scale
                inverse = diags_array(1.0 / (diagonal + added))
                damped = matrix + added * diags_array(np.ones_like(diagonal))
                step, _ = cg(damped, -gradient, rtol=1e-4, maxiter=_INNER_STEPS, M=inverse)
                tried = face.copy()
                tried[free] += step.reshape(-1, 3)
                found = self.energy(tried, rest)
                if found <= energy or damping > 1e6:
                    break
                damping *= 10.0
            if found > energy:
                return face
            face, energy = tried, found
            damping = max(damping / 5.0, 1e-9)
            if np.abs(step).max() < smallest:
                break
        return face

    def _linear(
        self, face: NDArray[np.float64], rest: NDArray[np.float64], free: NDArray[np.bool_]
    ) -> tuple[Any, NDArray[np.float64]]:
        """(S, 3F) how the missing lengths change with the free vertices, and (S,) the lengths."""
        from scipy.sparse import csr_array

        offsets = face[self.pairs[:, 1]] - face[self.pairs[:, 0]]
        size = np.linalg.norm(offsets, axis=1)
        root = np.sqrt(self.stiffness)
        along = np.divide(
            offsets, size[:, None], out=np.zeros_like(offsets), where=size[:, None] > 0
        )
        along *= root[:, None]
        place = np.cumsum(free) - 1
        rows = np.broadcast_to(np.arange(len(self.pairs))[:, None, None], (*self.pairs.shape, 3))
        columns = 3 * place[self.pairs][:, :, None] + np.arange(3)
        values = np.stack([-along, along], axis=1)
        real = np.broadcast_to(free[self.pairs][:, :, None], rows.shape)
        shape = (len(self.pairs), 3 * int(free.sum()))
        slopes = csr_array((values[real], (rows[real], columns[real])), shape=shape)
        return slopes, root * (size - rest)


def _second_neighbours(edges: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """(S, 2) pairs that share a neighbour and no edge."""
    from scipy.sparse import coo_array, csr_array, triu

    joined = csr_array(
        coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(count, count))
    )
    joined = joined + joined.T
    two = triu(joined @ joined, k=1).tocoo()
    pairs = np.stack([two.row, two.col], axis=1).astype(np.int64)
    near = np.isin(pairs @ [count, 1], np.sort(edges, axis=1) @ [count, 1])
    return pairs[~near]


def _ties(mesh: Mesh, held: NDArray[np.bool_], anchors: int) -> NDArray[np.int64]:
    """(S, 2) every vertex of a part that hangs on nothing, and held ones far from each other."""
    fixed = np.flatnonzero(held)
    if not fixed.size:
        return np.zeros((0, 2), dtype=np.int64)
    part_of = component_of(len(mesh.vertices), mesh.edges)
    loose = np.flatnonzero((np.bincount(part_of, held) == 0)[part_of])
    points = mesh.vertices[fixed]
    away = np.linalg.norm(points - mesh.vertices[loose].mean(axis=0), axis=1) if loose.size else 0
    chosen = [int(np.argmin(away))]
    apart = np.linalg.norm(points - points[chosen[0]], axis=1)
    while len(chosen) < min(anchors, fixed.size):
        chosen.append(int(apart.argmax()))
        apart = np.minimum(apart, np.linalg.norm(points - points[chosen[-1]], axis=1))
    grid = np.meshgrid(loose, fixed[chosen], indexing="ij")
    return np.stack(grid, axis=2).reshape(-1, 2)
