"""Order things that are linked to at most two others: the one traversal all curves come from."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray


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
