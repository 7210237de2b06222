"""Correctives of pairs of sliders: the smallest smooth displacement that undoes what they do.

A displacement u of the vertices, driven by m, the least weight of some sliders, turns a triangle
with normal c against the unit normal n of its neighbourhood by n·dc(m u), which is linear in u for
small u. A vertex v that is a depth d behind the plane, of normal n, of what it faces there, f, gets
out of it by m n·(u_v - u_f). The least u that mends several poses at once is

    min ½ uᵀ Q u   such that   n·c + m n·dc(u) ≥ ε |c₀|         for each folded triangle and pose,
                               m n·(u_v - u_f) ≥ d - d₁         for each vertex too deep and pose,

where d₁ is the largest depth by one of the sliders alone, Q = M + ℓ⁴ L M⁻¹ L, of the mass and the
Laplacian of the neutral, makes u smooth, and u is 0 away from the damage. In its dual there is one
number of at least 0 a constraint (Lawson and Hanson, Solving Least Squares Problems, 1974, ch. 23).
As neither is linear in u, this is repeated from where the last u led, with what that damages anew.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations, product
from typing import Any, ClassVar, NamedTuple

import numpy as np

from elastomorph.errors import ParameterError
from elastomorph.holding.correction import Correction, straight_morph
from elastomorph.holding.damage import (
    ACTIVE,
    DEEP,
    MOVED,
    Contacts,
    Event,
    Indices,
    Mask,
    Points,
    Surface,
    by_sliders,
    crosses,
    dot,
    poses_alone,
    taken_weights,
)
from elastomorph.holding.eyes import blinks_of
from elastomorph.model.cholesky import symmetric_factor
from elastomorph.model.geometry import neighbours
from elastomorph.model.morph import Morph
from elastomorph.model.surface import surface_operators
from elastomorph.rig.naming import shape_of
from elastomorph.rig.performance import Performance
from elastomorph.rig.rig import Rig
from elastomorph.rig.sliders import spread_rows

LARGEST = 8e-3
"""Farthest that a corrective may move a vertex, over D."""

# The normal of a triangle along that of its neighbourhood, over its length at rest.
_UPRIGHT = 0.05
# Depth beyond that of single sliders that is too deep, over D.
_TOO_DEEP = DEEP / 2
# Weights at which each slider alone is looked at.
_ALONE = np.linspace(0, 1, 5)
# Length below which displacements are smooth, over D, and rings that may move around damage.
_SMOOTH, _RINGS = 0.005, 8
# Rounds of linearising, and constraints of one problem at most.
_ROUNDS, _MOST = 6, 300
# What the dual is damped by, over its largest diagonal, for what nothing undoes.
_DAMPING = 1e-7
# Folds, or vertices too deep, in all frames that are looked at, that a corrective must undo.
_LEAST = 2
# Frames in which it is looked for what a corrective adds.
_CHECKED = 30


def pair_corrections(
    kind: type[Folds | Lips], rig: Rig, most: int, takes: Sequence[Performance]
) -> Iterator[tuple[Correction, Morph | None]]:
    """Correctives that undo damage where two sliders meet, the most useful first.

    Each is driven by the lesser weight of two sliders and is fitted to frames in which they do
    damage; of folds also to 16 weights of the two, in quarters. One that would move a vertex
    farther than `LARGEST` is made smaller, of lips also one that does other damage; one that leaves
    as much as there was, or adds edges at which the surface turns back, or vertices that pass what
    they face, is dropped.

    Args:
        kind: Of the damage: visible folds, or lips that pass.
        rig: The rig; what counts is its `Rig.pose`.
        most: How many at most.
        takes: Weights that say which sliders meet, and how far. Only the first half of each is
            looked at, so that the second can tell what was gained.

    Yields:
        A row and the morph that it tells of; rows alone where the rig has some of this kind.

    Raises:
        MeshError: The neutral has no polygons.
        ParameterError: A rig with fewer than two sliders, or none that moves the mouth where lips
            are asked for, or a take that drives none of them.
    """
    poses = poses_alone(rig)
    weights = [taken_weights(rig, take) for take in takes]
    there = [name for name in rig.sliders.correctives if name.startswith(f"{kind.name}_")]
    if there:
        yield from ((Correction(n, note=f"{n} is there already, and kept"), None) for n in there)
        return
    halves = [own[: (len(own) + 1) // 2] for own in weights]
    share = -(-kind.frames // len(halves))
    frames = np.concatenate([half[spread_rows(len(half), share)] for half in halves])
    search, every = _Search.of(kind, rig, poses, frames), np.concatenate(weights)
    while most and (pair := search.next_pair()) is not None:
        if (displacement := search.corrective(pair)) is None:
            continue
        names = tuple(rig.names[place] for place in pair)
        name, size = "_".join((kind.name, *names)), search.damage.diameter
        before, after = search.take(pair, displacement)
        in_use = int((every[:, pair].min(axis=1) > 0).sum())
        most -= 1
        row = Correction(name, names, "min", (), before, after, size, in_use, targets=1)
        yield row, straight_morph(rig, np.arange(len(displacement)), displacement)


class _Scene(NamedTuple):
    """A pose, the weights of the sliders and of the corrective in it, and what is to be undone."""

    pose: Points
    sliders: Points
    weight: float
    rows: Indices


class _Bounds(NamedTuple):
    """Constraints of a displacement u: Σ gradients·u(vertices) ≥ bounds."""

    vertices: Indices  # (K, 3), or 6 with those of creases
    gradients: Points  # (K, 3 or 6, 3)
    bounds: Points  # (K,)


@dataclass(frozen=True, eq=False)
class Folds:
    """Triangles that are seen folded."""

    surface: Surface
    name: ClassVar[str] = "fold"
    # Frames of takes that correctives are chosen by, and those of them that one is fitted to.
    frames: ClassVar[int] = 250
    fitted: ClassVar[int] = 12
    looked_at: ClassVar[int] = 10_000
    grid: ClassVar[tuple[float, ...]] = (0.25, 0.5, 0.75, 1.0)
    shares: ClassVar[tuple[float, ...]] = (1.0,)
    diameter: ClassVar[float] = 0.0

    def near(self, moved: Mask) -> Indices:
        """Triangles that (V,) vertices can fold."""
        return np.flatnonzero(self.surface.reached(moved) & ~self.surface.folded_at_rest)

    def found(self, points: Points, sliders: Points, near: Indices | None = None) -> Indices:
        """Triangles, of all or of some, that are seen folded in a pose."""
        return self.surface.visible_folds(points, near)

    def among(self, points: Points, sliders: Points, rows: Indices) -> Mask:
        """(R,) which of some triangles are folded, seen or not."""
        return self.surface.folded(points, rows)

    def size(self, scenes: Sequence[_Scene], frames: int) -> float:
        """Folds a frame, where some of the frames have any."""
        return sum(len(scene.rows) for scene in scenes) / frames

    def grows(self, scenes: Sequence[_Scene], displacement: Points) -> bool:
        """Never: how many there are says all."""
        return False

    def vertices(self, rows: Indices) -> Indices:
        """Corners of triangles."""
        return self.surface.triangles[rows].ravel()

    def bounds(self, points: Points, scene: _Scene, rows: Indices) -> _Bounds:
        """What unfolds triangles in a pose of a scene, beyond it."""
        own = self.surface.triangles[rows]
        across, mean = self.surface.normals_around(points, rows)
        mean /= np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-300)
        length = self.surface.at_rest[rows]
        gradients = scene.weight * _turning(points, own, mean) / length[:, None, None]
        return _Bounds(own, gradients, _UPRIGHT - dot(across, mean) / length)


def _turning(points: Points, triangles: Indices, normals: Points) -> Points:
    """(K, 3, 3) by how much the normals of triangles grow along others, by their corners."""
    a, b, c = points[triangles.T]
    # n·(a × b + b × c + c × a) by a is n × (c - b), and so on round the triangle.
    return np.stack([np.cross(normals, side) for side in (c - b, a - c, b - a)], axis=1)


@dataclass(frozen=True, eq=False)
class Creases:
    """Edges at which the surface turns back."""

    surface: Surface
    edges: Indices  # (E, 2) triangles on both sides

    def near(self, moved: Mask) -> Indices:
        """Edges that (V,) vertices turn."""
        turned = moved[self.surface.triangles][self.edges]  # (E, 2, 3)
        return np.flatnonzero(turned.any(axis=(1, 2)))

    def among(self, points: Points, sliders: Points, rows: Indices) -> Mask:
        """(R,) at which of some edges the surface turns back."""
        one, other = self.surface.triangles[self.edges[rows].T]
        return np.asarray(dot(crosses(points, one), crosses(points, other)) < 0)

    def bounds(self, points: Points, scene: _Scene, rows: Indices) -> _Bounds:
        """What turns triangles towards each other again."""
        both = self.edges[rows].T
        sides = self.surface.triangles[both]
        normals = np.array([crosses(points, side) for side in sides])
        normals /= np.maximum(np.linalg.norm(normals, axis=2, keepdims=True), 1e-300)
        lengths = self.surface.at_rest[both][:, :, None, None] / scene.weight
        growth = [_turning(points, sides[k], normals[1 - k]) / lengths[k] for k in (0, 1)]
        return _Bounds(np.hstack([*sides]), np.hstack(growth), _UPRIGHT - dot(*normals))


@dataclass(frozen=True, eq=False)
class Lips:
    """Vertices that are deeper behind what they face than a single slider takes them."""

    contacts: Contacts  # of the mouth
    alone: Points  # (sliders, weights, R) depths by one
    name: ClassVar[str] = "lips"
    frames: ClassVar[int] = 100
    fitted: ClassVar[int] = 8
    looked_at: ClassVar[int] = 4
    grid: ClassVar[tuple[float, ...]] = ()
    shares: ClassVar[tuple[float, ...]] = (1.0, 0.6, 0.3)

    @classmethod
    def of(cls, rig: Rig, contacts: Contacts) -> Lips:
        """Contacts that shapes of a mouth move and no blink does, and each slider alone there."""
        mouth = [name for name in rig.names if (shape_of(name) or "").startswith("mouth")]
        if not mouth:
            raise ParameterError(
                "the rig has no slider that moves lips: expected mouthClose or others of ARKit, "
                f"in any spelling, found {', '.join(rig.names[:8])}, …"
            )
        is_lip = np.zeros(len(contacts.vertices), dtype=bool)
        for names, kept in ((mouth, True), (blinks_of(rig.names), False)):
            for name in names:
                way = np.linalg.norm(rig[name].delta[contacts.vertices], axis=1)
                is_lip[way > MOVED * contacts.surface.diameter] = kept
        own = np.flatnonzero(is_lip)
        lips = replace(contacts, vertices=contacts.vertices[own], faced=contacts.faced[own])
        poses = ([rig.pose({name: weight}) for weight in _ALONE.tolist()] for name in rig.names)
        every = np.arange(len(own))
        alone = [[lips.depths(pose, every)[0] for pose in of_one] for of_one in poses]
        return cls(lips, np.maximum(alone, 0.0))

    @property
    def diameter(self) -> float:
        """D of what the targets move."""
        return self.contacts.surface.diameter

    def near(self, moved: Mask) -> Indices:
        """Contacts that (V,) vertices are a side of."""
        return np.flatnonzero(moved[self.contacts.vertices] | (self.contacts.faced @ moved > 0))

    def excess(self, points: Points, sliders: Points, rows: Indices | None = None) -> Points:
        """(R,) how much deeper some vertices, or all, are than with one of the sliders alone."""
        rows = np.arange(len(self.contacts.vertices)) if rows is None else rows
        depth, passes = self.contacts.depths(points, rows)
        return np.where(passes, depth - self._allowed(sliders, rows), 0.0)

    def _allowed(self, sliders: Points, rows: Indices) -> Points:
        place = np.clip(sliders, 0, 1) * (len(_ALONE) - 1)
        low = np.minimum(place.astype(int), len(_ALONE) - 2)
        part, each = (place - low)[:, None], np.arange(len(place))
        table = self.alone[:, :, rows]
        return np.asarray(((1 - part) * table[each, low] + part * table[each, low + 1]).max(axis=0))

    def found(self, points: Points, sliders: Points, near: Indices | None = None) -> Indices:
        """Contacts, of all or of some, that are too deep in a pose."""
        near = np.arange(len(self.contacts.vertices)) if near is None else near
        return near[self.among(points, sliders, near)]

    def among(self, points: Points, sliders: Points, rows: Indices) -> Mask:
        """(R,) which of some contacts are too deep."""
        return np.asarray(self.excess(points, sliders, rows) > _TOO_DEEP * self.diameter)

    def size(self, scenes: Sequence[_Scene], frames: int) -> float:
        """The largest excess in some of the frames."""
        return max(map(self._largest, scenes))

    def _largest(self, scene: _Scene) -> float:
        return float(self.excess(scene.pose, scene.sliders).max(initial=0.0))

    def grows(self, scenes: Sequence[_Scene], displacement: Points) -> bool:
        """Whether a displacement makes the largest excess larger."""
        after = (scene._replace(pose=scene.pose + scene.weight * displacement) for scene in scenes)
        return max(map(self._largest, after)) > max(map(self._largest, scenes))

    def vertices(self, rows: Indices) -> Indices:
        """Both sides of contacts."""
        return np.concatenate([self.contacts.vertices[rows], self.contacts.faced[rows].indices])

    def bounds(self, points: Points, scene: _Scene, rows: Indices) -> _Bounds:
        """What parts contacts in a pose of a scene, beyond it."""
        off, normals, faced = self.contacts.closest(points, rows)
        own = np.stack([self.contacts.vertices[rows], faced] * 3, axis=1)
        gradients = scene.weight / 3 * np.stack([normals, -normals] * 3, axis=1)
        # More than a corrective may do at this weight is not asked of it.
        most = LARGEST / 2 * scene.weight * self.diameter
        bounds = np.minimum(dot(off, normals) - self._allowed(scene.sliders, rows), most)
        # In parts of a length, so that they count as much as those of creases.
        return _Bounds(own, gradients / self.contacts.farthest, bounds / self.contacts.farthest)


@dataclass(eq=False)
class _Task:
    """What a displacement is to undo, or not to do anew, in one scene."""

    kind: Folds | Creases | Lips
    scene: _Scene
    near: Indices  # rows that the displacement can change
    before: Indices  # rows that were damaged, seen or not
    wanted: Indices  # rows that bound the displacement

    def bounds(self, displacement: Points) -> _Bounds:
        points = self.scene.pose + self.scene.weight * displacement
        vertices, gradients, bounds = self.kind.bounds(points, self.scene, self.wanted)
        before = np.einsum("kci,kci->k", gradients, displacement[vertices])
        return _Bounds(vertices, gradients, bounds + before)

    def look(self, displacement: Points, *, seen: bool) -> bool:
        """Want what is damaged anew, and what is seen; whether anything wanted is left."""
        kind, (pose, sliders, weight, _) = self.kind, self.scene
        points = pose + weight * displacement
        now = self.near[kind.among(points, sliders, self.near)]
        more = ~np.isin(now, self.before)
        if seen and isinstance(kind, Folds | Lips):
            more |= np.isin(now, kind.found(points, sliders, now))
        left = bool((more | np.isin(now, self.wanted)).any())
        self.wanted = np.union1d(self.wanted, now[more])
        return left


def _least(free: Indices, factor: Any, answers: dict[int, Points], limits: list[_Bounds]) -> Points:
    """(N, 3) least displacement of the free vertices within limits, damped.

    Answers to a pull at one vertex are kept: other limits ask for most of them again.
    """
    from scipy.linalg import cholesky, solve_triangular
    from scipy.optimize import nnls

    corners, gradients, bounds = map(np.concatenate, zip(*limits, strict=True))
    if len(bounds) > _MOST:  # the worst of them; what is left comes in later rounds
        some = np.argsort(-bounds)[:_MOST]
        corners, gradients, bounds = corners[some], gradients[some], bounds[some]
    place = np.minimum(np.searchsorted(free, corners), len(free) - 1)
    gradients = gradients * (free[place] == corners)[:, :, None]
    used, column = np.unique(place, return_inverse=True)
    fresh = [one for one in used.tolist() if one not in answers]
    units = np.zeros((len(free), len(fresh)))
    units[fresh, np.arange(len(fresh))] = 1.0
    answers.update(zip(fresh, factor.solve(units).T, strict=True))
    green = np.stack([answers[one] for one in used.tolist()])
    pulls = np.zeros((len(bounds), len(used), 3))
    np.add.at(pulls, (np.arange(len(bounds))[:, None], column.reshape(place.shape)), gradients)
    flat = pulls.transpose(0, 2, 1).reshape(len(bounds), -1)
    gram = (pulls.transpose(0, 2, 1) @ green[:, used]).reshape(flat.shape) @ flat.T
    gram[np.diag_indices_from(gram)] += _DAMPING * max(float(gram.diagonal().max()), 1e-300)
    upper = cholesky(gram)
    dual, _ = nnls(upper, solve_triangular(upper, bounds, trans="T"), maxiter=30 * len(bounds))
    return np.asarray(green.T @ np.tensordot(dual, pulls, 1))


@dataclass(eq=False)
class _Search:
    """What is looked at to choose correctives, moved by those that were taken."""

    rig: Rig
    contacts: Contacts
    damage: Folds | Lips
    creases: Creases
    mass: Points
    laplacian: Any
    frames: Points  # (F, sliders) of takes
    poses: list[Points]
    found: list[Indices]  # what is damaged in each
    events: list[Event]
    tried: set[tuple[int, int]] = field(default_factory=set)
    taken: list[tuple[list[int], Points]] = field(default_factory=list)

    @classmethod
    def of(cls, kind: type[Folds | Lips], rig: Rig, alone: list[Points], frames: Points) -> _Search:
        surface = Surface.of(rig)
        contacts = Contacts.of(surface, rig.neutral, alone)
        damage = Lips.of(rig, contacts) if kind is Lips else Folds(surface)
        operators = surface_operators(rig.neutral)
        creases = Creases(surface, neighbours(surface.triangles))
        # Operators measure in units in which the area is 1.
        laplacian = operators.laplacian * (_SMOOTH * surface.diameter) ** 2 / operators.area
        poses = [rig.pose(frame) for frame in frames]
        found = [damage.found(*each) for each in zip(poses, frames, strict=True)]
        looked = [own[spread_rows(len(own), kind.looked_at)] for own in found]
        events = list(by_sliders(rig, frames, looked, damage.among))
        known = contacts, damage, creases, operators.mass, laplacian
        return cls(rig, *known, frames, poses, found, events)

    def next_pair(self) -> tuple[int, int] | None:
        """The pair of sliders that takes part in most damage, once; None where none is left."""
        counts = Counter(pair for *_, own in self.events for pair in combinations(own, 2))
        left = [(counts[pair], pair) for pair in counts if pair not in self.tried]
        most, pair = max(left, default=(0, None))
        if pair is None or most < _LEAST:
            return None
        self.tried.add(pair)
        return pair

    def scenes(self, pair: tuple[int, int]) -> dict[int, _Scene]:
        """Frames in which a pair is active."""
        least = self.frames[:, pair].min(axis=1)
        return {
            place: _Scene(self.poses[place], self.frames[place], least[place], self.found[place])
            for place in np.flatnonzero(least > 0).tolist()
        }

    def take(self, pair: tuple[int, int], displacement: Points) -> tuple[float, float]:
        """Move the frames by a corrective; damage before and after, where it is active."""
        scenes = self.scenes(pair)
        before = self.damage.size([*scenes.values()], len(self.frames))
        for place, (pose, sliders, weight, _) in scenes.items():
            self.poses[place] = pose + weight * displacement
            self.found[place] = self.damage.found(self.poses[place], sliders)
        after = self.damage.size([*self.scenes(pair).values()], len(self.frames))
        self.taken.append(([*pair], displacement))
        self.events = [one for one in self.events if one[1] in self.found[one[0]]]
        return before, after

    def corrective(self, pair: tuple[int, int]) -> Points | None:
        """(V, 3) what undoes damage of a pair, None where that is too little or adds other."""
        judged = self.scenes(pair)
        own = np.unique([place for place, _, by in self.events if {*pair} <= {*by}])
        own = own[self.frames[own][:, pair].min(axis=1) > ACTIVE]
        fitted = [
            judged[place] for place in own[spread_rows(len(own), self.damage.fitted)].tolist()
        ]
        every, grid = [*judged.values()], []
        for weights in product(self.damage.grid, self.damage.grid):
            row = np.zeros(len(self.rig.names))
            row[[*pair]] = weights
            pose = self._pose(row)
            grid.append(_Scene(pose, row, min(weights), self.damage.found(pose, row)))
        checked = [every[place] for place in spread_rows(len(every), _CHECKED)]
        tries = [(grid + fitted, ()), (fitted, ())] if grid else [(fitted, ()), (fitted, checked)]
        for scenes, watched in tries:
            fit = self.fit(scenes, watched)
            far = float(np.linalg.norm(fit, axis=1).max())
            fit *= min(1.0, LARGEST * self.contacts.surface.diameter / max(far, 1e-300))
            for share in self.damage.shares:
                if self._gain(every, share * fit) >= _LEAST and not self._adds(every, share * fit):
                    return share * fit
        return None

    def fit(self, scenes: Sequence[_Scene], watched: Sequence[_Scene] = ()) -> Points:
        """(V, 3) the displacement that undoes the damage of scenes, 0 where there is none.

        In watched scenes it only does no other.
        """
        from scipy.sparse import csc_array, diags_array

        found, undone = np.zeros((len(self.mass), 3)), self.damage
        if not any(len(scene.rows) for scene in scenes):
            return found
        free = self._around(undone.vertices(np.unique(np.concatenate([s.rows for s in scenes]))))
        mass, laplacian = self.mass[free], self.laplacian[:, free]
        smooth = csc_array(laplacian.T @ diags_array(1.0 / self.mass) @ laplacian)
        factor = symmetric_factor(csc_array(smooth + diags_array(mass, format="csc")))
        answers: dict[int, Points] = {}
        moves = np.zeros(len(self.mass), dtype=bool)
        moves[free] = True
        guarded = (self.creases,) if isinstance(undone, Lips) else ()
        tasks = []
        for kind in (*guarded, undone):
            near = kind.near(moves)
            for scene in scenes if kind is undone else (*scenes, *watched):
                before = near[kind.among(scene.pose, scene.sliders, near)]
                wanted = scene.rows if kind is undone else before[:0]
                tasks.append(_Task(kind, scene, near, before, wanted))
        for turn in range(_ROUNDS):
            limits = [task.bounds(found) for task in tasks if len(task.wanted)]
            found[free] = _least(free, factor, answers, limits)
            # What was damaged before and is seen now counts too, every other time.
            left = [task.look(found, seen=turn % 2 == 1) for task in tasks]
            if turn % 2 and not any(left):
                break
        return found

    def _around(self, vertices: Indices) -> Indices:
        """Vertices within some rings of some, those at the end of the rings left out."""
        touching = self.contacts.surface.touching
        reached = np.zeros(len(self.mass), dtype=np.float32)
        reached[vertices] = 1.0
        for _ in range(_RINGS):
            reached = ((touching @ (touching.T @ reached)) > 0).astype(np.float32)
        return np.flatnonzero(reached)

    def _pose(self, row: Points) -> Points:
        """The rig with what was taken."""
        points = self.rig.pose(row)
        for drivers, displacement in self.taken:
            points += max(0.0, row[drivers].min()) * displacement
        return points

    def _gain(self, scenes: Sequence[_Scene], displacement: Points) -> int:
        """How much less is damaged, in numbers."""
        near, gain = self.damage.near(np.any(displacement, axis=1)), 0
        for pose, sliders, m, rows in scenes:
            left = self.damage.found(pose + m * displacement, sliders, near)
            gain += int(np.isin(rows, near).sum()) - len(left)
        return gain

    def _adds(self, scenes: Sequence[_Scene], displacement: Points) -> bool:
        """Whether a displacement adds edges that turn back, vertices that pass, or depth."""
        contacts, moved = self.contacts, np.any(displacement, axis=1)
        rows, edges = np.flatnonzero(moved[contacts.vertices]), self.creases.near(moved)
        crossing, turned = np.zeros((2, 2), dtype=np.int64)
        for place in spread_rows(len(scenes), _CHECKED):
            pose, sliders, m, _ = scenes[place]
            for when, points in enumerate((pose, pose + m * displacement)):
                turned[when] += self.creases.among(points, sliders, edges).sum()
                depth, passes = contacts.depths(points, rows)
                crossing[when] += (depth[passes] > DEEP * contacts.surface.diameter).sum()
        added = turned[1] > turned[0] or crossing[1] > crossing[0]
        return bool(added or self.damage.grows(scenes, displacement))
