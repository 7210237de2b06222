"""Choose among crossing edge loops, best first, until no run of three vertices is left."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves.chains import Chains

__all__ = ["SHORTEST", "GrowingCurves", "choose_runs"]

SHORTEST = 3


@dataclass(frozen=True, eq=False)
class GrowingCurves:
    """Curves under construction: which vertices follow each other.

    Attributes:
        links: (V, 2) int32, the neighbours of each vertex along its curve, -1 for none.
        is_closed: (V,) bool, whether its curve is closed.
    """

    links: NDArray[np.int32]
    is_closed: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class _Visits:
    """What is left of the loops: one entry for each time a loop passes through a free vertex.

    Attributes:
        vertex: (N,) the vertex.
        loop: (N,) the loop.
        place: (N,) where the loop passes it, counted through all loops, ascending.
        previous: (N,) ``place`` of the last earlier visit of the same loop to the same vertex.
        uncut: (L,) bool, loops that are closed and that nothing was taken of yet.
        simple: (L,) bool, loops that pass through no vertex twice.
    """

    vertex: NDArray[np.int32]
    loop: NDArray[np.int32]
    place: NDArray[np.int64]
    previous: NDArray[np.int64]
    uncut: NDArray[np.bool_]
    simple: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class _Runs:
    """Candidates for curves: of each free run the longest part without a repeated vertex.

    Attributes:
        start: (K,) first entry of each in the visits.
        length: (K,) number of vertices.
        closed: (K,) bool.
    """

    start: NDArray[np.int64]
    length: NDArray[np.int64]
    closed: NDArray[np.bool_]

    def only(self, kept: NDArray[np.bool_]) -> _Runs:
        """Some of the candidates."""
        return _Runs(self.start[kept], self.length[kept], self.closed[kept])

    def entries(self) -> NDArray[np.int64]:
        """The entries of all candidates, one candidate after another."""
        stop = np.cumsum(self.length)
        entries = np.repeat(self.start - (stop - self.length), self.length)
        entries += np.arange(len(entries))
        return entries


def choose_runs(loops: Chains, taken: NDArray[np.bool_]) -> GrowingCurves:
    """Choose vertex-disjoint runs of loops, best first.

    Closed loops come before open runs: they are what modellers lay around eyes and mouth, and the
    series of the paper is periodic along them. Of closed loops, the one whose crossing closed
    loops have the fewest vertices in all comes first. Where two families of parallel loops cross,
    each loop of one crosses all of the other, so the larger family wins as a whole. Of open runs,
    the longest comes first. Ties go to the longer, then to the one with the lowest vertex.

    Taking a run cuts the loops that cross it, and what is left of them competes again with its new
    length. All runs that outrank every run they cross are taken at once; a round costs the same
    whether it takes one or a thousand.

    Args:
        loops: Vertices along every edge loop.
        taken: (V,) bool, vertices that are not to be used; those chosen are added in place.

    Returns:
        The chosen runs, each of at least three vertices.
    """
    growing = GrowingCurves(
        np.full((len(taken), 2), -1, dtype=np.int32), np.zeros(len(taken), dtype=np.bool_)
    )
    strongest = np.empty(len(taken), dtype=np.int32)
    visits = _as_visits(loops)
    while True:
        visits = _free(visits, taken)
        runs = _candidates(visits)
        runs = runs.only(runs.length >= SHORTEST)
        if len(runs.start) == 0:
            return growing
        vertex = visits.vertex[runs.entries()]
        rank = _ranks(runs, vertex, len(taken))
        claims = np.repeat(rank, runs.length)
        strongest[vertex] = len(rank)
        np.minimum.at(strongest, vertex, claims)
        first = np.cumsum(runs.length) - runs.length
        chosen = runs.only(np.logical_and.reduceat(strongest[vertex] == claims, first))
        _enter(growing, visits.vertex[chosen.entries()], chosen)
        taken[visits.vertex[chosen.entries()]] = True


def _ranks(runs: _Runs, vertex: NDArray[np.int32], vertex_count: int) -> NDArray[np.int32]:
    """The rank of each run, 0 for the best.

    Args:
        runs: The runs.
        vertex: Their vertices, one run after another.
        vertex_count: Number of vertices V.
    """
    first = np.cumsum(runs.length) - runs.length
    own = np.repeat(np.where(runs.closed, runs.length, 0), runs.length)
    passing = np.bincount(vertex, weights=own, minlength=vertex_count)
    crossed = np.where(runs.closed, np.add.reduceat(passing[vertex] - own, first), 0.0)
    lowest = np.minimum.reduceat(vertex, first)
    order = np.lexsort((lowest, -runs.length, crossed, ~runs.closed))
    rank = np.empty(len(order), dtype=np.int32)
    rank[order] = np.arange(len(order))
    return rank


def _as_visits(loops: Chains) -> _Visits:
    previous = loops.previous_visits()
    items = loops.items
    owner = loops.owners()
    simple = np.ones(len(loops.closed), dtype=np.bool_)
    simple[owner[previous >= 0]] = False
    crossing = np.flatnonzero(loops.closed & ~simple)
    if crossing.size:
        # A closed loop through a vertex twice cannot be one curve: start it where most is kept.
        items = items.copy()
        for loop in crossing.tolist():
            part = slice(loops.offsets[loop], loops.offsets[loop + 1])
            items[part] = np.roll(items[part], -_longest_simple_start(items[part]))
        previous = Chains(items, loops.offsets, loops.closed).previous_visits()
    return _Visits(items, owner, np.arange(len(items)), previous, loops.closed, simple)


def _longest_simple_start(vertices: NDArray[np.int32]) -> int:
    """Where the longest cyclic part without a repeated vertex starts."""
    twice = np.concatenate([vertices, vertices])
    span = Chains(twice, np.array([0, len(twice)]), np.zeros(1, np.bool_))
    first = np.maximum.accumulate(span.previous_visits() + 1)
    return int(first[np.argmax(np.arange(len(twice)) - first)]) % len(vertices)


def _free(visits: _Visits, taken: NDArray[np.bool_]) -> _Visits:
    """The visits to vertices that are still free."""
    gone = taken[visits.vertex]
    if not gone.any():
        return visits
    hit = np.zeros(len(visits.uncut), dtype=np.bool_)
    hit[visits.loop[gone]] = True
    if (hit & visits.uncut).any():
        visits = _started_at_cuts(visits, hit & visits.uncut, gone)
        gone = taken[visits.vertex]
    free = ~gone
    return _Visits(
        visits.vertex[free],
        visits.loop[free],
        visits.place[free],
        visits.previous[free],
        visits.uncut & ~hit,
        visits.simple,
    )


def _started_at_cuts(visits: _Visits, hit: NDArray[np.bool_], gone: NDArray[np.bool_]) -> _Visits:
    """Closed loops turned to start after a vertex that is gone, so that no run wraps around."""
    inside = np.flatnonzero(hit[visits.loop])
    loop = visits.loop[inside]
    begins = np.diff(loop, prepend=-1) != 0
    first, block = np.flatnonzero(begins), np.cumsum(begins) - 1
    lengths = np.diff(first, append=len(loop))
    step = np.arange(len(loop)) - first[block]
    last_gone = np.zeros(len(first), dtype=np.int64)
    lost = np.flatnonzero(gone[inside])
    last_gone[block[lost]] = step[lost]
    source = inside[first[block] + (step + last_gone[block] + 1) % lengths[block]]
    vertex, previous = visits.vertex.copy(), visits.previous.copy()
    vertex[inside] = visits.vertex[source]
    if not visits.simple[hit].all():
        turned = Chains(vertex[inside], np.append(first, len(loop)), np.ones(len(first), np.bool_))
        before = turned.previous_visits()
        previous[inside] = np.where(before < 0, -1, visits.place[inside[before]])
    return replace(visits, vertex=vertex, previous=previous)


def _candidates(visits: _Visits) -> _Runs:
    count = len(visits.vertex)
    if count == 0:
        nothing = np.empty(0, dtype=np.int64)
        return _Runs(nothing, nothing, np.empty(0, dtype=np.bool_))
    begins = np.ones(count, dtype=np.bool_)
    begins[1:] = (np.diff(visits.place) != 1) | (np.diff(visits.loop) != 0)
    start = np.flatnonzero(begins)
    length = np.diff(start, append=count)
    loop = visits.loop[start]
    closed = visits.uncut[loop] & visits.simple[loop]
    if (visits.previous >= 0).any():
        floor = np.repeat(visits.place[start], length)
        first = np.maximum.accumulate(np.maximum(floor, visits.previous + 1))
        extent = visits.place - first + 1
        longest = np.maximum.reduceat(extent, start)
        peak = np.flatnonzero(extent == np.repeat(longest, length))
        run = np.repeat(np.arange(len(start)), length)[peak]
        last = peak[np.flatnonzero(np.diff(run, prepend=-1))]
        return _Runs(last - longest + 1, longest, closed)
    return _Runs(start, length, closed)


def _enter(growing: GrowingCurves, vertex: NDArray[np.int32], runs: _Runs) -> None:
    """Enter runs whose vertices lie one after another."""
    stop = np.cumsum(runs.length)
    start = stop - runs.length
    before, after = np.roll(vertex, 1), np.roll(vertex, -1)
    before[start] = np.where(runs.closed, vertex[stop - 1], -1)
    after[stop - 1] = np.where(runs.closed, vertex[start], -1)
    growing.links[vertex, 0], growing.links[vertex, 1] = before, after
    growing.is_closed[vertex] = np.repeat(runs.closed, runs.length)
