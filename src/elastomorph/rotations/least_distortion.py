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

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from elastomorph.mesh import Mesh
from elastomorph.rotations.polynomial_bend import PolynomialBend, at_nodes, moments_needed
from elastomorph.rotations.turning import ArcBend, EdgeBend
from elastomorph.rotations.vertex_rotations import VertexRotations
from elastomorph.surface import surface_operators
from elastomorph.surface.cholesky import Cholesky
from elastomorph.surface.dissection import EliminationTree

__all__ = ["LeastDistortion", "SurfaceEdges"]

# The part of its shorter length that an edge may be off its rotated self and still count half.
_HALF_TRUSTED = 0.3
# μ: only waves far longer than the whole surface, such as a shift of a part, are left to the arcs.
_SCREEN = 0.01
# Chebyshev coefficients solved for together, and the part of the longest chord below which two of
# them in a row end the series.
_TOGETHER = 4
_NEGLIGIBLE = 1e-9


@dataclass(frozen=True, eq=False)
class SurfaceEdges:
    """The edges of a surface with their weights, found once for all targets.

    Attributes:
        ends: (E, 2) vertices.
        weights: (E,) half the sum of the cotangents opposite, not below 0.
        mass: (V,) share of the area.
        tree: The order in which equations of these edges are solved.
    """

    ends: NDArray[np.integer]
    weights: NDArray[np.float64]
    mass: NDArray[np.float64]
    tree: EliminationTree

    @classmethod
    def of(cls, mesh: Mesh) -> SurfaceEdges:
        """The edges that the Laplacian of a surface joins.

        Negative weights, of edges in very obtuse triangles, count as none: with weights changed
        edge by edge they could make the energy unbounded.

        Raises:
            MeshError: The mesh has no polygon with an area.
        """
        surface = surface_operators(mesh)
        joined = coo_array(surface.stiffness)
        once = (joined.row < joined.col) & (joined.data < 0)
        ends = np.stack([joined.row[once], joined.col[once]], axis=1)
        tree = EliminationTree.of(mesh.vertices, ends)
        return cls(ends, -joined.data[once], surface.mass, tree)


@dataclass(frozen=True, eq=False)
class LeastDistortion:
    """The bend of the least distorted path between two shapes, ready for any moment.

    Vertices that do not move stay exactly, components that turn as a whole do so exactly.

    Attributes:
        moving: (V,) vertices that move: all others have no bend.
        longest: The largest turn of a vertex, radians.
    """

    moving: NDArray[np.bool_]
    longest: float
    _whole: _Whole
    _screened: _Screened | None
    _free: NDArray[np.bool_]

    @classmethod
    def of(
        cls,
        start: NDArray[np.float64],
        end: NDArray[np.float64],
        rotations: VertexRotations,
        surface: SurfaceEdges,
    ) -> LeastDistortion:
        """Prepare for all times.

        Args:
            start: (V, 3) positions at t = 0.
            end: (V, 3) positions at t = 1.
            rotations: Of each vertex.
            surface: The edges.
        """
        moving = (start != end).any(axis=1)
        free = moving.copy()
        for part in rotations.whole:
            free[part] = False
        screened = _Screened.of(start, end, rotations, surface, free) if free.any() else None
        longest = float(np.linalg.norm(rotations.vectors, axis=1).max(initial=0.0))
        return cls(moving, longest, _Whole.of(start, end, rotations), screened, free)

    def at(self, t: float) -> NDArray[np.float64]:
        """(V, 3) offset from the straight line, by one solve."""
        offsets = np.zeros((len(self.moving), 3))
        offsets[self._whole.vertices] = self._whole.at(t)
        if self._screened is not None:
            offsets[self._free] = self._screened.factor.solve(self._screened.wanted(t))
        offsets[~self.moving] = 0.0
        return offsets

    def bend(self) -> PolynomialBend:
        """The offset at all times, to about 1e-9 of the longest chord."""
        count = moments_needed(self.longest)
        coefficients = np.zeros((count, len(self.moving), 3))
        coefficients[:, self._whole.vertices] = at_nodes(self._whole.at, count)
        if self._screened is not None:
            coefficients[:, self._free] = self._screened.series(count)
        return PolynomialBend(coefficients[:, self.moving], self.moving)


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
class _Screened:
    """The screened Poisson equation of the free vertices, factored; the others have bend 0.

    A free vertex has only free neighbours and vertices that do not move: whole components have no
    edges to others.
    """

    arcs: ArcBend
    edges: EdgeBend
    divergence: csr_array
    pull: NDArray[np.float64]
    factor: Cholesky
    negligible: float

    @classmethod
    def of(
        cls,
        start: NDArray[np.float64],
        end: NDArray[np.float64],
        rotations: VertexRotations,
        surface: SurfaceEdges,
        free: NDArray[np.bool_],
    ) -> _Screened:
        used = free[surface.ends].any(axis=1)
        ends, weights = surface.ends[used], surface.weights[used]
        before, after = (points[ends[:, 1]] - points[ends[:, 0]] for points in (start, end))
        edges = EdgeBend.of(before, after, rotations.of_edges(ends))
        weights = weights * _trust(before, after, edges)
        count, numbers = int(free.sum()), np.arange(len(ends))
        row_of = np.cumsum(free) - 1
        first, second = free[ends].T
        rows = np.concatenate([row_of[ends[first, 0]], row_of[ends[second, 1]]])
        columns = np.concatenate([numbers[first], numbers[second]])
        signed = np.concatenate([-weights[first], weights[second]])
        divergence = csr_array(coo_array((signed, (rows, columns)), shape=(count, len(ends))))
        pull = _SCREEN * surface.mass[free]
        both = first & second
        diagonal = pull + np.bincount(rows, np.abs(signed), minlength=count)
        factor = Cholesky.of(surface.tree, free, ends[both], weights[both], diagonal)
        chords = (end - start)[free]
        negligible = _NEGLIGIBLE * float(np.linalg.norm(chords, axis=1).max())
        arcs = ArcBend.of(chords, rotations.vectors[free])
        return cls(arcs, edges, divergence, pull, factor, negligible)

    def wanted(self, t: float) -> NDArray[np.float64]:
        """(free vertices, 3) right-hand side at a time."""
        return self.divergence @ self.edges.at(t) + self.pull[:, None] * self.arcs.at(t)

    def series(self, count: int) -> NDArray[np.float64]:
        """(count, free vertices, 3) Chebyshev coefficients of the bend over t(1 - t).

        They fall faster than any power once turns are followed, so the last of them are left out.
        """
        wanted = at_nodes(self.wanted, count)
        found = np.zeros_like(wanted)
        for first in range(0, count, _TOGETHER):
            some = wanted[first : first + _TOGETHER]
            columns = some.transpose(1, 0, 2).reshape(some.shape[1], -1)
            solved = self.factor.solve(columns).reshape(some.shape[1], -1, 3).transpose(1, 0, 2)
            found[first : first + _TOGETHER] = solved
            if np.abs(solved[-2:]).max() < self.negligible:
                break
        return found


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
