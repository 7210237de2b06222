"""Colour refinement (Weisfeiler-Leman): vertices are told apart by their surroundings alone.

Each round, the colour of a vertex takes in those of the polygon corners around it, in their order
round the polygon. Two numberings of one mesh give the same colours, so vertices of a rare colour
are few candidates for each other, and parts of different colours are different parts. A reversed
polygon has other colours. Colours are 64-bit hashes; equal ones by accident can only make a search
fail, for what it finds is checked polygon by polygon.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.connectivity import HalfEdges

__all__ = ["Colouring", "mixed"]

Hashes = NDArray[np.uint64]

_ROUNDS = 256


def mixed(values: Hashes) -> Hashes:
    """Every bit of the result depends on every bit of the value (as SplitMix64 ends)."""
    x = values + np.uint64(0x9E3779B97F4A7C15)
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return np.asarray(x ^ (x >> np.uint64(31)))


class Colouring:
    """The colours of a mesh, refined as far as asked.

    Attributes:
        vertices: (V,) uint64.
        corners: (C,) uint64, of the last round.
        rounds: Rounds so far.
    """

    def __init__(self, half_edges: HalfEdges, seeds: Iterable[int] = ()) -> None:
        """Start with one colour for all vertices but the seeds, which have one each, in order."""
        half = half_edges
        self._half = half
        self._order = np.argsort(half.start, kind="stable")
        ordered = half.start[self._order]
        self._firsts = np.flatnonzero(np.diff(ordered, prepend=-1))
        self._used = ordered[self._firsts]
        self._sides = mixed((half.alike * 64 + half.against).astype(np.uint64))
        self.vertices: Hashes = np.ones(half.vertex_count, dtype=np.uint64)
        for number, vertex in enumerate(seeds):
            self.vertices[vertex] = mixed(np.array([number + 2], dtype=np.uint64))[0]
        self.corners: Hashes = np.zeros(len(half.start), dtype=np.uint64)
        self.rounds = 0

    def advance(self) -> None:
        """One round."""
        half = self._half
        self.rounds += 1
        if not len(half.start):
            return
        own = self.vertices[half.start]
        # Multiplied by different numbers, so that before and after are not the same.
        around = mixed(own[half.following] * np.uint64(3) + self._sides)
        around += mixed(own[half.previous] * np.uint64(5) + self._sides[half.previous])
        corners = mixed(own + mixed(around))
        faces: Hashes = np.add.reduceat(corners, half.faces.offsets[:-1], dtype=np.uint64)
        self.corners = mixed(corners + np.uint64(7) * faces[half.faces.corner_faces])
        sums: Hashes = np.add.reduceat(self.corners[self._order], self._firsts, dtype=np.uint64)
        self.vertices = self.vertices.copy()
        self.vertices[self._used] = mixed(self.vertices[self._used] * np.uint64(11) + sums)

    def settle(self, part_of: NDArray[np.integer]) -> None:
        """Go on until each part (V,) has a vertex of its own colour, or its colours are final."""
        before = np.zeros(int(part_of.max()) + 1, dtype=np.int64)
        own = mixed(part_of.astype(np.uint64))
        while self.rounds < _ROUNDS:
            self.advance()
            _, firsts, counts = np.unique(
                mixed(self.vertices + own), return_index=True, return_counts=True
            )
            parts = part_of[firsts]
            number, unique = (
                np.bincount(parts[chosen], minlength=len(before))
                for chosen in (slice(None), counts == 1)
            )
            if ((unique > 0) | (number == before)).all():
                return
            before = number

    def exhaust(self) -> None:
        """Go on until no round tells more vertices apart."""
        before = 0
        while self.rounds < _ROUNDS:
            self.advance()
            number = len(np.unique(self.vertices))
            if number in (before, len(self.vertices)):
                return
            before = number
