"""A mesh taken apart into connected pieces that know their half-edges and their colours."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.half_edges import HalfEdges
from elastomorph.doctor.relabelling.branching import Piece
from elastomorph.doctor.relabelling.colours import Colouring, mixed
from elastomorph.doctor.relabelling.walk import Walk
from elastomorph.model.components import component_of
from elastomorph.model.mesh import Mesh
from elastomorph.model.polygons import Polygons

__all__ = ["Parts"]


class Parts:
    """The connected pieces of one mesh.

    Attributes:
        mesh: The mesh.
        half_edges: Its polygons, or others in their place.
        part_of: (V,) piece of each vertex.
        colouring: The colours its pieces are told apart by.
        seeds: Vertices that have a colour of their own from the start.
    """

    def __init__(
        self,
        mesh: Mesh,
        *,
        faces: Polygons | None = None,
        seeds: Sequence[int] = (),
        rounds: int | None = None,
    ) -> None:
        """Take a mesh apart.

        Args:
            mesh: The mesh.
            faces: Polygons in place of its own, on the same edges.
            seeds: Vertices known beforehand.
            rounds: Rounds of colours, those of the mesh it will be compared with; by default as
                many as it takes.
        """
        self.mesh = mesh
        self.seeds = tuple(seeds)
        self.half_edges = HalfEdges.of(mesh.faces if faces is None else faces, len(mesh.vertices))
        self.part_of = component_of(len(mesh.vertices), mesh.edges)
        self.colouring = Colouring(self.half_edges, seeds)
        if rounds is None:
            self.colouring.settle(self.part_of)
        else:
            for _ in range(rounds):
                self.colouring.advance()
        self._walks: dict[int, Walk] = {}

    @cached_property
    def vertices(self) -> list[NDArray[np.int64]]:
        """The vertices of each piece, rising."""
        return _grouped(self.part_of, int(self.part_of.max()) + 1)

    @cached_property
    def corners(self) -> list[NDArray[np.int64]]:
        """The polygon corners of each piece."""
        return _grouped(self.part_of[self.half_edges.start], int(self.part_of.max()) + 1)

    @cached_property
    def by_colour(self) -> dict[tuple[int, int], list[int]]:
        """Pieces that connectivity does not tell apart, by their size and the sum of colours."""
        order = np.argsort(self.part_of, kind="stable")
        firsts = np.flatnonzero(np.diff(self.part_of[order], prepend=-1))
        sums = np.add.reduceat(mixed(self.colouring.vertices)[order], firsts)
        alike: dict[tuple[int, int], list[int]] = defaultdict(list)
        for part, total in enumerate(sums.tolist()):
            alike[len(self.vertices[part]), total].append(part)
        return dict(alike)

    def rarest(self, part: int) -> tuple[int, np.uint64]:
        """A corner of the rarest colour of a piece, and that colour."""
        corners = self.corners[part]
        colours = self.colouring.corners[corners]
        values, firsts, counts = np.unique(colours, return_index=True, return_counts=True)
        least = int(np.argmin(counts))
        return int(corners[firsts[least]]), values[least]

    def coloured(self, part: int, colour: np.uint64) -> NDArray[np.int64]:
        """The corners of a piece that have a colour."""
        corners = self.corners[part]
        return np.asarray(corners[self.colouring.corners[corners] == colour])

    def walk(self, corner: int) -> Walk:
        """The walk from a corner, made once."""
        if corner not in self._walks:
            self._walks[corner] = Walk.of(self.half_edges, corner)
        return self._walks[corner]

    def piece(self, part: int, points: NDArray[np.float64]) -> Piece:
        """A piece numbered for itself, at positions of its vertices."""
        return Piece(self.half_edges, self.vertices[part], points)


def _grouped(numbers: NDArray[np.integer], count: int) -> list[NDArray[np.int64]]:
    """The places at which each of the numbers 0 to ``count - 1`` stands."""
    order = np.argsort(numbers, kind="stable").astype(np.int64)
    return np.split(order, np.searchsorted(numbers[order], np.arange(1, count)))
