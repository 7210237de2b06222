"""Tetrahedra inside a closed surface, and how its vertices ride on them.

A body-centred cubic lattice: the corners and centres of cubes, with four tetrahedra about each face
that two cubes share, all of one shape. Those stay that have a node inside the surface or a vertex
of it; the surface is not meshed, it is carried. Holes (a neck, the sockets of eyes) are closed by
a cone to the middle of their rim.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import MeshError
from elastomorph.model.mesh import Mesh
from elastomorph.model.surface import triangulate

# The lattice lies askew of the axes' origin, so that no line of it runs along an edge.
_ASKEW = np.sqrt([2.0, 3.0, 5.0]) % 1.0
# Less of a solid than this share of the box around it is a sheet.
_LEAST_SOLID = 1e-3
_AROUND = ((0, 0), (1, 0), (1, 1), (0, 1))


@dataclass(frozen=True, eq=False)
class Closed:
    """A closed surface: triangles, each counting in part."""

    points: NDArray[np.float64]  # (P, 3)
    triangles: NDArray[np.int64]  # (T, 3), counter-clockwise from outside
    shares: NDArray[np.float64]  # (T,)

    @property
    def volume(self) -> float:
        """What is inside."""
        a, b, c = np.moveaxis(self.points[self.triangles], 1, 0)
        return float((np.einsum("ti,ti->t", a, np.cross(b, c)) * self.shares).sum()) / 6.0

    @classmethod
    def of(cls, mesh: Mesh) -> Closed:
        """A mesh with its holes closed; of one connected part.

        Raises:
            MeshError: It has no inside.
        """
        triangles, shares = triangulate(mesh)
        corners = triangles.astype(np.int64)
        ends = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
        weights = np.tile(shares, 3) * np.where(ends[:, 0] < ends[:, 1], 1.0, -1.0)
        edges, place = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)
        net = np.bincount(place.ravel(), weights)
        open_edges = np.abs(net) > 1e-6
        rim = np.where((net > 0)[:, None], edges[:, ::-1], edges)[open_edges]
        points, caps = _cones(mesh.vertices, rim)
        found = cls(
            points,
            np.concatenate([corners, caps]),
            np.concatenate([shares, np.abs(net[open_edges])]),
        )
        if found.volume < 0:
            found = cls(points, found.triangles[:, ::-1], found.shares)
        box = float(np.ptp(points, axis=0).prod())
        if not found.volume > _LEAST_SOLID * box:
            raise MeshError("it needs a closed body, and this surface has next to nothing inside")
        return found

    def inside(
        self, x: NDArray[np.float64], y: NDArray[np.float64], z: NDArray[np.float64]
    ) -> NDArray[np.bool_]:
        """(X, Y, Z) whether the points of a grid are inside: how often lines along x cross."""
        a, b, c = np.moveaxis(self.points[self.triangles], 1, 0)
        low = np.minimum(np.minimum(a, b), c)
        high = np.maximum(np.maximum(a, b), c)
        first = np.stack([np.searchsorted(own, low[:, i]) for i, own in ((1, y), (2, z))], axis=1)
        last = np.stack([np.searchsorted(own, high[:, i]) for i, own in ((1, y), (2, z))], axis=1)
        spans = last - first
        counts = spans.prod(axis=1)
        triangle = np.repeat(np.arange(len(counts)), counts)
        number = np.arange(len(triangle)) - np.repeat(np.cumsum(counts) - counts, counts)
        j = first[triangle, 0] + number // np.maximum(spans[triangle, 1], 1)
        k = first[triangle, 1] + number % np.maximum(spans[triangle, 1], 1)
        line = np.stack([y[j], z[k]], axis=1)
        corners = (a[triangle], b[triangle], c[triangle])
        # Twice the areas that the line makes with the sides, across x.
        areas = np.stack(
            [
                _crossed(corners[(i + 1) % 3][:, 1:] - line, corners[(i + 2) % 3][:, 1:] - line)
                for i in range(3)
            ],
            axis=1,
        )
        whole = areas.sum(axis=1)
        hit = ((areas > 0).all(axis=1) | (areas < 0).all(axis=1)) & (whole != 0)
        areas, whole, triangle = areas[hit], whole[hit], triangle[hit]
        at = sum(areas[:, i] * corners[i][hit, 0] for i in range(3)) / whole
        winding = np.zeros((len(y), len(z), len(x)))
        turns = np.sign(whole) * self.shares[triangle]
        np.add.at(winding, (j[hit], k[hit]), turns[:, None] * (x < np.asarray(at)[:, None]))
        return np.moveaxis(winding > 0.5, 2, 0)


@dataclass(frozen=True, eq=False)
class Lattice:
    """Tetrahedra and the points that ride on them."""

    nodes: NDArray[np.float64]  # (N, 3)
    tetrahedra: NDArray[np.int64]  # (K, 4), positive volume
    carrier: NDArray[np.int64]  # (P,) the tetrahedron of each point; -1 where it is in none
    shares: NDArray[np.float64]  # (P, 4) its barycentric coordinates

    @classmethod
    def inside(
        cls, surface: Closed, skin: NDArray[np.float64], riders: NDArray[np.float64], count: int
    ) -> Lattice:
        """About so many nodes within a surface and about (S, 3) points of it; (P, 3) ride along."""
        step = (2.0 * surface.volume / count) ** (1.0 / 3.0)
        low = surface.points.min(axis=0) - (2.0 + _ASKEW) * step
        shape = np.ceil(np.ptp(surface.points, axis=0) / step).astype(int) + 6
        corners = [low[i] + step * np.arange(shape[i]) for i in range(3)]
        centres = [own[:-1] + step / 2 for own in corners]
        is_in = np.concatenate([surface.inside(*own).ravel() for own in (corners, centres)])
        nodes = np.concatenate(
            [
                np.stack(np.meshgrid(*own, indexing="ij"), 3).reshape(-1, 3)
                for own in (corners, centres)
            ]
        )
        tetrahedra = _tetrahedra(tuple(int(n) for n in shape))
        kept = np.asarray(is_in[tetrahedra].any(axis=1))
        kept[_located(nodes, tetrahedra, skin)[0]] = True
        # What hangs on an edge alone would swing about it: with it all that its nodes span.
        touched = np.zeros(len(nodes), dtype=bool)
        touched[tetrahedra[kept]] = True
        kept |= touched[tetrahedra].all(axis=1)
        used = np.flatnonzero(touched)
        renamed = np.searchsorted(used, tetrahedra[kept])
        carrier, shares = _located(nodes, tetrahedra, riders)
        place = np.where(kept, np.cumsum(kept) - 1, -1)
        return cls(nodes[used], renamed, np.where(carrier >= 0, place[carrier], -1), shares)

    def carried(self, nodes: NDArray[np.float64]) -> NDArray[np.float64]:
        """(P, 3) the riders where the nodes are elsewhere; meaningless for those in none."""
        corners = nodes[self.tetrahedra[self.carrier]]
        return np.asarray(np.einsum("pc,pci->pi", self.shares, corners))


def _cones(
    points: NDArray[np.float64], rim: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """The points with the middles of all rims behind them, and triangles from rims to middles."""
    from elastomorph.model.geometry import component_of

    if not len(rim):
        return points, np.zeros((0, 3), dtype=np.int64)
    own, place = np.unique(rim, return_inverse=True)
    rim_of = component_of(len(own), place.reshape(-1, 2))
    sums = np.stack([np.bincount(rim_of, axis) for axis in points[own].T], axis=1)
    middles = sums / np.bincount(rim_of)[:, None]
    apex = len(points) + rim_of[place.reshape(-1, 2)[:, 0]]
    return np.concatenate([points, middles]), np.column_stack([rim, apex])


def _crossed(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])


def _tetrahedra(shape: tuple[int, ...]) -> NDArray[np.int64]:
    """(K, 4) of a lattice of so many corners along each axis; centres are numbered behind them."""
    corner = np.arange(np.prod(shape)).reshape(shape)
    cubes = tuple(n - 1 for n in shape)
    centre = corner.size + np.arange(np.prod(cubes)).reshape(cubes)
    found = []
    for axis in range(3):
        others = [i for i in range(3) if i != axis]
        one, other = (np.take(centre, np.arange(s, cubes[axis] - 1 + s), axis) for s in (0, 1))
        ring = []
        for offsets in _AROUND:
            part = np.take(corner, np.arange(1, cubes[axis]), axis)
            for i, offset in zip(others, offsets, strict=True):
                part = np.take(part, np.arange(offset, cubes[i] + offset), i)
            ring.append(part)
        # Seen along y the two other axes turn the other way round.
        ends = (one, other) if axis != 1 else (other, one)
        for i in range(4):
            found.append(
                np.stack([ends[0], ring[i], ring[(i + 1) % 4], ends[1]], -1).reshape(-1, 4)
            )
    return np.concatenate(found)


def _located(
    nodes: NDArray[np.float64], tetrahedra: NDArray[np.int64], points: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """(P,) the tetrahedron each point is in, and (P, 4) its barycentric coordinates there."""
    from scipy.spatial import cKDTree

    near = 12
    found = cKDTree(nodes[tetrahedra].mean(axis=1)).query(points, k=near)[1]
    candidates: NDArray[np.int64] = np.asarray(found)
    corners = nodes[tetrahedra[candidates]]
    sides = np.swapaxes(corners[:, :, 1:] - corners[:, :, :1], 2, 3)
    rest = np.linalg.solve(sides, (points[:, None] - corners[:, :, 0])[..., None])[..., 0]
    shares = np.concatenate([1.0 - rest.sum(axis=2, keepdims=True), rest], axis=2)
    best = shares.min(axis=2).argmax(axis=1)
    own = np.arange(len(points))
    within = shares[own, best].min(axis=1) > -1e-9
    return np.where(within, candidates[own, best], -1), shares[own, best]
