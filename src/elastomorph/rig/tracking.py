"""Slider weights of a whole take of markers: the face that each frame shows, wherever the head is.

A marker is at y = s·R_f·p(w_f) + o_f, with p a point of the rig, one scale s for the take, and a
rotation and an offset a frame, which drop out: for every face they are those nearest to the
markers (variable projection). What is left is `Rig.solve` with each frame held near its neighbours,

    Σ_f Σ_m c |R_fᵀ(y - o_f)/s - p_m(w_f)|² / 2d² + λ Σ_j w_fj + μ/2 |w_f - w_f-1|²,

d the farthest that a slider moves a marker, and weights c that fade out markers far off (Geman and
McClure). Frames are solved one after the other, forward and then back.

What tracking a take of markers finds.

Slider weights that bring points of a face to positions: dragging a face.

After Lewis and Anjyo, Direct Manipulation Blendshapes (2010), on bent paths: the pose is that of
`Rig.pose` at the handles only, with the derivatives of bend curves and of the products that drive
correctives, and within bounds. Sliders that the handles do not need stay where they were.

Least squares with bounds and few moves: the x in a box whose residuals are smallest.

    ½ |r(x)|² + λ Σ |x_j - x⁰_j| + ½ ρ |x - x⁰|²,    low ≤ x ≤ high

The second term leaves at x⁰ exactly what need not move; the third, far smaller, shares out what the
others leave open. Levenberg-Marquardt steps, each the exact minimum of its quadratic model in the
box, which an active set finds: residuals have few parameters, so everything is small and dense.

Where many x reach the same, those of the least sum are at the end of a curved way along which the
residuals stay small. A step that leaves it is brought back by a second-order correction (Nocedal
and Wright, Numerical Optimization, 2006, Sec. 18.3).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import PurePath
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.blas_threads import one_blas_thread
from elastomorph.errors import ParameterError, warn
from elastomorph.model.geometry import fit_rotation
from elastomorph.model.markers import Markers
from elastomorph.numbers import as_number, as_numbers, is_whole
from elastomorph.rig.handles import Handle, HandledPoints, Place, asked, mixed
from elastomorph.rig.sliders import Sliders, Weights, spread_rows

if TYPE_CHECKING:
    from elastomorph.rig.rig import Rig


Floats = NDArray[np.float64]

# At (J,) parameters: (R,) residuals, their (R, J) derivatives, and (J, J) Σ_i r_i ∇²r_i or what of
# it is known and no direction has less than 0 of.
Residuals = Callable[[Floats], tuple[Floats, Floats, Floats]]

_STEPS = 60
# The search ends with a step of less than this in every parameter, or that promises no more than
# this part of the cost.
_PRECISION, _WORTH = 1e-8, 3e-4
# Damping where the model has held so far, as a part of the largest diagonal element; it is raised
# tenfold, and by ten times more for each time in a row.
_LEAST_DAMPING, _RAISE = 1e-8, 10.0
# Parameters that have more than this part of the most to gain are let go together.
_TOGETHER = 0.3


class Box(NamedTuple):
    """Where parameters may be, where they start, and what it costs to leave there; all (J,)."""

    low: Floats
    high: Floats
    start: Floats
    prior: float  # λ
    ridge: float  # ρ
    # Of residuals; without it those that stay large would blind the search to the others.
    fine: float = np.inf

    def cost(self, x: Floats) -> float:
        """λ Σ |x_j - x⁰_j| + ½ ρ |x - x⁰|²."""
        away = x - self.start
        return self.prior * float(np.abs(away).sum()) + 0.5 * self.ridge * float(away @ away)


class _Trial(NamedTuple):
    x: Floats
    left: Floats
    rows: Floats
    curved: Floats
    cost: float


def nearest(residuals: Residuals, box: Box, near: Floats) -> Floats:
    """The minimum that is downhill from a point in the box; (J,)."""

    def tried(x: Floats) -> _Trial:
        left, rows, curved = residuals(x)
        return _Trial(x, left, rows, curved, _half_square(left) + box.cost(x))

    here = tried(near)
    aim = near
    damping, raised = _LEAST_DAMPING, _RAISE
    for _ in range(_STEPS):
        x, left, rows, curved, cost = here
        model = rows.T @ rows + curved
        largest = float(model.diagonal().max(initial=0.0))
        model += damping * largest * np.eye(len(x))
        # From the aim before: what is at a bound there mostly stays.
        aim = _model_minimum(model, rows.T @ left - model @ x, box, aim)
        moved = aim - x
        modelled = left + rows @ moved
        promised = cost - _half_square(modelled) - box.cost(aim)
        promised -= 0.5 * float(moved @ curved @ moved)
        worth = min(_WORTH * cost, 0.5 * box.fine**2)
        if np.abs(moved).max(initial=0.0) <= _PRECISION or promised <= worth:
            break
        trial = tried(aim)
        if cost - trial.cost <= 0.5 * promised:
            turned = left + trial.left - modelled
            aim = _model_minimum(model, rows.T @ turned - model @ x, box, aim)
            trial = min(trial, tried(aim), key=lambda one: one.cost)
        if trial.cost < cost:
            # The more of what the model promised has come, the longer the next step.
            if cost - trial.cost > 0.5 * promised:
                damping = max(0.1 * damping, _LEAST_DAMPING)
            here, raised = trial, _RAISE
        else:
            damping *= raised
            raised *= _RAISE
    return here.x


def _half_square(residuals: Floats) -> float:
    return 0.5 * float(residuals @ residuals)


def _model_minimum(model: Floats, offset: Floats, box: Box, near: Floats) -> Floats:
    """The minimum over the box of ½ xᵀMx + oᵀx and the other terms, from near it; M is definite.

    Those with much to gain are let go, and all that are free go to their common minimum, or to
    where the first of them meets a bound or its start, and stays.
    """
    from scipy.linalg.lapack import dposv

    low, high, start, prior, ridge, _ = box
    model = model + ridge * np.eye(len(near))
    offset = offset - ridge * start
    x, sides = near.copy(), np.sign(near - start)
    free = (x > low) & (x < high) & (sides != 0)
    enough = 1e-6 * prior + 1e-15 * float(model.diagonal().max(initial=0.0))
    for _ in range(20 * len(x) + 20):
        slope = model @ x + offset
        # On one side of its start the cost of a parameter is smooth.
        least, most = np.where(sides > 0, start, low), np.where(sides > 0, high, start)
        own = free.nonzero()[0]
        while own.size:
            here, pull = x[own], slope[own] + prior * sides[own]
            aim = here - dposv(model[own[:, None], own], pull)[1]
            within = np.minimum(np.maximum(aim, least[own]), most[own])
            met = within != aim
            if not met.any():
                x[own], own = aim, own[:0]
            else:
                parts = (within - here)[met] / (aim - here)[met]
                part = float(parts.min())
                met[met] = parts <= part
                on_the_way = np.minimum(
                    np.maximum(here + part * (aim - here), least[own]), most[own]
                )
                x[own] = np.where(met, within, on_the_way)
                free[own[met]] = False
                own = own[~met]
            slope = model @ x + offset
        up = np.where(x < high, -slope - np.where(x >= start, prior, -prior), 0.0)
        down = np.where(x > low, slope - np.where(x <= start, prior, -prior), 0.0)
        gain = np.where(free, 0.0, np.maximum(up, down))
        most_gain = float(gain.max(initial=0.0))
        if most_gain <= enough:
            break
        chosen = gain >= _TOGETHER * most_gain
        free |= chosen
        away = np.where(up >= down, 1.0, -1.0)
        sides = np.where(chosen, np.where(x == start, away, np.sign(x - start)), sides)
    return x


Bounds = tuple[float, float] | Mapping[str, tuple[float, float]]
"""Least and greatest weight of every slider, or of some by name; the others have 0 and 1."""

PRIOR = 1e-8
# A first search at a strong prior settles which sliders move; without it a weak one creeps along
# the faces that reach the handles.
_FIRST_PRIOR = 1e-4
# The ridge is this part of the prior, yet never so little that weights are not determined.
_LIMITED_RIDGE, _LEAST_RIDGE = 1e-3, 1e-12
# A handle that is nearer than this part of the farthest a slider moves one has been reached.
_REACHED = 1e-3


@dataclass(frozen=True)
class Solved:
    """Weights that bring handles as near to their positions as the sliders can.

    Attributes:
        weights: Of each slider, for `Rig.pose`.
        distances: How far each handle is left from its position, in the unit of the vertices.
        within: A handle no farther than this has reached its position: a thousandth of the
            farthest that one slider moves one of them.
    """

    weights: Mapping[str, float]
    distances: Mapping[Handle, float]
    within: float

    @property
    def reached(self) -> bool:
        """Whether every handle has reached its position."""
        return all(distance <= self.within for distance in self.distances.values())

    def __str__(self) -> str:
        moved = ", ".join(f"{n} {w:.2f}" for n, w in self.weights.items() if round(w, 2))
        count = len(self.distances)
        left = {h: d for h, d in self.distances.items() if d > self.within}
        said = f"{count - len(left)} of {count} handles reached"
        if left:
            worst = max(left, key=lambda handle: left[handle])
            said += f", {worst!r} left {left[worst]:.3g} away"
        return f"{said}; {moved or 'every slider at 0'}"


def solve(
    rig: Rig,
    handles: Mapping[Handle, ArrayLike],
    weights: Weights | None,
    bounds: Bounds,
    prior: float,
    landmarks: Mapping[str, Place] | None,
) -> Solved:
    """The weights that `Rig.solve` finds."""
    mix, goals = asked(handles, landmarks, len(rig.neutral.vertices))
    low, high = limits(rig.sliders, bounds)
    at = np.zeros(len(low)) if weights is None else rig.sliders.row(weights)
    strength = as_number(prior, "the prior", least=0)
    start = np.clip(at, low, high)
    with one_blas_thread():
        points = HandledPoints.of(rig, mix)
        search = _Search(goals, points.reach or 1.0, Box(low, high, start, strength, 0.0, _REACHED))
        found, left = search.on(points, start)
        if (left > search.within).any() and points.stall(start):
            # Nothing leads away from there: straight paths say which sliders are needed.
            straight = search.on(points.straight, start)[0]
            other, nearer = search.on(points, np.clip(points.paced(straight), low, high))
            if nearer @ nearer < left @ left:
                found, left = other, nearer
    return Solved(
        dict(zip(rig.names, found.tolist(), strict=True)),
        dict(zip(handles, left.tolist(), strict=True)),
        search.within,
    )


class _Search(NamedTuple):
    """The search for (H, 3) positions of points in a box, at no less than its prior."""

    goals: Floats
    scale: float  # Of residuals: the farthest that one slider moves one of them
    box: Box

    @property
    def within(self) -> float:
        """The distance at which a goal is reached."""
        return _REACHED * self.scale

    def on(self, points: HandledPoints, row: Floats) -> tuple[Floats, Floats]:
        """The (sliders,) weights found from some on, and (H,) distances left."""

        def residuals(row: Floats) -> tuple[Floats, Floats, Floats]:
            moving = points.at(row)
            left = (moving.positions - self.goals).ravel() / self.scale
            return left, moving.rates / self.scale, moving.curved(left) / self.scale

        prior = self.box.prior
        for cost in sorted({max(prior, _FIRST_PRIOR), prior}, reverse=True):
            ridge = max(_LIMITED_RIDGE * cost, _LEAST_RIDGE)
            row = nearest(residuals, self.box._replace(prior=cost, ridge=ridge), row)
        return row, np.linalg.norm(points.at(row).positions - self.goals, axis=1)


def limits(sliders: Sliders, bounds: Bounds) -> tuple[Floats, Floats]:
    """(sliders,) least and greatest weights."""
    both = np.tile([0.0, 1.0], (len(sliders.names), 1))
    if isinstance(bounds, Mapping):
        for name, pair in bounds.items():
            sliders.require(name, sliders.names)
            both[sliders.names.index(name)] = _pair(pair, f"the bounds of {name!r}")
    else:
        both[:] = _pair(bounds, "bounds")
    return both[:, 0].copy(), both[:, 1].copy()


def _pair(bounds: ArrayLike, what: str) -> Floats:
    pair = as_numbers(bounds, what)
    if pair.shape != (2,) or not pair[0] <= pair[1] or not np.isfinite(pair).all():
        raise ParameterError(
            f"{what} must be two finite numbers, the least and the greatest, found {bounds!r}"
        )
    return pair


_OFF = 0.1
# Of the size of the face: 0.08 is between two people, 0.33 where left and right are exchanged.
_UNLIKE = 0.2


def warn_unlike(distances: Floats, rest: Floats) -> None:
    """Warn where most markers are so far from their (M, 3) places that these are hardly theirs."""
    size = np.sqrt(np.square(rest - rest.mean(axis=0)).sum(axis=1).mean())
    part = float(np.nanmedian(distances) / size)
    if part > _UNLIKE:
        warn(
            f"half of the markers are off their places on the rig by {part:.0%} of the size of the "
            "face and more: check that each place is that of its marker, and that left and right "
            "are not exchanged"
        )


@dataclass(frozen=True, eq=False)
class Tracked:
    """The weights of a take, and where the head was.

    Attributes:
        names: J sliders, those that the markers show.
        weights: (T, J) weights; of frames with too few markers those between their neighbours.
        scale: Size of the recorded face over that of the rig.
        rotations: (T, 3, 3) of the head, NaN for frames with too few markers.
        offsets: (T, 3) of the head, in the unit of the markers: y = scale·R·p + offset.
        distances: (T, M) of each marker from the face, in the unit of the rig; NaN where missing.
        trust: (T, M) how much each marker counts, from 0, missing or far off, to 1.
        unseen: Sliders that no marker shows, and that are left out: their weights would be the
            prior's, and 0 whatever the face does.
    """

    names: tuple[str, ...]
    weights: Floats
    scale: float
    rotations: Floats
    offsets: Floats
    distances: Floats
    trust: Floats
    unseen: tuple[str, ...] = ()

    @property
    def left(self) -> Floats:
        """(M,) RMS of what is left of each marker where it counts, in the unit of the rig."""
        counts = self._seen & (self.trust >= _OFF)
        squares = np.square(np.where(counts, self.distances, 0.0)).sum(axis=0)
        with np.errstate(invalid="ignore"):
            left: Floats = np.sqrt(squares / counts.sum(axis=0))
        return left

    @property
    def between(self) -> NDArray[np.intp]:
        """Frames with too few markers."""
        return np.flatnonzero(np.isnan(self.rotations[:, 0, 0]))

    @property
    def _seen(self) -> NDArray[np.bool_]:
        return np.isfinite(self.distances)

    def __str__(self) -> str:
        count = len(self.weights)
        seen, off = self._seen, self._seen & (self.trust < _OFF)
        rms = np.sqrt(np.mean(np.square(self.distances[seen & ~off])))
        said = (
            f"{count:,} frame{'s' * (count != 1)}, scale {self.scale:.4g}, {rms:.3g} left (RMS); "
            f"{(~seen).mean():.1%} of the markers missing, {off.mean():.1%} far off and left out"
        )
        if count := len(self.unseen):
            said += f"; {count} slider{'s' * (count != 1)} that no marker shows left out"
        few = len(self.between)
        return said + (f"; {few:,} frames with too few are between their neighbours" if few else "")


TRACKING_PRIOR, SMOOTH = 1e-4, 3e-4
_RIDGE = 1e-3
# Markers farther off than this many times the middle one of the frame fade out, but none that is
# nearer than this part of the farthest that a slider moves one.
_FAR, _NEAR = 4.0, 0.02
_LEAST_MARKERS = 4
_FITS = 4
_HALF = 0.5
_SCALE_FRAMES = 100


def track(
    rig: Rig,
    markers: ArrayLike,
    places: Sequence[Handle],
    *,
    rest: int | None = None,
    bounds: Bounds = (0.0, 1.0),
    prior: float = TRACKING_PRIOR,
    smooth: float = SMOOTH,
    landmarks: Mapping[str, Place] | None = None,
    progress: Callable[[str], object] = lambda said: None,
) -> Tracked:
    """Slider weights of a whole take of markers, wherever the head is in each frame.

    Args:
        rig: Whose sliders.
        markers: (T, M, 3) positions in any unit, NaN where a marker is missing, as `read_markers`
            finds them in files: ``em.read_markers("take.c3d").of(names)``.
        places: Where each marker is on the face: M handles as for `Rig.solve`.
        rest: A frame in which the face is at rest: the markers are then taken to be where they
            are in it, which removes the difference between this face and that of the rig.
        bounds: As for `Rig.solve`.
        prior: Cost of moving a slider by 1, beside half the squared distances over the farthest
            that a slider moves a marker.
        smooth: μ of the sum above; more for noise, less for quick movements.
        landmarks: Vertex of each landmark that places name.
        progress: Told how far it is.

    Raises:
        ParameterError: A place or setting that cannot be, shapes that do not fit, or no frame with
            four markers.
    """
    mix = mixed(_listed(places), landmarks, len(rig.neutral.vertices))
    taken = _taken(markers, len(mix.firsts))
    low, high = limits(rig.sliders, bounds)
    cost, near = as_number(prior, "the prior", least=0), as_number(smooth, "smooth", least=0)
    box = Box(low, high, np.clip(0.0, low, high), cost, max(_RIDGE * cost, 1e-12))
    with one_blas_thread():
        points = HandledPoints.of(rig, mix)
        _require_spread(points.rest)
        ever = np.asarray(np.isfinite(taken).all(axis=2).any(axis=0))
        whole = np.flatnonzero(np.isfinite(taken).all(axis=2).sum(axis=1) >= _LEAST_MARKERS)
        if not len(whole):
            raise ParameterError(f"no frame has {_LEAST_MARKERS} markers; a face needs as many")
        unseen = _unseen(points, ever, cost) & (box.start == 0)
        box = box._replace(low=np.where(unseen, 0.0, low), high=np.where(unseen, 0.0, high))
        if rest is not None:
            points = _worn(points, taken, rest, places)
        scale = _scale(points, taken[whole if rest is None else [rest]])
        # What sets out without speed is found on straight paths first.
        ways = [points.straight, points] if points.stall(box.start) else [points]
        if rest is None:
            # Extents differ by expressions, too: the scale at which faces fit tells the two apart.
            sized = _Frames(ways[0], taken / scale, box, 0.0, sized=True)
            some = whole[spread_rows(len(whole), _SCALE_FRAMES)].tolist()
            scale *= float(np.median([sized.solve(frame) for frame in some]))
        solver = _Frames(ways[0], taken / scale, box, near)
        _solve_all(solver, ways, whole, progress)
    warn_unlike(solver.distances, points.rest)
    return _tracked(rig.names, unseen, solver, whole, scale)


def _solve_all(
    solver: _Frames,
    ways: Sequence[HandledPoints],
    whole: NDArray[np.intp],
    progress: Callable[[str], object],
) -> None:
    """Solve the frames forth and back, on paths of one kind after another."""
    rounds = [(way, order) for way in ways for order in (whole, whole[::-1])]
    for number, (way, order) in enumerate(rounds, 1):
        if way is not solver.points:
            solver.points = way
            paced = [way.paced(row) for row in solver.weights[whole]]
            solver.weights[whole] = np.clip(paced, solver.box.low, solver.box.high)
        for done, frame in enumerate(order):
            if done % 100 == 0:
                progress(f"frame {done:,} of {len(order):,}, {number} of {len(rounds)}")
            solver.solve(int(frame), again=number % 2 == 0)


class _Head(NamedTuple):
    """Where a head is: y = size·R·p + offset."""

    rotation: Floats
    offset: Floats
    size: float

    def back(self, positions: Floats) -> Floats:
        """(M, 3) positions in the frame of the rig."""
        return (positions - self.offset) @ self.rotation / self.size


class _Frames:
    """The frames of a take, solved one at a time next to those already solved."""

    def __init__(
        self, points: HandledPoints, taken: Floats, box: Box, smooth: float, *, sized: bool = False
    ) -> None:
        self.points, self.taken, self.box, self.smooth = points, taken, box, smooth
        self.sized = sized  # Whether each frame has a scale of its own
        frames, count = taken.shape[:2]
        self.reach = points.reach or 1.0
        self.weights = np.full((frames, len(box.start)), np.nan)
        self.rotations = np.full((frames, 3, 3), np.nan)
        self.offsets = np.full((frames, 3), np.nan)
        self.distances = np.full((frames, count), np.nan)
        self.trust = np.zeros((frames, count))

    def solve(self, frame: int, *, again: bool = False) -> float:
        """Find the weights of a frame from its own, or those of its neighbours; its scale.

        Again, there is no doubt which markers are far off.
        """
        known = [
            self.weights[near]
            for near in (frame - 1, frame + 1)
            if 0 <= near < len(self.weights) and not np.isnan(self.weights[near, :1]).any()
        ]
        own = self.weights[frame]
        near = own if np.isfinite(own).all() else known[0] if known else self.box.start
        seen = np.isfinite(self.taken[frame]).all(axis=1)
        goals = np.where(seen[:, None], self.taken[frame], 0.0)
        held = self.smooth * len(known)
        middle = np.mean(known, axis=0) if known else near

        def face_near(row: Floats, trust: Floats) -> Floats:
            def residuals(row: Floats) -> tuple[Floats, Floats, Floats]:
                return self._residuals(row, goals, trust, np.sqrt(held), middle)

            return nearest(residuals, self.box, row)

        every = seen.astype(float)
        trust, usual = self._trust(near, goals, every)
        found = face_near(near, trust)
        if not again and (trust[seen] < _HALF).any():
            # Markers far off that move together are no errors but a slider that few of them show.
            other = face_near(near, every)
            own, far = self._trust(other, goals, every)
            other = face_near(other, own)
            usual = min(usual, far)

            def cost(row: Floats, trust: Floats) -> float:
                face = self.points.at(row).positions
                back = self._head(face, goals, trust).back(goals)
                away = np.square(back - face).sum(axis=1)[seen]
                faded = float((away / (1.0 + away / usual**2)).sum()) / self.reach**2
                return self.box.cost(row) + 0.5 * (
                    faded + held * float(np.square(row - middle).sum())
                )

            if cost(other, own) < cost(found, trust):
                found, trust = other, own
        face = self.points.at(found).positions
        head = self._head(face, goals, trust)
        away = np.linalg.norm(head.back(goals) - face, axis=1)
        self.weights[frame], self.trust[frame] = found, trust
        self.rotations[frame], self.offsets[frame] = head.rotation, head.offset
        self.distances[frame] = np.where(seen, away, np.nan)
        return head.size

    def _head(self, face: Floats, goals: Floats, trust: Floats) -> _Head:
        """Where the head is if it has this face."""
        rotation, offset = fit_rotation(face, goals, trust)
        if not self.sized:
            return _Head(rotation, offset, 1.0)
        shares = trust / trust.sum()
        middle = shares @ face
        arms, aims = (face - middle) @ rotation.T, goals - shares @ goals
        size = float(shares @ (arms * aims).sum(axis=1)) / float(
            shares @ np.square(arms).sum(axis=1)
        )
        return _Head(rotation, shares @ goals - size * rotation @ middle, size)

    def _trust(self, row: Floats, goals: Floats, seen: Floats) -> tuple[Floats, float]:
        """(M,) how much markers count beside a face near the one looked for; what is far there."""
        face = self.points.at(row).positions
        trust = seen
        for _ in range(_FITS):
            away = np.linalg.norm(self._head(face, goals, trust).back(goals) - face, axis=1)
            usual = max(_FAR * float(np.median(away[seen > 0])), _NEAR * self.reach)
            trust = seen / np.square(1.0 + np.square(away / usual))
        return trust, usual

    def _residuals(
        self, row: Floats, goals: Floats, trust: Floats, held: float, middle: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Of markers to the face, with the head where it is nearest, and to the neighbours."""
        moving = self.points.at(row)
        face = moving.positions
        back = self._head(face, goals, trust).back(goals)
        root = np.repeat(np.sqrt(trust) / self.reach, 3)
        left = root * (face - back).ravel()
        # What moves as the head could is no error: derivatives without their rigid part.
        free = _rigid(face)[: 6 + int(self.sized)]
        basis = np.linalg.qr((free * root).T)[0]
        rates = root[:, None] * moving.rates
        rates -= basis @ (basis.T @ rates)
        curved = moving.curved(root * left)
        return (
            np.concatenate([left, held * (row - middle)]),
            np.concatenate([rates, held * np.eye(len(row))]),
            curved,
        )


def _rigid(face: Floats) -> Floats:
    """(7, 3M) how points move with a head that moves, turns and grows."""
    arms = face - face.mean(axis=0)
    turns = np.cross(np.eye(3)[:, None], arms[None]).reshape(3, -1)
    return np.concatenate([np.tile(np.eye(3), len(face)), turns, arms.reshape(1, -1)])


def _unseen(points: HandledPoints, ever: NDArray[np.bool_], prior: float) -> NDArray[np.bool_]:
    """(sliders,) those of which the markers say so little that the prior would halve each weight.

    A slider alone moves markers so that the sum is least at w - λ/s, s the sum of their squares
    over that of the reach, without what the head could do too.
    """
    basis = np.linalg.qr(_rigid(points.rest[ever])[:6].T)[0]
    moved = points.fields.reshape(len(points.fields), -1, 3)[:, ever].reshape(
        len(points.fields), -1
    )
    left = np.square(moved - moved @ basis @ basis.T).sum(axis=1) / (points.reach or 1.0) ** 2
    told = dict.fromkeys(points.sliders.morphs, 0.0)
    for name, own in zip(told, np.maximum.reduceat(left, points.deltas), strict=True):
        for driver in points.sliders.drivers(name):
            told[driver] = max(told[driver], float(own))
    unseen = np.array([told[name] <= max(2 * prior, 1e-12) for name in points.sliders.names])
    if unseen.all():
        raise ParameterError(
            "no marker is on a part of the face that a slider moves, so there is nothing to track; "
            "check the places of the markers, or give a smaller prior"
        )
    return unseen


def _tracked(
    names: tuple[str, ...],
    unseen: NDArray[np.bool_],
    solver: _Frames,
    whole: NDArray[np.intp],
    scale: float,
) -> Tracked:
    """The result, weights of frames without enough markers between those of their neighbours."""
    frames = np.arange(len(solver.weights))
    weights = np.zeros((len(frames), len(names)))
    for column, own in zip(weights.T, solver.weights.T, strict=True):
        column[:] = np.interp(frames, whole, own[whole])
    return Tracked(
        tuple(name for name, out in zip(names, unseen, strict=True) if not out),
        weights[:, ~unseen],
        scale,
        solver.rotations,
        scale * solver.offsets,
        solver.distances,
        solver.trust,
        tuple(name for name, out in zip(names, unseen, strict=True) if out),
    )


def _scale(points: HandledPoints, frames: Floats) -> float:
    """The middle ratio of the extent of the markers to that of the same points at rest."""
    ratios = []
    for frame in frames[:: max(1, len(frames) // _SCALE_FRAMES)]:
        seen = np.isfinite(frame).all(axis=1)
        pairs = [points.rest[seen], frame[seen]]
        middle = [np.median(each, axis=0) for each in pairs]
        lengths = [
            np.linalg.norm(each - centre, axis=1)
            for each, centre in zip(pairs, middle, strict=True)
        ]
        ratios.append(np.mean(lengths[1]) / np.mean(lengths[0]))
    scale = float(np.median(ratios))
    if scale == 0:
        raise ParameterError("the markers are all in one place, which is no face")
    return scale


def _worn(
    points: HandledPoints, taken: Floats, rest: int, places: Sequence[Handle]
) -> HandledPoints:
    """The points where the markers are on the face at rest, by a frame that shows it."""
    if not is_whole(rest):
        raise ParameterError(f"rest is the number of a frame, found {rest!r}")
    if not 0 <= rest < len(taken):
        raise ParameterError(f"rest is frame {rest}, but there are {len(taken):,} from 0")
    there = np.asarray(np.isfinite(taken).all(axis=2))
    lacking = np.flatnonzero(there.any(axis=0) & ~there[rest]).tolist()
    if lacking:
        raise ParameterError(
            f"the frame at rest, {rest}, must have all markers, but lacks that at "
            + ", ".join(str(places[marker]) for marker in lacking[:12])
        )
    seen = there[rest]
    size = _scale(points, taken[rest : rest + 1])
    frame = taken[rest, seen] / size
    rotation, offset = fit_rotation(points.rest[seen], frame)
    worn = points.rest.copy()
    worn[seen] = (frame - offset) @ rotation
    warn_unlike(np.linalg.norm(worn - points.rest, axis=1), points.rest)
    return replace(points, rest=worn)


def _listed(places: Sequence[Handle]) -> Sequence[Handle]:
    if isinstance(places, str) or not isinstance(places, Sequence | np.ndarray) or not len(places):
        raise ParameterError(
            f"places are a list of vertices or landmarks, one a marker, found {places!r}"
        )
    return places


def _taken(markers: ArrayLike, count: int) -> Floats:
    """(T, M, 3) positions, a marker that lacks a coordinate missing."""
    if isinstance(markers, str | PurePath | Markers):
        raise ParameterError(
            "markers are an array of (T, M, 3) positions, such as em.read_markers('take.c3d')"
            f".of(names), found {str(markers)!r:.80}"
        )
    taken = as_numbers(markers, "markers")
    if taken.ndim != 3 or taken.shape[1:] != (count, 3) or not len(taken):
        raise ParameterError(
            f"markers must have shape (T, {count}, 3), one for each place, found {taken.shape}"
        )
    if np.isinf(taken).any():
        raise ParameterError("markers must be finite numbers, or NaN where they are missing")
    return taken


def _require_spread(rest: Floats) -> None:
    """Refuse markers that say nothing of how the head is turned."""
    spread = np.linalg.svd(rest - rest.mean(axis=0), compute_uv=False)
    if len(rest) < _LEAST_MARKERS or spread[1] <= 1e-6 * spread[0]:
        raise ParameterError(
            f"tracking needs at least {_LEAST_MARKERS} markers that are not all on one line, "
            f"found {len(rest)}"
        )
