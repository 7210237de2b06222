"""Which point of a scan each vertex of a template belongs to, and how far that is to be trusted.

A scan is a surface with noise, holes and borders, and says of a vertex only how far it is from it.
So a point counts that is near and faces the same way, and the less the farther it is away; none
counts at a border or where the template is hidden, as within the mouth.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry import Surface, robust
from elastomorph.model.geometry import sides_of

Points = NDArray[np.float64]

# Directions into which a vertex looks for what hides it, and how many of them must be free.
_LOOKS, _FREE = 40, 0.3
# Least cosine of the angle between the normals of a vertex and its point.
_FACING = 0.5
# Points that a scan is looked up by; more are thinned out.
_MOST = 400_000


@dataclass(frozen=True, eq=False)
class Matches:
    """The points of a scan that belong to vertices.

    Attributes:
        points: (V, 3) on the scan.
        normals: (V, 3) of the scan there, of length 1.
        distances: (V,) from the vertices.
        cosines: (V,) of the angle between the normals of vertex and scan.
        border: (V,) whether the point is at a border of the scan.
    """

    points: Points
    normals: Points
    distances: Points
    cosines: Points
    border: NDArray[np.bool_]

    def weights(self, reach: float) -> Points:
        """(V,) from 0 to 1 by distance (Geman and McClure): a quarter at the reach."""
        return robust(self.distances, reach) * (self.cosines > _FACING) * ~self.border


class ScanPoints:
    """Points of a scan as dense as a template asks for, with their normals.

    Attributes:
        points: (N, 3).
        normals: (N, 3) of length 1.
        border: (N,) which are at a border.
    """

    def __init__(self, surface: Surface, spacing: float, most: int = _MOST) -> None:
        """Vertices, and points within triangles that are larger than the spacing; most of them."""
        border = border_vertices(len(surface.vertices), surface.triangles)
        used = np.unique(surface.triangles)
        tables = [(surface.vertices[used], surface.normals[used], border[used])]
        for weights, triangles in _within(surface, spacing):
            corners = surface.triangles[triangles]
            at_border = np.any(border[corners], axis=1)
            normals = weights @ surface.normals[corners]
            normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-30)
            edge = np.repeat(at_border[:, None], len(weights), axis=1)
            places = weights @ surface.vertices[corners]
            tables.append((places.reshape(-1, 3), normals.reshape(-1, 3), edge.ravel()))
        self.points, self.normals, self.border = (
            np.concatenate(each) for each in zip(*tables, strict=True)
        )
        if len(self.points) > most:
            kept = np.random.default_rng(0).choice(len(self.points), most, replace=False)
            kept.sort()
            self.points, self.normals = self.points[kept], self.normals[kept]
            self.border = self.border[kept]
        self._trees: dict[int, Any] = {}

    def fewer(self, count: int) -> ScanPoints:
        """Every so many of the points, that about so many are left."""
        step = max(1, len(self.points) // count)
        copy = object.__new__(ScanPoints)
        copy.points, copy.normals = self.points[::step], self.normals[::step]
        copy.border, copy._trees = self.border[::step], {}
        return copy

    def mirrored(self, mirror: Points) -> ScanPoints:
        """The points of the scan reflected, by a (3, 3) diagonal matrix."""
        copy = object.__new__(ScanPoints)
        copy.points, copy.normals = self.points @ mirror, self.normals @ mirror
        copy.border, copy._trees = self.border, {}
        return copy

    def matches(self, points: Points, normals: Points, turn: float, nearly: float = 0.0) -> Matches:
        """The point of the scan's tangent planes that is near (N, 3) points and faces alike.

        Args:
            points: (N, 3).
            normals: (N, 3) there.
            turn: the distance, in the units of the points, that counts as much as normals that
                differ by 1.
            nearly: part by which another point may be farther away than the nearest.
        """
        tree, turn = self._tree_of(turn)
        own = tree.query(np.hstack([points, turn * normals]), eps=nearly)[1]
        there = self.normals[own]
        height = np.einsum("ij,ij->i", points - self.points[own], there)
        # Of the nearest point only what is across counts beyond its plane: points are dense.
        place = points - height[:, None] * there
        aside = np.linalg.norm(place - self.points[own], axis=1)
        near = aside < np.maximum(2 * self._spacing, np.abs(height))
        place = np.where(near[:, None], place, self.points[own])
        return Matches(
            place,
            there,
            np.linalg.norm(place - points, axis=1),
            np.einsum("ij,ij->i", there, normals),
            self.border[own],
        )

    def _tree_of(self, turn: float) -> tuple[Any, float]:
        """Points and normals, sorted; one for all of about the same weight of normals."""
        from scipy.spatial import cKDTree

        step = round(2 * np.log2(turn))
        if step not in self._trees:
            self._trees[step] = cKDTree(np.hstack([self.points, 2 ** (step / 2) * self.normals]))
        return self._trees[step], 2 ** (step / 2)

    @cached_property
    def _spacing(self) -> float:
        """Median distance of a point to the next one."""
        from scipy.spatial import cKDTree

        some = self.points[:: max(1, len(self.points) // 2000)]
        near = np.asarray(cKDTree(self.points).query(some, k=2)[0])
        return float(np.median(near[:, 1]))


def _within(surface: Surface, spacing: float) -> list[tuple[Points, NDArray[np.int64]]]:
    """Weights of points within triangles, and the triangles that are large enough to need them."""
    area = np.linalg.norm(surface.face_normals, axis=1) / 2
    wanted = np.minimum(np.sqrt(area) / spacing, 12).astype(np.int64)
    found = []
    for count in np.unique(wanted[wanted > 0]):
        steps = (np.arange(count) + 1 / 3) / count
        u, v = (each.ravel() for each in np.meshgrid(steps, steps))
        inside = u + v < 1
        u, v = u[inside], v[inside]
        weights = np.stack([1 - u - v, u, v], axis=1)
        found.append((weights, np.flatnonzero(wanted == count)))
    return found


def border_vertices(count: int, triangles: NDArray[np.integer]) -> NDArray[np.bool_]:
    """(V,) which vertices are on an edge of a single triangle."""
    low, high = np.sort(sides_of(triangles), axis=1).T
    edges, times = np.unique(low * count + high, return_counts=True)
    found: NDArray[np.bool_] = np.zeros(count, dtype=bool)
    found[np.concatenate(np.divmod(edges[times == 1], count))] = True
    return found


def exposed(surface: Surface, some: NDArray[np.integer], inward: bool = False) -> Points:
    """(N,) how much of what some vertices look at is free, from 0 (hidden) to 1."""
    normals = surface.normals[some] * (-1 if inward else 1)
    side = np.where(np.abs(normals[:, :1]) > 0.6, [[0.0, 1.0, 0.0]], [[1.0, 0.0, 0.0]])
    first = np.cross(normals, side)
    first /= np.maximum(np.linalg.norm(first, axis=1, keepdims=True), 1e-30)
    second = np.cross(normals, first)
    size = np.linalg.norm(np.ptp(surface.vertices, axis=0))
    starts = surface.vertices[some] + 1e-3 * size * normals
    free = np.zeros(len(normals))
    for x, y, z in _hemisphere(_LOOKS):
        free += ~surface.cast(starts, x * first + y * second + z * normals).met
    return free / _LOOKS


def outer(surface: Surface) -> NDArray[np.bool_]:
    """(V,) which vertices of a template a scanner can see: not those within mouth, nose or eyes."""
    return exposed(surface, np.arange(len(surface.vertices))) >= _FREE


def inside_out(surface: Surface) -> bool:
    """Whether a surface shows its inside: its back is freer than its front."""
    used = np.unique(surface.triangles)
    some = used[:: max(1, len(used) // 2000)]
    return bool(exposed(surface, some).mean() < exposed(surface, some, inward=True).mean())


def _hemisphere(count: int) -> Points:
    """(count, 3) directions, spread evenly by their cosine (a Fibonacci spiral)."""
    number = np.arange(count)
    z = np.sqrt((number + 0.5) / count)
    angle = number * np.pi * (3 - np.sqrt(5))
    across = np.sqrt(1 - z**2)
    return np.stack([across * np.cos(angle), across * np.sin(angle), z], axis=1)
