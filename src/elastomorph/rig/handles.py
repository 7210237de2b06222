"""Points of a face that are to be somewhere, and how they move with the sliders of a rig."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import ParameterError
from elastomorph.model.bend_curve import BendCurve
from elastomorph.numbers import as_numbers, is_whole, shown
from elastomorph.rig.sliders import Sliders

if TYPE_CHECKING:
    from elastomorph.rig.rig import Rig

Floats = NDArray[np.float64]

Place = int | tuple[Sequence[int], Sequence[float]]
"""A vertex; or vertices and their shares of a point between them, which sum to 1."""

Handle = str | Place
"""A place, or the name of a landmark."""

_SHARES_SUM = 1e-6
_PACES = 33
_STALLED = 0.25
"""Of a path's mean speed: one that is slower begins or ends there."""


class Mix(NamedTuple):
    """Points as sums of vertices, the vertices of one point after those of another."""

    vertices: NDArray[np.intp]  # (N,)
    shares: Floats  # (N,)
    firsts: NDArray[np.intp]  # (H,) first vertex of each point

    def of(self, fields: Floats) -> Floats:
        """(F, H, 3) the points of fields at the (F, N, 3) vertices."""
        return np.add.reduceat(fields * self.shares[:, None], self.firsts, axis=1)


class Moving(NamedTuple):
    """Points of a pose, and their derivatives with respect to the weights of the morphs."""

    positions: Floats  # (H, 3)
    speeds: Floats  # (morphs, 3H) first derivatives
    turns: Floats  # (morphs, 3H) second derivatives; a morph's path depends on no other's weight
    through: Floats  # (morphs, sliders) derivatives of the morphs' weights

    @property
    def rates(self) -> Floats:
        """(3H, sliders) derivatives of the coordinates."""
        return self.speeds.T @ self.through

    def curved(self, left: Floats) -> Floats:
        """(sliders, sliders) what the turning of paths adds to the normal matrix of residuals.

        Only where it adds: what bends towards its goal shall make no minimum a saddle.
        """
        bends = np.maximum(self.turns @ left, 0.0)
        return self.through.T @ (bends[:, None] * self.through)


@dataclass(frozen=True, eq=False)
class HandledPoints:
    """Some points of a rig, fast to pose and to differentiate."""

    sliders: Sliders
    rest: Floats  # (H, 3) in the neutral
    fields: Floats  # (F, 3H) how Δ and bends of all morphs move them
    deltas: NDArray[np.intp]  # (morphs,) row of each morph's Δ; its bends follow
    bends: NDArray[np.intp]  # (K,) the rows that are bends
    curves: tuple[tuple[int, BendCurve], ...]  # Of each, with the number of its morph

    @classmethod
    def of(cls, rig: Rig, points: Mix) -> HandledPoints:
        """The points on the morphs of a rig."""
        morphs = list(rig.morphs.values())
        parts = [rig.neutral.vertices.take(points.vertices, axis=0)[None]]
        for morph in morphs:
            parts.append(morph.delta.take(points.vertices, axis=0)[None])
            if morph.bend_curves:
                parts.append(morph.bends.take(points.vertices, axis=1))
        fields = points.of(np.concatenate(parts))
        rows = len(fields) - 1
        deltas = np.cumsum([0, *(1 + len(morph.bend_curves) for morph in morphs)])[:-1]
        return cls(
            rig.sliders,
            fields[0],
            fields[1:].reshape(rows, fields[0].size),
            deltas,
            np.delete(np.arange(rows), deltas),
            tuple((j, curve) for j, morph in enumerate(morphs) for curve in morph.bend_curves),
        )

    @property
    def reach(self) -> float:
        """The farthest that one slider at 1 moves one of the points."""
        lengths = np.linalg.norm(self.fields[self.deltas].reshape(-1, 3), axis=1)
        return float(lengths.max(initial=0.0))

    @property
    def straight(self) -> HandledPoints:
        """The points on straight paths to the same targets."""
        count = len(self.deltas)
        none = np.arange(0)
        return HandledPoints(
            self.sliders, self.rest, self.fields[self.deltas], np.arange(count), none, ()
        )

    def stall(self, row: Floats) -> bool:
        """Whether a slider moves the points far, yet hardly from (sliders,) weights on.

        Beams set out so, and a search that goes downhill finds nothing to do there.
        """
        bent, even = (np.linalg.norm(each.at(row).rates, axis=0) for each in (self, self.straight))
        return bool((bent < _STALLED * even).any())

    def paced(self, row: Floats) -> Floats:
        """The (sliders,) weights that bring each as far along its chord as straight paths come."""
        times, ways = self._progress
        there = [np.interp(at, way, times) for at, way in zip(row, ways, strict=True)]
        return np.where((row > 0) & (row < 1), there, row)

    @cached_property
    def _progress(self) -> tuple[Floats, Floats]:
        """(T,) weights, and (sliders, T) how far each slider alone has come along its chord."""
        times = np.linspace(0.0, 1.0, _PACES)
        ways = np.tile(times, (len(self.sliders.names), 1))
        for way, own in zip(ways, np.eye(len(ways)), strict=True):
            moved = np.array([self.at(time * own).positions - self.rest for time in times])
            along = np.tensordot(moved, moved[-1])
            if along[-1] > 0:
                way[:] = np.maximum.accumulate(along / along[-1])
        return times, ways

    @cached_property
    def _bends(self) -> list[tuple[NDArray[np.intp], NDArray[np.intp]]]:
        """Morphs that have a first bend, and its row; those that have a second, and so on."""
        own = [morph for morph, _ in self.curves]
        counts = np.bincount(np.array(own, dtype=np.intp), minlength=len(self.deltas))
        have = [np.flatnonzero(counts > bend) for bend in range(counts.max(initial=0))]
        return [(morphs, self.deltas[morphs] + 1 + bend) for bend, morphs in enumerate(have)]

    def at(self, row: Floats) -> Moving:
        """Where the points are at (sliders,) weights, and how they move from there."""
        times, through = self.sliders.drive_rates(row)
        factors = np.zeros((3, len(self.fields)))
        factors[0, self.deltas], factors[1, self.deltas] = times, 1.0
        each = times.tolist()
        given = [curve.derivatives_at(each[morph]) for morph, curve in self.curves]
        factors[:, self.bends] = np.array(given).reshape(-1, 3).T
        positions = self.rest + (factors[0] @ self.fields).reshape(-1, 3)
        speeds = self.fields[self.deltas]
        turns = np.zeros_like(speeds)
        for morphs, bends in self._bends:
            for order, rates in ((1, speeds), (2, turns)):
                rates[morphs] += factors[order, bends, None] * self.fields[bends]
        return Moving(positions, speeds, turns, through)


def asked(
    handles: Mapping[Handle, ArrayLike], landmarks: Mapping[str, Place] | None, count: int
) -> tuple[Mix, Floats]:
    """The points that handles name on a mesh of so many vertices, and their (H, 3) positions.

    Raises:
        ParameterError: There are none, one is not on the mesh or not known, or a position is not
            three finite numbers.
    """
    if not isinstance(handles, Mapping) or not handles:
        raise ParameterError(
            "handles are a mapping from vertices or landmarks to positions, such as "
            f"{{2010: [0, 1, 2]}}, with at least one in it, found {shown(handles)}"
        )
    mix = mixed(handles, landmarks, count)
    goals = np.empty((len(handles), 3))
    for goal, (handle, position) in zip(goals, handles.items(), strict=True):
        given = as_numbers(position, f"the position of {handle!r}")
        if given.shape != (3,) or not np.isfinite(given).all():
            raise ParameterError(
                f"the position of {handle!r} must be three finite numbers, found {shown(position)}"
            )
        goal[:] = given
    return mix, goals


def mixed(handles: Iterable[Handle], landmarks: Mapping[str, Place] | None, count: int) -> Mix:
    """The points that handles name on a mesh of so many vertices.

    Raises:
        ParameterError: One is not on the mesh or not known.
    """
    known = {} if landmarks is None else landmarks
    if not isinstance(known, Mapping):
        raise ParameterError(
            "landmarks are a mapping from names to vertices, such as {'chin': 2010}, found "
            f"{shown(landmarks)}"
        )
    vertices: list[int] = []
    shares: list[float] = []
    firsts: list[int] = []
    for handle in handles:
        if isinstance(handle, str) and handle not in known:
            raise ParameterError(
                f"the landmark {handle!r} is not known: say where it is, as in "
                f"landmarks={{{handle!r}: 2010}}"
            )
        firsts.append(len(vertices))
        place = known[handle] if isinstance(handle, str) else handle
        corners, parts = _point(place, handle, count)
        vertices += corners
        shares += parts
    return Mix(np.array(vertices), np.array(shares), np.array(firsts))


def _point(place: object, handle: Handle, count: int) -> tuple[list[int], list[float]]:
    """Vertices of a place and their shares."""
    corners: list[Any] = [place]
    parts: list[Any] = [1.0]
    if isinstance(place, tuple | list) and len(place) == 2:
        corners, parts = (list(of) if isinstance(of, Iterable) else [] for of in place)
    whole = all(is_whole(corner) for corner in corners)
    if not corners or not whole or len(corners) != len(parts):
        raise ParameterError(
            "a handle is a vertex, the name of a landmark, or vertices and their shares such as "
            f"((12, 40, 41), (0.2, 0.3, 0.5)), found {shown(handle)}"
        )
    for corner in corners:
        if not 0 <= corner < count:
            raise ParameterError(
                f"the handle {handle!r} is on vertex {corner}, but the mesh has {count:,} vertices,"
                " counted from 0"
            )
    numbers = as_numbers(parts, f"the shares of {handle!r}")
    if not abs(float(numbers.sum()) - 1.0) <= _SHARES_SUM:
        raise ParameterError(f"the shares of {handle!r} must sum to 1, found {parts}")
    return [int(corner) for corner in corners], numbers.tolist()
