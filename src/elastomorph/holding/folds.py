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
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import combinations, product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.holding.correction import Correction, straight_morph
from elastomorph.holding.damage import (
    ACTIVE,
    DEEP,
    Contacts,
    Indices,
    Points,
    Surface,
    crosses,
    dot,
    folds_by_sliders,
    taken_weights,
)
from elastomorph.model.cholesky import symmetric_factor
from elastomorph.model.geometry import neighbours
from elastomorph.model.morph import Morph
from elastomorph.model.surface import surface_operators
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
# Frames of takes that correctives are chosen by, and those of them that one is fitted to.
_FRAMES, _FITTED = 100, 8
# Visible folds, in all frames that are looked at, that a corrective must undo.
_LEAST = 2
# Frames in which it is looked for what a corrective adds.
_CHECKED = 30


def fold_corrections(
    rig: Rig, most: int, takes: Sequence[Performance]
) -> Iterator[tuple[Correction, Morph | None]]:
    """Correctives that undo visible folds where two sliders meet, the most useful first.

    Each is driven by the lesser weight of two sliders and is fitted to 16 weights of the two, in
    quarters, and to frames in which they fold something. One that would move a vertex farther than
    `LARGEST` is made smaller; one that leaves as many folds as there were, or adds edges at which
    the surface turns back, or vertices that pass what they face, is dropped.

    Args:
        rig: The rig; what counts is its `Rig.pose`.
        most: How many at most.
        takes: Weights that say which sliders meet, and how far. Only the first half of each is
            looked at, so that the second can tell what was gained.

    Yields:
        A row, whose damage is folds a frame that was looked at, and the morph that it tells of;
        none where the rig has one of this name.

    Raises:
        MeshError: The neutral has no polygons.
        ParameterError: A rig with fewer than two sliders, or a take that drives none of them.
    """
    if len(rig.names) < 2:
        raise ParameterError(f"pairs need two sliders or more, the rig has {len(rig.names)}")
    weights = [taken_weights(rig, take) for take in takes]
    halves = [own[: (len(own) + 1) // 2] for own in weights]
    share = -(-_FRAMES // len(halves))
    frames = np.concatenate([half[spread_rows(len(half), share)] for half in halves])
    search, every = _Search.of(rig, frames), np.concatenate(weights)
    while most and (pair := search.next_pair()) is not None:
        names = tuple(rig.names[place] for place in pair)
        name = "_".join(("fold", *names))
        if name in rig:
            yield Correction(name, note=f"{name} is there already, and kept"), None
        elif (displacement := search.corrective(pair)) is not None:
            before, after = search.take(pair, displacement)
            in_use = int((every[:, pair].min(axis=1) > 0).sum())
            most -= 1
            yield (
                Correction(name, names, "min", (), before, after, frames=in_use, targets=1),
                straight_morph(rig, np.arange(len(displacement)), displacement),
            )


class _Scene(NamedTuple):
    """A pose, the weight of the corrective in it, and triangles to unfold."""

    pose: Points
    weight: float
    rows: Indices


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
        lengths = np.linalg.norm(crosses(surface.rest, surface.triangles), axis=1)
        # Operators measure in units in which the area is 1.
        length = _SMOOTH * surface.diameter / np.sqrt(operators.area)
        return cls(surface, operators.mass, operators.laplacian * length**2, lengths)

    def fit(self, scenes: Sequence[_Scene]) -> Points:
        """(V, 3) the displacement that undoes the folds of scenes, 0 where there are none."""
        from scipy.sparse import csc_array, diags_array

        surface, found = self.surface, np.zeros((len(self.mass), 3))
        if not any(len(scene.rows) for scene in scenes):
            return found
        free = self._around(np.unique(np.concatenate([scene.rows for scene in scenes])))
        mass, laplacian = self.mass[free], self.laplacian[:, free]
        smooth = csc_array(laplacian.T @ diags_array(1.0 / self.mass) @ laplacian)
        factor = symmetric_factor(csc_array(smooth + diags_array(mass, format="csc")))
        moves = np.zeros(len(self.mass), dtype=bool)
        moves[free] = True
        near = np.flatnonzero(surface.reached(moves) & ~surface.folded_at_rest)
        wanted = [scene.rows for scene in scenes]
        folded = [near[surface.folded(scene.pose, near)] for scene in scenes]
        for turn in range(_ROUNDS):
            parts = [
                self._linear(pose + m * found, m, rows, found)
                for (pose, m, _), rows in zip(scenes, wanted, strict=True)
            ]
            found[free] = _least(factor, free, *map(np.concatenate, zip(*parts, strict=True)))
            left = False
            for place, (pose, m, _) in enumerate(scenes):
                points = pose + m * found
                now = near[surface.folded(points, near)]
                more = ~np.isin(now, folded[place])
                if turn % 2:  # what was folded before, and hidden by what is unfolded now
                    more |= surface.seen(points, now)
                left |= bool((more | np.isin(now, wanted[place])).any())
                wanted[place] = np.union1d(wanted[place], now[more])
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
        self, points: Points, weight: float, rows: Indices, found: Points
    ) -> tuple[Indices, Points, Points]:
        """(K, 3) corners, (K, 3, 3) their gradients and (K,) bounds of triangles in a pose."""
        own = self.surface.triangles[rows]
        across, mean = self.surface.normals_around(points, rows)
        mean /= np.maximum(np.linalg.norm(mean, axis=1, keepdims=True), 1e-300)
        a, b, c = points[own.T]
        # n·(a × b + b × c + c × a) by a is n × (c - b), and so on round the triangle.
        gradients = weight * np.stack([np.cross(mean, side) for side in (c - b, a - c, b - a)], 1)
        length = np.maximum(self.at_rest[rows], 1e-300)
        bounds = np.einsum("kci,kci->k", gradients, found[own]) - dot(across, mean)
        return own, gradients / length[:, None, None], _UPRIGHT + bounds / length


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
    """What is looked at to choose correctives, moved by those that were taken."""

    rig: Rig
    surface: Surface
    contacts: Contacts
    fitter: _Fitter
    edges: Indices  # (E, 2) triangles on both sides of an edge
    frames: NDArray[np.float64]  # (F, sliders) of takes
    poses: list[Points]
    folds: list[Indices]  # triangles that are seen folded in each
    events: list[tuple[int, int, tuple[int, ...]]]  # frame and triangle, sliders that it takes
    tried: set[tuple[int, int]] = field(default_factory=set)
    taken: list[tuple[list[int], Points]] = field(default_factory=list)

    @classmethod
    def of(cls, rig: Rig, frames: NDArray[np.float64]) -> _Search:
        surface = Surface.of(rig)
        alone = [surface.rest, *(rig.pose({name: 1.0}) for name in rig.names)]
        contacts = Contacts.of(surface, rig.neutral, alone)
        poses = [rig.pose(frame) for frame in frames]
        folds = [surface.visible_folds(pose) for pose in poses]
        events = list(folds_by_sliders(rig, surface, frames))
        edges, fitter = neighbours(surface.triangles), _Fitter.of(rig, surface)
        return cls(rig, surface, contacts, fitter, edges, frames, poses, folds, events)

    def next_pair(self) -> tuple[int, int] | None:
        """The pair of sliders that takes part in most folds, once; None where no pair is left."""
        counts = Counter(pair for *_, own in self.events for pair in combinations(own, 2))
        left = [(counts[pair], pair) for pair in counts if pair not in self.tried]
        most, pair = max(left, default=(0, None))
        if pair is None or most < _LEAST:
            return None
        self.tried.add(pair)
        return pair

    def take(self, pair: tuple[int, int], displacement: Points) -> tuple[float, float]:
        """Move the frames by a corrective; folds a frame before and after, where it is active."""
        least = self.frames[:, pair].min(axis=1)
        active = np.flatnonzero(least > 0)
        before = sum(len(self.folds[place]) for place in active)
        for place in active:
            self.poses[place] += least[place] * displacement
            self.folds[place] = self.surface.visible_folds(self.poses[place])
        after = sum(len(self.folds[place]) for place in active)
        self.taken.append(([*pair], displacement))
        self.events = [one for one in self.events if one[1] in self.folds[one[0]]]
        return before / len(least), after / len(least)

    def corrective(self, pair: tuple[int, int]) -> Points | None:
        """(V, 3) what undoes folds of a pair, None where that is too little or adds damage."""
        columns, least = [*pair], self.frames[:, pair].min(axis=1)
        judged = {
            place: _Scene(self.poses[place], least[place], self.folds[place])
            for place in np.flatnonzero(least > 0)
        }
        own = np.unique([place for place, _, by in self.events if {*pair} <= {*by}])
        own = own[least[own] > ACTIVE]
        fitted = [judged[place] for place in own[spread_rows(len(own), _FITTED)]]
        grid = []
        for weights in product(_GRID, _GRID):
            row = np.zeros(len(self.rig.names))
            row[columns] = weights
            pose = self._pose(row)
            grid.append(_Scene(pose, min(weights), self.surface.visible_folds(pose)))
        for scenes in (grid + fitted, fitted):
            displacement = self.fitter.fit(scenes)
            far = float(np.linalg.norm(displacement, axis=1).max())
            displacement *= min(1.0, LARGEST * self.surface.diameter / max(far, 1e-300))
            if self._gain([*judged.values()], displacement) >= _LEAST and not self._adds(
                [*judged.values()], displacement
            ):
                return displacement
        return None

    def _pose(self, row: NDArray[np.float64]) -> Points:
        """The rig with what was taken."""
        points = self.rig.pose(row)
        for drivers, displacement in self.taken:
            points += max(0.0, row[drivers].min()) * displacement
        return points

    def _gain(self, scenes: Sequence[_Scene], displacement: Points) -> int:
        """How many visible folds fewer there are."""
        surface, gain = self.surface, 0
        reached = surface.reached(np.any(displacement, axis=1))
        near = np.flatnonzero(reached & ~surface.folded_at_rest)
        for pose, m, rows in scenes:
            points = pose + m * displacement
            left = near[surface.folded(points, near)]
            gain += int(reached[rows].sum() - surface.seen(points, left).sum())
        return gain

    def _adds(self, scenes: Sequence[_Scene], displacement: Points) -> bool:
        """Whether a displacement adds edges that turn back, or vertices behind what they face."""
        surface, contacts = self.surface, self.contacts
        rows = np.flatnonzero(displacement[contacts.vertices].any(axis=1))
        crossing, turned = np.zeros((2, 2), dtype=np.int64)
        for place in spread_rows(len(scenes), _CHECKED):
            pose, m, _ = scenes[place]
            for when, points in enumerate((pose, pose + m * displacement)):
                turned[when] += self._turned_back(points)
                depth, passes = contacts.depths(points, rows)
                crossing[when] += (depth[passes] > DEEP * surface.diameter).sum()
        return bool(turned[1] > turned[0] or crossing[1] > crossing[0])

    def _turned_back(self, points: Points) -> int:
        across = crosses(points, self.surface.triangles)
        return int((dot(across[self.edges[:, 0]], across[self.edges[:, 1]]) < 0).sum())
