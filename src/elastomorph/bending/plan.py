"""Which targets of a character bend, by how much, and what is added to its files for it.

Only numbers: the same plan is written to every format.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from elastomorph.bending.fewest import Way, farthest, ways
from elastomorph.errors import BakeError, ParameterError
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.morph import Morph
from elastomorph.numbers import as_number
from elastomorph.paths import Method
from elastomorph.rig import Rig
from elastomorph.rig.build import extent_of, with_paths
from elastomorph.rig.positive import turned_positive

__all__ = ["BentMorph", "Plan", "make_plan"]

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
        gain: The largest distance between the path and the straight line, as a fraction of D.
        error: How far what is stored may be from the path, as a fraction of D; that of the path's
            own storage, `Morph.bake_error`, is in it.
    """

    name: str
    morph: Morph
    fold: BendCurve | None
    gain: float
    error: float


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
    names, extent = _names(rig, only), extent_of(rig)
    part = extent / (rig.neutral.diameter or 1.0)
    rig = _with_paths(rig, _held_within(part, baked, _named(rig, method, names)), say)
    scale = extent or 1.0
    options: dict[str, list[Way]] = {}
    gains: dict[str, float] = {}
    for name in names:
        morph = turned_positive(rig.morphs[name])
        gains[name] = farthest(morph.bend_curves, morph.bends) / scale
        if gains[name] > tolerance:
            options[name] = ways(morph, tolerance * scale, fold=fold)
    chosen = {name: len(own) - 1 for name, own in options.items()}
    if max_targets is not None:
        room = _Room.of(rig, as_number(max_targets, "the most targets", least=0), meshes)
        chosen = room.filled(options)
    bent, left_out = list[BentMorph](), list[BentMorph]()
    for name, own in options.items():
        nothing = chosen[name] == 0 and own[0].fold is None
        way = own[-1 if nothing else chosen[name]].within(tolerance * scale)
        found = _bent(name, rig.morphs[name], way, gains[name], scale)
        (left_out if nothing else bent).append(found)
    return Plan(rig, extent, tuple(bent), tuple(left_out))


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


def _bent(name: str, morph: Morph, way: Way, gain: float, scale: float) -> BentMorph:
    diameter = morph.neutral.diameter or 1.0
    error = way.error + morph.bake_error * diameter
    stored = replace(morph, bends=way.bends, bend_curves=way.curves, bake_error=error / diameter)
    return BentMorph(name, stored, way.fold, gain, error / scale)


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
            meshes = [(len(rig.morphs), np.arange(len(rig.neutral.vertices)))]
        taken = np.array([count for count, _ in meshes], dtype=np.int64)
        return cls(int(most) - taken, [vertices for _, vertices in meshes])

    def filled(self, options: Mapping[str, list[Way]]) -> dict[str, int]:
        """The number of bends of each path: greedily, the most gained a target."""
        costs = {name: [self._cost(way) for way in own] for name, own in options.items()}
        chosen = dict.fromkeys(options, 0)
        free = self.free
        while True:
            best, step = 0.0, None
            for name, own in options.items():
                now = chosen[name]
                for more in range(now + 1, len(own)):
                    added = costs[name][more] - costs[name][now]
                    if ((added > 0) & (added > free)).any():
                        continue
                    gained = (own[now].error - own[more].error) / max(1, int(added.max()))
                    if gained > best:
                        best, step = gained, (name, more, added)
            if step is None:
                return chosen
            name, more, added = step
            chosen[name], free = more, free - added

    def _cost(self, way: Way) -> NDArray[np.int64]:
        """(M,) targets that a way adds to each mesh: the bends that move one of its vertices."""
        moved: NDArray[np.bool_] = np.asarray(way.bends.any(axis=2))
        return np.array([moved[:, own].any(axis=1).sum() for own in self.vertices], dtype=np.int64)
