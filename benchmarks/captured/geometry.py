"""Similarities, closest points and what cameras see: an implementation apart from the package's."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from numpy.typing import NDArray
from scipy.spatial import cKDTree

__all__ = ["Nearest", "Similar", "closest", "similarity", "to_segments", "views_of"]

Points = NDArray[np.float64]
_CANDIDATES = 40  # triangles whose middles are nearest; the closest point lies in one of them
_BLOCK = 4096
# Of the angle between normal and camera; how far behind the surface a point still counts, in cm.
_LEAST_COSINE, _BEHIND = 0.2, 0.05


@dataclass(frozen=True, eq=False)
class Similar:
    """X ↦ scale · X Rᵀ + shift."""

    scale: float
    turn: Points
    shift: Points

    def __call__(self, points: Points) -> Points:
        """(..., 3) points moved."""
        return self.scale * points @ self.turn.T + self.shift


def similarity(source: Points, goal: Points) -> Similar:
    """The best one in the mean square from points (N, 3) to others.

    S. Umeyama, Least-squares estimation of transformation parameters between two point patterns,
    IEEE Transactions on Pattern Analysis and Machine Intelligence 13 (1991).
    """
    a, b = source - source.mean(axis=0), goal - goal.mean(axis=0)
    left, singular, right = np.linalg.svd(b.T @ a)
    sign = np.array([1, 1, np.sign(np.linalg.det(left @ right))])
    turn = left @ np.diag(sign) @ right
    scale = float((singular * sign).sum() / (a**2).sum())
    return Similar(scale, turn, goal.mean(axis=0) - scale * turn @ source.mean(axis=0))


@dataclass(frozen=True, eq=False)
class Nearest:
    """Closest points of a surface: triangles (N,), weights (N, 3) in them, distances (N,)."""

    triangles: NDArray[np.int64]
    weights: Points
    distances: Points

    def on(self, vertices: Points, triangles: NDArray[np.integer]) -> Points:
        """(N, 3) the same points of the surface where its vertices are elsewhere."""
        return np.einsum("nc,nca->na", self.weights, vertices[triangles[self.triangles]])


def closest(points: Points, vertices: Points, triangles: NDArray[np.integer]) -> Nearest:
    """Closest points of a surface to points (N, 3)."""
    corners = vertices[triangles]
    tree = cKDTree(corners.mean(axis=1))
    count = min(_CANDIDATES, len(triangles))
    best, weights, distances = [], [], []
    for first in range(0, len(points), _BLOCK):
        own = points[first : first + _BLOCK]
        candidates = tree.query(own, count)[1].reshape(len(own), count)
        w = _weights(own[:, None], corners[candidates])
        off = np.einsum("nkc,nkca->nka", w, corners[candidates]) - own[:, None]
        length = np.linalg.norm(off, axis=2)
        row, pick = np.arange(len(own)), length.argmin(axis=1)
        best.append(candidates[row, pick])
        weights.append(w[row, pick])
        distances.append(length[row, pick])
    return Nearest(*(np.concatenate(part) for part in (best, weights, distances)))


def _weights(points: Points, corners: Points) -> Points:
    """(..., 3) weights of the closest point of triangles (..., 3, 3).

    Inside, where the projection onto the plane is; else the nearest of the closest points of the
    three sides.
    """
    a, b, c = (corners[..., k, :] for k in range(3))
    u, v, w = b - a, c - a, points - a
    uu, uv, vv = (u * u).sum(-1), (u * v).sum(-1), (v * v).sum(-1)
    wu, wv = (w * u).sum(-1), (w * v).sum(-1)
    determinant = np.maximum(uu * vv - uv * uv, 1e-300)
    s, t = (wu * vv - wv * uv) / determinant, (wv * uu - wu * uv) / determinant
    inside = np.stack([1 - s - t, s, t], axis=-1)
    found, least = inside, np.where((inside >= 0).all(axis=-1), -1.0, np.inf)
    for first, second in ((0, 1), (1, 2), (2, 0)):
        start, way = corners[..., first, :], corners[..., second, :] - corners[..., first, :]
        along = ((points - start) * way).sum(-1) / np.maximum((way * way).sum(-1), 1e-300)
        along = np.clip(along, 0, 1)
        away = ((start + along[..., None] * way - points) ** 2).sum(-1)
        side = np.zeros_like(inside)
        side[..., first], side[..., second] = 1 - along, along
        nearer = away < least
        found, least = np.where(nearer[..., None], side, found), np.where(nearer, away, least)
    return found


def to_segments(points: Points, starts: Points, ends: Points) -> Points:
    """(N,) distance of points to the nearest of some segments."""
    way = ends - starts
    squared = np.maximum((way**2).sum(axis=1), 1e-300)
    along = np.einsum("nsa,sa->ns", points[:, None] - starts, way) / squared
    on = starts + np.clip(along, 0, 1)[..., None] * way
    return np.linalg.norm(on - points[:, None], axis=2).min(axis=1)


def views_of(
    points: Points,
    normals: Points,
    vertices: Points,
    triangles: NDArray[np.integer],
    cameras: list[tuple[Points, Points]],
) -> NDArray[np.int64]:
    """(N,) how many photographs show each point of a surface.

    Args:
        points: (N, 3) on it.
        normals: (N, 3) there.
        vertices: (V, 3) of it.
        triangles: (T, 3) of it.
        cameras: Position (3,) of each, and whether points (N, 3) fall into its photograph.
    """
    rays = EmbreeScene()
    TriangleMesh(rays, vertices.astype(np.float32), triangles.astype(np.int32))
    count = np.zeros(len(points), dtype=np.int64)
    for position, within in cameras:
        ways = points - position
        distances = np.linalg.norm(ways, axis=1)
        ways /= distances[:, None]
        start = np.ascontiguousarray(np.broadcast_to(position, ways.shape), dtype=np.float32)
        first = rays.run(start, ways.astype(np.float32), query="DISTANCE")
        facing = -np.einsum("na,na->n", ways, normals) > _LEAST_COSINE
        count += facing & (first > distances - _BEHIND) & np.asarray(within, dtype=bool)
    return count
