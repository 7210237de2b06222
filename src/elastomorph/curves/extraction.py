"""A mesh as curves that hold every vertex exactly once (Sec. 4.2 of the paper)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import hypot

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves.loops import edge_ends, trace_loops
from elastomorph.curves.network import Curve, CurveNetwork
from elastomorph.curves.selection import SHORTEST, GrowingCurves, choose_runs, ordered_chains
from elastomorph.model.mesh import Mesh, require_mesh

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
