"""Which targets of a character bend, by how much, and what is added to its files for it.

Only numbers: the same plan is written to every format.

A path V₀ + tΔ + Σ_k b_k(t) D_k can often do with fewer bends than it came with. Its bent part is
a matrix, times by coordinates; of its singular vectors the first r are the r bends that leave the
least (in least squares), with curves that are sums of the b_k. They are what is stored where they
are fewer; otherwise the bends stay what they were.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import BakeError, ParameterError
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.morph import Morph
from elastomorph.numbers import as_number
from elastomorph.paths import Method
from elastomorph.paths.bake import largest_sum
from elastomorph.rig import Rig
from elastomorph.rig.build import extent_of, with_paths
from elastomorph.rig.laws import Corrective
from elastomorph.rig.pairs import is_pair_bend
from elastomorph.rig.positive import turned_positive

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Way:
    """A path as it may be stored, less its straight part."""

    bends: Floats  # (K, V, 3)
    curves: tuple[BendCurve, ...]
    fold: BendCurve | None  # Added to the weight of Δ
    error: float  # Distance from the path at most, in the unit of the vertices

    def within(self, tolerance: float) -> Way:
        """The same, zero where that moves no vertex farther from the path than the tolerance.

        At each vertex the bends that move it least are left out, as many as there is room for.
        """
        if not len(self.bends):
            return self
        peaks = np.array([curve.height for curve in self.curves])
        moves = peaks[:, None] * np.linalg.norm(self.bends, axis=2)
        order = np.argsort(moves, axis=0)
        lost = self.error + np.cumsum(np.take_along_axis(moves, order, axis=0), axis=0)
        small = np.empty(moves.shape, dtype=bool)
        np.put_along_axis(small, order, lost <= tolerance, axis=0)
        small |= moves == 0
        error = self.error + float(np.where(small, moves, 0.0).sum(axis=0).max())
        left: NDArray[np.bool_] = np.asarray(~small.all(axis=1))
        curves = tuple(curve for curve, some in zip(self.curves, left, strict=True) if some)
        bends = np.where(small[left, :, None], 0.0, self.bends[left])
        return Way(bends, curves, self.fold, error)


def farthest(curves: tuple[BendCurve, ...], bends: Floats) -> float:
    """The largest |Σ_k b_k(t) D_k| of (K, V, 3) bends, over all vertices and all t in [0, 1].

    Every piece of degree n is sampled at 32n + 1 Chebyshev points, which no polynomial exceeds
    between them by more than 1/cos(π/64) - 1 = 0.12 %: so much too small it may be.
    """
    moved = bends.any(axis=(0, 2)) if len(bends) else np.zeros(0, dtype=bool)
    if not moved.any():
        return 0.0
    bends = bends[:, moved]
    breaks = np.unique(np.concatenate([curve.breaks for curve in curves]))
    points = 32 * max(1, *(curve.coefficients.shape[1] - 1 for curve in curves))
    part = (1 - np.cos(np.pi * np.arange(points + 1) / points)) / 2
    times = np.unique(breaks[:-1] + part[:, None] * np.diff(breaks))
    rows = np.stack([curve(times) for curve in curves], axis=1)
    return largest_sum(rows, bends, np.linalg.norm(bends, axis=2))


def ways(morph: Morph, tolerance: float, *, fold: bool) -> list[Way]:
    """The ways to store a path by the number of their bends, up to what is within a tolerance.

    The tolerance is in the unit of the vertices. With `fold` what the bends have in common with Δ
    goes into the weight of Δ itself where that saves a bend.
    """
    plain = _fewest(morph.bend_curves, morph.bends, None, tolerance)
    size = float(np.einsum("vi,vi->", morph.delta, morph.delta))
    if not fold or len(plain) == 1 or not size:
        return plain
    share = np.einsum("kvi,vi->k", morph.bends, morph.delta) / size
    rest = morph.bends - share[:, None, None] * morph.delta
    folded = _fewest(morph.bend_curves, rest, combined(morph.bend_curves, share), tolerance)
    return folded if len(folded) < len(plain) else plain


def _fewest(
    curves: tuple[BendCurve, ...], bends: Floats, fold: BendCurve | None, tolerance: float
) -> list[Way]:
    found = [Way(bends[:0], (), fold, farthest(curves, bends))]
    if found[0].error <= tolerance:
        return found
    whole = Way(bends, curves, fold, 0.0)
    count = len(whole.within(tolerance).bends)
    parts = _Parts.of(curves, bends)
    for number in range(1, min(count, len(parts.curves) + 1)):
        way = parts.first(number, fold)
        found.append(way)
        # The other half is for what moves next to nothing, without which files are smaller.
        if way.error <= tolerance / 2 and (parts.positive or not _positive(curves)):
            return found
    return [*found, whole]


@dataclass(frozen=True, eq=False)
class _Parts:
    """The bent part of a path as a sum of products, curve by bend, the most of it first."""

    curves: tuple[BendCurve, ...]
    bends: Floats  # (R, V, 3)
    positive: bool  # Whether sums of the curves can be made positive, see `first`

    @classmethod
    def of(cls, curves: tuple[BendCurve, ...], bends: Floats) -> _Parts:
        moved = bends.any(axis=(0, 2))
        flat = bends[:, moved].reshape(len(bends), -1)
        breaks = np.unique(np.concatenate([curve.breaks for curve in curves]))
        nodes, weights = np.polynomial.legendre.leggauss(
            max(curve.coefficients.shape[1] for curve in curves)
        )
        spans = np.diff(breaks)
        times = (breaks[:-1] + (nodes[:, None] + 1) / 2 * spans).ravel()
        roots = np.sqrt(weights[:, None] / 2 * spans).ravel()
        rows = roots[:, None] * np.stack([curve(times) for curve in curves], axis=1)
        _, sizes, fields = np.linalg.svd(np.linalg.qr(rows, mode="r") @ flat, full_matrices=False)
        some = sizes > 1e-12 * sizes[0]
        sizes, fields = sizes[some], fields[some]
        shares = flat @ fields.T / sizes  # of each new curve in each bend curve
        scaled, found = [], np.zeros((len(sizes), *bends.shape[1:]))
        for share, size, field, bend in zip(shares.T, sizes, fields, found, strict=True):
            curve = combined(curves, share)
            peak = curve.peak[1]
            scaled.append(combined((curve,), np.array([1 / peak])))
            bend[moved] = (peak * size * field).reshape(-1, 3)
        first = _over_arch(scaled[0])
        return cls(tuple(scaled), found, bool(first.min() > _LEAST * first.max()))

    def first(self, number: int, fold: BendCurve | None) -> Way:
        """The way with that many bends.

        All curves but the first swing to both sides. So much of the first is added to them, and
        of their bends taken from its own, that none is negative.
        """
        error = farthest(self.curves[number:], self.bends[number:])
        curves, bends = list(self.curves[:number]), self.bends[:number].copy()
        for k in range(1, number if self.positive else 0):
            ratio = _over_arch(curves[k]) / _over_arch(curves[0])
            more = 1.01 * max(0.0, float(-ratio.min()))
            curve = combined((curves[k], curves[0]), np.array([1.0, more]))
            bends[0] -= more * bends[k]
            peak = curve.peak[1]
            curves[k] = combined((curve,), np.array([1 / peak]))
            bends[k] *= peak
        return Way(bends, tuple(curves), fold, error)


# How much of its largest value a curve over t(1 - t) must have everywhere to be called positive.
_LEAST = 0.02


def _over_arch(curve: BendCurve) -> Floats:
    """(N,) values of b(t) over t(1 - t): 0 and negative where b is."""
    times = curve.times_within(101)[1:-1].ravel()
    times = times[(times > 0) & (times < 1)]
    return np.asarray(curve(times) / (times * (1 - times)))


def _positive(curves: tuple[BendCurve, ...]) -> bool:
    return all(float(curve(curve.times_within(65)).min()) >= -1e-9 for curve in curves)


def combined(curves: tuple[BendCurve, ...], weights: Floats) -> BendCurve:
    """The curve Σ_k w_k b_k."""
    breaks = np.unique(np.concatenate([curve.breaks for curve in curves]))
    terms = max(curve.coefficients.shape[1] for curve in curves)
    rows = np.zeros((len(breaks) - 1, terms))
    for curve, weight in zip(curves, weights, strict=True):
        rows += weight * _over(curve, breaks, terms)
    return BendCurve(breaks, rows)


def _over(curve: BendCurve, breaks: Floats, terms: int) -> Floats:
    """(S, terms) coefficients of a curve in the pieces of finer breaks."""
    pieces = np.searchsorted(curve.breaks, breaks[:-1], side="right") - 1
    steps = breaks[:-1] - curve.breaks[pieces]
    rows = np.zeros((len(pieces), terms))
    rows[:, : curve.coefficients.shape[1]] = curve.coefficients[pieces]
    # Horner's scheme, once for each derivative: a Taylor shift.
    for first in range(terms - 1):
        for column in range(terms - 2, first - 1, -1):
            rows[:, column] += steps * rows[:, column + 1]
    return rows


Methods = str | Method | Mapping[str, str | Method] | None


@dataclass(frozen=True, eq=False)
class BentMorph:
    """A target that bends, and what is added for it.

    Attributes:
        name: Its name.
        morph: Neutral, target, and the bends and curves that are to be added; the curves are
            positive where they can be. Its ``bake_error`` is `error` as a fraction of the diameter
            of the neutral. Of a path that is folded it is the part beside the fold.
        fold: The curve that is added to the weight of the target itself, if any.
        law: What drives it where it is no target of the file: a pair bend, or a corrective, whose
            shape is added too.
        gain: The largest distance between the path and the straight line, as a fraction of D.
        error: How far what is stored may be from the path, as a fraction of D; that of the path's
            own storage, `Morph.bake_error`, is in it.
    """

    name: str
    morph: Morph
    fold: BendCurve | None
    gain: float
    error: float
    law: Corrective | None = None

    @property
    def shape(self) -> Floats | None:
        """(V, 3) what a corrective adds as a target of its own; None of all else."""
        delta = self.morph.delta
        return delta if self.law is not None and delta.any() else None

    @property
    def added(self) -> tuple[BendCurve | None, ...]:
        """The curves of the targets that are added; a shape has none."""
        return (*(() if self.shape is None else (None,)), *self.morph.bend_curves)


@dataclass(frozen=True, eq=False)
class Plan:
    """What is added to a character.

    Attributes:
        rig: The face with its paths.
        extent: D, the largest distance between two vertices that its targets move.
        bent: The targets that bend, in the order of the rig.
        left_out: Those that bend too, but of which nothing found a place.
    """

    rig: Rig
    extent: float
    bent: tuple[BentMorph, ...]
    left_out: tuple[BentMorph, ...]

    def with_correctives(self, rig: Rig) -> Plan:
        """The same, and what sliders drive in a rig that is not in the file, but for pair bends.

        Args:
            rig: One on the same neutral, with morphs that are driven entirely by sliders of that
                of the plan.
        """
        scale = self.extent or 1.0
        known = {*self.rig.morphs, *rig.pair_bends()}
        laws = {n: own for n, own in rig.sliders.correctives.items() if n not in known}
        more = {name: rig.morphs[name] for name in laws}
        added = tuple(
            BentMorph(
                name,
                morph,
                None,
                farthest((*morph.bend_curves,), morph.bends) / scale,
                morph.bake_error * (rig.neutral.diameter or 1.0) / scale,
                laws[name],
            )
            for name, morph in more.items()
        )
        whole = Rig(
            self.rig.neutral,
            {**self.rig.morphs, **more},
            correctives={**self.rig.sliders.correctives, **laws},
            groups=self.rig.sliders.groups,
        )
        return replace(self, rig=whole, bent=(*self.bent, *added))


def make_plan(
    rig: Rig,
    method: Methods = None,
    *,
    only: Collection[str] | None = None,
    tolerance: float = 1e-5,
    baked: float | None = None,
    max_targets: int | None = None,
    fold: bool = False,
    meshes: Sequence[tuple[int, NDArray[np.integer]]] | None = None,
    say: Callable[[str], None] = lambda _: None,
) -> Plan:
    """What to add to a character so that its targets follow their paths.

    A path is stored with the fewest bends that hold it within the tolerance; one that stays within
    the tolerance of its straight line is not bent. Methods hold their paths within their own
    tolerance of the D of the rig, however large the rest of the body is.

    Under `max_targets` bends are added one by one where they gain most, until there is no room;
    some then have fewer than they need, and a larger `error`.

    Args:
        rig: The face. Paths that it has stay where no method is named for them.
        method: A method for all targets, or by name of the target; ``auto`` by default.
        only: The only targets that may bend.
        tolerance: What the fewest bends may leave, as a fraction of D.
        baked: What methods may leave, where it is less than their own tolerance.
        max_targets: The most morph targets a mesh may have.
        fold: What bends share with Δ becomes a curve of its weight, where that saves one.
        meshes: The meshes of the file, for `max_targets`: how many targets each has already, and
            its vertices in the rig. By default one, with the targets of the rig.
        say: Told what is being done.

    Raises:
        ParameterError: A name or method is unknown, or a number out of its range.
        BakeError: A turn is too sharp to be stored.
    """
    tolerance = as_number(tolerance, "the tolerance", above=0)
    before, names, extent = set(rig.morphs), _names(rig, only), extent_of(rig)
    part = extent / (rig.neutral.diameter or 1.0)
    rig = _with_paths(rig, _held_within(part, baked, _named(rig, method, names)), say)
    names = [name for name in names if name in rig.morphs]
    names += [name for name in rig.morphs if name not in before]
    scale = extent or 1.0
    options: dict[str, list[Way]] = {}
    gains: dict[str, float] = {}
    for name in names:
        morph = turned_positive(rig.morphs[name])
        gains[name] = farthest(morph.bend_curves, morph.bends) / scale
        if gains[name] > tolerance:
            options[name] = ways(morph, tolerance * scale, fold=fold)
    chosen = {name: len(own) - 1 for name, own in options.items()}
    pairs = rig.pair_bends()
    if max_targets is not None:
        room = _Room.of(rig, as_number(max_targets, "the most targets", least=0), meshes)
        chosen = room.filled(options, pairs)
    bent, left_out = list[BentMorph](), list[BentMorph]()
    for name, own in options.items():
        nothing = chosen[name] == 0 and own[0].fold is None
        way = own[-1 if nothing else chosen[name]].within(tolerance * scale)
        found = _bent(name, rig.morphs[name], way, gains[name], scale, pairs.get(name))
        (left_out if nothing else bent).append(found)
    return Plan(rig, extent, tuple(bent), tuple(left_out))


def not_bare(rig: Rig) -> Rig:
    """The rig, in which a straight line stands for no path that is still to be chosen."""
    morphs = {name: replace(morph, bare=False) for name, morph in rig.morphs.items()}
    own = rig.sliders
    return Rig(rig.neutral, morphs, correctives=own.correctives, groups=own.groups)


def plan_as_is(original: Rig, rig: Rig, tolerance: float) -> Plan:
    """What to add to the original of a file so that it has the paths and correctives of a rig.

    Args:
        original: The face in the original. Its targets with bends keep those.
        rig: The face with the paths of the file, none of them bare, and what is driven by sliders.
        tolerance: As for `make_plan`.
    """
    morphs = {n: m for n, m in rig.morphs.items() if n in original or is_pair_bend(m)}
    bends = [n for n in morphs if n not in original or not len(original[n].bends)]
    laws = {n: own for n, own in rig.sliders.correctives.items() if n in morphs}
    plan = make_plan(Rig(rig.neutral, morphs, correctives=laws), only=bends, tolerance=tolerance)
    return plan.with_correctives(rig)


def _names(rig: Rig, only: Collection[str] | None) -> list[str]:
    if only is None:
        return list(rig.morphs)
    if isinstance(only, str) or not isinstance(only, Collection):
        raise ParameterError(f"only is a list of names, such as ['jawOpen'], found {only!r}")
    for name in only:
        rig.sliders.require(name, tuple(rig.morphs))
    return [name for name in rig.morphs if name in set(only)]


def _named(rig: Rig, method: Methods, names: list[str]) -> dict[str, Method]:
    """The methods of the targets that are named, and by default of those that have no path."""
    named: Mapping[str, str | Method]
    if isinstance(method, Mapping):
        named = method
        for name in named:
            rig.sliders.require(name, tuple(rig.morphs))
    else:
        named = {} if method is None else dict.fromkeys(names, method)
    asked = (name for name in names if name in named or rig.morphs[name].bare)
    return {name: Method.of(named.get(name, "auto")) for name in asked}


def _held_within(
    part: float, baked: float | None, methods: Mapping[str, Method]
) -> dict[str, Method]:
    """Methods with their tolerances, fractions of the neutral's diameter, as ones of D.

    D is this part of the diameter.
    """
    held = {}
    for name, method in methods.items():
        held[name] = method
        if method.has("tolerance") and part:
            own = method.tolerance if baked is None else min(method.tolerance, baked)
            held[name] = replace(method, tolerance=own * min(1.0, part))  # type: ignore[call-arg]
    return held


def _with_paths(rig: Rig, methods: Mapping[str, Method], say: Callable[[str], None]) -> Rig:
    """The rig with paths by these methods."""
    groups: dict[Method, list[str]] = {}
    for name, own in methods.items():
        groups.setdefault(own, []).append(name)
    try:
        for own, members in groups.items():
            rig = with_paths(rig, own, names=members, say=say)
    except BakeError as error:
        source = rig.neutral.source
        raise error if source is None else BakeError(f"{source.path}: {error}") from error
    return rig


def _bent(
    name: str, morph: Morph, way: Way, gain: float, scale: float, law: Corrective | None
) -> BentMorph:
    diameter = morph.neutral.diameter or 1.0
    error = way.error + morph.bake_error * diameter
    stored = replace(morph, bends=way.bends, bend_curves=way.curves, bake_error=error / diameter)
    return BentMorph(name, stored, way.fold, gain, error / scale, law)


@dataclass(frozen=True, eq=False)
class _Room:
    """How many targets each mesh can still take."""

    free: NDArray[np.int64]  # (M,)
    vertices: list[NDArray[np.integer]]  # Of each mesh, in the rig

    @classmethod
    def of(
        cls, rig: Rig, most: float, meshes: Sequence[tuple[int, NDArray[np.integer]]] | None
    ) -> _Room:
        if meshes is None:
            count = len(rig.morphs) - len(rig.pair_bends())
            meshes = [(count, np.arange(len(rig.neutral.vertices)))]
        taken = np.array([count for count, _ in meshes], dtype=np.int64)
        return cls(int(most) - taken, [vertices for _, vertices in meshes])

    def filled(
        self, options: Mapping[str, list[Way]], pairs: Mapping[str, Corrective]
    ) -> dict[str, int]:
        """The number of bends of each path: greedily, the most gained a target.

        A pair bend is the difference of paths: it comes with the second of both, never without.
        """
        costs = {name: [self._cost(way) for way in own] for name, own in options.items()}
        meeting = {name: own.drivers for name, own in pairs.items() if name in options}
        chosen = dict.fromkeys(options, 0)
        free = self.free

        def bend(names: Collection[str], counts: Mapping[str, int]) -> bool:
            return all(counts.get(n, 1) or options[n][0].fold is not None for n in names)

        while True:
            best, step = 0.0, None
            for name, own in options.items():
                if name in meeting and not bend(meeting[name], chosen):
                    continue
                for more in range(chosen[name] + 1, len(own)):
                    then = chosen | {name: more}
                    for pair, both in meeting.items():
                        if name in both and bend(both, then):
                            then[pair] = max(1, chosen[pair])
                    moved = [n for n, count in then.items() if count != chosen[n]]
                    added = sum(costs[n][then[n]] - costs[n][chosen[n]] for n in moved)
                    added = np.asarray(added)
                    if ((added > 0) & (added > free)).any():
                        continue
                    gained = sum(
                        options[n][chosen[n]].error - options[n][then[n]].error for n in moved
                    ) / max(1, int(added.max()))
                    if gained > best:
                        best, step = gained, (then, added)
            if step is None:
                return chosen
            chosen, free = step[0], free - step[1]

    def _cost(self, way: Way) -> NDArray[np.int64]:
        """(M,) targets that a way adds to each mesh: the bends that move one of its vertices."""
        moved: NDArray[np.bool_] = np.asarray(way.bends.any(axis=2))
        return np.array([moved[:, own].any(axis=1).sum() for own in self.vertices], dtype=np.int64)
