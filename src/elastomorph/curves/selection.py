"""Choose among crossing edge loops, best first, until no run of three vertices is left."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves.chains import Chains

SHORTEST = 3


@dataclass(frozen=True, eq=False)
class GrowingCurves:
    """Curves in the making: (V, 2) int32 neighbours of each vertex along its curve, -1: none."""

    links: NDArray[np.int32]
    is_closed: NDArray[np.bool_]


def choose_runs(loops: Chains, taken: NDArray[np.bool_]) -> GrowingCurves:
    """Choose vertex-disjoint runs of loops, each of at least three vertices, best first.

    Closed loops come before open runs: they are what modellers lay around eyes and mouth, and the
    series of the paper is periodic along them. Of closed loops, the one whose crossing closed
    loops have the fewest vertices in all comes first. Where two families of parallel loops cross,
    each loop of one crosses all of the other, so the larger family wins as a whole. Of open runs,
    the longest comes first. Ties go to the longer, then to the one with the lowest vertex.

    Taking a run cuts the loops that cross it, and what is left of them competes again with its new
    length. All runs that outrank every run they cross are taken at once; a round costs the same
    whether it takes one or a thousand. What is taken is added to ``taken``, (V,) bool, in place.
    """
    growing = GrowingCurves(
        np.full((len(taken), 2), -1, dtype=np.int32), np.zeros(len(taken), dtype=np.bool_)
    )
    strongest = np.empty(len(taken), dtype=np.int32)
    loops, simple = _started_at_longest_part(loops)
    while True:
        loops = _without(loops, taken)
        runs = loops if simple else _longest_parts(loops)
        runs = runs.only(runs.lengths >= SHORTEST)
        if len(runs.closed) == 0:
            return growing
        rank = _ranks(runs, len(taken))
        claims = np.repeat(rank, runs.lengths)
        strongest[runs.items] = len(rank)
        np.minimum.at(strongest, runs.items, claims)
        best = strongest[runs.items] == claims
        chosen = runs.only(np.logical_and.reduceat(best, runs.offsets[:-1]))
        _enter(growing, chosen)
        taken[chosen.items] = True


def _started_at_longest_part(loops: Chains) -> tuple[Chains, bool]:
    """Closed loops that pass a vertex twice, started where most is kept; whether none passes two.

    Such a loop cannot be one curve: only its longest part without a repeated vertex can.
    """
    repeated = loops.previous_visits() >= 0
    if not repeated.any():
        return loops, True
    items = loops.items.copy()
    crossing = np.unique(loops.owners()[repeated])
    for loop in crossing[loops.closed[crossing]].tolist():
        part = slice(loops.offsets[loop], loops.offsets[loop + 1])
        vertices = items[part]
        twice = np.concatenate([vertices, vertices])
        span = Chains(twice, np.array([0, len(twice)]), np.zeros(1, np.bool_))
        first = np.maximum.accumulate(span.previous_visits() + 1)
        start = int(first[np.argmax(np.arange(len(twice)) - first)]) % len(vertices)
        items[part] = np.roll(vertices, -start)
    return Chains(items, loops.offsets, loops.closed), False


def _without(loops: Chains, taken: NDArray[np.bool_]) -> Chains:
    """What is left of loops when vertices are taken: closed ones start after one of these."""
    items, gone = loops.items, taken[loops.items]
    lost = np.flatnonzero(gone)
    if not lost.size:
        return loops
    owner = loops.owners()
    hit = np.zeros(len(loops.closed), dtype=np.bool_)
    hit[owner[lost]] = True
    turned = np.flatnonzero((hit & loops.closed)[owner])
    if turned.size:
        begin, length = loops.offsets[:-1][owner[turned]], loops.lengths[owner[turned]]
        shift = np.zeros(len(loops.closed), dtype=np.int64)
        shift[owner[lost]] = lost + 1  # of several, the last assignment stays
        source = begin + (turned + shift[owner[turned]] - 2 * begin) % length
        items = items.copy()
        items[turned], gone[turned] = items[source], gone[source]
    begins = np.roll(gone, 1)
    begins[loops.offsets[:-1]] = True
    free = np.flatnonzero(~gone)
    starts = np.flatnonzero(begins[free])
    closed = (loops.closed & ~hit)[owner[free[starts]]]
    return Chains(items[free], np.append(starts, len(free)), closed)


def _longest_parts(loops: Chains) -> Chains:
    """Of each loop the longest part without a repeated vertex, closed if that is all of it."""
    previous = loops.previous_visits()
    if not len(previous) or previous.max() < 0:
        return loops
    owner = loops.owners()
    start = loops.offsets[:-1]
    first = np.maximum.accumulate(np.maximum(start[owner], previous + 1))
    extent = np.arange(len(owner)) - first + 1
    length = np.maximum.reduceat(extent, start)
    peak = np.flatnonzero(extent == length[owner])
    last = peak[np.flatnonzero(np.diff(owner[peak], prepend=-1))]
    offsets = np.concatenate([[0], np.cumsum(length)])
    entries = np.repeat(last + 1 - offsets[1:], length) + np.arange(offsets[-1])
    return Chains(loops.items[entries], offsets, loops.closed & (length == loops.lengths))


def _ranks(runs: Chains, vertex_count: int) -> NDArray[np.int32]:
    """The rank of each run, 0 for the best, on a mesh with so many vertices."""
    length, first = runs.lengths, runs.offsets[:-1]
    own = np.repeat(np.where(runs.closed, length, 0), length)
    passing = np.bincount(runs.items, weights=own, minlength=vertex_count)
    crossed = np.where(runs.closed, np.add.reduceat(passing[runs.items] - own, first), 0.0)
    lowest = np.minimum.reduceat(runs.items, first)
    order = np.lexsort((lowest, -length, crossed, ~runs.closed))
    rank = np.empty(len(order), dtype=np.int32)
    rank[order] = np.arange(len(order))
    return rank


def _enter(growing: GrowingCurves, runs: Chains) -> None:
    """Link the vertices of runs."""
    items, first, last = runs.items, runs.offsets[:-1], runs.offsets[1:] - 1
    before, after = np.roll(items, 1), np.roll(items, -1)
    before[first] = np.where(runs.closed, items[last], -1)
    after[last] = np.where(runs.closed, items[first], -1)
    growing.links[items, 0], growing.links[items, 1] = before, after
    growing.is_closed[items] = np.repeat(runs.closed, runs.lengths)
