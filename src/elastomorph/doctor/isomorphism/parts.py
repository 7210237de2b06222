"""The connected parts of a mesh, told apart by colours, and how one part is laid on another.

Vertices are told apart by their surroundings alone (colour refinement, Weisfeiler-Leman): each
round, the colour of a vertex takes in those of the polygon corners around it, in their order round
the polygon. Two numberings of one mesh give the same colours, so vertices of a rare colour are few
candidates for each other, and parts of different colours are different parts. A reversed polygon
has other colours. Colours are 64-bit hashes; equal ones by accident can only make a search fail,
for what it finds is checked polygon by polygon.

On an oriented surface, "the next corner of the polygon" and "the corner across the edge" lead from
one corner to every other of its part. So one matched corner determines all: the traversal is
recorded once and replayed from any number of corners of the other mesh at the same time.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.neutral import HalfEdges
from elastomorph.model.geometry import component_of
from elastomorph.model.mesh import Mesh
from elastomorph.model.polygons import Polygons

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
