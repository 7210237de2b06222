"""A surface of triangles that rays and points can be asked of."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

from elastomorph.capturing.geometry.camera import Camera
from elastomorph.errors import MissingExtraError
from elastomorph.model.geometry import sides_of
from elastomorph.model.surface import closest_weights

Points = NDArray[np.float64]
Triangles = NDArray[np.integer]

# Pairs of a point and a triangle that are measured at once: about 100 MB.
_AT_ONCE = 400_000


@dataclass(frozen=True, eq=False)
class Hits:
    """Where rays meet a surface first.

    Attributes:
        depths: (...) in lengths of the ray's direction; infinite where nothing is met.
        triangles: (...) int64, −1 where nothing is met.
        weights: (..., 3) of the triangle's corners.
    """

    depths: Points
    triangles: NDArray[np.int64]
    weights: Points

    @property
    def met(self) -> NDArray[np.bool_]:
        """(...) whether the ray meets anything."""
        return self.triangles >= 0


@dataclass(frozen=True, eq=False)
class Closest:
    """The closest points of a surface.

    Attributes:
        points: (N, 3) on the surface.
        triangles: (N,) int64.
        weights: (N, 3) of the triangle's corners.
        distances: (N,).
    """

    points: Points
    triangles: NDArray[np.int64]
    weights: Points
    distances: Points


class Surface:
    """Triangles in space.

    Attributes:
        vertices: (V, 3).
        triangles: (T, 3) vertex indices.
    """

    def __init__(self, vertices: Points, triangles: Triangles) -> None:
        self.vertices = np.asarray(vertices, dtype=np.float64)
        self.triangles = np.asarray(triangles, dtype=np.int64)

    @cached_property
    def face_normals(self) -> Points:
        """(T, 3) twice the area of each triangle along its normal."""
        a, b, c = np.moveaxis(self.vertices[self.triangles], 1, 0)
        return np.cross(b - a, c - a)

    @cached_property
    def normals(self) -> Points:
        """(V, 3) unit normals, triangles weighted by their area; zeros where there are none."""
        total = np.zeros_like(self.vertices)
        for corner in self.triangles.T:
            np.add.at(total, corner, self.face_normals)
        total /= np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-30)
        return total

    @cached_property
    def ways(self) -> Any:
        """(V, V) sparse: the lengths of the edges, for ways along the surface."""
        first, second = edges_of(self.triangles).T
        count = len(self.vertices)
        lengths = np.linalg.norm(self.vertices[first] - self.vertices[second], axis=1)
        lengths = np.maximum(lengths, np.finfo(float).tiny)
        return sparse.coo_array((lengths, (first, second)), shape=(count, count)).tocsr()

    def at(self, where: Hits | Closest, values: Points) -> Points:
        """(..., K) values (V, K) at the vertices, between them at points of the surface.

        Where a ray met nothing they are those of some triangle.
        """
        corners = self.triangles[np.maximum(where.triangles, 0)]
        found: Points = np.einsum("...i,...ij->...j", where.weights, values[corners])
        return found

    def cast(self, origins: Points, directions: Points) -> Hits:
        """Where rays from (..., 3) or (3,) origins along (..., 3) directions meet it first."""
        rays = np.ascontiguousarray(directions.reshape(-1, 3), dtype=np.float32)
        starts = np.empty_like(rays)
        starts[:] = np.broadcast_to(origins, directions.shape).reshape(-1, 3)
        found = self._scene.run(starts, rays, output=True)
        triangles = found["primID"].astype(np.int64)
        met = triangles >= 0
        u, v = (np.where(met, found[key], 0.0).astype(np.float64) for key in "uv")
        depths = np.where(met, found["tfar"].astype(np.float64), np.inf)
        weights = np.stack([1 - u - v, u, v], axis=-1)
        shape = directions.shape[:-1]
        return Hits(depths.reshape(shape), triangles.reshape(shape), weights.reshape((*shape, 3)))

    def free(self, origins: Points, directions: Points) -> NDArray[np.bool_]:
        """(...) whether nothing is on the rays from (..., 3) origins along (..., 3) directions."""
        starts, rays = (
            np.ascontiguousarray(own.reshape(-1, 3), dtype=np.float32)
            for own in (origins, directions)
        )
        found: NDArray[np.bool_] = self._scene.run(starts, rays, query="OCCLUDED") < 0
        return found.reshape(directions.shape[:-1])

    def seen(self, camera: Camera) -> Hits:
        """(H, W) where the ray through each pixel meets it; depths are along the axis."""
        return self.cast(camera.position, camera.directions())

    def visible(
        self,
        camera: Camera,
        points: Points,
        normals: Points,
        *,
        least_cosine: float,
        tolerance: float,
        border: float = 4.0,
    ) -> tuple[NDArray[np.bool_], Points]:
        """Which (N, 3) points of the surface, with (N, 3) normals, a camera sees.

        Args:
            camera: whose photograph must hold the point, `border` pixels from its edge.
            points: on the surface.
            normals: there.
            least_cosine: of the angle between the normal and the direction to the camera.
            tolerance: how far before the point something may stand, in the units of the points.
            border: in pixels.

        Returns:
            (N,) whether it is seen, and (N,) the cosines.
        """
        away = points - camera.position
        far = np.linalg.norm(away, axis=1)
        cosines = -np.einsum("ij,ij->i", away, normals) / far
        pixels, depths = camera.project(points)
        wanted = (cosines > least_cosine) & (depths > 0) & camera.inside(pixels, border)
        hits = self.cast(camera.position, away[wanted] / far[wanted, None])
        wanted[wanted] = hits.depths > far[wanted] - tolerance
        return wanted, cosines

    def closest(self, points: Points) -> Closest:
        """The closest points of the surface to (N, 3) points."""
        parts = max(1, len(points) * 40 // _AT_ONCE)
        found = [self._closest(part) for part in np.array_split(points, parts)]
        return Closest(*(np.concatenate(each) for each in zip(*found, strict=True)))

    def _closest(self, points: Points) -> tuple[Points, NDArray[np.int64], Points, Points]:
        best = self._vertex_tree.query(points, workers=2)[0] * (1 + 1e-9) + 1e-30
        pairs: list[tuple[NDArray[np.int64], NDArray[np.int64]]] = []
        for tree, triangles, radius in self._triangle_trees:
            near = tree.query_ball_point(points, best + radius, workers=2, return_sorted=False)
            counts = np.fromiter(map(len, near), dtype=np.int64, count=len(near))
            which = np.concatenate([np.zeros(0), *near]).astype(np.int64)
            pairs.append((np.repeat(np.arange(len(points)), counts), triangles[which]))
        asked, triangles = (np.concatenate(each) for each in zip(*pairs, strict=True))
        weights = np.concatenate(
            [
                closest_weights(points[asked[some]], self.vertices[self.triangles[triangles[some]]])
                for some in np.array_split(np.arange(len(asked)), len(asked) // _AT_ONCE + 1)
            ]
        )
        corners = self.vertices[self.triangles[triangles]]
        places = np.einsum("ni,nij->nj", weights, corners)
        distances = np.linalg.norm(places - points[asked], axis=1)
        order = np.lexsort((triangles, distances, asked))
        first = order[np.searchsorted(asked[order], np.arange(len(points)))]
        return places[first], triangles[first], weights[first], distances[first]

    @cached_property
    def _scene(self) -> Any:
        try:
            from embreex.mesh_construction import TriangleMesh
            from embreex.rtcore_scene import EmbreeScene
        except ImportError as error:
            raise MissingExtraError("embreex", "capture") from error

        scene = EmbreeScene()
        TriangleMesh(
            scene,
            np.ascontiguousarray(self.vertices, dtype=np.float32),
            np.ascontiguousarray(self.triangles, dtype=np.int32),
        )
        return scene

    @cached_property
    def _vertex_tree(self) -> Any:
        from scipy.spatial import cKDTree

        return cKDTree(self.vertices[np.unique(self.triangles)])

    @cached_property
    def _triangle_trees(self) -> list[tuple[Any, NDArray[np.int64], float]]:
        """Trees of the middles of triangles of like size, with their indices and largest radius."""
        from scipy.spatial import cKDTree

        corners = self.vertices[self.triangles]
        middles = (corners.max(axis=1) + corners.min(axis=1)) / 2
        radii = np.linalg.norm(corners - middles[:, None], axis=2).max(axis=1)
        sizes = np.ceil(np.log2(np.maximum(radii, 1e-3 * radii.max() + 1e-300)))
        trees = []
        for size in np.unique(sizes):
            mine = np.flatnonzero(sizes == size)
            trees.append((cKDTree(middles[mine]), mine, float(radii[mine].max())))
        return trees


def edges_of(triangles: Triangles) -> NDArray[np.int64]:
    """(E, 2) vertices at the ends of the edges of (T, 3) triangles, the smaller first."""
    return np.unique(np.sort(sides_of(triangles), axis=1), axis=0)
