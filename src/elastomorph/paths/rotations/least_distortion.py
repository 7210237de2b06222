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

from elastomorph.paths.rotations.bends import (
    ArcBend,
    EdgeBend,
    PolynomialBend,
    at_nodes,
    moments_needed,
)
from elastomorph.paths.rotations.edge_equation import EdgeEquation, SurfaceEdges
from elastomorph.paths.rotations.vertex_rotations import VertexRotations

__all__ = ["LeastDistortion"]


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
    _equation: EdgeEquation | None

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
        equation = EdgeEquation.of(start, end, rotations, surface, free) if free.any() else None
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
