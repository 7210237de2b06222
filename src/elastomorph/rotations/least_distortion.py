"""The path on which every edge turns with its neighbourhood, as nearly as all edges together can.

At each time the positions x minimise, in units of total area 1,

    Σ_ij w_ij ‖(x_j - x_i) - e_ij(t)‖² + μ Σ_i m_i ‖x_i - a_i(t)‖²

e_ij(t) turns the edge steadily by the mean rotation of its two ends (`EdgeBend`), w_ij is its
cotangent weight, less where neutral edge, rotated, is far from the target's; a_i(t) is the arc of
the vertex (`ArcBend`) and m_i its share of the area: it fixes what edges leave open, and keeps
edges that disagree from adding up to a drift. The minimum is a Poisson equation with one matrix
for all times.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array, csr_array, dia_array

from elastomorph.rotations.polynomial_bend import PolynomialBend, moments_needed
from elastomorph.rotations.turning import ArcBend, EdgeBend
from elastomorph.rotations.vertex_rotations import VertexRotations
from elastomorph.surface import SurfaceOperators

__all__ = ["SurfaceEdges", "least_distortion"]

# The part of its shorter length that an edge may be off its rotated self and still count half.
_HALF_TRUSTED = 0.3
# μ: only waves far longer than the whole surface, such as a shift of a part, are left to the arcs.
_SCREEN = 0.01


@dataclass(frozen=True, eq=False)
class SurfaceEdges:
    """The edges of a surface with their weights, found once for all targets.

    Attributes:
        ends: (E, 2) vertices.
        weights: (E,) half the sum of the cotangents opposite, not below 0.
        mass: (V,) share of the area.
    """

    ends: NDArray[np.integer]
    weights: NDArray[np.float64]
    mass: NDArray[np.float64]

    @classmethod
    def of(cls, surface: SurfaceOperators) -> SurfaceEdges:
        """The edges that the Laplacian of a surface joins.

        Negative weights, of edges in very obtuse triangles, count as none: with weights changed
        edge by edge they could make the energy unbounded.
        """
        joined = coo_array(surface.stiffness)
        once = (joined.row < joined.col) & (joined.data < 0)
        ends = np.stack([joined.row[once], joined.col[once]], axis=1)
        return cls(ends, -joined.data[once], surface.mass)


def least_distortion(
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    rotations: VertexRotations,
    surface: SurfaceEdges,
) -> PolynomialBend:
    """The bend of the least distorted path.

    Vertices that do not move stay exactly, components that turn as a whole do so exactly.

    Args:
        start: (V, 3) positions at t = 0.
        end: (V, 3) positions at t = 1.
        rotations: Of each vertex.
        surface: The edges.
    """
    chords = end - start
    moving = (chords != 0).any(axis=1)
    free = moving.copy()
    for part in rotations.whole:
        free[part] = False
    whole = [_whole_bend(start[p], end[p], rotations.vectors[p[0]]) for p in rotations.whole]
    screened = [_Screened.of(start, end, rotations, surface, free)] if free.any() else []

    def bend(t: float) -> NDArray[np.float64]:
        offset = np.zeros_like(chords)
        for part, turn in zip(rotations.whole, whole, strict=True):
            offset[part] = turn(t)
        for equation in screened:
            offset[free] = equation.at(t)
        offset[~moving] = 0.0
        return offset

    longest = float(np.linalg.norm(rotations.vectors, axis=1).max(initial=0.0))
    return PolynomialBend.through(bend, moments_needed(longest))


def _whole_bend(
    start: NDArray[np.float64], end: NDArray[np.float64], vector: NDArray[np.float64]
) -> Callable[[float], NDArray[np.float64]]:
    """Bend of a component with one rotation: its mean on an arc, all else turned about it."""
    means = start.mean(axis=0, keepdims=True), end.mean(axis=0, keepdims=True)
    mean = ArcBend.of(means[1] - means[0], vector)
    about = EdgeBend.of(start - means[0], end - means[1], vector)
    return lambda t: mean.at(t) + about.at(t)


@dataclass(frozen=True, eq=False)
class _Screened:
    """The screened Poisson equation of the free vertices, factored; the others have bend 0.

    A free vertex has only free neighbours and vertices that do not move: whole components have no
    edges to others.
    """

    arcs: ArcBend
    edges: EdgeBend
    divergence: csr_array
    pull: NDArray[np.float64]
    inverse: Callable[[NDArray[np.float64]], NDArray[np.float64]]

    @classmethod
    def of(
        cls,
        start: NDArray[np.float64],
        end: NDArray[np.float64],
        rotations: VertexRotations,
        surface: SurfaceEdges,
        free: NDArray[np.bool_],
    ) -> _Screened:
        from scipy.sparse.linalg import splu

        used = free[surface.ends].any(axis=1)
        ends, weights = surface.ends[used], surface.weights[used]
        before, after = (points[ends[:, 1]] - points[ends[:, 0]] for points in (start, end))
        edges = EdgeBend.of(before, after, rotations.of_edges(ends))
        weights = weights * _trust(before, after, edges)
        numbers = np.arange(len(ends))
        number_of = np.cumsum(free) - 1
        rows, columns, signs = [], [], []
        for side, sign in ((0, -1.0), (1, 1.0)):
            mine = free[ends[:, side]]
            rows.append(number_of[ends[mine, side]])
            columns.append(numbers[mine])
            signs.append(np.full(int(mine.sum()), sign))
        shape = (int(free.sum()), len(ends))
        index = (np.concatenate(rows), np.concatenate(columns))
        incidence = csr_array(coo_array((np.concatenate(signs), index), shape=shape))
        divergence = csr_array(incidence @ dia_array((weights[None], 0), shape=(len(ends),) * 2))
        pull = _SCREEN * surface.mass[free]
        screen = dia_array((pull[None], 0), shape=(shape[0], shape[0]))
        matrix = csc_array(divergence @ incidence.T + screen)
        factored = splu(
            matrix,
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        arcs = ArcBend.of((end - start)[free], rotations.vectors[free])
        return cls(arcs, edges, divergence, pull, factored.solve)

    def at(self, t: float) -> NDArray[np.float64]:
        """(free vertices, 3) bend at a time."""
        wanted = self.divergence @ self.edges.at(t) + self.pull[:, None] * self.arcs.at(t)
        return self.inverse(wanted)


def _trust(
    before: NDArray[np.float64], after: NDArray[np.float64], edges: EdgeBend
) -> NDArray[np.float64]:
    """(E,) 1 where the rotation carries an edge to its end, less the farther off it lands."""
    angle = edges.angle[:, None]
    turned = before + (np.cos(angle) - 1.0) * edges.start + np.sin(angle) * edges.start_turned
    shorter = np.minimum(np.linalg.norm(before, axis=1), np.linalg.norm(after, axis=1))
    allowed = (_HALF_TRUSTED * shorter) ** 2
    off = turned - after
    missed = np.einsum("ei,ei->e", off, off)
    # An edge without length at one end says nothing.
    trust = np.divide(allowed, allowed + missed, out=np.zeros_like(allowed), where=allowed > 0)
    return np.asarray(trust)
