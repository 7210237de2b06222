"""Which vertex of one file is which of another: an isomorphism of their polygons.

Vertices are told apart by colour refinement, matched by a traversal of half-edges or, where that
does not get everywhere, by backtracking; positions choose among the automorphisms.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, count

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.frames import frame_between
from elastomorph.doctor.neutral import HalfEdges
from elastomorph.model.geometry import component_of
from elastomorph.model.mesh import Mesh
from elastomorph.model.polygons import Polygons

# Are two lists of polygons the same: in another order, from another corner, reversed, or split?

# Polygons up to this size are compared with triangles they may have been split into.
_LARGEST = 16


def corresponding_corners(ours: Polygons, theirs: Polygons) -> NDArray[np.int64] | None:
    """(C,) for each corner of our polygons the same corner of theirs; None where they differ.

    Polygons are the same that name the same vertices in the same cyclic order; a reversed one is
    another polygon. Where a polygon is there twice, either may be taken.
    """
    if not np.array_equal(np.sort(ours.sizes), np.sort(theirs.sizes)):
        return None
    corners = np.empty(ours.indices.size, dtype=np.int64)
    for size in np.unique(ours.sizes).tolist():
        mine, my_rows = _sorted_rows(ours, size)
        their, their_rows = _sorted_rows(theirs, size)
        if not np.array_equal(my_rows, their_rows):
            return None
        corners[mine] = their
    return corners


def _sorted_rows(faces: Polygons, size: int) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """(F, n) corners and vertices of the polygons of one size, each from its least rotation."""
    starts = faces.offsets[:-1][faces.sizes == size]
    vertices = faces.indices[starts[:, None] + np.arange(size)]
    least = vertices == vertices.min(axis=1, keepdims=True)
    first = least.argmax(axis=1)
    for row in np.flatnonzero(least.sum(axis=1) > 1).tolist():
        turns = np.flatnonzero(least[row]).tolist()
        first[row] = min(turns, key=lambda turn, row=row: np.roll(vertices[row], -turn).tolist())  # type: ignore[misc]
    turned = (first[:, None] + np.arange(size)) % size
    rows = np.take_along_axis(vertices, turned, axis=1)
    order = np.lexsort(rows.T[::-1])
    return (starts[:, None] + turned)[order], rows[order]


def corners_either_way(
    ours: Polygons, theirs: Polygons
) -> tuple[NDArray[np.int64], NDArray[np.bool_]] | None:
    """As `corresponding_corners`, whichever way polygons run, and (F,) which of ours do not agree.

    None where the polygons do not even name the same vertices next to each other.
    """
    our_turns, their_turns = _runs_down(ours), _runs_down(theirs)
    found = corresponding_corners(
        reversed_polygons(ours, our_turns), reversed_polygons(theirs, their_turns)
    )
    if found is None:
        return None
    corners = np.empty_like(found)
    corners[reversed_corners(ours, our_turns)] = reversed_corners(theirs, their_turns)[found]
    partner = theirs.corner_faces[corners[ours.offsets[:-1]]]
    return corners, our_turns != their_turns[partner]


def _runs_down(faces: Polygons) -> NDArray[np.bool_]:
    """(F,) whether the vertex after the least is larger than the one before it."""
    if not len(faces):
        return np.zeros(0, dtype=bool)
    least = np.minimum.reduceat(faces.indices, faces.offsets[:-1])
    at = np.flatnonzero(faces.indices == least[faces.corner_faces])
    corner = at[np.unique(faces.corner_faces[at], return_index=True)[1]]
    starts, sizes = faces.offsets[:-1], faces.sizes
    before = starts + (corner - starts - 1) % sizes
    after = starts + (corner - starts + 1) % sizes
    return np.asarray(faces.indices[after] > faces.indices[before])


def reversed_corners(faces: Polygons, which: NDArray[np.bool_]) -> NDArray[np.int64]:
    """(C,) the corner to read at each place to reverse some polygons; each keeps its first."""
    place = np.arange(faces.indices.size)
    starts, sizes = faces.offsets[:-1][faces.corner_faces], faces.sizes[faces.corner_faces]
    backwards = starts + (starts - place) % sizes
    return np.asarray(np.where(which[faces.corner_faces], backwards, place), dtype=np.int64)


def reversed_polygons(faces: Polygons, which: NDArray[np.bool_] | None = None) -> Polygons:
    """The same polygons, some of them or all run the other way round."""
    which = np.ones(len(faces), dtype=bool) if which is None else which
    return Polygons(faces.indices[reversed_corners(faces, which)], faces.offsets)


def triangles_of(ours: Polygons, theirs: Polygons, count: int) -> NDArray[np.bool_] | None:
    """Whether triangles are our polygons split: (T,) which of them run the other way round.

    None where they are not; ``count`` is the number of vertices.
    """
    sizes = ours.sizes
    if not len(theirs) or (theirs.sizes != 3).any() or sizes.max(initial=0) == 3:
        return None
    if int((sizes - 2).sum()) != len(theirs) or sizes.max() > _LARGEST:
        return None
    rows = []
    for size in np.unique(sizes).tolist():
        starts = ours.offsets[:-1][sizes == size]
        polygons = ours.indices[starts[:, None] + np.arange(size)].astype(np.int64)
        rows += [polygons[:, list(three)] for three in combinations(range(size), 3)]
    allowed = np.concatenate(rows)
    wanted = _keys(theirs.indices.reshape(-1, 3).astype(np.int64), count)
    forwards = np.isin(wanted, _keys(allowed, count))
    if forwards.all():
        return ~forwards
    backwards = np.isin(wanted, _keys(allowed[:, ::-1], count))
    return ~forwards if (forwards | backwards).all() else None


def _keys(triangles: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """(T,) one number for each triangle and direction, whichever vertex comes first."""
    first = triangles.argmin(axis=1)[:, None]
    turned = np.take_along_axis(triangles, (first + np.arange(3)) % 3, axis=1)
    return np.asarray((turned[:, 0] * count + turned[:, 1]) * count + turned[:, 2])


# The connected parts of a mesh, told apart by colours, and how one part is laid on another.
#
# Vertices are told apart by their surroundings alone (colour refinement, Weisfeiler-Leman): each
# round, the colour of a vertex takes in those of the polygon corners around it, in their order
# round the polygon. Two numberings of one mesh give the same colours, so vertices of a rare
# colour are few candidates for each other, and parts of different colours are different parts. A
# reversed polygon has other colours. Colours are 64-bit hashes; equal ones by accident can only
# make a search fail, for what it finds is checked polygon by polygon.
#
# On an oriented surface, "the next corner of the polygon" and "the corner across the edge" lead
# from one corner to every other of its part. So one matched corner determines all: the traversal
# is recorded once and replayed from any number of corners of the other mesh at the same time.

Hashes = NDArray[np.uint64]

Corners = NDArray[np.int64]

# Images of corners that are worked on at a time.
_AT_ONCE = 4_000_000

_ROUNDS = 256


def mixed(values: Hashes) -> Hashes:
    """Every bit of the result depends on every bit of the value (as SplitMix64 ends)."""
    x = values + np.uint64(0x9E3779B97F4A7C15)
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return np.asarray(x ^ (x >> np.uint64(31)))


class Colouring:
    """The colours of vertices (V,) and, of the last round, corners (C,), refined as asked."""

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


class Parts:
    """The connected parts of one mesh: (V,) part of each vertex, and colours to tell them apart.

    ``faces`` stand in place of its own polygons, on the same edges; ``seeds`` have a colour of
    their own from the start. Colours are refined in so many rounds, those of the mesh it will be
    compared with; by default as many as it takes.
    """

    def __init__(
        self,
        mesh: Mesh,
        *,
        faces: Polygons | None = None,
        seeds: Sequence[int] = (),
        rounds: int | None = None,
    ) -> None:
        self.mesh, self.seeds = mesh, tuple(seeds)
        self.half_edges = HalfEdges.of(mesh.faces if faces is None else faces, len(mesh.vertices))
        self.part_of = component_of(len(mesh.vertices), mesh.edges)
        self.colouring = Colouring(self.half_edges, seeds)
        if rounds is None:
            self.colouring.settle(self.part_of)
        for _ in range(rounds or 0):
            self.colouring.advance()
        self._traversals: dict[int, _Traversal] = {}

    @cached_property
    def vertices(self) -> list[NDArray[np.int64]]:
        """The vertices of each part, rising."""
        return _grouped(self.part_of, int(self.part_of.max()) + 1)

    @cached_property
    def corners(self) -> list[Corners]:
        """The polygon corners of each part."""
        return _grouped(self.part_of[self.half_edges.start], int(self.part_of.max()) + 1)

    @cached_property
    def by_colour(self) -> dict[tuple[int, int], list[int]]:
        """Parts that connectivity does not tell apart, by their size and the sum of colours."""
        sums = np.zeros(len(self.vertices), dtype=np.uint64)
        np.add.at(sums, self.part_of, mixed(self.colouring.vertices))
        alike: dict[tuple[int, int], list[int]] = defaultdict(list)
        for part, total in enumerate(sums.tolist()):
            alike[len(self.vertices[part]), total].append(part)
        return dict(alike)

    def rarest(self, part: int) -> tuple[int, np.uint64]:
        """A corner of the rarest colour of a part, and that colour."""
        corners = self.corners[part]
        colours = self.colouring.corners[corners]
        values, firsts, counts = np.unique(colours, return_index=True, return_counts=True)
        least = int(np.argmin(counts))
        return int(corners[firsts[least]]), values[least]

    def coloured(self, part: int, colour: np.uint64) -> Corners:
        """The corners of a part that have a colour."""
        corners = self.corners[part]
        return np.asarray(corners[self.colouring.corners[corners] == colour])

    def images(self, corner: int, other: Parts, seeds: Corners) -> list[Corners] | None:
        """For each seed where the part of a corner fits, the other's corner for each of `reached`.

        None where the traversal does not reach the whole part.
        """
        part = self.part_of[self.half_edges.start[corner]]
        if len(self.reached(corner)) < len(self.corners[part]):
            return None
        traversal, half = self._traversals[corner], other.half_edges
        chunk = max(1, _AT_ONCE // max(1, len(traversal.corners)))
        found: list[Corners] = []
        for start in range(0, len(seeds), chunk):
            images = traversal.replayed(half, seeds[start : start + chunk])
            found += [image for image in images if traversal.fits(self.half_edges, half, image)]
        return found

    def reached(self, corner: int) -> Corners:
        """(N,) the corners that the traversal from a corner reaches, in its order."""
        if corner not in self._traversals:
            self._traversals[corner] = _Traversal.of(self.half_edges, corner)
        return self._traversals[corner].corners

    def alone(self, part: int) -> HalfEdges:
        """The polygons of a part, its vertices numbered from 0."""
        vertices, half = self.vertices[part], self.half_edges
        inside = np.full(half.vertex_count, -1, dtype=np.int64)
        inside[vertices] = np.arange(len(vertices))
        own = inside[half.start] >= 0
        faces = half.faces
        sizes = faces.sizes[own[faces.offsets[:-1]]] if len(faces) else faces.sizes
        polygons = Polygons(inside[half.start[own]], np.append(0, np.cumsum(sizes)))
        return HalfEdges.of(polygons, len(vertices))


def _grouped(numbers: NDArray[np.integer], count: int) -> list[NDArray[np.int64]]:
    """The places at which each of the numbers 0 to ``count - 1`` stands."""
    order = np.argsort(numbers, kind="stable").astype(np.int64)
    return np.split(order, np.searchsorted(numbers[order], np.arange(1, count)))


@dataclass(frozen=True, eq=False)
class _Traversal:
    """Breadth first from one corner: (N,) corners in the order they are reached, and the steps.

    Each step reaches the next few corners, across the edge or not, from some reached before.
    """

    corners: Corners
    steps: tuple[tuple[bool, NDArray[np.int64]], ...]

    @classmethod
    def of(cls, half_edges: HalfEdges, seed: int) -> _Traversal:
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
                steps.append((across, place[frontier[fresh[firsts]]]))
                place[ends] = count + np.arange(len(ends))
                count += len(ends)
                new.append(ends)
            frontier = np.concatenate(new) if new else np.empty(0, dtype=np.int64)
            reached += new
        return cls(np.concatenate(reached), tuple(steps))

    def replayed(self, other: HalfEdges, seeds: Corners) -> NDArray[np.int64]:
        """(K, N) the corners of another mesh that the same steps reach; C for nowhere."""
        nowhere = len(other.start)
        following = np.append(other.following, nowhere)
        twin = np.append(np.where(other.twin < 0, nowhere, other.twin), nowhere)
        images = np.empty((len(seeds), len(self.corners)), dtype=np.int64)
        images[:, 0] = seeds
        count = 1
        for across, sources in self.steps:
            stop = count + len(sources)
            images[:, count:stop] = (twin if across else following)[images[:, sources]]
            count = stop
        return images

    def fits(self, here: HalfEdges, other: HalfEdges, image: Corners) -> bool:
        """Whether each polygon lands on one of its size, and each vertex on one of its own."""
        if image.max() >= len(other.start):
            return False
        corner_to = np.full(len(here.start), -1, dtype=np.int64)
        corner_to[self.corners] = image
        if not np.array_equal(other.following[image], corner_to[here.following[self.corners]]):
            return False
        mine, theirs = here.start[self.corners], other.start[image]
        forth = np.full(here.vertex_count, -1, dtype=np.int64)
        back = np.full(other.vertex_count, -1, dtype=np.int64)
        forth[mine], back[theirs] = theirs, mine
        return bool((forth[mine] == theirs).all() and (back[theirs] == mine).all())


# Finds which vertex of a target is which of the neutral, from how they are connected.
#
# Parts are matched by their colours. Within a part one matched polygon corner determines all
# others, so a corner of the rarest colour is tried on every corner of that colour; parts joined
# at points, or that branch at edges, are matched by individualising a vertex, refining, and
# backtracking. Where several ways fit, or several parts are alike, positions choose, at the
# smallest sum of squared distances from where the part is expected: moved as the nearest vertex
# about which there is no doubt, for lashes go with the lid. Whatever is found is checked: the
# polygons must be those of the neutral, all of them.

# Corners tried for one part, nearest first, where symmetry makes more of them possible.
_TRIED = 256
# Vertices individualised for one part before backtracking gives up.
_ATTEMPTS = 400
# Parts alike, up to which each is compared with each; more are matched by their centres.
_EACH_WITH_EACH = 24
# Vertices that must be known before they can tell unit, axes and motion of the others.
_ENOUGH = 8


@dataclass(frozen=True, eq=False)
class Relabelling:
    """Which vertex and which corner of the target is which of the neutral."""

    new_index: NDArray[np.int64]  # (V,) number in the neutral of each vertex of the target
    corners: NDArray[np.int64]  # (C,) corner of the target for each corner of the neutral
    chosen: int  # parts for which connectivity left a choice that positions decided
    chosen_vertices: int  # how many vertices they have


@dataclass(frozen=True)
class Mismatch:
    """Why there is no relabelling, in words, and whether the pairs that were given are to blame."""

    reason: str
    seeds: bool = False


@dataclass(frozen=True, eq=False)
class _Match:
    """Their vertices for the vertices of one of our parts, and how many others would fit."""

    theirs: NDArray[np.int64]
    cost: float
    candidates: int


def find_relabelling(ours: Parts, target: Parts, *, scale: float = 1.2) -> Relabelling | Mismatch:
    """Match a target with a neutral by connectivity, and by position where that leaves a choice.

    Parts of the target are refined as often, with seeds in the same order. Sizes that differ by
    more than ``scale`` are brought to one size before positions are compared.
    """
    if {c: len(parts) for c, parts in ours.by_colour.items()} != {
        c: len(parts) for c, parts in target.by_colour.items()
    }:
        return _unequal(ours, target)
    search = _Search(ours, target, scale)
    if not search.match_all():
        return Mismatch("pieces that look alike do not fit on each other polygon by polygon")
    new_index = search.new_index
    broken = [(a, b) for a, b in _pairs(ours, target) if new_index[b] != a]
    if broken:
        return Mismatch(f"{_named(broken)}: the pairs contradict each other", True)
    renamed = Polygons(new_index[target.half_edges.start], target.half_edges.faces.offsets)
    corners = corresponding_corners(ours.half_edges.faces, renamed)
    if corners is None:
        return Mismatch("the polygons are connected in another way")
    return Relabelling(new_index, corners, search.chosen, search.chosen_vertices)


class _Search:
    def __init__(self, ours: Parts, target: Parts, scale: float) -> None:
        self.ours, self.theirs, self.scale = ours, target, scale
        self.here = self.expected = ours.mesh.vertices
        self.there = target.mesh.vertices
        self.new_index = np.full(len(self.there), -1, dtype=np.int64)
        self.chosen = self.chosen_vertices = 0

    def match_all(self) -> bool:
        groups = list(self.ours.by_colour.items())
        # What is unique tells in which unit and axes the rest has to be compared.
        undecided = []
        for colour, parts in groups:
            if len(parts) > 1 or colour[0] == 1:
                continue
            part, other = parts[0], self.theirs.by_colour[colour][0]
            if len(self._corners(part, other)) > 1:
                undecided.append(colour)
            elif not self._accept(part, self._match(part, other)):
                return False
        if undecided or any(len(parts) > 1 for _, parts in groups):
            self._expect()
        undecided += [c for c, parts in groups if len(parts) > 1 or c[0] == 1]
        return all(self._match_alike(colour) for colour in undecided)

    def _expect(self) -> None:
        """Where the rest should be: in unit and axes of the neutral, carried by what is known."""
        from scipy.spatial import cKDTree

        known = np.flatnonzero(self.new_index >= 0)
        if known.size < _ENOUGH:
            return
        here = self.here[self.new_index[known]]
        self.there = frame_between(here, self.there[known], self.scale).back(self.there)
        nearest = cKDTree(here).query(self.here)[1]
        self.expected = self.here + (self.there[known] - here)[nearest]

    def _accept(self, part: int, match: _Match | None, alike: int = 1) -> bool:
        if match is None:
            return False
        self.new_index[match.theirs] = self.ours.vertices[part]
        if match.candidates > 1 or alike > 1:
            self.chosen += 1
            self.chosen_vertices += len(match.theirs)
        return True

    def _match_alike(self, colour: tuple[int, int]) -> bool:
        """Match parts of the same colours with each other, at the least sum of squares."""
        mine, theirs = self.ours.by_colour[colour], self.theirs.by_colour[colour]
        if len(mine) == 1:
            return self._accept(mine[0], self._match(mine[0], theirs[0]))
        from scipy.optimize import linear_sum_assignment

        if len(mine) > _EACH_WITH_EACH or colour[0] == 1:
            here = np.stack([self.expected[self.ours.vertices[p]].mean(axis=0) for p in mine])
            there = np.stack([self.there[self.theirs.vertices[p]].mean(axis=0) for p in theirs])
            costs = ((here[:, None] - there[None]) ** 2).sum(axis=2)
            pairs = zip(*linear_sum_assignment(costs), strict=True)
            found = [(mine[i], self._match(mine[i], theirs[j])) for i, j in pairs]
        else:
            table = [[self._match(part, other) for other in theirs] for part in mine]
            costs = np.array([[np.inf if m is None else m.cost for m in row] for row in table])
            if not np.isfinite(costs).any(axis=1).all():
                return False
            ceiling = 1.0 + float(costs[np.isfinite(costs)].max()) * len(mine)
            pairs = zip(*linear_sum_assignment(np.minimum(costs, ceiling)), strict=True)
            found = [(mine[i], table[i][j]) for i, j in pairs]
        return all(self._accept(part, match, alike=len(mine)) for part, match in found)

    def _corners(self, part: int, other: int) -> NDArray[np.int64]:
        """Corners of their part on which the rarest corner of ours may lie, nearest first."""
        corner, colour = self.ours.rarest(part)
        candidates = self.theirs.coloured(other, colour)
        if len(candidates) > 1:
            middle = self.there[self.theirs.vertices[other]].mean(axis=0)
            wanted = self.expected[self.ours.half_edges.start[corner]] + (
                middle - self.expected[self.ours.vertices[part]].mean(axis=0)
            )
            starts = self.there[self.theirs.half_edges.start[candidates]]
            distance = np.linalg.norm(starts - wanted, axis=1)
            candidates = candidates[np.argsort(distance, kind="stable")[:_TRIED]]
        return candidates

    def _match(self, part: int, other: int) -> _Match | None:
        """The nearest way to lay one of our parts on one of theirs."""
        vertices = self.ours.vertices[part]
        if len(vertices) == 1 and not len(self.ours.corners[part]):
            return _Match(self.theirs.vertices[other], 0.0, 1)
        corner, _ = self.ours.rarest(part)
        images = self.ours.images(corner, self.theirs, self._corners(part, other))
        if images is None:
            return self._backtracked(part, other)
        place = np.searchsorted(vertices, self.ours.half_edges.start[self.ours.reached(corner)])
        best: _Match | None = None
        for image in images:
            theirs = np.empty(len(vertices), dtype=np.int64)
            theirs[place] = self.theirs.half_edges.start[image]
            cost = float(((self.there[theirs] - self.expected[vertices]) ** 2).sum())
            if best is None or cost < best.cost:
                best = _Match(theirs, cost, len(images))
        return best

    def _backtracked(self, part: int, other: int) -> _Match | None:
        mine, theirs = self.ours.vertices[part], self.theirs.vertices[other]
        here, there = self.expected[mine], self.there[theirs]
        found = _backtrack(
            self.ours.alone(part),
            self.theirs.alone(other),
            here - here.mean(axis=0),
            there - there.mean(axis=0),
            [
                (int(np.searchsorted(mine, a)), int(np.searchsorted(theirs, b)))
                for a, b in _pairs(self.ours, self.theirs)
                if a in mine and b in theirs
            ],
            count(),
        )
        if found is None:
            return None
        order = np.empty(len(found), dtype=np.int64)
        order[found] = np.arange(len(found))
        return _Match(theirs[order], float(((there[order] - here) ** 2).sum()), 1)


def _backtrack(
    ours: HalfEdges,
    theirs: HalfEdges,
    here: NDArray[np.float64],
    there: NDArray[np.float64],
    pairs: list[tuple[int, int]],
    attempts: count[int],
) -> NDArray[np.int64] | None:
    """For each of their vertices ours; None where no way was found.

    Where colours leave a choice, one vertex is paired with the nearest candidate and colours are
    refined again, until all are told apart or a pair turns out wrong and the next is tried.
    """
    if next(attempts) >= _ATTEMPTS:
        return None
    mine = Colouring(ours, [pair[0] for pair in pairs])
    their = Colouring(theirs, [pair[1] for pair in pairs])
    mine.exhaust()
    while their.rounds < mine.rounds:
        their.advance()
    my_order, their_order = np.argsort(mine.vertices), np.argsort(their.vertices)
    if not np.array_equal(mine.vertices[my_order], their.vertices[their_order]):
        return None
    _, firsts, counts = np.unique(mine.vertices, return_index=True, return_counts=True)
    if counts.max() == 1:
        match = np.empty(len(my_order), dtype=np.int64)
        match[their_order] = my_order
        renamed = Polygons(match[theirs.start], theirs.faces.offsets)
        return match if corresponding_corners(ours.faces, renamed) is not None else None
    vertex = int(firsts[np.argmin(np.where(counts > 1, counts, len(my_order) + 1))])
    candidates = np.flatnonzero(their.vertices == mine.vertices[vertex])
    distance = np.linalg.norm(there[candidates] - here[vertex], axis=1)
    for candidate in candidates[np.argsort(distance, kind="stable")].tolist():
        found = _backtrack(ours, theirs, here, there, [*pairs, (vertex, candidate)], attempts)
        if found is not None:
            return found
    return None


def _unequal(ours: Parts, target: Parts) -> Mismatch:
    """Say which parts have no equal, or which of the given pairs cannot be."""
    seeds = _pairs(ours, target)
    if seeds:
        plain = Parts(ours.mesh, faces=ours.half_edges.faces)
        rounds = plain.colouring.rounds
        other = Parts(target.mesh, faces=target.half_edges.faces, rounds=rounds)
        colours, others = plain.colouring.vertices, other.colouring.vertices
        wrong = [(a, b) for a, b in seeds if colours[a] != others[b]]
        if wrong:
            return Mismatch(
                f"{_named(wrong)}: the polygons around these vertices are not alike", True
            )
        if set(plain.by_colour) == set(other.by_colour):
            return Mismatch(f"{_named(seeds)}: the pairs contradict each other", True)
    alone = [
        parts[0]
        for colour, parts in ours.by_colour.items()
        if len(target.by_colour.get(colour, ())) != len(parts)
    ]
    largest = max(alone, key=lambda part: len(ours.vertices[part]), default=None)
    if largest is None:
        return Mismatch(
            f"the neutral has {len(ours.vertices):,} pieces, the target {len(target.vertices):,}"
        )
    vertices = ours.vertices[largest]
    return Mismatch(
        f"{len(alone):,} of {len(ours.vertices):,} pieces of the neutral have no equal in it; the "
        f"largest of them has {len(vertices):,} vertices, the first is {vertices[0]}"
    )


def _pairs(ours: Parts, target: Parts) -> list[tuple[int, int]]:
    return list(zip(ours.seeds, target.seeds, strict=True))


def _named(pairs: Sequence[tuple[int, int]]) -> str:
    return ", ".join(f"{a}={b}" for a, b in pairs)
