"""Finds which vertex of a target is which of the neutral, from how they are connected.

Pieces are matched by their colours. Within a piece one matched polygon corner determines all
others (`Walk`), so a corner of the rarest colour is tried on every corner of that colour. Where
several fit, or several pieces are alike, positions choose, at the smallest sum of squared
distances from where the piece is expected: moved as the nearest vertex about which there is no
doubt, for lashes go with the lid. Whatever is found is checked: the polygons must be those of the
neutral, all of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.frames import frame_between
from elastomorph.doctor.relabelling.branching import branched_match
from elastomorph.doctor.relabelling.parts import Parts
from elastomorph.doctor.relabelling.same_polygons import corresponding_corners
from elastomorph.model.polygons import Polygons

__all__ = ["Mismatch", "Relabelling", "find_relabelling"]

# Corners tried for one piece, nearest first, where symmetry makes more of them possible.
_TRIED = 256
# Pieces alike, up to which each is compared with each; more are matched by their centres.
_EACH_WITH_EACH = 24
# Vertices that must be known before they can tell unit, axes and motion of the others.
_ENOUGH = 8


@dataclass(frozen=True, eq=False)
class Relabelling:
    """Which vertex and which corner of the target is which of the neutral.

    Attributes:
        new_index: (V,) int64, number in the neutral of each vertex of the target.
        corners: (C,) int64, corner of the target for each corner of the neutral.
        chosen: Pieces for which connectivity left a choice that positions decided.
        chosen_vertices: How many vertices they have.
    """

    new_index: NDArray[np.int64]
    corners: NDArray[np.int64]
    chosen: int
    chosen_vertices: int


@dataclass(frozen=True)
class Mismatch:
    """Why there is no relabelling.

    Attributes:
        reason: In words.
        seeds: Whether the pairs that were given are to blame.
    """

    reason: str
    seeds: bool = False


@dataclass(frozen=True, eq=False)
class _Match:
    """Their vertices for the vertices of one of our pieces, and how many others would fit."""

    theirs: NDArray[np.int64]
    cost: float
    candidates: int


def find_relabelling(ours: Parts, target: Parts, *, scale: float = 1.2) -> Relabelling | Mismatch:
    """Match a target with a neutral by connectivity, and by position where that leaves a choice.

    Args:
        ours: The pieces of the neutral.
        target: The pieces of the target, with as many rounds of colours, and seeds in the same
            order.
        scale: Sizes that differ by more are brought to one size before positions are compared.
    """
    if set(ours.by_colour) != set(target.by_colour) or any(
        len(parts) != len(target.by_colour[colour]) for colour, parts in ours.by_colour.items()
    ):
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
        unique = [c for c, parts in groups if len(parts) == 1 and c[0] > 1]
        undecided = []
        for colour in unique:
            part, other = self.ours.by_colour[colour][0], self.theirs.by_colour[colour][0]
            if len(self._corners(part, other)) == 1:
                match = self._match(part, other)
                if match is None:
                    return False
                self._settle(part, match)
            else:
                undecided.append(colour)
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

    def _settle(self, part: int, match: _Match, alike: int = 1) -> None:
        self.new_index[match.theirs] = self.ours.vertices[part]
        if match.candidates > 1 or alike > 1:
            self.chosen += 1
            self.chosen_vertices += len(match.theirs)

    def _match_alike(self, colour: tuple[int, int]) -> bool:
        """Match pieces of the same colours with each other, at the least sum of squares."""
        mine, theirs = self.ours.by_colour[colour], self.theirs.by_colour[colour]
        if len(mine) == 1:
            match = self._match(mine[0], theirs[0])
            if match is not None:
                self._settle(mine[0], match)
            return match is not None
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
        for part, match in found:
            if match is None:
                return False
            self._settle(part, match, alike=len(mine))
        return True

    def _corners(self, part: int, other: int) -> NDArray[np.int64]:
        """Corners of their piece on which the rarest corner of ours may lie, nearest first."""
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
        """The nearest way to lay one of our pieces on one of theirs."""
        vertices = self.ours.vertices[part]
        if len(vertices) == 1 and not len(self.ours.corners[part]):
            return _Match(self.theirs.vertices[other], 0.0, 1)
        corner, _ = self.ours.rarest(part)
        walk = self.ours.walk(corner)
        if len(walk.corners) < len(self.ours.corners[part]):
            return self._branched(part, other)
        place = np.searchsorted(vertices, self.ours.half_edges.start[walk.corners])
        best: _Match | None = None
        images = walk.images(self.theirs.half_edges, self._corners(part, other))
        for image in images:
            theirs = np.empty(len(vertices), dtype=np.int64)
            theirs[place] = self.theirs.half_edges.start[image]
            cost = float(((self.there[theirs] - self.expected[vertices]) ** 2).sum())
            if best is None or cost < best.cost:
                best = _Match(theirs, cost, len(images))
        return best

    def _branched(self, part: int, other: int) -> _Match | None:
        ours = self.ours.piece(part, self.expected)
        theirs = self.theirs.piece(other, self.there)
        seeds = [
            (int(np.searchsorted(ours.vertices, a)), int(np.searchsorted(theirs.vertices, b)))
            for a, b in zip(self.ours.seeds, self.theirs.seeds, strict=True)
            if a in ours.vertices and b in theirs.vertices
        ]
        match = branched_match(ours, theirs, seeds)
        if match is None:
            return None
        order = np.empty(len(match), dtype=np.int64)
        order[match] = np.arange(len(match))
        found = theirs.vertices[order]
        cost = float(((self.there[found] - self.expected[ours.vertices]) ** 2).sum())
        return _Match(found, cost, 1)


def _unequal(ours: Parts, target: Parts) -> Mismatch:
    """Say which pieces have no equal, or which of the given pairs cannot be."""
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
