"""The neutral with its photographs, prepared once for all poses that are followed from it.

Pieces of skin around each vertex.

Samples lie all over the neutral's surface. Those near a vertex *along the surface*, so that the
lower lip is never near the upper one, are its patch.

Where skin touches other skin: lips that are closed, lids.

Upper and lower lip are two surfaces that meet where no photograph looks. No landmark and no name
tells them apart here, only the mesh: vertices that are close in space and far along the surface.
It is the same for a mouth that is a slit with an open border and for one that leads into a bag.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

from elastomorph.capturing.geometry.camera import Camera, View
from elastomorph.capturing.geometry.deformation import Deformation
from elastomorph.capturing.geometry.sampling import blurred, sampled
from elastomorph.capturing.geometry.surface import Surface
from elastomorph.model.geometry import largest_distance

Points = NDArray[np.float64]

# Times the distance in space that the way along the surface is longer.
_LIP_DETOUR = 4.0
# Vertices whose ways along the surface are held at once.
_ROWS = 256


def touching(surface: Surface, reach: float) -> NDArray[np.bool_]:
    """(V,) vertices within `reach` of a part of the surface that is far from them along it.

    What is matched there by its place alone may belong to either side.
    """
    from scipy.sparse.csgraph import dijkstra
    from scipy.spatial import cKDTree

    vertices = surface.vertices
    found = np.zeros(len(vertices), dtype=bool)
    pairs = cKDTree(vertices).query_pairs(reach, output_type="ndarray")
    facing = np.einsum("ij,ij->i", surface.normals[pairs[:, 0]], surface.normals[pairs[:, 1]])
    # Skin beside skin faces the same way; what touches turns towards each other.
    pairs = pairs[facing < 0.5]
    graph = surface.ways
    first, order = np.unique(pairs[:, 0], return_inverse=True)
    for rows in np.array_split(np.arange(len(first)), len(first) // _ROWS + 1):
        if not len(rows):
            continue
        near: Any = dijkstra(graph, directed=False, indices=first[rows], limit=_LIP_DETOUR * reach)
        mine = np.flatnonzero((order >= rows[0]) & (order <= rows[-1]))
        apart = np.isinf(near[order[mine] - rows[0], pairs[mine, 1]])
        found[pairs[mine[apart]].ravel()] = True
    return found


def folded(rest: Surface, vertices: Points, rotations: Points) -> NDArray[np.bool_]:
    """(V,) corners of triangles that were turned over beside their surroundings.

    Along the line where lips meet vertices then have changed their order.
    """
    now = Surface(vertices, rest.triangles).face_normals
    corners = rest.triangles
    expected = np.einsum("nij,nj->ni", rotations[corners].mean(axis=1), rest.face_normals)
    over = np.einsum("ij,ij->i", now, expected) < 0
    found = np.zeros(len(vertices), dtype=bool)
    found[corners[over].ravel()] = True
    return found


Single = NDArray[np.float32]

# Rows of distances along the surface that are held at once.
# How much longer than straight the way along the surface to a sample of the patch may be.
_DETOUR = 1.5


@dataclass(frozen=True, eq=False)
class Patches:
    """Samples of a surface and which of them belong to which vertex.

    Attributes:
        surface: the neutral.
        triangles: (S,) of each sample.
        weights: (S, 3) of the triangle's corners.
        first: (V + 1,) where the entries of each vertex begin.
        samples: (E,) sample of each entry.
        closeness: (E,) float32, how much it counts for the vertex by its distance.
        ramps: (E, 2) float32, where it lies beside the vertex, in radii.
    """

    surface: Surface
    triangles: NDArray[np.int64]
    weights: Points
    first: NDArray[np.int64]
    samples: NDArray[np.int64]
    closeness: Single
    ramps: Single

    @classmethod
    def of(
        cls, surface: Surface, wanted: NDArray[np.bool_], spacing: float, radius: float
    ) -> Patches:
        """Patches of a radius around the `wanted` vertices, of samples so far apart."""
        from scipy.spatial import cKDTree

        corners = surface.triangles
        near = np.flatnonzero(wanted[corners].any(axis=1))
        triangles, weights = _spread(surface, near, spacing)
        places = np.einsum("si,sij->sj", weights, surface.vertices[corners[triangles]])
        tree = cKDTree(places)
        vertices = np.flatnonzero(wanted)
        found: Any = tree.query_ball_point(surface.vertices[vertices], radius, workers=2)
        counts = np.array([len(each) for each in found], dtype=np.int64)
        samples = np.concatenate([np.zeros(0, dtype=np.int64), *found]).astype(np.int64)
        owners = np.repeat(vertices, counts)
        kept = _connected(surface, owners, triangles[samples], radius)
        samples, owners = samples[kept], owners[kept]
        off = (places[samples] - surface.vertices[owners]) / radius
        far = np.linalg.norm(off, axis=1)
        first = np.searchsorted(owners, np.arange(len(surface.vertices) + 1))
        closeness = np.exp(-2 * far**2).astype(np.float32)
        across, up = _tangents(surface.normals)
        ramps = np.stack(
            [np.einsum("ij,ij->i", off, way[owners]) for way in (across, up)], axis=1
        ).astype(np.float32)
        return cls(surface, triangles, weights, first, samples, closeness, ramps)

    def entries(self, vertices: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """The entries of some vertices, and for each the vertex's place among them."""
        counts = self.first[vertices + 1] - self.first[vertices]
        owners = np.repeat(np.arange(len(vertices)), counts)
        starts = np.cumsum(counts) - counts
        return np.arange(len(owners)) + (self.first[vertices] - starts)[owners], owners

    @cached_property
    def mixing(self) -> Any:
        """(V, V) sparse: how much the place of each vertex counts in the patch of each."""
        count = len(self.surface.vertices)
        owners = np.repeat(np.arange(count), np.diff(self.first))
        corners = self.surface.triangles[self.triangles[self.samples]]
        values = self.weights[self.samples] * self.closeness[:, None].astype(np.float64)
        mixed = sparse.coo_array(
            (values.ravel(), (np.repeat(owners, 3), corners.ravel())), shape=(count, count)
        ).tocsr()
        return sparse.diags_array(1 / np.maximum(mixed.sum(axis=1), 1e-30)) @ mixed

    def at(self, vertices: Points) -> Points:
        """(S, 3) places of the samples on the surface with (V, 3) vertices."""
        corners = vertices[self.surface.triangles[self.triangles]]
        found: Points = np.einsum("si,sij->sj", self.weights, corners)
        return found


def _spread(
    surface: Surface, near: NDArray[np.int64], spacing: float
) -> tuple[NDArray[np.int64], Points]:
    """Samples in some triangles, about one in each square of the spacing.

    Inside a triangle they follow the R₂ sequence (Roberts, 2018), folded where it leaves it.
    """
    areas = np.linalg.norm(surface.face_normals[near], axis=1) / 2
    counts = np.maximum(1, np.round(areas / spacing**2)).astype(np.int64)
    triangles = np.repeat(near, counts)
    number = np.arange(len(triangles)) - np.repeat(np.cumsum(counts) - counts, counts)
    u, v = (number + 0.5) * 0.7548776662466927 % 1, (number + 0.5) * 0.5698402909980532 % 1
    out = u + v > 1
    u, v = np.where(out, 1 - u, u), np.where(out, 1 - v, v)
    return triangles, np.stack([1 - u - v, u, v], axis=1)


def _tangents(normals: Points) -> tuple[Points, Points]:
    """(N, 3) and (N, 3) directions along a surface with (N, 3) normals."""
    least = np.eye(3)[np.abs(normals).argmin(axis=1)]
    across = np.cross(normals, least)
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-30)
    return across, np.cross(normals, across)


def _connected(
    surface: Surface, owners: NDArray[np.int64], triangles: NDArray[np.int64], radius: float
) -> NDArray[np.bool_]:
    """Which pairs of a vertex and a triangle are near along the surface and face one way."""
    from scipy.sparse.csgraph import dijkstra

    faces, graph = surface.triangles, surface.ways
    sides = surface.vertices[faces] - surface.vertices[np.roll(faces, 1, axis=1)]
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    normals = surface.face_normals[triangles]
    kept: NDArray[np.bool_] = np.einsum("ij,ij->i", normals, surface.normals[owners]) > 0
    asked = np.unique(owners)
    for rows in np.array_split(asked, len(asked) // _ROWS + 1):
        if not len(rows):
            continue
        begin, end = np.searchsorted(owners, [rows[0], rows[-1] + 1])
        mine = slice(begin, end)
        limit = _DETOUR * radius + longest[triangles[mine]]
        ways = dijkstra(graph, directed=False, indices=rows, limit=float(limit.max(initial=0)))
        row = np.searchsorted(rows, owners[mine])
        way = ways[row[:, None], faces[triangles[mine]]].min(axis=1)
        kept[mine] &= way <= limit
    return kept


# Of the angle between a normal and the direction to a camera, below which nothing is believed.
LEAST_COSINE = 0.2
# Pixels by which something may stand before a vertex that is still said to be seen.
_BEFORE = 1.5
# Pixels between samples of a patch, and its radius.
_SPACING, PATCH_RADIUS = 1.5, 9.0
# Of D: how near skin is that touches.
_TOUCHING = 0.006
# Photographs that would be made smaller by less than this are left as they are.
_ALMOST = 0.85
# Every so many pixels of a neutral photograph the depth of the surface is kept.
_DEPTH_STEP = 2


class Level:
    """The neutral with photographs of one size.

    Attributes:
        surface: of the neutral.
        views: its photographs at this size.
        pixel: length on the surface that a pixel shows.
    """

    def __init__(self, surface: Surface, views: Sequence[View], scale: float) -> None:
        self.surface = surface
        self.views = [view.scaled(scale) for view in views]
        self.scale = scale
        middle = surface.vertices.mean(axis=0)
        self.pixel = float(
            np.median([v.camera.project(middle)[1] / v.camera.focal for v in self.views])
        )

    def looked(self, posed: Surface, camera: Camera) -> tuple[NDArray[np.bool_], Points]:
        """Which vertices of the surface, neutral or posed, a camera sees, and their cosines."""
        return posed.visible(
            camera,
            posed.vertices,
            posed.normals,
            least_cosine=LEAST_COSINE,
            tolerance=_BEFORE * self.pixel,
        )

    @cached_property
    def seen(self) -> tuple[NDArray[np.bool_], Points]:
        """(K, V) which vertices each photograph of the neutral sees, and the cosines."""
        found = [self.looked(self.surface, view.camera) for view in self.views]
        visible = np.stack(
            [
                each & view.usable(view.camera.project(self.surface.vertices)[0])
                for (each, _), view in zip(found, self.views, strict=True)
            ]
        )
        return visible, np.stack([cosines for _, cosines in found])

    @cached_property
    def ways(self) -> Points:
        """(K, V, 3) directions from the neutral's vertices to each camera."""
        far = np.stack([v.camera.position for v in self.views])[:, None] - self.surface.vertices
        found: Points = far / np.linalg.norm(far, axis=2, keepdims=True)
        return found

    @cached_property
    def depths(self) -> list[Single]:
        """Of the surface in each photograph, every second pixel."""
        return [
            self.surface.cast(v.camera.position, v.camera.directions(_DEPTH_STEP)).depths.astype(
                np.float32
            )
            for v in self.views
        ]

    @cached_property
    def patches(self) -> Patches:
        """Around each vertex that any photograph sees."""
        return Patches.of(
            self.surface,
            np.any(self.seen[0], axis=0),
            _SPACING * self.pixel,
            PATCH_RADIUS * self.pixel,
        )

    @cached_property
    def shown(self) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
        """(K, S) what each photograph shows at the samples, and which it sees."""
        places = self.patches.at(self.surface.vertices)
        corners = self.surface.triangles[self.patches.triangles]
        values = [
            sampled(blurred(view.grey), view.camera.project(places)[0]) for view in self.views
        ]
        known = np.stack([each[corners].all(axis=1) for each in self.seen[0]])
        return np.stack(values), known


class Reference:
    """The neutral: surface, photographs, and its deformations.

    Attributes:
        surface: its vertices and triangles.
        views: its photographs.
    """

    def __init__(
        self, vertices: Points, triangles: NDArray[np.integer], views: Sequence[View]
    ) -> None:
        self.surface = Surface(vertices, triangles)
        # A sequence that reads photographs when asked is gone through once.
        self.views = list(views)
        self._levels: dict[float, Level] = {}

    @cached_property
    def extent(self) -> float:
        """D: the largest distance between two of its vertices."""
        return largest_distance(self.surface.vertices)

    def scales(self, heads: Sequence[float]) -> list[float]:
        """Sizes of the photographs at which D is about so many pixels long, 1 at most."""
        middle = self.surface.vertices.mean(axis=0)
        lengths = [
            v.camera.focal * self.extent / max(float(v.camera.project(middle)[1]), 1e-9)
            for v in self.views
        ]
        wanted = [head / float(np.median(lengths)) for head in heads]
        return [1.0 if scale > _ALMOST else scale for scale in wanted]

    @cached_property
    def touching(self) -> NDArray[np.bool_]:
        """(V,) where the surface touches itself: lips that are closed, lids."""
        return touching(self.surface, _TOUCHING * self.extent)

    @cached_property
    def deformation(self) -> Deformation:
        """Of the surface at rest."""
        return Deformation(self.surface.vertices, self.surface.triangles)

    def level(self, scale: float) -> Level:
        """The photographs at a size; kept for the next pose."""
        if scale not in self._levels:
            self._levels[scale] = Level(self.surface, self.views, scale)
        return self._levels[scale]
