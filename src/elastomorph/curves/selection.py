"""Runs of free vertices on edge loops, chosen best first until none of three is left."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

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


@dataclass(frozen=True, eq=False)
class Chains:
    """Sequences of indices, stored one after another.

    Attributes:
        items: (N,) int32, the K sequences end to end.
        offsets: (K + 1,) int64, where each starts.
        closed: (K,) bool, whether the last item is followed by the first.
    """

    items: NDArray[np.int32]
    offsets: NDArray[np.int64]
    closed: NDArray[np.bool_]

    @property
    def lengths(self) -> NDArray[np.int64]:
        """(K,) number of items of each sequence."""
        return np.diff(self.offsets)

    def owners(self) -> NDArray[np.int32]:
        """(N,) int32, the sequence each entry of ``items`` belongs to."""
        return np.repeat(np.arange(len(self.closed), dtype=np.int32), self.lengths)

    def previous_visits(self) -> NDArray[np.int64]:
        """(N,) the last earlier entry of the same sequence and item, -1 for none."""
        count = len(self.items)
        item, entry = np.divmod(
            np.sort(self.items.astype(np.int64) * count + np.arange(count)), max(count, 1)
        )
        owner = self.owners()[entry]
        again = np.flatnonzero((item[1:] == item[:-1]) & (owner[1:] == owner[:-1])) + 1
        previous = np.full(count, -1, dtype=np.int64)
        previous[entry[again]] = entry[again - 1]
        return previous

    def only(self, kept: NDArray[np.bool_]) -> Chains:
        """Some of the sequences, of (K,) bool those to keep."""
        if kept.all():
            return self
        offsets = np.concatenate([[0], np.cumsum(self.lengths[kept])])
        return Chains(self.items[np.repeat(kept, self.lengths)], offsets, self.closed[kept])

    def arrays(self) -> list[NDArray[np.int32]]:
        """The sequences as separate views of ``items``."""
        return [self.items[start:stop] for start, stop in pairwise(self.offsets.tolist())]


def ordered_chains(links: NDArray[np.int32]) -> Chains:
    """Walk every chain of a graph in which nothing has more than two neighbours.

    An open chain starts at its end of lower index, a closed one at its lowest index in the
    direction of the lower neighbour. Chains come in the order of their lowest index. The work is
    linear: all chains are strung into one path, which a single breadth-first search walks.

    Links are (N, 2) int32, the neighbours of each item, -1 for none; symmetric, never an item
    itself. Two items linked twice form a closed chain.
    """
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import breadth_first_order, connected_components

    count = len(links)
    if count == 0:
        return Chains(np.empty(0, np.int32), np.zeros(1, np.int64), np.empty(0, np.bool_))
    itself = np.arange(count, dtype=np.int32)
    weights = np.ones(2 * count)
    indptr = np.arange(0, 2 * count + 1, 2, dtype=np.int32)

    def graph(neighbours: NDArray[np.int32]) -> csr_matrix:
        filled = np.where(neighbours < 0, itself[:, None], neighbours)
        return csr_matrix((weights, filled.reshape(-1), indptr), shape=(count, count))

    # On a symmetric graph weak components need no transpose, unlike undirected ones.
    chain_count, label = connected_components(graph(links), directed=True, connection="weak")
    path = np.array(links)
    ends = np.flatnonzero((links < 0).any(axis=1))
    start = np.full(chain_count, -1, dtype=np.int32)
    stop = np.full(chain_count, -1, dtype=np.int32)
    start[label[ends[::-1]]] = ends[::-1]  # where indices repeat, the last assignment stays
    stop[label[ends]] = ends
    closed = start < 0
    if closed.any():
        inside = np.flatnonzero(closed[label])[::-1]
        start[label[inside]] = inside
        first = start[closed]
        column = np.argmax(links[first], axis=1)
        last = links[first, column]
        path[first, column] = -1
        back = np.where(links[last, 0] == first, 0, 1)
        path[last, back] = -1
        stop[closed] = last
    for here, there in ((start[1:], stop[:-1]), (stop[:-1], start[1:])):
        free = np.where(path[here, 0] < 0, 0, 1)
        path[here, free] = there
    items = breadth_first_order(graph(path), int(start[0]), return_predecessors=False)
    lengths = np.bincount(label, minlength=chain_count)
    offsets = np.concatenate([[0], np.cumsum(lengths)])
    return Chains(items.astype(np.int32, copy=False), offsets, closed)
