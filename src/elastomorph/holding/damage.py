"""Visible damage where sliders meet: triangles that fold, and surfaces that pass into each other.

A triangle is folded where its normal points against the mean normal, by area, of all triangles
within three rings of it in the same pose. It is seen where that neighbourhood faces the front, +Z,
and one of four points of it is hidden by nothing that lies in front by more than a little. Surfaces
that face each other, as lips and lids do, pass by how far a vertex is behind the tangent plane of
what it faces. What the neutral and the single sliders do at the same weights does not count: it is
not of their meeting.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import chain, combinations
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import MeshError, ParameterError
from elastomorph.model.geometry import moved_extent
from elastomorph.model.mesh import Mesh
from elastomorph.paths.rotations.passing import Sheets, facing, least_places
from elastomorph.paths.rotations.vertex_rotations import Neighbourhoods
from elastomorph.rig.performance import Performance, slider_weights
from elastomorph.rig.rig import Rig
from elastomorph.rig.sliders import spread_rows

if TYPE_CHECKING:
    from scipy.sparse import csr_array

ACTIVE = 0.05
"""Weight from which a slider takes part in a frame."""

DEEP = 1e-3
"""Depth that is damage, over D: surfaces on one path may pass by as much."""

MOVED = 1e-4
"""A slider moves vertices that go farther than this, over D."""

# Rings of a triangle's neighbourhood.
_RINGS = 3
# What lies in front by less, over D, hides nothing: the layers of a tight fold are one to the eye.
_IN_FRONT = 5e-4
# Where a triangle is looked at: its middle, and near its corners.
_PLACES = np.array([[1, 1, 1], [2.4, 0.3, 0.3], [0.3, 2.4, 0.3], [0.3, 0.3, 2.4]]) / 3
# Directions of two sliders whose cosine is below are opposites: left and right, open and shut.
_OPPOSITE = -0.5
# Vertices face each other within so many edges; what is faced may slide by so many rings.
_NEAR, _SLIDE = 4.0, 3
# A vertex that is not straight behind what it faces is beside the border of the surface.
_STRAIGHT_BEHIND = 0.9
# A depth, over D, that is as bad to look at as one folded triangle.
_ONE_FOLD = 5e-3
# Frames of a take that are looked at, and pairs to which a third slider is tried.
_FRAMES, _EXTENDED = 80, 20
# Of the triangles around the deepest vertex, every so many-th is looked at.
_SAMPLE = 5

Points = NDArray[np.float64]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]
Event = tuple[int, int, tuple[int, ...]]  # place of a frame, row of damage, sliders that it takes
Among = Callable[[Points, Points, Indices], Mask]  # of a pose, sliders and rows: what is damaged


@dataclass(frozen=True, eq=False)
class Surface:
    """The triangles of a rig, each with its neighbourhood, found once for all poses."""

    rest: Points  # (V, 3)
    triangles: Indices  # (T, 3), polygons split in fans
    near: csr_array  # (T, T) ones within three rings, itself among them
    touching: csr_array  # (V, T) ones where a triangle has a vertex
    diameter: float  # D: of what the targets move

    @classmethod
    def of(cls, rig: Rig) -> Surface:
        """The surface of a rig's neutral.

        Raises:
            MeshError: It has no polygons.
        """
        from scipy.sparse import csr_array

        neutral = rig.neutral
        triangles = neutral.faces.triangles().astype(np.int64)
        if not len(triangles):
            raise MeshError(
                f"{neutral.name} has no polygons: nothing of it can fold. Take a rig with a surface"
            )
        corner = triangles.ravel(), np.repeat(np.arange(len(triangles)), 3)
        shape = len(neutral.vertices), len(triangles)
        touching = csr_array((np.ones(triangles.size, dtype=np.float32), corner), shape)
        near, ring = csr_array(touching.T), _ones(touching @ touching.T)
        for _ in range(_RINGS - 1):
            near = _ones(near @ ring)
        targets = [morph.target.vertices for morph in rig.morphs.values()]
        extent = moved_extent(neutral.vertices, targets) or neutral.diameter
        return cls(neutral.vertices, triangles, _ones(near @ touching), touching, extent)

    @cached_property
    def folded_at_rest(self) -> Mask:
        """(T,) triangles that are folded in the neutral."""
        return self.folded(self.rest)

    @cached_property
    def at_rest(self) -> Points:
        """(T,) lengths of the normals of triangles in the neutral, at least a little."""
        lengths = np.linalg.norm(crosses(self.rest, self.triangles), axis=1)
        return np.asarray(np.maximum(lengths, 1e-300))

    def _crosses(self, points: Points, picked: csr_array) -> Points:
        """(T, 3) normals of the triangles that a matrix has, 0 of others."""
        used, some = np.zeros(len(self.triangles), dtype=bool), np.zeros(self.triangles.shape)
        used[picked.indices] = True
        some[used] = crosses(points, self.triangles[used])
        return some

    def normals_around(self, points: Points, rows: Indices | None = None) -> tuple[Points, Points]:
        """(R, 3) normals of some triangles, or of all, and sums of those near each."""
        near = self.near if rows is None else self.near[rows]
        some = self._crosses(points, near)
        return some if rows is None else some[rows], near @ some

    def folded(self, points: Points, rows: Indices | None = None) -> Mask:
        """(R,) which of some triangles, or of all, are folded in a pose, (V, 3)."""
        return np.asarray(dot(*self.normals_around(points, rows)) < 0)

    def seen(self, points: Points, rows: Indices) -> Mask:
        """(R,) which of some triangles are seen from the front in a pose."""
        seen = self.normals_around(points, rows)[1][:, 2] > 0
        if not seen.any():
            return seen
        corners = points.T[:, self.triangles.T]  # (3 axes, 3 corners, T)
        low, high = corners.min(axis=1), corners.max(axis=1)
        free = _IN_FRONT * self.diameter
        for place in np.flatnonzero(seen):
            places = corners[:, :, rows[place]] @ _PLACES.T
            first, last = places.min(axis=1), places.max(axis=1)
            over = high[2] > first[2] + free
            for axis in (0, 1):
                over &= (low[axis] <= last[axis]) & (high[axis] >= first[axis])
            over[rows[place]] = False
            near = corners[:, :, over]
            seen[place] = any((_height(near, at) <= at[2] + free).all() for at in places.T)
        return seen

    def visible_folds(self, points: Points, rows: Indices | None = None) -> Indices:
        """Triangles, of some or all, that are seen and folded in a pose, but not in the neutral."""
        rows = np.flatnonzero(~self.folded_at_rest) if rows is None else rows
        rows = rows[self.folded(points, rows)]
        return rows[self.seen(points, rows)]

    def reached(self, moved: Mask) -> Mask:
        """(T,) triangles with one of (V,) vertices in their neighbourhood."""
        touched = (self.touching.T @ moved.astype(np.float32)) > 0
        return np.asarray((self.near @ touched.astype(np.float32)) > 0)

    def normals(self, points: Points, rows: Indices | None = None) -> Points:
        """(R, 3) unit normals of some vertices, or of all; zero where there are none."""
        touching = self.touching if rows is None else self.touching[rows]
        sums = touching @ self._crosses(points, touching)
        length = np.linalg.norm(sums, axis=1, keepdims=True)
        return np.asarray(sums / np.where(length > 0, length, 1.0))


@dataclass(frozen=True, eq=False)
class Contacts:
    """Vertices that face each other at rest or where one slider is full, and what they face."""

    surface: Surface
    vertices: Indices  # (M,)
    faced: csr_array  # (M, V) ones
    farthest: float  # distance up to which they do

    @classmethod
    def of(cls, surface: Surface, neutral: Mesh, poses: Sequence[Points]) -> Contacts:
        """Those within one sheet of a surface, in some poses, each (V, 3)."""
        from scipy.sparse import coo_array, csr_array

        rest, count = poses[0], len(poses[0])
        sheets = Sheets.of(neutral, Neighbourhoods.of(count, neutral.edges))
        ring = _ones(sheets.ring)
        edge = np.linalg.norm(np.diff(rest[sheets.triangles], axis=1), axis=2).mean()
        near = _NEAR * float(edge)
        used = np.flatnonzero(sheets.numbers >= 0)
        firsts, others = [], []
        for points in poses:
            moved = used if points is rest else used[(points != rest).any(axis=1)[used]]
            normals = surface.normals(points)
            first, other = facing(points, normals, sheets, used, moved, near, candidates=1)
            firsts += [first, other]
            others += [other, first]
        pair = np.concatenate(firsts), np.concatenate(others)
        pairs = csr_array(coo_array((np.ones(len(pair[0]), np.float32), pair), (count, count)))
        for _ in range(_SLIDE):
            pairs = _ones(pairs @ ring)
        vertices = np.flatnonzero(np.diff(pairs.indptr)).astype(np.int64)
        every = cls(surface, vertices, pairs[vertices], near)
        # What is behind at rest is the other side of the same flesh.
        depth, _ = every.depths(rest, np.arange(len(vertices)))
        kept = depth <= DEEP * surface.diameter
        return cls(surface, vertices[kept], every.faced[kept], near)

    def closest(self, points: Points, rows: Indices) -> tuple[Points, Points, Indices]:
        """(R, 3) way to the closest vertex of what each faces, its normal and its number."""
        faced, own = self.faced[rows], points[self.vertices[rows]]
        off = points[faced.indices] - np.repeat(own, np.diff(faced.indptr), axis=0)
        places = least_places(dot(off, off), faced.indptr[:-1])
        numbers = faced.indices[places].astype(np.int64)
        return off[places], self.surface.normals(points, numbers), numbers

    def depths(self, points: Points, rows: Indices) -> tuple[Points, Mask]:
        """(R,) how far vertices are behind what is closest of what they face, if straight."""
        if not len(rows):
            return np.zeros(0), np.zeros(0, dtype=bool)
        off, normals, _ = self.closest(points, rows)
        depth, distance = dot(off, normals), np.sqrt(dot(off, off))
        return depth, (depth > _STRAIGHT_BEHIND * distance) & (distance < self.farthest)


@dataclass(frozen=True)
class Meeting:
    """Two or three sliders at once, and the visible damage of that.

    Attributes:
        sliders: Their names.
        weights: Where they were looked at: in the frame of the take in which the least of them is
            largest; all 1 without a take, or where it never uses them together.
        folds: Triangles that are seen and folded there, and not with fewer of the sliders.
        depth: How much deeper than with one of them a vertex is behind what it faces there, where
            that is seen, in the unit of the neutral.
        share: That depth over D.
        opposite: Whether they move in opposite directions, as left and right do.
        frames: Frames of the take in which all are active; None without a take.
        per_frame: Folded triangles that are seen in a frame of the take and need these sliders, no
            fewer and no others; None without a take.
    """

    sliders: tuple[str, ...]
    weights: tuple[float, ...]
    folds: int
    depth: float
    share: float
    opposite: bool
    frames: int | None = None
    per_frame: float | None = None

    @property
    def rank(self) -> tuple[bool, float, float]:
        """To sort by, the worst first; what the take never uses, else opposites, last."""
        last = self.opposite if self.frames is None else not self.frames
        return last, -(self.per_frame or 0.0), -(self.folds + self.share / _ONE_FOLD)


def rank_meetings(
    rig: Rig,
    take: Performance | None = None,
    *,
    triples: bool = True,
    say: Callable[[str], None] = lambda _: None,
) -> list[Meeting]:
    """Pairs and triples of sliders whose meeting does visible damage, the worst first.

    Args:
        rig: The rig; what counts is its `Rig.pose`.
        take: Weights that say how often sliders meet, and how far; matched to them by name.
        triples: Whether to try a third slider with the worst pairs.
        say: Told what is being done.

    Raises:
        MeshError: The neutral has no polygons.
        ParameterError: The rig has fewer than two sliders, or the take drives none of them.
    """
    poses = poses_alone(rig)
    weights = None if take is None else taken_weights(rig, take)
    surface = Surface.of(rig)
    say("looking at each slider alone")
    judge = _Judge.of(rig, surface, poses, weights)
    if weights is not None:
        say("looking at frames of the take")
        frames = weights[spread_rows(len(weights), _FRAMES)]
        counts = Counter(sliders for _, _, sliders in folds_by_sliders(rig, surface, frames))
        judge.per_frame.update({own: number / len(frames) for own, number in counts.items()})
    found: dict[tuple[int, ...], Meeting] = {}

    def look(meetings: Sequence[tuple[int, ...]], what: str) -> None:
        for number, sliders in enumerate(meetings, start=1):
            say(f"{what} {number} of {len(meetings)}")
            meeting = judge.meeting(sliders)
            if meeting is not None:
                found[sliders] = meeting

    look(list(combinations(range(len(rig.names)), 2)), "pair")
    if triples:
        worst = sorted((p for p in found if not found[p].rank[0]), key=lambda p: found[p].rank)
        wider: set[tuple[int, ...]] = {sliders for sliders in judge.per_frame if len(sliders) == 3}
        for pair in worst[:_EXTENDED]:
            thirds = {other for two in found if set(two) & set(pair) for other in two} - {*pair}
            wider |= {(*sorted((*pair, third)),) for third in thirds}
        look(sorted(wider), "triple")
    return sorted(found.values(), key=lambda meeting: meeting.rank)


def folds_by_sliders(rig: Rig, surface: Surface, frames: Points) -> Iterator[Event]:
    """`by_sliders` of the visible folds of (F, sliders) frames."""
    found = [surface.visible_folds(rig.pose(frame)) for frame in frames]
    return by_sliders(rig, frames, found, lambda points, _, rows: surface.folded(points, rows))


def by_sliders(rig: Rig, frames: Points, found: Sequence[Indices], among: Among) -> Iterator[Event]:
    """Place and row of all that was found in (F, sliders) frames, and the sliders it takes.

    Sliders are left out of a frame one by one, the least active first, where the row stays among
    what is damaged without.
    """
    for place, (frame, rows) in enumerate(zip(frames, found, strict=True)):
        groups = [(frame, rows)] if len(rows) else []
        for slider in np.argsort(frame, kind="stable")[(frame == 0).sum() :]:
            split = []
            for kept, own in groups:
                without = kept.copy()
                without[slider] = 0.0
                stays = among(rig.pose(without), without, own)
                split += [(without, own[stays]), (kept, own[~stays])]
            groups = [group for group in split if len(group[1])]
        for kept, own in groups:
            sliders = tuple(np.flatnonzero(kept).tolist())
            yield from ((place, row, sliders) for row in own.tolist())


def poses_alone(rig: Rig) -> list[Points]:
    """The neutral, and each slider at 1; refuses a rig that has no pair of them."""
    if len(rig.names) < 2:
        raise ParameterError(f"pairs need two sliders or more, the rig has {len(rig.names)}")
    return [rig.neutral.vertices, *(rig.pose({name: 1.0}) for name in rig.names)]


def taken_weights(rig: Rig, take: Performance) -> Points:
    """(T, sliders) weights of a take, within 0 and 1; refuses one that drives nothing."""
    weights = slider_weights(rig, take, clip=True)
    if not weights.any():
        raise ParameterError(
            f"no weight of {take.source or 'the take'} drives a slider of the rig "
            f"({len(rig.names)} sliders); see 'elastomorph animate --list' for the names of both"
        )
    return weights


@dataclass(frozen=True, eq=False)
class _Judge:
    """What is known of each slider alone, by which meetings are judged."""

    rig: Rig
    surface: Surface
    contacts: Contacts
    weights: Points | None  # (T, sliders) of a take
    motions: NDArray[np.float32]  # (sliders, V, 3) at full weight
    moved: Mask  # (sliders, V)
    reached: Mask  # (sliders, T)
    per_frame: dict[tuple[int, ...], float] = field(default_factory=dict)

    @classmethod
    def of(cls, rig: Rig, surface: Surface, poses: list[Points], weights: Points | None) -> _Judge:
        motions = np.array([pose - poses[0] for pose in poses[1:]], dtype=np.float32)
        moved = np.linalg.norm(motions, axis=2) > MOVED * surface.diameter
        contacts = Contacts.of(surface, rig.neutral, poses)
        reached = np.array([surface.reached(each) for each in moved])
        return cls(rig, surface, contacts, weights, motions, moved, reached)

    def meeting(self, sliders: tuple[int, ...]) -> Meeting | None:
        """What some sliders do together and fewer of them do not; None where that is nothing."""
        columns = list(sliders)
        rows = np.flatnonzero(self.reached[columns].all(axis=0) & ~self.surface.folded_at_rest)
        if not len(rows):
            return None
        weights, frames, per_frame = np.ones(len(sliders)), None, None
        if self.weights is not None:
            least = self.weights[:, columns].min(axis=1)
            frames = int((least > ACTIVE).sum())
            per_frame = self.per_frame.get(sliders, 0.0)
            weights = self.weights[least.argmax(), columns] if frames else weights
        pose = self._pose(sliders, weights)
        rows = rows[self.surface.folded(pose, rows)]
        contacts, depth = self._deep(pose, np.all(self.moved[columns], axis=0))
        excess = depth
        every = range(len(sliders))
        for some in chain.from_iterable(combinations(every, few) for few in every[1:]):
            if not len(rows) and not len(contacts):
                return None
            fewer = self._pose(tuple(columns[place] for place in some), weights[list(some)])
            rows = rows[~self.surface.folded(fewer, rows)]
            own, _ = self.contacts.depths(fewer, contacts)
            excess = np.minimum(excess, depth - np.maximum(own, 0.0))
        folds = int(self.surface.seen(pose, rows).sum())
        deeper = self._seen_depth(pose, contacts, excess)
        if not folds and not deeper and not per_frame:
            return None
        pairs = combinations(sliders, 2)
        opposite = any(_cosine(*self.motions[list(pair)]) < _OPPOSITE for pair in pairs)
        share, names = deeper / self.surface.diameter, tuple(self.rig.names[i] for i in sliders)
        shown = tuple(weights.tolist())
        return Meeting(names, shown, folds, deeper, share, opposite, frames, per_frame)

    def _pose(self, sliders: tuple[int, ...], weights: Points) -> Points:
        row = np.zeros(len(self.rig.names))
        row[list(sliders)] = weights
        return self.rig.pose(row)

    def _deep(self, pose: Points, moved: Mask) -> tuple[Indices, Points]:
        """(R,) contacts among moved vertices that are deep in a pose, and how deep."""
        some = np.flatnonzero(moved[self.contacts.vertices])
        depth, passes = self.contacts.depths(pose, some)
        deep = passes & (depth > DEEP * self.surface.diameter)
        return some[deep], depth[deep]

    def _seen_depth(self, pose: Points, contacts: Indices, excess: Points) -> float:
        """The largest excess of depth, 0 where it is small or nothing around it is seen."""
        if not len(contacts) or excess.max() < DEEP * self.surface.diameter:
            return 0.0
        deepest = self.contacts.vertices[contacts[[excess.argmax()]]]
        touching = self.surface.touching[deepest].indices
        around = self.surface.near[touching[:1]].indices[::_SAMPLE].astype(np.int64)
        return float(excess.max()) if self.surface.seen(pose, around).any() else 0.0


def _cosine(first: NDArray[np.float32], second: NDArray[np.float32]) -> float:
    lengths = float(np.linalg.norm(first) * np.linalg.norm(second))
    return float(np.vdot(first, second)) / lengths if lengths else 0.0


def crosses(points: Points, triangles: Indices) -> Points:
    """(T, 3) normals of triangles, twice as long as their areas."""
    a, b, c = points[triangles.T]
    ab, ac = (b - a).T, (c - a).T
    # A product of columns is several times faster than np.cross.
    return np.stack([ab[i - 2] * ac[i - 1] - ab[i - 1] * ac[i - 2] for i in range(3)], axis=1)


def _height(corners: Points, place: Points) -> Points:
    """(N,) z of triangles, (3 axes, 3, N), over or under a point; minus infinity beside them."""
    x, y = corners[:2] - place[:2, None, None]
    following, last = [1, 2, 0], [2, 0, 1]
    shares = x[following] * y[last] - y[following] * x[last]
    whole = shares.sum(axis=0)
    inside = ((shares >= 0).all(axis=0) | (shares <= 0).all(axis=0)) & (whole != 0)
    height = (shares * corners[2]).sum(axis=0) / np.where(whole != 0, whole, 1.0)
    return np.where(inside, height, -np.inf)


def dot(first: Points, second: Points) -> Points:
    """(N,) products of rows."""
    return np.asarray(np.einsum("ni,ni->n", first, second))


def _ones(matrix: csr_array) -> csr_array:
    """The same places, all one."""
    from scipy.sparse import csr_array

    kept = csr_array(matrix)
    kept.data[:] = 1.0
    return kept
