"""Finds which vertex of a target is which of the neutral, from how they are connected.

Parts are matched by their colours. Within a part one matched polygon corner determines all others,
so a corner of the rarest colour is tried on every corner of that colour; parts joined at points,
or that branch at edges, are matched by individualising a vertex, refining, and backtracking. Where
several ways fit, or several parts are alike, positions choose, at the smallest sum of squared
distances from where the part is expected: moved as the nearest vertex about which there is no
doubt, for lashes go with the lid. Whatever is found is checked: the polygons must be those of the
neutral, all of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.frames import frame_between
from elastomorph.doctor.isomorphism.parts import Colouring, Parts
from elastomorph.doctor.isomorphism.polygons import corresponding_corners
from elastomorph.doctor.neutral import HalfEdges
from elastomorph.model.polygons import Polygons

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
