"""A mesh as curves that hold every vertex exactly once (Sec. 4.2 of the paper).

Runs of free vertices on edge loops, chosen best first until none of three is left.

Trace the edge loops of a mesh: every edge, followed straight on through every vertex.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import hypot

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves.network import Curve, CurveNetwork
from elastomorph.model.mesh import Mesh, require_mesh
from elastomorph.model.polygons import Polygons


def edge_loops(mesh: Mesh) -> tuple[Curve, ...]:
    """Every edge loop of a mesh; each edge lies on exactly one.

    A loop goes straight on through each vertex: to the opposite edge where an even number of edges
    meet, along the border at the border. It ends where the number is odd, where it arrives at a
    border from inside, and at edges shared by three or more polygons. A loop that passes twice
    through a vertex is cut there, so that no curve repeats a vertex.

    Args:
        mesh: Polygons of any size, in any number of components, wound either way.

    Returns:
        The loops, those of the lowest edge first. A vertex lies on several.

    Raises:
        MeshError: It is no mesh.
    """
    require_mesh(mesh, "what loops are traced on")
    loops = _cut_at_crossings(trace_loops(edge_ends(mesh.faces, len(mesh.vertices))))
    return tuple(
        Curve(vertices, closed)
        for vertices, closed in zip(loops.arrays(), loops.closed.tolist(), strict=True)
    )


def trace_loops(ends: EdgeEnds) -> Chains:
    """The vertices of every edge loop, uncut: a loop may pass through a vertex several times."""
    straight = straight_successors(ends).reshape(-1, 2)
    chains = ordered_chains(np.where(straight < 0, -1, straight >> 1).astype(np.int32))
    return _vertices_along(chains, ends.edges)


def _vertices_along(chains: Chains, edges: NDArray[np.int32]) -> Chains:
    """The vertices passed by chains of edges."""
    first, last = chains.offsets[:-1], chains.offsets[1:] - 1
    pairs = edges[chains.items]
    before = np.roll(pairs, 1, axis=0)
    before[first] = pairs[last]
    shared = (pairs[:, 0] == before[:, 0]) | (pairs[:, 0] == before[:, 1])
    start = np.where(shared, pairs[:, 0], pairs[:, 1])
    # The first edge of an open chain starts at the vertex that it does not share with the second.
    open_first, open_last = first[~chains.closed], last[~chains.closed]
    second = np.minimum(open_first + 1, open_last)
    onward = np.where(open_first == open_last, pairs[open_first, 1], start[second])
    start[open_first] = pairs[open_first].sum(axis=1) - onward
    final = pairs[open_last].sum(axis=1) - start[open_last]
    items = np.insert(start, open_last + 1, final)
    offsets = chains.offsets + np.concatenate([[0], np.cumsum(~chains.closed)])
    return Chains(items.astype(np.int32), offsets, chains.closed)


def _cut_at_crossings(loops: Chains) -> Chains:
    """Cut loops at every vertex that they pass more than once; the cut vertex ends both pieces."""
    previous = loops.previous_visits()
    again = previous >= 0
    crossed = again.copy()
    crossed[previous[again]] = True
    if not crossed.any():
        return loops
    owner = loops.owners()
    affected = np.zeros(len(loops.closed), dtype=np.bool_)
    affected[owner[crossed]] = True
    pieces: list[NDArray[np.int32]] = []
    closed: list[bool] = []
    for loop, vertices in enumerate(loops.arrays()):
        if not affected[loop]:
            pieces.append(vertices)
            closed.append(bool(loops.closed[loop]))
            continue
        cuts = np.flatnonzero(crossed[loops.offsets[loop] : loops.offsets[loop + 1]])
        if loops.closed[loop]:
            vertices = np.roll(vertices, -cuts[0])
            vertices = np.append(vertices, vertices[0])
            cuts = np.append(cuts - cuts[0], len(vertices) - 1)
        bounds = np.unique(np.concatenate([[0], cuts, [len(vertices) - 1]]))
        for start, stop in pairwise(bounds.tolist()):
            returns = bool(vertices[start] == vertices[stop])
            pieces.append(vertices[start : stop + (not returns)])
            closed.append(returns)
    lengths = np.array([len(piece) for piece in pieces])
    return Chains(
        np.concatenate(pieces), np.concatenate([[0], np.cumsum(lengths)]), np.array(closed)
    )


@dataclass(frozen=True, eq=False)
class EdgeEnds:
    """The edges of a mesh and the polygon corners between them.

    An *edge end* is one end of one edge: end ``2 e`` is edge e at its lower vertex, ``2 e + 1`` at
    its higher. Two ends at a vertex are neighbours where a polygon has its corner between them.
    No polygon's direction is used, so polygons may be wound either way.

    Attributes:
        edges: (E, 2) int32, every edge once, lower vertex first, ascending (as ``Mesh.edges``).
        neighbours: (2 E, 2) int32, the neighbouring ends, -1 for none.
        on_border: (2 E,) bool, ends with exactly one corner beside them.
    """

    edges: NDArray[np.int32]
    neighbours: NDArray[np.int32]
    on_border: NDArray[np.bool_]


def edge_ends(faces: Polygons, vertex_count: int) -> EdgeEnds:
    """The edges of some polygons, and which of their ends share a corner.

    A vertex repeated in a row within a polygon counts once. Where three or more corners meet in
    an edge end (a non-manifold edge), that end gets no neighbours.
    """
    starts, following = _corners(faces)
    stops = starts[following]
    edges, edge = _unique_edges(starts, stops, vertex_count)
    ahead = 2 * edge + (starts > stops)
    behind = np.empty_like(ahead)
    behind[following] = ahead ^ 1
    between = ahead != behind
    if not between.all():
        ahead, behind = ahead[between], behind[between]
    neighbours = np.full((2 * len(edges), 2), -1, dtype=np.int32)
    # Polygons wound alike fill one column each way; what finds its column taken tries the other.
    from_ahead = _entered(neighbours, 0, ahead, behind)
    from_behind = _entered(neighbours, 1, behind, ahead)
    crowding = np.concatenate(
        [_entered(neighbours, 1, *from_ahead)[0], _entered(neighbours, 0, *from_behind)[0]]
    )
    on_border = (neighbours[:, 0] < 0) != (neighbours[:, 1] < 0)
    if crowding.size:
        crowded = np.zeros(len(neighbours), dtype=np.bool_)
        crowded[crowding] = True
        neighbours[crowded] = -1
        neighbours[(neighbours >= 0) & crowded[neighbours]] = -1
    return EdgeEnds(edges, neighbours, on_border)


def _entered(
    neighbours: NDArray[np.int32], column: int, end: NDArray[np.int32], other: NDArray[np.int32]
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Enter ``other`` as a neighbour of ``end``, one for each end; returns those without room."""
    entry = np.arange(end.size, dtype=np.int32)
    last = np.empty(len(neighbours), dtype=np.int32)
    last[end] = entry
    fits = (last[end] == entry) & (neighbours[end, column] < 0)
    if fits.all():
        neighbours[end, column] = other
        return end[:0], other[:0]
    neighbours[end[fits], column] = other[fits]
    return end[~fits], other[~fits]


def _corners(faces: Polygons) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """The vertex of each corner and the corner after it, without repeats in a row."""
    starts, following = faces.indices, faces.next_corners
    repeated = starts == starts[following]
    if not repeated.any():
        return starts, following
    sizes = np.bincount(faces.corner_faces[~repeated], minlength=len(faces))
    sizes = sizes[sizes > 0]
    last = np.cumsum(sizes) - 1
    following = np.arange(1, int(sizes.sum()) + 1)
    following[last] = last - sizes + 1
    return starts[~repeated], following


def _unique_edges(
    starts: NDArray[np.int32], stops: NDArray[np.int32], vertex_count: int
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """The (E, 2) edges in ascending order, and which of them each (start, stop) is."""
    keys = np.minimum(starts, stops) * np.int64(vertex_count) + np.maximum(starts, stops)
    order = np.argsort(keys)
    keys = keys[order]
    first = np.ones(len(keys), dtype=np.bool_)
    first[1:] = keys[1:] != keys[:-1]
    edge = np.empty(len(keys), dtype=np.int32)
    edge[order] = np.cumsum(first, dtype=np.int32) - 1
    return np.stack(np.divmod(keys[first], vertex_count), axis=1).astype(np.int32), edge


def straight_successors(ends: EdgeEnds) -> NDArray[np.int32]:
    """(2 E,) int32, the edge end straight on from each across their vertex; an involution.

    In a full ring of n ends around a vertex that is the opposite one when n is even, and none
    (-1) when n is odd. In a fan with a border on both sides the two border edges continue each
    other and the edges between them end.
    """
    rings = ordered_chains(ends.neighbours)
    straight = np.full(len(ends.neighbours), -1, dtype=np.int32)
    full = np.flatnonzero(rings.closed & (rings.lengths % 2 == 0))
    full = full[np.argsort(rings.lengths[full], kind="stable")]
    sizes, begins = np.unique(rings.lengths[full], return_index=True)
    for size, same in zip(sizes.tolist(), np.split(full, begins[1:]), strict=False):
        ring = rings.items[rings.offsets[same, None] + np.arange(size)]
        straight[ring] = np.roll(ring, size // 2, axis=1)
    fan = ~rings.closed & (rings.lengths > 1)
    first, last = rings.items[rings.offsets[:-1][fan]], rings.items[rings.offsets[1:][fan] - 1]
    both = ends.on_border[first] & ends.on_border[last]
    first, last = first[both], last[both]
    straight[first], straight[last] = last, first
    return straight


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


_APPEND, _INSERT, _CUT, _OPEN = range(4)


def extract_curves(mesh: Mesh, keep: Iterable[Curve] = ()) -> CurveNetwork:
    """Curves along the edges of a mesh, with every vertex on exactly one.

    The curves are edge loops and parts of them: closed loops first, then the longest runs that are
    left. Vertices that no loop is left for are taken into the curves beside them. Length is
    counted in vertices.

    Args:
        mesh: Polygons of any size, in any number of components, or none at all.
        keep: Curves an artist has drawn. They are taken as they are, whether they follow edges or
            not; the rest of the mesh is covered around them.

    Returns:
        The kept curves, then the others, longest first. Consecutive vertices of those share an
        edge. A curve of one or two vertices is left only where no curve beside it could take it,
        such as a vertex without edges.

    Raises:
        MeshError: It is no mesh.
        CurveError: A kept curve names a vertex that the mesh does not have, or two share one.
    """
    require_mesh(mesh, "what curves are found on")
    vertex_count = len(mesh.vertices)
    kept = CurveNetwork(keep, vertex_count)
    fixed = kept.curve_of >= 0
    ends = edge_ends(mesh.faces, vertex_count)
    growing = choose_runs(trace_loops(ends), fixed.copy())
    join_short_curves(growing, fixed, ends.edges, mesh.vertices)
    chains = ordered_chains(growing.links)
    order = np.argsort(-chains.lengths, kind="stable")
    order = order[~fixed[chains.items[chains.offsets[:-1][order]]]]
    arrays, closed = chains.arrays(), chains.closed.tolist()
    found = (Curve(arrays[chain], closed[chain]) for chain in order.tolist())
    return CurveNetwork((*kept, *found), vertex_count)


def join_short_curves(
    growing: GrowingCurves,
    fixed: NDArray[np.bool_],
    edges: NDArray[np.int32],
    vertices: NDArray[np.float64],
) -> None:
    """Join curves of one or two vertices to longer ones, changing ``growing`` in place.

    In this order, and of several possibilities of a kind the straightest:

    1. append a short curve to the end of an open curve, or to another short one;
    2. insert it between two consecutive vertices that it is connected to;
    3. cut an open curve beside it in two and append it to one part, where the other keeps at
       least three vertices;
    4. open a closed curve beside it and append it there.

    What none of these can take stays: vertices without edges, components of two vertices, and
    places where everything around is too short to cut or ``fixed``, (V,) bool, to keep its links.
    """
    single = (growing.links < 0).all(axis=1) & ~fixed
    touching = edges[single[edges].any(axis=1)]
    touching = np.concatenate([touching, touching[:, ::-1]])
    touching = touching[single[touching[:, 0]] & ~fixed[touching[:, 1]]]
    around: dict[int, set[int]] = {}
    for vertex, neighbour in touching.tolist():
        around.setdefault(vertex, set()).add(neighbour)
    joining = _Joining(growing, vertices, around)
    waiting = sorted(around)
    for kinds in ((_APPEND, _INSERT), (_APPEND, _INSERT, _CUT), (_APPEND, _INSERT, _CUT, _OPEN)):
        changed = True
        while changed:
            changed = False
            for vertex in waiting:
                changed |= joining.join(vertex, kinds)
            waiting = [vertex for vertex in waiting if joining.short_curve(vertex)]


@dataclass(frozen=True, order=True)
class _Join:
    """A change: mean cosine of the turns along the new piece, pairs to join, and one to part."""

    straightness: float
    joined: tuple[tuple[int, int], ...]
    parted: tuple[int, int] | None


@dataclass(frozen=True, eq=False)
class _Joining:
    """Curves to change in place, (V, 3) positions, and what single vertices may be joined to."""

    growing: GrowingCurves
    vertices: NDArray[np.float64]
    around: dict[int, set[int]]

    def join(self, vertex: int, kinds: tuple[int, ...]) -> bool:
        """Make the best change of the first kind that is possible; whether there was one."""
        short = self.short_curve(vertex)
        for kind in kinds if short else ():
            best = max(self._possible(short, kind), default=None)
            if best is not None:
                self._apply(short, best)
                return True
        return False

    def short_curve(self, vertex: int) -> tuple[int, ...]:
        """The vertices of the curve of a vertex if they are one or two, else none."""
        beside = self._along(vertex)
        if not beside:
            return (vertex,)
        if len(beside) == 1 and len(self._along(beside[0])) == 1:
            return (vertex, beside[0])
        return ()

    def _along(self, vertex: int) -> list[int]:
        """The neighbours of a vertex along its curve."""
        return [other for other in self.growing.links[vertex].tolist() if other >= 0]

    def _possible(self, short: tuple[int, ...], kind: int) -> Iterator[_Join]:
        """The changes of a kind, from either end of a short curve to any curve beside it."""
        for end, far in {(short[0], short[-1]), (short[-1], short[0])}:
            for onto in self.around[end].difference(short):
                beside = self._along(onto)
                if kind == _APPEND and len(beside) < 2:
                    straight = self._straightness(*beside, onto, end, far)
                    yield _Join(straight, ((onto, end),), None)
                elif kind == _INSERT:
                    for following in self.around[far].intersection(beside).difference(short):
                        straight = self._straightness(onto, end, far, following)
                        joined = ((onto, end), (far, following))
                        yield _Join(straight, joined, (onto, following))
                elif kind >= _CUT and len(beside) == 2:
                    if self.growing.is_closed[onto] != (kind == _OPEN):
                        continue
                    for kept, parted in (beside, beside[::-1]):
                        if kind == _OPEN or self._is_long(parted, onto):
                            straight = self._straightness(kept, onto, end, far)
                            yield _Join(straight, ((onto, end),), (onto, parted))

    def _is_long(self, vertex: int, behind: int) -> bool:
        """Whether what is left of an open curve, from a vertex onwards, is no short curve."""
        for _ in range(SHORTEST - 1):
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

    def _apply(self, short: tuple[int, ...], join: _Join) -> None:
        links, is_closed = self.growing.links, self.growing.is_closed
        if join.parted is not None:
            one, other = join.parted
            if is_closed[one]:
                if len(join.joined) == 2:
                    is_closed[list(short)] = True
                else:
                    self._mark_open(one)
            links[one, links[one].tolist().index(other)] = -1
            links[other, links[other].tolist().index(one)] = -1
        for one, other in join.joined:
            links[one, links[one].tolist().index(-1)] = other
            links[other, links[other].tolist().index(-1)] = one

    def _mark_open(self, start: int) -> None:
        """Mark the vertices of a closed curve as those of an open one."""
        behind, vertex = start, self._along(start)[0]
        self.growing.is_closed[start] = False
        while vertex != start:
            self.growing.is_closed[vertex] = False
            beside = self._along(vertex)
            behind, vertex = vertex, beside[1] if beside[0] == behind else beside[0]
