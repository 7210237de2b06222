"""One matched corner determines all: a walk over polygons, and the same walk on another mesh.

On an oriented surface, "the next corner of the polygon" and "the corner across the edge" lead from
one corner to every other of its piece. The walk is written down once and followed from any number
of corners of the other mesh at the same time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.half_edges import HalfEdges

__all__ = ["Walk"]

# Images of corners that are worked on at a time.
_AT_ONCE = 4_000_000


@dataclass(frozen=True, eq=False)
class _Step:
    across: bool
    sources: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Walk:
    """A walk from one corner.

    Attributes:
        half_edges: The mesh it was made on.
        corners: (N,) the corners in the order they are reached.
        steps: From which of those reached before, and whether across the edge.
    """

    half_edges: HalfEdges
    corners: NDArray[np.int64]
    steps: tuple[_Step, ...]

    @classmethod
    def of(cls, half_edges: HalfEdges, seed: int) -> Walk:
        """The walk to all corners that can be reached from one."""
        place = np.full(len(half_edges.start) + 1, -1, dtype=np.int64)
        place[-1] = 0  # where twin is -1: never to be reached
        place[seed] = 0
        reached = [np.array([seed], dtype=np.int64)]
        count, steps, frontier = 1, [], reached[0]
        while frontier.size:
            new = []
            for across, table in ((False, half_edges.following), (True, half_edges.twin)):
                ends = table[frontier]
                fresh = np.flatnonzero(place[ends] < 0)
                if not fresh.size:
                    continue
                ends, firsts = np.unique(ends[fresh], return_index=True)
                steps.append(_Step(across, place[frontier[fresh[firsts]]]))
                place[ends] = count + np.arange(len(ends))
                count += len(ends)
                new.append(ends)
            frontier = np.concatenate(new) if new else np.empty(0, dtype=np.int64)
            reached += new
        return cls(half_edges, np.concatenate(reached), tuple(steps))

    def images(self, other: HalfEdges, seeds: NDArray[np.int64]) -> list[NDArray[np.int64]]:
        """The corners of another mesh that the same walk reaches, where it fits exactly.

        Args:
            other: The half-edges of the other mesh.
            seeds: (K,) corners to begin at.

        Returns:
            (N,) corners for each seed from which each polygon lands on a polygon of the same
            size, and each vertex on one vertex of its own.
        """
        chunk = max(1, _AT_ONCE // max(1, len(self.corners)))
        found: list[NDArray[np.int64]] = []
        for start in range(0, len(seeds), chunk):
            images = self._followed(other, seeds[start : start + chunk])
            found += [image for image in images if self._fits(other, image)]
        return found

    def _followed(self, other: HalfEdges, seeds: NDArray[np.int64]) -> NDArray[np.int64]:
        nowhere = len(other.start)
        following = np.append(other.following, nowhere)
        twin = np.append(np.where(other.twin < 0, nowhere, other.twin), nowhere)
        images = np.empty((len(seeds), len(self.corners)), dtype=np.int64)
        images[:, 0] = seeds
        count = 1
        for step in self.steps:
            table = twin if step.across else following
            stop = count + len(step.sources)
            images[:, count:stop] = table[images[:, step.sources]]
            count = stop
        return images

    def _fits(self, other: HalfEdges, image: NDArray[np.int64]) -> bool:
        if image.max() >= len(other.start):
            return False
        here = self.half_edges
        corner_to = np.full(len(here.start), -1, dtype=np.int64)
        corner_to[self.corners] = image
        if not np.array_equal(other.following[image], corner_to[here.following[self.corners]]):
            return False
        mine, theirs = here.start[self.corners], other.start[image]
        forth = np.full(here.vertex_count, -1, dtype=np.int64)
        back = np.full(other.vertex_count, -1, dtype=np.int64)
        forth[mine], back[theirs] = theirs, mine
        return bool((forth[mine] == theirs).all() and (back[theirs] == mine).all())
