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

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.cholesky import Cholesky, EliminationTree
from elastomorph.model.mesh import Mesh
from elastomorph.model.surface import surface_operators
from elastomorph.paths.rotations.bends import (
    ArcBend,
    EdgeBend,
    PolynomialBend,
    at_nodes,
    moments_needed,
)
from elastomorph.paths.rotations.vertex_rotations import VertexRotations

if TYPE_CHECKING:
    from scipy.sparse import csr_array

# The part of its shorter length that an edge may be off its rotated self and still count half.
_HALF_TRUSTED = 0.3
# μ: only waves far longer than the whole surface, such as a shift of a part, are left to the arcs.
_SCREEN = 0.01
# Chebyshev coefficients solved for together, and the part of the longest chord below which two of
# them in a row end the series.
_TOGETHER = 3
_NEGLIGIBLE = 1e-7


@dataclass(frozen=True, eq=False)
class LeastDistortion:
    """The bend of the least distorted path between two shapes, ready for any moment.

    Vertices that do not move stay exactly, components that turn as a whole do so exactly.
    """

    moving: NDArray[np.bool_]
    longest: float  # turn of a vertex, radians
    _whole: _Whole
    _equation: _EdgeEquation | None

    @classmethod
    def of(
        cls,
        start: NDArray[np.float64],
        end: NDArray[np.float64],
        rotations: VertexRotations,
        surface: SurfaceEdges,
    ) -> LeastDistortion:
        """Between (V, 3) positions; nothing is solved yet."""
        moving = (start != end).any(axis=1)
        free = moving & ~rotations.straight
        for part in rotations.whole:
            free[part] = False
        equation = _EdgeEquation.of(start, end, rotations, surface, free) if free.any() else None
        longest = float(np.linalg.norm(rotations.vectors, axis=1).max(initial=0.0))
        return cls(moving, longest, _Whole.of(start, end, rotations), equation)

    def at(self, t: float) -> NDArray[np.float64]:
        """(V, 3) offset from the straight line, by one solve."""
        offsets = np.zeros((len(self.moving), 3))
        offsets[self._whole.vertices] = self._whole.at(t)
        if self._equation is not None:
            offsets[self._equation.free] = self._equation.at(t)
        offsets[~self.moving] = 0.0
        return offsets

    def at_most(self, t: float) -> float:
        """A length that no offset at a time exceeds, without a solve."""
        whole = float(np.linalg.norm(self._whole.at(t), axis=1).max(initial=0.0))
        return whole if self._equation is None else max(whole, self._equation.at_most(t))

    def bend(self) -> PolynomialBend:
        """The offset at all times, to about 1e-9 of the longest chord."""
        count = moments_needed(self.longest)
        own = self.moving[self._whole.vertices]
        parts = [(self._whole.vertices[own], at_nodes(self._whole.at, count)[:, own])]
        if self._equation is not None:
            parts.append((np.flatnonzero(self._equation.free), self._equation.series(count)))
        number = np.cumsum(self.moving) - 1
        used = max((len(values) for vertices, values in parts if vertices.size), default=1)
        coefficients = np.zeros((used, int(self.moving.sum()), 3))
        for vertices, values in parts:
            coefficients[: len(values), number[vertices]] = values[:used]
        return PolynomialBend(coefficients, self.moving)


@dataclass(frozen=True, eq=False)
class _Whole:
    """Components with one rotation each: their mean on an arc, all else turned about it."""

    vertices: NDArray[np.int64]
    part: NDArray[np.int64]
    means: ArcBend
    about: EdgeBend

    @classmethod
    def of(
        cls, start: NDArray[np.float64], end: NDArray[np.float64], rotations: VertexRotations
    ) -> _Whole:
        parts = rotations.whole
        vertices = np.concatenate([np.zeros(0, np.int64), *parts])
        part = np.repeat(np.arange(len(parts)), [len(p) for p in parts])
        first, last = (
            np.array([points[p].mean(axis=0) for p in parts]).reshape(-1, 3)
            for points in (start, end)
        )
        vectors = rotations.vectors[[p[0] for p in parts]] if parts else np.zeros((0, 3))
        about = EdgeBend.of(
            start[vertices] - first[part], end[vertices] - last[part], vectors[part]
        )
        return cls(vertices, part, ArcBend.of(last - first, vectors), about)

    def at(self, t: float) -> NDArray[np.float64]:
        """(vertices, 3) bend at a time."""
        return self.means.at(t)[self.part] + self.about.at(t)


@dataclass(frozen=True, eq=False)
class SurfaceEdges:
    """The (E, 2) edges of a surface with their weights, found once for all targets."""

    ends: NDArray[np.integer]
    weights: NDArray[np.float64]  # (E,) half the sum of the cotangents opposite, not below 0
    mass: NDArray[np.float64]  # (V,) share of the area
    tree: EliminationTree  # the order in which equations of these edges are solved

    @classmethod
    def of(cls, mesh: Mesh) -> SurfaceEdges:
        """The edges that the Laplacian of a surface joins.

        Negative weights, of edges in very obtuse triangles, count as none: with weights changed
        edge by edge they could make the energy unbounded.

        Raises:
            MeshError: The mesh has no polygon with an area.
        """
        from scipy.sparse import coo_array

        surface = surface_operators(mesh)
        joined = coo_array(surface.laplacian)
        once = (joined.row < joined.col) & (joined.data < 0)
        ends = np.stack([joined.row[once], joined.col[once]], axis=1)
        tree = EliminationTree.of(mesh.vertices, ends)
        return cls(ends, -joined.data[once], surface.mass, tree)


@dataclass(frozen=True, eq=False)
class _EdgeEquation:
    """The equation of the free vertices; the others have bend 0.

    A free vertex has only free neighbours and vertices that do not move or go straight: whole
    components have no edges to others. The E edges are those with an end among the F vertices that
    are `free`.
    """

    free: NDArray[np.bool_]
    arcs: ArcBend
    edges: EdgeBend
    weights: NDArray[np.float64]
    ends: NDArray[np.integer]
    screen: NDArray[np.float64]  # (F,) μ m
    tree: EliminationTree
    negligible: float  # a length that does not matter

    @classmethod
    def of(
        cls,
        start: NDArray[np.float64],
        end: NDArray[np.float64],
        rotations: VertexRotations,
        surface: SurfaceEdges,
        free: NDArray[np.bool_],
    ) -> _EdgeEquation:
        used = free[surface.ends].any(axis=1)
        ends, weights = surface.ends[used], surface.weights[used]
        before, after = (points[ends[:, 1]] - points[ends[:, 0]] for points in (start, end))
        edges = EdgeBend.of(before, after, rotations.of_edges(ends))
        chords = (end - start)[free]
        return cls(
            free,
            ArcBend.of(chords, rotations.vectors[free]),
            edges,
            weights * _trust(before, after, edges),
            ends,
            _SCREEN * surface.mass[free],
            surface.tree,
            _NEGLIGIBLE * float(np.linalg.norm(chords, axis=1).max()),
        )

    @cached_property
    def _divergence(self) -> csr_array:
        """(F, E) -w where an edge begins and w where it ends."""
        from scipy.sparse import coo_array, csr_array

        numbers, row_of = np.arange(len(self.ends)), np.cumsum(self.free) - 1
        first, second = self.free[self.ends].T
        rows = np.concatenate([row_of[self.ends[first, 0]], row_of[self.ends[second, 1]]])
        columns = np.concatenate([numbers[first], numbers[second]])
        signed = np.concatenate([-self.weights[first], self.weights[second]])
        shape = (len(self.screen), len(self.ends))
        return csr_array(coo_array((signed, (rows, columns)), shape=shape))

    @cached_property
    def _factor(self) -> Cholesky:
        both = self.free[self.ends].all(axis=1)
        diagonal = self.screen + np.asarray(abs(self._divergence).sum(axis=1)).ravel()
        return Cholesky.of(self.tree, self.free, self.ends[both], self.weights[both], diagonal)

    def right_side(self, t: float) -> NDArray[np.float64]:
        return self._divergence @ self.edges.at(t) + self.screen[:, None] * self.arcs.at(t)

    def at(self, t: float) -> NDArray[np.float64]:
        """(F, 3) bend at a time."""
        return self._factor.solve(self.right_side(t))

    def at_most(self, t: float) -> float:
        """A length that no bend at a time exceeds.

        With Green's function G of the equation, the bend of a vertex v is

            Σ_ij w_ij (G_vi - G_vj) ε_ij + Σ_i p_i G_vi a_i,   ε_ij the bend of an edge, p the pull.

        G_v is the potential of a unit current that enters at v and leaves through the pulls and
        the vertices that stay. No edge carries more than all of it, w_ij |G_vi - G_vj| ≤ 1, nor do
        the pulls, Σ p_i G_vi ≤ 1: the bend is at most the longest arc and all edges together.
        """
        edges = np.linalg.norm(self.edges.at(t), axis=1)[self.weights > 0]
        arcs = np.linalg.norm(self.arcs.at(t), axis=1)
        return float(edges.sum() + arcs.max(initial=0.0))

    def series(self, count: int) -> NDArray[np.float64]:
        """(N, F, 3) Chebyshev coefficients of the bend over t(1 - t), N at most `count`.

        Once turns are followed, each is a small part of the one before; where two in a row are
        negligible, what follows is far more so, and is left out.
        """
        right_side = at_nodes(self.right_side, count)
        found = []
        for first in range(0, count, _TOGETHER):
            some = right_side[first : first + _TOGETHER]
            columns = some.transpose(1, 0, 2).reshape(some.shape[1], -1)
            solved = self._factor.solve(columns).reshape(some.shape[1], -1, 3)
            found.append(solved.transpose(1, 0, 2))
            if np.abs(solved[:, -2:]).max() < self.negligible:
                break
        return np.concatenate(found)


def _trust(
    before: NDArray[np.float64], after: NDArray[np.float64], edges: EdgeBend
) -> NDArray[np.float64]:
    """(E,) 1 where the rotation carries an edge to its end, less the farther off it lands."""
    shorter = np.minimum(np.linalg.norm(before, axis=1), np.linalg.norm(after, axis=1))
    allowed = (_HALF_TRUSTED * shorter) ** 2
    off = edges.missed(before, after)
    missed = np.einsum("ei,ei->e", off, off)
    # An edge without length at one end says nothing.
    trust = np.divide(allowed, allowed + missed, out=np.zeros_like(allowed), where=allowed > 0)
    return np.asarray(trust)
