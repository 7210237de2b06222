"""How the surface around each vertex turns from one mesh to another, smoothed over a few rings."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.geometry import connected_parts
from elastomorph.paths.rotations.bends import EdgeBend
from elastomorph.paths.rotations.quaternions import (
    aligned_with,
    common_turns,
    near_half_turn,
    nearest_quaternions,
    rotation_vectors,
    vanishes,
)

if TYPE_CHECKING:
    from scipy.sparse import csr_array

# The change of length, as a logarithm, at which an edge counts half. Edges between lips or between
# gums are stretched many times over; what they turn by means nothing.
_HALF_TRUSTED = 0.3
# The part of the change of edges that a turn may leave: chins with markers leave 5 to 11 %, brows
# 40 to 90 %, lids more than there was.
_UNEXPLAINED = 0.25
# Rounds in which vertices close to half a turn take the way round of their neighbours.
_ALIGNMENTS = 8


@dataclass(frozen=True, eq=False)
class Neighbourhoods:
    """The (E, 2) edges around every vertex of a mesh, found once for all targets."""

    edges: NDArray[np.integer]
    at_vertex: csr_array  # (V, E) ones where an edge ends at a vertex
    adjacency: csr_array  # (V, V) ones where an edge joins two vertices
    parts: list[NDArray[np.int64]]  # vertices of each connected component

    @classmethod
    def of(cls, count: int, edges: NDArray[np.integer]) -> Neighbourhoods:
        """Of V vertices, with and without edges, and (E, 2) edges, each once."""
        from scipy.sparse import coo_array, csr_array

        numbers, ends = np.tile(np.arange(len(edges)), 2), edges.T.ravel()
        one = np.ones(ends.size)
        at_vertex = csr_array(coo_array((one, (ends, numbers)), shape=(count, len(edges))))
        others = edges[:, ::-1].T.ravel()
        adjacency = csr_array(coo_array((one, (ends, others)), shape=(count, count)))
        return cls(edges, at_vertex, adjacency, connected_parts(count, edges))

    def within(self, vertices: NDArray[np.bool_], rings: int) -> NDArray[np.bool_]:
        """(V,) the vertices and all that are up to a number of edges away."""
        reached = vertices.astype(np.float64)
        for _ in range(rings):
            reached = np.minimum(1.0, reached + self.adjacency @ reached)
        return np.asarray(reached > 0)


@dataclass(frozen=True, eq=False)
class VertexRotations:
    """A rotation at each vertex: (V, 4) unit (w, x, y, z), where w < 0 is a turn by more than π.

    ``whole`` are the vertices of each component that moves and turns as a whole, by one rotation.
    ``straight`` are those that have no rotation, (V,) bool: around them everything shrinks to a
    point, or grows from one.
    """

    quaternions: NDArray[np.float64]
    whole: tuple[NDArray[np.int64], ...]
    straight: NDArray[np.bool_]

    @cached_property
    def vectors(self) -> NDArray[np.float64]:
        """(V, 3) axis times angle, radians; zero where nothing is known."""
        return rotation_vectors(self.quaternions)

    def of_edges(self, ends: NDArray[np.integer]) -> NDArray[np.float64]:
        """(E, 3) rotation vector halfway between those of (E, 2) vertices."""
        first, second = self.quaternions[ends[:, 0]], self.quaternions[ends[:, 1]]
        opposed = np.sum(first * second, axis=1) < 0
        mean = first + np.where(opposed[:, None], -second, second)
        return rotation_vectors(mean / np.linalg.norm(mean, axis=1, keepdims=True))

    def without(self, vertices: NDArray[np.bool_]) -> VertexRotations:
        """The same with some more vertices that go straight: whole components."""
        quaternions = np.where(vertices[:, None], [1.0, 0.0, 0.0, 0.0], self.quaternions)
        return VertexRotations(quaternions, self.whole, self.straight | vertices)

    def where_edges_turn(
        self, start: NDArray[np.float64], end: NDArray[np.float64], around: Neighbourhoods
    ) -> VertexRotations:
        """No rotation in components whose edges hardly turn by theirs.

        A few edges on a curve have some rotation even where one marker moves alone. It means
        something if it explains most of how they change: Σ ‖R e₀ - e₁‖² ≤ ¼ Σ ‖e₀ - e₁‖².
        """
        before, after = (p[around.edges[:, 1]] - p[around.edges[:, 0]] for p in (start, end))
        turned = EdgeBend.of(before, after, self.of_edges(around.edges)).missed(before, after)
        part_of = np.empty(len(start), dtype=np.int64)
        for number, part in enumerate(around.parts):
            part_of[part] = number
        missed, changed = (
            np.bincount(
                part_of[around.edges[:, 0]], np.einsum("ei,ei->e", off, off), len(around.parts)
            )
            for off in (turned, before - after)
        )
        still = (missed > _UNEXPLAINED * changed)[part_of]
        quaternions = np.where(still[:, None], [1.0, 0.0, 0.0, 0.0], self.quaternions)
        return replace(self, quaternions=quaternions)


def vertex_rotations(
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    around: Neighbourhoods,
    *,
    diameter: float,
    rings: int,
) -> VertexRotations:
    """The smoothed local rotation at each vertex.

    It is the polar factor of the covariance Σ w e₀ e₁ᵀ of the edges e₀ → e₁ around the vertex,
    summed over its rings with binomial weights: covariances are averaged, not rotations, so long
    edges count more than short ones and no angle has to be unwrapped. Edges that become longer or
    shorter by a factor s ≥ 1 count w = s⁻¹/(1 + (log s/0.3)²). Components that turn as a whole
    (`common_turns`) have one rotation; where all edges at a vertex, or a whole component, shrink to
    under a thousandth of their size, or grow from it, there is none.
    """
    scale = diameter or 1.0
    before = (start[around.edges[:, 1]] - start[around.edges[:, 0]]) / scale
    after = (end[around.edges[:, 1]] - end[around.edges[:, 0]]) / scale
    products = np.einsum("ei,ej->eij", before, after).reshape(-1, 9)
    covariances = around.at_vertex @ (products * _trust(before, after)[:, None])
    most = nearest_quaternions(covariances.sum(axis=0).reshape(1, 3, 3))
    for _ in range(rings):
        covariances = covariances + around.adjacency @ covariances
    moving = (start != end).any(axis=1)
    near = around.within(moving, rings + 1)
    # Edges that stay as they are turn by nothing.
    quaternions = np.tile([1.0, 0.0, 0.0, 0.0], (len(start), 1))
    quaternions[near] = nearest_quaternions(covariances[near].reshape(-1, 3, 3))
    # A mesh that hardly turns as a whole has no say about its parts.
    turns_far = bool(most[0, 0] < np.cos(np.pi / 4))
    if turns_far:
        quaternions = aligned_with(quaternions, most)
    for _ in range(_ALIGNMENTS):
        if not near_half_turn(quaternions).any():
            break
        quaternions = aligned_with(quaternions, around.adjacency @ quaternions)
    parts = [part for part in around.parts if moving[part].any()]
    turns, as_one = common_turns(start, end, parts, diameter)
    if turns_far:
        turns = aligned_with(turns, most)
    whole = [part for part, one in zip(parts, as_one, strict=True) if one]
    straight = vanishes(*(np.sqrt(around.at_vertex @ (e * e).sum(axis=1)) for e in (before, after)))
    # What such a vertex is joined to is at the same point.
    straight = around.within(straight, 1)
    for part, turn in zip(whole, turns[as_one], strict=True):
        quaternions[part] = turn
        straight[part] = straight[part].all()
    quaternions[straight] = 1.0, 0.0, 0.0, 0.0
    return VertexRotations(quaternions, tuple(whole), straight)


def _trust(before: NDArray[np.float64], after: NDArray[np.float64]) -> NDArray[np.float64]:
    """(E,) weight of each edge: 1 where it keeps its length, 0 where it appears or vanishes."""
    lengths = np.linalg.norm(before, axis=1), np.linalg.norm(after, axis=1)
    real = (lengths[0] > 0) & (lengths[1] > 0)
    weights = np.zeros(len(before))
    stretch = np.abs(np.log(lengths[1][real]) - np.log(lengths[0][real]))
    # s⁻¹: a covariance grows with both lengths, but an edge should not count for being torn.
    weights[real] = np.exp(-stretch) / (1.0 + (stretch / _HALF_TRUSTED) ** 2)
    return weights
