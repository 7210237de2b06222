"""Take the vertices that no edge loop was left for into the curves beside them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import hypot

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves.selection import Threads

__all__ = ["mend_scraps"]

_SHORTEST = 3


def mend_scraps(
    threads: Threads,
    fixed: NDArray[np.bool_],
    edges: NDArray[np.int32],
    vertices: NDArray[np.float64],
) -> None:
    """Join curves of one or two vertices to longer ones, changing ``threads`` in place.

    In this order, and of several possibilities of a kind the straightest:

    1. append a scrap to the end of an open curve, or to another scrap;
    2. insert it between two consecutive vertices that it is connected to;
    3. cut an open curve beside it in two and append it to one part, where the other keeps at
       least three vertices;
    4. open a closed curve beside it and append it there.

    What none of these can take stays: vertices without edges, components of two vertices, and
    places where everything around is fixed or too short to cut.

    Args:
        threads: The curves; vertices without links are curves of one vertex.
        fixed: (V,) bool, vertices that must keep their links.
        edges: (E, 2) int32, as ``Mesh.edges``.
        vertices: (V, 3) positions, which decide what is straight.
    """
    scrap = (threads.links < 0).all(axis=1) & ~fixed
    touching = edges[scrap[edges].any(axis=1)]
    touching = np.concatenate([touching, touching[:, ::-1]])
    touching = touching[scrap[touching[:, 0]] & ~fixed[touching[:, 1]]]
    around: dict[int, set[int]] = {}
    for vertex, neighbour in touching.tolist():
        around.setdefault(vertex, set()).add(neighbour)
    mender = _Mender(threads, vertices, around)
    waiting = sorted(around)
    for kinds in range(2, 5):
        changed = True
        while changed:
            changed = False
            for vertex in waiting:
                changed |= mender.mend(vertex, kinds)
            waiting = [vertex for vertex in waiting if mender.scrap(vertex)]


@dataclass(frozen=True, order=True)
class _Repair:
    """A change that takes a scrap into another curve; the best compares as the largest.

    Attributes:
        straightness: Mean cosine of the turns along the new piece of curve, from -1 to 1.
        joined: Pairs of vertices that become consecutive.
        parted: A pair that is consecutive no longer, or none.
    """

    straightness: float
    joined: tuple[tuple[int, int], ...]
    parted: tuple[int, int] | None


@dataclass(frozen=True, eq=False)
class _Mender:
    """The curves, and what is needed to judge a change to them.

    Attributes:
        threads: The curves, changed in place.
        vertices: (V, 3) positions.
        around: For each vertex that began as a scrap, those it may be joined to.
    """

    threads: Threads
    vertices: NDArray[np.float64]
    around: dict[int, set[int]]

    def mend(self, vertex: int, kinds: int) -> bool:
        """Make the best repair of the first kind that is possible; whether there was one."""
        scrap = self.scrap(vertex)
        if scrap:
            for repairs in (self._appended, self._inserted, self._cut, self._opened)[:kinds]:
                best = max(repairs(scrap), default=None)
                if best is not None:
                    self._apply(scrap, best)
                    return True
        return False

    def scrap(self, vertex: int) -> tuple[int, ...]:
        """The vertices of the curve of a vertex if they are one or two, else none."""
        beside = self._along(vertex)
        if not beside:
            return (vertex,)
        if len(beside) == 1 and len(self._along(beside[0])) == 1:
            return (vertex, beside[0])
        return ()

    def _along(self, vertex: int) -> list[int]:
        """The neighbours of a vertex along its curve."""
        return [other for other in self.threads.links[vertex].tolist() if other >= 0]

    def _contacts(self, scrap: tuple[int, ...]) -> Iterator[tuple[int, int, int]]:
        """An end of the scrap, its other end, and a vertex of another curve beside the first."""
        for end, far in {(scrap[0], scrap[-1]), (scrap[-1], scrap[0])}:
            for onto in self.around[end]:
                if onto not in scrap:
                    yield end, far, onto

    def _appended(self, scrap: tuple[int, ...]) -> Iterator[_Repair]:
        for end, far, onto in self._contacts(scrap):
            beside = self._along(onto)
            if len(beside) < 2:
                yield _Repair(self._straightness(*beside, onto, end, far), ((onto, end),), None)

    def _inserted(self, scrap: tuple[int, ...]) -> Iterator[_Repair]:
        for end, far, onto in self._contacts(scrap):
            for following in self._along(onto):
                if following in self.around[far] and following not in scrap:
                    straightness = self._straightness(onto, end, far, following)
                    yield _Repair(straightness, ((onto, end), (far, following)), (onto, following))

    def _cut(self, scrap: tuple[int, ...]) -> Iterator[_Repair]:
        for end, far, onto in self._contacts(scrap):
            beside = self._along(onto)
            if self.threads.on_ring[onto] or len(beside) < 2:
                continue
            for kept, parted in (beside, beside[::-1]):
                if self._has(_SHORTEST, parted, onto):
                    straightness = self._straightness(kept, onto, end, far)
                    yield _Repair(straightness, ((onto, end),), (onto, parted))

    def _opened(self, scrap: tuple[int, ...]) -> Iterator[_Repair]:
        for end, far, onto in self._contacts(scrap):
            if self.threads.on_ring[onto]:
                beside = self._along(onto)
                for kept, parted in (beside, beside[::-1]):
                    straightness = self._straightness(kept, onto, end, far)
                    yield _Repair(straightness, ((onto, end),), (onto, parted))

    def _has(self, count: int, vertex: int, behind: int) -> bool:
        """Whether an open curve has so many vertices from one on, away from the one behind it."""
        for _ in range(count - 1):
            onward = [other for other in self._along(vertex) if other != behind]
            if not onward:
                return False
            vertex, behind = onward[0], vertex
        return True

    def _straightness(self, *path: int) -> float:
        """The mean cosine of the turns along a path; 0 where it has none."""
        points = [self.vertices[vertex].tolist() for vertex in dict.fromkeys(path)]
        steps = [[b - a for a, b in zip(p, q, strict=True)] for p, q in pairwise(points)]
        cosines = [
            sum(a * b for a, b in zip(p, q, strict=True)) / (hypot(*p) * hypot(*q) or 1.0)
            for p, q in pairwise(steps)
        ]
        return sum(cosines) / len(cosines) if cosines else 0.0

    def _apply(self, scrap: tuple[int, ...], repair: _Repair) -> None:
        links, on_ring = self.threads.links, self.threads.on_ring
        if repair.parted is not None:
            one, other = repair.parted
            if on_ring[one]:
                if len(repair.joined) == 2:
                    on_ring[list(scrap)] = True
                else:
                    self._clear_ring(one)
            links[one, links[one].tolist().index(other)] = -1
            links[other, links[other].tolist().index(one)] = -1
        for one, other in repair.joined:
            links[one, links[one].tolist().index(-1)] = other
            links[other, links[other].tolist().index(-1)] = one

    def _clear_ring(self, start: int) -> None:
        """Mark the vertices of a closed curve as those of an open one."""
        behind, vertex = start, self._along(start)[0]
        self.threads.on_ring[start] = False
        while vertex != start:
            self.threads.on_ring[vertex] = False
            beside = self._along(vertex)
            behind, vertex = vertex, beside[1] if beside[0] == behind else beside[0]
