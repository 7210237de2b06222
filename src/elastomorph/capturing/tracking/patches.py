"""Pieces of skin around each vertex, found again in photographs to a fraction of a pixel.

Samples lie all over the neutral's surface. Those near a vertex *along the surface*, so that the
lower lip is never near the upper one, are its patch. What the neutral's photographs show at the
samples is looked for in a photograph of the pose: each patch is shifted by the displacement that
fits best after brightness and contrast are fitted too (Lucas and Kanade, IJCAI 1981; Baker and
Matthews, IJCV 56(3), 2004).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

from elastomorph.capturing.geometry.camera import Camera
from elastomorph.capturing.geometry.sampling import sampled
from elastomorph.capturing.geometry.surface import Surface

Points = NDArray[np.float64]
Single = NDArray[np.float32]

# Rows of distances along the surface that are held at once.
_ROWS = 256
# How much longer than straight the way along the surface to a sample of the patch may be.
_DETOUR = 1.5
# Grey values: what a photograph's noise and rounding leave at least; a flat patch's contrast.
_NOISE = 1.0
# Samples of a blurred photograph tell less than as many independent ones.
_CORRELATED = 3.0
# Pixels that cameras are off by at least.
_FLOOR = 0.12


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


@dataclass(frozen=True, eq=False)
class Shifts:
    """Where patches were found in one photograph.

    Attributes:
        vertices: (N,) their middles.
        shifts: (N, 2) in pixels from where the surface has them.
        information: (N, 2, 2) inverse covariance, per pixel².
        likeness: (N,) correlation of neutral and pose after the shift.
    """

    vertices: NDArray[np.int64]
    shifts: Points
    information: Points
    likeness: Points


def shifted(
    patches: Patches,
    places: Points,
    camera: Camera,
    picture: Single,
    reference: tuple[NDArray[np.uint8], NDArray[np.bool_], NDArray[np.int64]],
    seen: NDArray[np.bool_],
    vertices: NDArray[np.int64],
    cosines: Points,
) -> Shifts:
    """Find patches in a photograph of the pose by one step of Gauss–Newton each.

    Args:
        patches: of the neutral.
        places: (S, 3) their samples on the surface of the pose so far.
        camera: of the photograph.
        picture: (H, W, 3) float32 its grey values and their changes along x and y.
        reference: (K, S) uint8 what the neutral's photographs show at the samples, (K, S) which
            samples they see, and (N,) which of the K is asked for each vertex.
        seen: (S,) which samples this photograph sees.
        vertices: (N,) whose patches are looked for.
        cosines: (N,) between their normals and the direction to the camera.
    """
    entries, owners = patches.entries(vertices)
    samples = patches.samples[entries]
    shown, known, chosen = reference
    chosen = chosen[owners]
    usable = seen[samples] & known[chosen, samples]
    entries, owners, samples, chosen = (x[usable] for x in (entries, owners, samples, chosen))
    values = np.zeros((len(places), 3), dtype=np.float32)
    values[seen] = sampled(picture, camera.project(places[seen])[0])
    values = values[samples]
    weight = patches.closeness[entries]
    here = shown[chosen, samples].astype(np.float32)
    sums = _Sums(owners, weight, len(vertices))
    return _solved(sums, here, values, patches.ramps[entries], vertices, cosines)


class _Sums:
    """Weighted sums over the entries of each vertex."""

    def __init__(self, owners: NDArray[np.int64], weights: Single, count: int) -> None:
        self._owners, self._weights, self._count = owners, weights, count
        self.total = np.bincount(owners, weights, count)
        self.effective = self.total**2 / np.maximum(np.bincount(owners, weights**2, count), 1e-9)

    def __call__(self, values: Single) -> Points:
        weights = (self._weights * values).astype(np.float64)
        return np.asarray(np.bincount(self._owners, weights, self._count), dtype=np.float64)

    def centred(self, values: Single) -> Single:
        """Values less the mean of their vertex."""
        mean = self(values) / np.maximum(self.total, 1e-9)
        less: Single = values - mean[self._owners].astype(np.float32)
        return less


def _solved(
    sums: _Sums,
    here: Single,
    values: Single,
    ramps: Single,
    vertices: NDArray[np.int64],
    cosines: Points,
) -> Shifts:
    """Shift, contrast and shading of each patch: I + ∇I · u = α R + β + γ · x."""
    there = sums.centred(values[:, 0])
    columns = [values[:, 1], values[:, 2], here, ramps[:, 0], ramps[:, 1]]
    columns = [sums.centred(column) for column in columns]
    count = len(columns)
    matrix = np.empty((len(vertices), count, count))
    right = np.empty((len(vertices), count))
    for i, one in enumerate(columns):
        for j in range(i, count):
            matrix[:, i, j] = matrix[:, j, i] = sums(one * columns[j])
        right[:, i] = sums(one * there)
    total = np.maximum(sums.total, 1e-9)
    floor = _NOISE**2 * total
    # Only what contrast and shading cannot explain tells of a shift.
    own = matrix[:, 2:, 2:] + (1e-4 * total)[:, None, None] * np.eye(count - 2)
    explained = np.linalg.solve(own, matrix[:, 2:, :2])
    tensor = matrix[:, :2, :2] - matrix[:, :2, 2:] @ explained
    goal = np.einsum("nij,ni->nj", explained, right[:, 2:]) - right[:, :2]
    damped = tensor + (1e-2 * floor)[:, None, None] * np.eye(2)
    shifts = np.linalg.solve(damped, goal[..., None])[..., 0]
    # What is left of both after the shading, and how alike it is.
    change = np.concatenate([shifts, np.zeros((len(vertices), count - 2))], axis=1)
    moved = right + np.einsum("nij,nj->ni", matrix, change)
    energy = sums(there * there) + np.einsum("ni,ni->n", change, right + moved)
    shade = np.linalg.solve(own[:, 1:, 1:], np.stack([moved[:, 3:], matrix[:, 3:, 2]], axis=2))
    energy -= np.einsum("ni,ni->n", shade[..., 0], moved[:, 3:])
    along = moved[:, 2] - np.einsum("ni,ni->n", shade[..., 0], matrix[:, 3:, 2])
    contrast = matrix[:, 2, 2] - np.einsum("ni,ni->n", shade[..., 1], matrix[:, 3:, 2])
    energy, contrast = np.maximum(energy, 0), np.maximum(contrast, 1e-9)
    likeness = along / np.sqrt((contrast + floor) * (energy + floor))
    left = np.maximum(energy - along**2 / contrast, 0) / total + _NOISE**2
    spread = (
        np.linalg.inv(damped)
        * (left * total * _CORRELATED / np.maximum(sums.effective * cosines, 1.0))[:, None, None]
    )
    information = np.linalg.inv(spread + _FLOOR**2 * np.eye(2))
    information[sums.effective < 12] = 0
    return Shifts(vertices, shifts, information, likeness)


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
