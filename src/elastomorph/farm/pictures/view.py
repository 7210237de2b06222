"""One posed subject before one camera: what rays through a picture meet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.surface import Surface
from elastomorph.farm.pictures.scenes import Scene
from elastomorph.farm.pictures.subject import MASKED, OPAQUE, Subject

__all__ = ["Points", "Seen", "Veil", "View", "mixed"]

_MOST_LAYERS = 24
"""Of what lets rays through, one behind another; hair of cards has a dozen."""
_ON = 3e-6
"""Of the distance, by which a ray that goes on starts behind what it has met."""
_SOLID = 0.995  # opacity from which nothing is seen through what blends
_LABELLED = 0.5  # opacity from which labels are those of what blends


@dataclass(frozen=True, eq=False)
class Points:
    """Points of the subject.

    Attributes:
        triangle: (N,) of the subject.
        weights: (N, 3) float32 of its corners.
        position: (N, 3) in the camera's axes.
        normal: (N, 3) float32 unit normals there, towards the camera.
    """

    triangle: NDArray[np.int64]
    weights: NDArray[np.float32]
    position: NDArray[np.float64]
    normal: NDArray[np.float32]

    def only(self, chosen: NDArray[np.bool_] | NDArray[np.int64]) -> Points:
        """Those of (N,) that are chosen."""
        return Points(
            self.triangle[chosen], self.weights[chosen], self.position[chosen], self.normal[chosen]
        )

    @classmethod
    def joined(cls, points: Sequence[Points]) -> Points:
        """All of them, one after another."""
        fields = ("triangle", "weights", "position", "normal")
        return cls(*(np.concatenate([getattr(own, name) for own in points]) for name in fields))


@dataclass(frozen=True, eq=False)
class Veil:
    """What shines through, met first, second or third …: rays, rising, and a point for each."""

    ray: NDArray[np.int64]
    points: Points


@dataclass(frozen=True, eq=False)
class Seen:
    """What N rays meet.

    Attributes:
        ray: (M,) those that end on something solid, rising.
        points: M, where.
        veils: What is before that, from the nearest to the farthest.
    """

    ray: NDArray[np.int64]
    points: Points
    veils: tuple[Veil, ...]


@dataclass(frozen=True, eq=False)
class _Met:
    depth: NDArray[np.float64]
    triangle: NDArray[np.int64]
    weights: NDArray[np.float32]


def mixed(weights: NDArray[np.float32], values: NDArray[np.float32]) -> NDArray[np.float32]:
    """(N, K) means of (N, 3, K) values with (N, 3) weights."""
    return np.asarray(np.einsum("ni,nik->nk", weights, values))


class View:
    """A subject with (V, 3) positions of the rig, in a scene.

    Attributes:
        seen: (V, 3) positions in the camera's axes.
        places: (V, 2) x and y in the picture.
    """

    def __init__(self, subject: Subject, positions: NDArray[np.floating], scene: Scene) -> None:
        self.subject, self.scene = subject, scene
        self.seen = scene.seen(positions)
        self.places = scene.pixels(self.seen)
        self.normals = subject.normals(self.seen)
        self._solid = np.flatnonzero(subject.opacity == OPAQUE)
        self._thin = np.flatnonzero(subject.opacity != OPAQUE)
        self.solid = Surface(self.seen, subject.triangles[self._solid])
        self.thin = Surface(self.seen, subject.triangles[self._thin])

    def look(self, places: NDArray[np.floating]) -> Seen:
        """What is met by rays through (N, 2) places in the picture."""
        ways = np.column_stack([self.scene.slopes(places), np.ones(len(places))])
        first = self._next(self.solid, self._solid, ways, np.zeros(len(ways)))
        layers = self._layers(ways, first) if len(self._thin) else []
        ray = np.flatnonzero(first.triangle >= 0)
        solid = self._points(first.triangle[ray], first.weights[ray])
        return Seen(ray, solid, tuple(layers))

    def labelled(self, found: Seen) -> tuple[NDArray[np.int64], Points]:
        """(K,) rays, rising, and the points that labels are of: solid, or hardly seen through."""
        ray, points = found.ray, found.points
        for veil in reversed(found.veils):
            there = self.opacity(veil.points) >= _LABELLED
            whole = Points.joined([veil.points.only(there), points])
            # Of two on a ray, the first in this order is the nearer.
            ray, kept = np.unique(np.concatenate([veil.ray[there], ray]), return_index=True)
            points = whole.only(kept)
        return ray, points

    def opacity(self, points: Points) -> NDArray[np.float32]:
        """(N,) from 0 to 1."""
        found = np.ones(len(points.triangle), dtype=np.float32)
        cloth = self.subject.cloth[points.triangle]
        for number in np.unique(cloth).tolist():
            own, mine = self.subject.cloths[number], np.flatnonzero(cloth == number)
            found[mine] = own.colour[3]
            if own.texels is not None:
                places = self.subject.places[points.triangle[mine]]
                found[mine] = own.texels.at(mixed(points.weights[mine], places))[:, 3]
        return found

    def _layers(self, ways: NDArray[np.float64], first: _Met) -> list[Veil]:
        """What blends before the solid; what is cut out, or blends with nothing, becomes solid."""
        kinds, layers = self.subject.opacity, []
        alive, after = np.arange(len(ways)), np.zeros(len(ways))
        for _ in range(_MOST_LAYERS):
            met = self._next(self.thin, self._thin, ways[alive], after)
            before = met.depth < first.depth[alive]
            alive, after = alive[before], met.depth[before]
            triangle, weights = met.triangle[before], met.weights[before]
            if not len(alive):
                break
            points = self._points(triangle, weights)
            opacity = self.opacity(points)
            cut = kinds[triangle] == MASKED
            cutoff = np.array([own.cutoff for own in self.subject.cloths])
            least = np.where(cut, cutoff[self.subject.cloth[triangle]], _SOLID)
            ends, blends = opacity >= least, ~cut & (opacity < least) & (opacity > 0)
            first.depth[alive[ends]] = after[ends]
            first.triangle[alive[ends]] = triangle[ends]
            first.weights[alive[ends]] = weights[ends]
            layers.append(Veil(alive[blends], points.only(blends)))
            alive, after = alive[~ends], after[~ends]
        return layers

    def _next(
        self,
        surface: Surface,
        own: NDArray[np.int64],
        ways: NDArray[np.float64],
        after: NDArray[np.float64],
    ) -> _Met:
        """What rays meet next behind a depth, but for the backs of what has only a front."""
        count = len(ways)
        met = _Met(np.full(count, np.inf), np.full(count, -1), np.zeros((count, 3), np.float32))
        going, start = np.arange(count), after * (1 + _ON)
        for _ in range(_MOST_LAYERS):
            if not len(going) or not len(own):
                break
            hits = surface.cast(start[:, None] * ways[going], ways[going])
            triangle = np.where(hits.met, own[np.maximum(hits.triangles, 0)], -1)
            back = hits.met & self.subject.one_sided[triangle]
            back[back] = self._turned_away(triangle[back], ways[going[back]])
            depth = start + hits.depths
            done = hits.met & ~back
            met.depth[going[done]], met.triangle[going[done]] = depth[done], triangle[done]
            met.weights[going[done]] = hits.weights[done]
            going, start = going[back], depth[back] * (1 + _ON)
        return met

    def _turned_away(
        self, triangle: NDArray[np.int64], ways: NDArray[np.float64]
    ) -> NDArray[np.bool_]:
        a, b, c = self.seen[self.subject.triangles[triangle]].transpose(1, 0, 2)
        return np.asarray(np.einsum("ni,ni->n", np.cross(b - a, c - a), ways) > 0)

    def _points(self, triangle: NDArray[np.int64], weights: NDArray[np.float32]) -> Points:
        corners = self.seen[self.subject.triangles[triangle]]
        position = np.einsum("ni,nik->nk", weights.astype(np.float64), corners)
        normal = mixed(weights, self.normals[self.subject.corners[triangle]])
        length = np.sqrt(np.einsum("ni,ni->n", normal, normal))
        away = np.einsum("ni,ni->n", normal, position) > 0
        normal *= (np.where(away, -1, 1) / np.maximum(length, 1e-20)).astype(np.float32)[:, None]
        return Points(triangle, weights, position, normal)
