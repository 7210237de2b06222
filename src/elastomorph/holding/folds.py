"""Correctives that undo folds where sliders meet: the smallest smooth displacement that does.

A displacement u of the vertices, driven by m, the least weight of some sliders, turns a triangle
with normal c against the unit normal n of its neighbourhood by n·dc(m u), which is linear in u for
small u. The least u that unfolds triangles in several poses at once is

    min ½ uᵀ Q u   such that   n·c + m n·dc(u) ≥ ε |c₀|   for each triangle and pose,

where Q = M + ℓ⁴ L M⁻¹ L, of the mass and the Laplacian of the neutral, makes it smooth, and u is 0
away from the triangles. In its dual there is one number of at least 0 a triangle and pose (Lawson
and Hanson, Solving Least Squares Problems, 1974, ch. 23). As c is not linear in u, this is repeated
from where the last u led, with what that folds anew.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations, product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.holding.damage import (
    ACTIVE,
    DEEP,
    Contacts,
    Indices,
    Mask,
    Patch,
    Points,
    Surface,
    crosses,
    dot,
    folds_by_sliders,
    rank_meetings,
    taken_weights,
)
from elastomorph.model.cholesky import symmetric_factor
from elastomorph.model.geometry import sides_of
from elastomorph.model.morph import Morph
from elastomorph.model.surface import surface_operators
from elastomorph.paths.straight import Linear
from elastomorph.rig.laws import Corrective
from elastomorph.rig.performance import Performance
from elastomorph.rig.rig import Rig
from elastomorph.rig.sliders import spread_rows

LARGEST = 8e-3
"""Farthest that a corrective may move a vertex, over D."""

# Weights of each slider at which folds are undone at once, 16 of a pair.
_GRID = (0.25, 0.5, 0.75, 1.0)
# The normal of a triangle along that of its neighbourhood, over its length at rest.
_UPRIGHT = 0.05
# Length below which displacements are smooth, over D, and rings that may move around a fold.
_SMOOTH, _RINGS = 0.005, 8
# Rounds of linearising, and triangles and poses of one problem at most.
_ROUNDS, _MOST = 6, 300
# What the dual is damped by, over its largest diagonal, for folds that nothing undoes.
_DAMPING = 1e-7
# Frames of a take that correctives are chosen by, and those of them that one is fitted to.
_FRAMES, _FITTED = 100, 8
# Visible folds, in all that is looked at, that a corrective must undo.
_LEAST = 2
# Poses in which it is looked for what a corrective adds.
_CHECKED = 30
# Parts of a corrective that are tried, where the whole of it adds something.
_SHARES = (1.0, 0.5)


@dataclass(frozen=True)
class FoldRow:
    """One corrective in a table.

    Attributes:
        sliders: What drives it.
        before: Visible folds before, a frame of the take or a pose of the grid.
        after: The same with the corrective.
        moved: How far it moves a vertex, in the unit of the neutral.
        share: That over D.
        vertices: How many it moves.
    """

    sliders: tuple[str, ...]
    before: float
    after: float
    moved: float
    share: float
    vertices: int


def fold_correctives(
    rig: Rig,
    count: int,
    takes: Performance | Sequence[Performance] | None = None,
    *,
    say: Callable[[str], None] = lambda _: None,
) -> list[tuple[str, Morph, Corrective, FoldRow]]:
    """Propose correctives that undo visible folds where two sliders meet, the most useful first.

    Each is driven by the lesser weight of two sliders and is fitted to 16 weights of the two, in
    quarters, and to frames in which they fold something. One that moves a vertex farther than
    `LARGEST` is made smaller; one that leaves as many folds as there were, or adds edges at which
    the surface turns back, or vertices that pass what they face, is dropped. The eye gains little:
    nothing proposes them unless it is asked to.

    Args:
        rig: The rig; what counts is its `Rig.pose`.
        count: How many at most.
        takes: Weights that say which sliders meet, and how far. Only the first half of each is
            looked at, so that the second can tell what was gained.
        say: Told what is being done.

    Returns:
        Name, straight path from the neutral, drivers and row of a table of each.

    Raises:
        MeshError: The neutral has no polygons.
        ParameterError: A count below 1, a rig with fewer than two sliders, or a take that drives
            none of them.
    """
    if not isinstance(count, int) or count < 1:
        raise ParameterError(f"correctives of folds: expected a count of at least 1, found {count}")
    if len(rig.names) < 2:
        raise ParameterError(f"pairs need two sliders or more, the rig has {len(rig.names)}")
    takes = [takes] if isinstance(takes, Performance) else list(takes or ())
    weights = [taken_weights(rig, take) for take in takes]
    search = _Search.of(rig, weights, say)
    path, rest = Linear().prepare(rig.neutral), rig.neutral.vertices
    proposals: list[tuple[str, Morph, Corrective, FoldRow]] = []
    while len(proposals) < count:
        found = search.next()
        if found is None:
            break
        names, displacement, row = found
        name = "_".join(("fold", *names))
        morph = path(rig.neutral.with_vertices(rest + displacement))
        proposals.append((name, morph, Corrective(names, "min"), row))
        say(f"{len(proposals)} of {count}: {' and '.join(names)}")
    return proposals


@dataclass(frozen=True, eq=False)
class _Event:
    """A triangle that is folded and seen in a frame, and the pairs of sliders that may mend it."""

    frame: int
    row: int
    pairs: tuple[tuple[int, int], ...]


@dataclass(frozen=True, eq=False)
class _Scenes:
    """Poses with the weight of the corrective in each, and triangles to unfold."""

    poses: list[Points]
    weights: list[float]
    rows: list[Indices]

    @property
    def folds(self) -> int:
        """How many there are to unfold."""
        return sum(map(len, self.rows))

    @classmethod
    def of(cls, surface: Surface, poses: list[Points], weights: list[float]) -> _Scenes:
        """Poses with all that is folded and seen in them."""
        return cls(poses, weights, [surface.visible_folds(pose) for pose in poses])

    def only(self, places: Iterable[int]) -> _Scenes:
        """Some of the poses."""
        kept = ([own[place] for place in places] for own in (self.poses, self.weights, self.rows))
        return _Scenes(*kept)  # type: ignore[arg-type]

    def __add__(self, other: _Scenes) -> _Scenes:
        return _Scenes(
            self.poses + other.poses, self.weights + other.weights, self.rows + other.rows
        )


@dataclass(eq=False)
class _Fitter:
    """Displacements of one rig."""

    surface: Surface
    mass: NDArray[np.float64]
    laplacian: Any
    at_rest: NDArray[np.float64]  # (T,) lengths of the normals of triangles

    @classmethod
    def of(cls, rig: Rig, surface: Surface) -> _Fitter:
        operators = surface_operators(rig.neutral)
        lengths = np.linalg.norm(crosses(rig.neutral.vertices, surface.triangles), axis=1)
        # Operators measure in units in which the area is 1.
        length = _SMOOTH * surface.diameter / np.sqrt(operators.area)
        return cls(surface, operators.mass, operators.laplacian * length**2, lengths)

    def fit(self, scenes: _Scenes) -> Points | None:
        """(V, 3) the displacement that undoes the folds of scenes, None where there are none."""
        from scipy.sparse import csc_array, diags_array

        if not scenes.folds:
            return None
        surface = self.surface
        free = self._around(np.unique(np.concatenate(scenes.rows)))
        mass, laplacian = self.mass[free], self.laplacian[:, free]
        smooth = csc_array(laplacian.T @ diags_array(1.0 / self.mass) @ laplacian)
        factor = symmetric_factor(csc_array(smooth + diags_array(mass, format="csc")))
        moves = np.zeros(len(self.mass), dtype=bool)
        moves[free] = True
        patch = surface.patch(np.flatnonzero(surface.reached(moves)))
        found = np.zeros((len(self.mass), 3))
        wanted = [np.isin(patch.rows, rows) for rows in scenes.rows]
        folded = [patch.folded(pose) for pose in scenes.poses]
        for turn in range(_ROUNDS):
            rows = [
                self._linear(patch, pose + m * found, m, some, found)
                for pose, m, some in zip(scenes.poses, scenes.weights, wanted, strict=True)
            ]
            found[free] = _least(factor, free, *map(np.concatenate, zip(*rows, strict=True)))
            left = False
            for scene, (pose, m) in enumerate(zip(scenes.poses, scenes.weights, strict=True)):
                points = pose + m * found
                now = patch.folded(points) & ~surface.folded_at_rest[patch.rows]
                more = now & ~folded[scene]
                if turn % 2:  # what was folded before, and hidden by what is unfolded now
                    more[now] |= surface.seen(points, patch.rows[now])
                left |= bool((now & (wanted[scene] | more)).any())
                wanted[scene] = wanted[scene] | more
            if turn % 2 and not left:
                break
        return found

    def _around(self, rows: Indices) -> Indices:
        """Vertices within some rings of triangles, those at the end of the rings left out."""
        touching, reached = self.surface.touching, np.zeros(len(self.mass), dtype=np.float32)
        reached[self.surface.triangles[rows]] = 1.0
        for _ in range(_RINGS):
            reached = ((touching @ (touching.T @ reached)) > 0).astype(np.float32)
        return np.flatnonzero(reached)

    def _linear(
        self, patch: Patch, points: Points, weight: float, wanted: Mask, found: Points
    ) -> tuple[Indices, Points, NDArray[np.float64]]:
        """(K, 3) corners, (K, 3, 3) their gradients and (K,) bounds of triangles of a patch."""
        rows = np.flatnonzero(wanted)
        own = patch.own[rows]
        mean = patch.near[rows] @ crosses(points, patch.around)
        mean /= np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-300)
        a, b, c = points[own.T]
        # n·(a × b + b × c + c × a) by a is n × (c - b), and so on round the triangle.
        gradients = weight * np.stack([np.cross(mean, side) for side in (c - b, a - c, b - a)], 1)
        height = np.einsum("ki,ki->k", crosses(points, own), mean)
        length = self.at_rest[patch.rows[rows]]
        bounds = _UPRIGHT * length - height + np.einsum("kci,kci->k", gradients, found[own])
        scale = 1.0 / np.maximum(length, 1e-300)
        return own, gradients * scale[:, None, None], bounds * scale


def _least(
    factor: Any, free: Indices, corners: Indices, gradients: Points, bounds: Points
) -> Points:
    """(N, 3) least displacement of the free vertices with gradients·u ≥ bounds, damped."""
    from scipy.linalg import cholesky, solve_triangular
    from scipy.optimize import nnls
    from scipy.sparse import csc_array

    if len(bounds) > _MOST:  # the worst of them; what is left comes in later rounds
        some = np.argsort(-bounds)[:_MOST]
        corners, gradients, bounds = corners[some], gradients[some], bounds[some]
    place = np.minimum(np.searchsorted(free, corners), len(free) - 1)
    gradients = gradients * (free[place] == corners)[:, :, None]
    number = np.repeat(np.arange(len(bounds)), 3)
    across = [
        csc_array(
            (gradients[:, :, axis].ravel(), (place.ravel(), number)), (len(free), len(bounds))
        )
        for axis in range(3)
    ]
    solved = [factor.solve(matrix.toarray()) for matrix in across]
    gram = sum(matrix.T @ own for matrix, own in zip(across, solved, strict=True))
    gram[np.diag_indices_from(gram)] += _DAMPING * max(float(gram.diagonal().max()), 1e-300)
    upper = cholesky(gram)
    dual, _ = nnls(upper, solve_triangular(upper, bounds, trans="T"), maxiter=30 * len(bounds))
    return np.stack([own @ dual for own in solved], axis=1)


@dataclass(eq=False)
class _Search:
    """What is looked at to choose correctives, and those that were taken."""

    rig: Rig
    surface: Surface
    contacts: Contacts
    fitter: _Fitter
    frames: NDArray[np.float64]  # (F, sliders) of takes
    events: list[_Event]
    order: list[tuple[int, int]]  # without a take, pairs to try
    edges: Indices  # (E, 2) triangles on both sides of an edge
    posed: _Scenes  # the frames, with what was taken
    tried: set[tuple[int, int]] = field(default_factory=set)
    taken: list[tuple[list[int], Points]] = field(default_factory=list)

    @classmethod
    def of(
        cls, rig: Rig, weights: Sequence[NDArray[np.float64]], say: Callable[[str], None]
    ) -> _Search:
        surface = Surface.of(rig)
        poses = [rig.neutral.vertices, *(rig.pose({name: 1.0}) for name in rig.names)]
        order: list[tuple[int, int]] = []
        frames, events, posed = np.zeros((0, len(rig.names))), [], _Scenes([], [], [])
        if weights:
            say("looking at frames of the take")
            halves = [own[: (len(own) + 1) // 2] for own in weights]
            share = -(-_FRAMES // len(halves))
            frames = np.concatenate([half[spread_rows(len(half), share)] for half in halves])
            posed = _Scenes.of(surface, [rig.pose(frame) for frame in frames], [0.0] * len(frames))
            moved = [np.any(pose != poses[0], axis=1) for pose in poses[1:]]
            reached = np.array([surface.reached(each) for each in moved])
            events = [
                _Event(place, row, _mending(frames[place], sliders, reached[:, row]))
                for place, row, sliders in folds_by_sliders(rig, surface, frames)
            ]
        else:
            ranked = rank_meetings(rig, triples=False, say=say)
            places = {name: place for place, name in enumerate(rig.names)}
            order = [
                (places[one.sliders[0]], places[one.sliders[1]])
                for one in ranked
                if one.folds and not one.opposite
            ]
        contacts = Contacts.of(surface, rig.neutral, poses)
        sides = np.sort(sides_of(surface.triangles), axis=1)
        by_side = np.lexsort(sides.T)
        same = (np.diff(sides[by_side], axis=0) == 0).all(axis=1)
        edges = np.stack([by_side[:-1][same], by_side[1:][same]], axis=1) % len(surface.triangles)
        return cls(
            rig, surface, contacts, _Fitter.of(rig, surface), frames, events, order, edges, posed
        )

    def pose(self, row: NDArray[np.float64]) -> Points:
        """The rig with what was taken."""
        points = self.rig.pose(row)
        for drivers, displacement in self.taken:
            points += max(0.0, row[drivers].min()) * displacement
        return points

    def next(self) -> tuple[tuple[str, str], Points, FoldRow] | None:
        """The next corrective that is worth it, which is taken; None where no pair has one."""
        while (pair := self._pair()) is not None:
            self.tried.add(pair)
            found = self._corrective(pair)
            if found is None:
                continue
            displacement, row = found
            self._take(pair, displacement)
            return (self.rig.names[pair[0]], self.rig.names[pair[1]]), displacement, row
        return None

    def _take(self, pair: tuple[int, int], displacement: Points) -> None:
        """Move the frames by a corrective, and forget what it mends."""
        self.taken.append(([*pair], displacement))
        for place in np.flatnonzero(self.frames[:, pair].min(axis=1) > 0):
            pose = self.posed.poses[place]
            pose += self.frames[place, pair].min() * displacement
            self.posed.rows[place] = self.surface.visible_folds(pose)
        self.events = [one for one in self.events if one.row in self.posed.rows[one.frame]]

    def _pair(self) -> tuple[int, int] | None:
        if not len(self.frames):
            return next((pair for pair in self.order if pair not in self.tried), None)
        counts = Counter(pair for event in self.events for pair in event.pairs)
        left = [(counts[pair], pair) for pair in counts if pair not in self.tried]
        most, pair = max(left, default=(0, None))
        return pair if most >= _LEAST else None

    def _corrective(self, pair: tuple[int, int]) -> tuple[Points, FoldRow] | None:
        columns, surface = [*pair], self.surface
        grid = np.zeros((len(_GRID) ** 2, len(self.rig.names)))
        grid[:, columns] = [*product(_GRID, _GRID)]
        weights = grid[:, columns].min(axis=1).tolist()
        judged = scenes = _Scenes.of(surface, [self.pose(row) for row in grid], weights)
        tries = [scenes]
        if len(self.frames):
            least = self.frames[:, columns].min(axis=1)
            judged = replace(self.posed, weights=least.tolist()).only(np.flatnonzero(least > 0))
            own = np.unique([event.frame for event in self.events if pair in event.pairs])
            own = own[self.frames[own][:, columns].min(axis=1) > ACTIVE] if len(own) else own
            own = own[spread_rows(len(own), _FITTED)]
            fitted = replace(self.posed, weights=least.tolist()).only(own)
            tries = [scenes + fitted, fitted]
        best: tuple[int, Points] | None = None
        for one in tries:
            displacement = None if best else self.fitter.fit(one)
            if displacement is None:
                continue
            far = float(np.linalg.norm(displacement, axis=1).max())
            displacement *= min(1.0, LARGEST * surface.diameter / max(far, 1e-300))
            for share in _SHARES:
                gain = self._gain(judged, share * displacement)
                if gain < _LEAST:
                    break
                if not self._adds(judged, share * displacement):
                    best = gain, share * displacement
                    break
        if best is None:
            return None
        gain, displacement = best
        total = len(self.frames) or len(judged.poses)
        far = np.linalg.norm(displacement, axis=1)
        row = FoldRow(
            tuple(self.rig.names[i] for i in pair), judged.folds / total,
            (judged.folds - gain) / total, float(far.max()), float(far.max()) / surface.diameter,
            int((far > 0).sum()),
        )  # fmt: skip
        return displacement, row

    def _gain(self, scenes: _Scenes, displacement: Points) -> int:
        """How many visible folds fewer there are."""
        surface, gain = self.surface, 0
        patch = surface.patch(np.flatnonzero(surface.reached(np.any(displacement, axis=1))))
        upright = ~surface.folded_at_rest[patch.rows]
        for pose, m, rows in zip(scenes.poses, scenes.weights, scenes.rows, strict=True):
            points = pose + m * displacement
            left = patch.rows[patch.folded(points) & upright]
            gain += int(np.isin(rows, patch.rows).sum() - surface.seen(points, left).sum())
        return gain

    def _adds(self, scenes: _Scenes, displacement: Points) -> bool:
        """Whether a displacement adds edges that turn back, or vertices behind what they face."""
        surface, contacts = self.surface, self.contacts
        rows = np.flatnonzero(displacement[contacts.vertices].any(axis=1))
        crossing, turned = np.zeros((2, 2), dtype=np.int64)
        for place in spread_rows(len(scenes.poses), _CHECKED):
            pose, m = scenes.poses[place], scenes.weights[place]
            for when, points in enumerate((pose, pose + m * displacement)):
                turned[when] += self._turned_back(points)
                depth, passes = contacts.depths(points, surface.normals(points), rows)
                crossing[when] += (depth[passes] > DEEP * surface.diameter).sum()
        return bool(turned[1] > turned[0] or crossing[1] > crossing[0])

    def _turned_back(self, points: Points) -> int:
        across = crosses(points, self.surface.triangles)
        return int((dot(across[self.edges[:, 0]], across[self.edges[:, 1]]) < 0).sum())


def _mending(
    frame: NDArray[np.float64], sliders: tuple[int, ...], reached: Mask
) -> tuple[tuple[int, int], ...]:
    """Pairs of sliders whose meeting can mend a fold that takes some, active in a frame.

    Of the sliders it takes; where that is one, that and another which moves the triangle.
    """
    if len(sliders) > 1:
        return tuple(combinations(sliders, 2))
    others = np.flatnonzero((frame > max(ACTIVE, frame[sliders[0]] / 2)) & reached)
    first = sliders[0]
    return tuple((min(first, o), max(first, o)) for o in others.tolist() if o != first)
