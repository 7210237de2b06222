"""The other poses, followed by the neutral's photographs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

from elastomorph.capturing.geometry import (
    Camera,
    Deformation,
    Surface,
    Table,
    View,
    blurred,
    correlation,
    flow_engine,
    pixel_grid,
    prepared,
    sampled,
)
from elastomorph.errors import CaptureError
from elastomorph.model.geometry import largest_distance

# Points of two poses that show the same skin.

Points = NDArray[np.float64]

# Neighbours that a match is compared with, and how far off their middle it may be in units of
# their own spread and in parts of the cloud's extent.
_NEIGHBOURS, _OUTLIER, _SLACK = 10, 5.0, 0.006


@dataclass(frozen=True, eq=False)
class Matches(Table):
    """Points of the neutral's skin and where the same skin is in a pose.

    Attributes:
        neutral: (N, 3) in the frame of the neutral.
        pose: (N, 3) in the same frame.
    """

    neutral: Points
    pose: Points


def consistent(matches: Matches, expected: Points, extent: float) -> NDArray[np.bool_]:
    """Which matches move as those around them do, beside what is expected of each.

    Args:
        matches: of which some are wrong.
        expected: (N, 3) where the pose is thought to have the points.
        extent: of the face, in the units of the points.
    """
    from scipy.spatial import cKDTree

    off = matches.pose - expected
    kept = np.ones(len(off), dtype=bool)
    for _ in range(3):
        if np.count_nonzero(kept) <= _NEIGHBOURS:
            return kept
        tree = cKDTree(matches.neutral[kept])
        _, near = tree.query(matches.neutral, k=_NEIGHBOURS + 1)
        around = off[kept][near]
        middle = np.median(around, axis=1)
        spread = np.median(np.linalg.norm(around - middle[:, None], axis=2), axis=1)
        far = np.linalg.norm(off - middle, axis=1)
        kept = far < _OUTLIER * spread + _SLACK * extent
    return kept


# Where photographs of a pose show vertices, and what that says of their places.


@dataclass(frozen=True, eq=False)
class Observations(Table):
    """Where photographs of a pose show vertices.

    Attributes:
        views: (N,) which photograph.
        vertices: (N,) which vertex.
        pixels: (N, 2) where it is there.
        information: (N, 2, 2) inverse covariance, per pixel².
        likeness: (N,) correlation of what the neutral and the pose show around it.
    """

    views: NDArray[np.int64]
    vertices: NDArray[np.int64]
    pixels: Points
    information: Points
    likeness: Points

    @classmethod
    def none(cls) -> Observations:
        """Nothing seen."""
        no = np.zeros(0, dtype=np.int64)
        return cls(no, no, np.zeros((0, 2)), np.zeros((0, 2, 2)), np.zeros(0))


def photographs(seen: Observations, count: int) -> NDArray[np.int64]:
    """(V,) in how many photographs each of `count` vertices was seen."""
    width = 1 + int(seen.views.max(initial=0))
    pairs = np.unique(seen.vertices * width + seen.views)
    return np.bincount(pairs // width, minlength=count)


def supported(seen: Observations, count: int, fewest: int | NDArray[np.float64]) -> Observations:
    """Those of vertices that so many photographs, (V,) or one number, show."""
    return seen.chosen((photographs(seen, count) >= fewest)[seen.vertices])


def residuals(cameras: Sequence[Camera], vertices: Points, seen: Observations) -> Points:
    """(N, 2) pixels from where the vertices are to where they were seen."""
    off = np.zeros((len(seen.views), 2))
    for number, camera in enumerate(cameras):
        mine = seen.views == number
        off[mine] = seen.pixels[mine] - camera.project(vertices[seen.vertices[mine]])[0]
    return off


def disagreement(off: Points, information: Points) -> Points:
    """(N,) squares of residuals (N, 2) in units of their spread."""
    found: Points = np.einsum("ni,nij,nj->n", off, information, off)
    return found


def normal_equations(
    cameras: Sequence[Camera],
    vertices: Points,
    seen: Observations,
    *,
    unit: float,
    robust: float,
    mixing: Any = None,
) -> tuple[Points, Points]:
    """(V, 3, 3) A and (V, 3) b of one step of Gauss–Newton on what was seen.

    Args:
        cameras: of the photographs.
        vertices: (V, 3) so far.
        seen: what the photographs show.
        unit: length that makes A a number: what a pixel shows.
        robust: residual, in units of its spread, from which on it counts less (Geman–McClure).
        mixing: (V, V) sparse, rows that add up to 1; what was seen is not a vertex but this
            mixture of them. A then bounds the true one, (Σ m x)ᵀ A (Σ m x) ≤ Σ m xᵀ A x, which
            shortens the step where vertices differ from their mixture and leads to the same end.
    """
    quadratic, pulls = np.zeros((len(vertices), 3, 3)), np.zeros((len(vertices), 3))
    off = residuals(cameras, vertices, seen)
    weights = unit**2 / (1 + disagreement(off, seen.information) / robust**2) ** 2
    for number, camera in enumerate(cameras):
        mine = seen.views == number
        which = seen.vertices[mine]
        change = camera.jacobian(vertices[which])
        information = seen.information[mine] * weights[mine][:, None, None]
        pull = np.einsum("nji,njk->nik", change, information)
        np.add.at(quadratic, which, pull @ change)
        np.add.at(pulls, which, np.einsum("nij,nj->ni", pull, off[mine]))
    if mixing is not None:
        pulls = mixing.T @ pulls
        quadratic = (mixing.T @ quadratic.reshape(-1, 9)).reshape(-1, 3, 3)
    return quadratic, pulls + np.einsum("nij,nj->ni", quadratic, vertices)


# How far off a vertex of a followed pose is expected to be, and the confidence that follows.
#
# Four things are expected to be wrong:
#
# - what photographs leave open: the covariance of the last step of Gauss–Newton from the noise that
#   was left in each patch, larger where photographs contradict each other more than that explains;
# - what they contradict each other by: where patches hold on to something else that looks alike,
#   each photograph has the vertex elsewhere, and more of them do not make their mean any better;
# - what a patch cannot follow: where the skin is stretched or compressed much, as around lips that
#   part, a patch is a bad picture of itself, by a part of its radius for each strain; and where
#   skin touches skin, as closed lips in the neutral, it reaches to one side only;
# - what no photographs show: a vertex that fewer than two found is filled in, and its error grows
#   along the surface with the way to vertices that were found, by as much as the surface is
#   anything but rigid on that way: the back of a head goes where its front goes, a cheek does not.
#
# With the expected error e, the confidence is 1 / (1 + (e / 0.005 D)²): 0.5 where 0.5 % of D is
# expected.

# Of D: the error at which half of the confidence is gone.
_HALF = 0.005
# Error that filling in adds for each length of the way from the nearest vertex that was found: of a
# surface of which nothing else is known, and for each part by which edges there are not rigid.
_FILLED, _BENT = 0.3, 0.5
# Error for each length by which photographs contradict each other.
_CONTRADICTED = 6.0
# Strain that patches follow without harm, and the part of their radius that each more costs.
_STRAIN, _STRETCHED = 0.15, 2.0
# Part of the radius of a patch that it costs to lie where skin touches skin.
_BESIDE = 0.5


def spreads(cameras: Sequence[Camera], vertices: Points, seen: Observations) -> Points:
    """(V,) standard deviation, a length; infinite where fewer than two photographs show it."""
    count = len(vertices)
    information = np.zeros((count, 3, 3))
    for number, camera in enumerate(cameras):
        mine = seen.views == number
        change = camera.jacobian(vertices[seen.vertices[mine]])
        own = np.einsum("nji,njk,nkl->nil", change, seen.information[mine], change)
        np.add.at(information, seen.vertices[mine], own)
    views = photographs(seen, count)
    off = disagreement(residuals(cameras, vertices, seen), seen.information)
    excess = np.bincount(seen.vertices, off, count) / np.maximum(2 * views - 3, 1)
    found = np.full(count, np.inf)
    known = views >= 2
    values = np.maximum(np.linalg.eigvalsh(information[known]), 1e-300)
    found[known] = np.sqrt((1 / values).sum(axis=1) * np.maximum(excess[known], 1))
    return found


def contradictions(
    cameras: Sequence[Camera], vertices: Points, seen: Observations, pixel: float
) -> Points:
    """(V,) lengths: what is expected where photographs contradict each other; 0 where none show.

    Args:
        cameras: of the photographs.
        vertices: (V, 3).
        seen: what the photographs show.
        pixel: length on the surface that a pixel shows.
    """
    count = len(vertices)
    squares = (residuals(cameras, vertices, seen) ** 2).sum(axis=1)
    total = np.bincount(seen.vertices, squares, count)
    times = np.maximum(np.bincount(seen.vertices, minlength=count), 1)
    found: Points = _CONTRADICTED * pixel * np.sqrt(total / times)
    return found


def stretched(deformation: Deformation, vertices: Points, radius: float) -> Points:
    """(V,) lengths: what strain of the surface adds to the error of patches of a radius.

    The strain of a vertex is the mean of |ln(length / length at rest)| over the edges around it.
    """
    first, second = deformation.edges.T
    rest = np.linalg.norm(deformation.rest[first] - deformation.rest[second], axis=1)
    now = np.linalg.norm(vertices[first] - vertices[second], axis=1)
    tiny = np.finfo(float).tiny
    strain = np.abs(np.log(np.maximum(now, tiny) / np.maximum(rest, tiny)))
    around = _around(deformation, strain)
    found: Points = _STRETCHED * radius * np.maximum(around - _STRAIN, 0)
    return found


def beside(deformation: Deformation, touching: NDArray[np.bool_], radius: float) -> Points:
    """(V,) lengths: what closed lips and lids add to the error of patches of a radius.

    A patch beside the line where skin meets skin reaches to one side only.
    """
    part = deformation.smoothed(touching.astype(np.float64), 2)
    found: Points = _BESIDE * radius * np.clip(2 * part, 0, 1)
    return found


def filled(deformation: Deformation, vertices: Points) -> Points:
    """(V,) errors for each length of the way over a vertex that filling in adds.

    By the part of their length that the edges around it are off where rotations of the surface at
    rest have them, as in the energy of surfaces that are as rigid as possible.
    """
    first, second = deformation.edges.T
    turned = deformation.rotations(vertices)
    before = deformation.rest[first] - deformation.rest[second]
    expected = np.einsum("eij,ej->ei", (turned[first] + turned[second]) / 2, before)
    off = np.linalg.norm(vertices[first] - vertices[second] - expected, axis=1)
    parts = off / np.maximum(np.linalg.norm(before, axis=1), np.finfo(float).tiny)
    return _BENT * _around(deformation, parts)


def expected_errors(
    neutral: Surface, spread: Points, extent: float, rates: Points | None = None
) -> Points:
    """(V,) lengths: the spread, or what filling in from better vertices leaves if that is less.

    Args:
        neutral: the surface along which is filled in.
        spread: (V,) lengths, infinite where too few photographs show a vertex.
        extent: D.
        rates: (V,) as `filled` gives them; without, those of a surface of which nothing is known.
    """
    from scipy.sparse.csgraph import dijkstra

    count = len(neutral.vertices)
    edges = neutral.ways.tocoo()
    # A vertex more, joined to each that was found by a way as long as its own error.
    known = np.flatnonzero(np.isfinite(spread))
    rows = np.concatenate([edges.row, np.full(len(known), count)])
    columns = np.concatenate([edges.col, known])
    rates = np.full(count, _FILLED) if rates is None else rates
    ways = (rates[edges.row] + rates[edges.col]) / 2 * edges.data
    costs = np.concatenate([ways, spread[known]])
    graph = sparse.coo_array(
        (np.maximum(costs, 1e-12 * extent), (rows, columns)), shape=(count + 1, count + 1)
    ).tocsr()
    found: Points = dijkstra(graph, directed=False, indices=[count])[0, :count]
    return found


def confidences(errors: Points, extent: float) -> Points:
    """(V,) in [0, 1] from expected errors; 0.5 at 0.5 % of D, the extent."""
    ratio = np.minimum(errors / (_HALF * extent), 1e6)
    found: Points = 1 / (1 + ratio**2)
    return found


def _around(deformation: Deformation, values: Points) -> Points:
    """(V,) means of (E,) values of the edges around each vertex, smoothed."""
    both, count = deformation.edges.T.ravel(), len(deformation.rest)
    total = np.bincount(both, np.concatenate([values, values]), count)
    mean = total / np.maximum(np.bincount(both, minlength=count), 1)
    return deformation.smoothed(deformation.smoothed(mean))


# Where skin touches other skin: lips that are closed, lids.
#
# Upper and lower lip are two surfaces that meet where no photograph looks. No landmark and no
# name tells them apart here, only the mesh: vertices that are close in space and far along the
# surface. It is the same for a mouth that is a slit with an open border and for one that leads
# into a bag.


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

# Pieces of skin around each vertex.
#
# Samples lie all over the neutral's surface. Those near a vertex *along the surface*, so that the
# lower lip is never near the upper one, are its patch.

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


# The neutral with its photographs, prepared once for all poses that are followed from it.

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


Picture = NDArray[np.uint8]

# The neutral's photographs, carried by the surface into those of a pose, and what they miss by.
#
# Each pixel of a pose's photograph looks at a point of the surface as it is assumed to be; that
# point was photographed in the neutral. The picture this makes would be the photograph itself if
# the surface were right: the optical flow between them says how far each vertex is off.

# Photographs of the neutral that each of the pose is compared with.
_SOURCES = 2
# Correlation below which nothing is believed, and pixels by which the way back may miss.
_ALIKE, _BACK = 0.5, 0.7
# Photographs that have to show a vertex to be believed, and part of those that look at it.
_FEWEST, _SUPPORT = 3, 0.4
# Pixels around the head that are kept of a photograph.
_MARGIN = 24
# Side of the square around a pixel, and the part of it that has to be known.
_BOX, _AROUND = 9, 0.85


def by_flow(level: Level, views: Sequence[View], vertices: Points) -> Observations:
    """What optical flow from some photographs of the neutral into each of the pose shows.

    Args:
        level: the neutral and its photographs.
        views: photographs of the pose, of the same size.
        vertices: (V, 3) of the pose as assumed so far.
    """
    neutral = level.surface.vertices
    posed = Surface(vertices, level.surface.triangles)
    cameras = [view.camera for view in level.views]
    found = []
    offered = np.zeros(len(vertices))
    for number, view in enumerate(views):
        seen, cosines = level.looked(posed, view.camera)
        seen &= view.usable(view.camera.project(vertices)[0])
        offered += seen & level.seen[0].any(axis=0)
        near = _nearest(cameras, neutral.mean(axis=0), view.camera, vertices.mean(axis=0))
        taken = [(level.views[i], level.depths[i], level.seen[0][i]) for i in near[:_SOURCES]]
        found += _missed(number, view, posed, neutral, taken, (seen, cosines))
    fewest = np.maximum(_FEWEST, _SUPPORT * offered)
    return supported(Observations.join([Observations.none(), *found]), len(vertices), fewest)


def _warped(
    places: Points, met: NDArray[np.bool_], target: Picture, view: View, depth: Single
) -> tuple[Picture, NDArray[np.bool_]]:
    """A photograph of the neutral as the pose's camera would have taken it, and where it shows it.

    Where the neutral shows nothing the pose's own photograph stands in: nothing moves there.

    Args:
        places: (H, W, 3) where on the neutral lies what each pixel of the pose's photograph sees.
        met: (H, W) where it sees the surface.
        target: (H, W) uint8 the pose's photograph.
        view: of the neutral.
        depth: of the neutral in that view, infinite beside it; may be of fewer pixels.
    """
    import cv2

    pixels, depths = view.camera.project(places)
    where = np.where(met[..., None], pixels, -9.0).astype(np.float32)
    picture: Any = cv2.remap(view.grey, where[..., 0], where[..., 1], cv2.INTER_LINEAR)
    step = view.camera.size[0] / depth.shape[1]
    coarse = ((where + 0.5) / np.float32(step) - 0.5).astype(np.float32)
    front: Any = cv2.remap(depth, coarse[..., 0], coarse[..., 1], cv2.INTER_NEAREST, borderValue=-1)
    known = met & view.camera.inside(pixels, 1) & (depths < front * 1.004)
    return np.where(known, picture, target), known


def _around_known(known: NDArray[np.bool_]) -> Single:
    """(H, W) which part of the surroundings of each pixel is known."""
    import cv2

    found: Any = cv2.boxFilter(known.astype(np.float32), -1, (_BOX, _BOX))
    return np.asarray(found)


def _flow_between(engine: Any, one: Picture, other: Picture) -> tuple[Single, Single, Single]:
    """(H, W, 2) flow, (H, W) pixels by which the way back misses, and (H, W) correlation."""
    import cv2

    there: Any = engine.calc(one, other, None)
    back: Any = engine.calc(other, one, None)
    columns, rows = pixel_grid(*one.shape[::-1])
    x, y = columns + there[..., 0], rows + there[..., 1]
    round_trip = np.linalg.norm(there + cv2.remap(back, x, y, cv2.INTER_LINEAR), axis=-1)
    found: Any = cv2.remap(other, x, y, cv2.INTER_LINEAR)
    return there, np.asarray(round_trip, dtype=np.float32), correlation(one, found)


def _cropped(camera: Camera, points: Points) -> tuple[slice, slice]:
    """The rows and columns of a photograph that hold the points, and a margin."""
    pixels, depths = camera.project(points)
    pixels = pixels[depths > 0]
    if not len(pixels):
        return slice(0, 0), slice(0, 0)
    low = np.maximum(np.floor(pixels.min(axis=0)).astype(int) - _MARGIN, 0)
    high = np.minimum(np.ceil(pixels.max(axis=0)).astype(int) + _MARGIN, camera.size)
    return slice(int(low[1]), int(max(high[1], low[1]))), slice(
        int(low[0]), int(max(high[0], low[0]))
    )


def _nearest(neutral: list[Camera], middle: Points, camera: Camera, around: Points) -> list[int]:
    """Cameras of the neutral by how alike they look at it as another camera looks at the pose."""
    wanted = camera.position - around
    ways = np.array([each.position - middle for each in neutral])
    cosines = ways @ wanted / np.linalg.norm(ways, axis=1) / np.linalg.norm(wanted)
    return [int(i) for i in np.argsort(-cosines, kind="stable")]


def _missed(
    number: int,
    view: View,
    posed: Surface,
    neutral: Points,
    sources: list[tuple[View, Single, NDArray[np.bool_]]],
    seen: tuple[NDArray[np.bool_], Points],
) -> list[Observations]:
    """Where one photograph of a pose shows the vertices, by each of some neutral photographs.

    Args:
        number: of the photograph.
        view: of the pose.
        posed: the surface as assumed so far.
        neutral: (V, 3) the neutral's vertices.
        sources: neutral views, their depths and (V,) which vertices they see.
        seen: (V,) which vertices the photograph sees, and their cosines.
    """
    rows, columns = _cropped(view.camera, posed.vertices)
    target = np.ascontiguousarray(view.grey[rows, columns])
    if min(target.shape) < 32:
        return []
    x, y = np.meshgrid(np.arange(columns.start, columns.stop), np.arange(rows.start, rows.stop))
    hits = posed.cast(view.camera.position, view.camera.through(np.stack([x, y], axis=-1)))
    places = posed.at(hits, neutral)
    found = []
    engine = flow_engine()
    pixels = view.camera.project(posed.vertices)[0]
    corner = np.array([columns.start, rows.start])
    for source, depth, known in sources:
        picture, shown = _warped(places, hits.met, target, source, depth)
        there, back, alike = _flow_between(engine, picture, target)
        both = np.flatnonzero(seen[0] & known)
        at = (pixels[both] - corner).astype(np.float32)
        maps = np.dstack([there, back, alike, _around_known(shown)])
        values = sampled(maps, at)
        good = (values[:, 3] > _ALIKE) & (values[:, 2] < _BACK) & (values[:, 4] > _AROUND)
        both, values = both[good], values[good]
        weight = values[:, 3] * seen[1][both]
        found.append(
            Observations(
                np.full(len(both), number),
                both,
                pixels[both] + values[:, :2],
                weight[:, None, None] * np.eye(2),
                values[:, 3].astype(np.float64),
            )
        )
    return found


# Patches of skin found again in a photograph, to a fraction of a pixel.
#
# What the neutral's photographs show at the samples of a patch is looked for in a photograph of
# the pose: each patch is shifted by the displacement that fits best after brightness and contrast
# are fitted too (Lucas and Kanade, IJCAI 1981; Baker and Matthews, IJCV 56(3), 2004).

# Grey values: what a photograph's noise and rounding leave at least; a flat patch's contrast.
_NOISE = 1.0
# Samples of a blurred photograph tell less than as many independent ones.
_CORRELATED = 3.0
# Pixels that cameras are off by at least.
_FLOOR = 0.12


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


# Matches as anchors of a surface: where points of it are in a pose.

# Reach of matches, in D, and how much the surface resists bending, in the turns of the beginning.
_BEGINNING = ((0.1, 0.5), (0.03, 0.5), (0.015, 0.2), (0.01, 0.2), (0.01, 0.2))
# Of D: how far from the surface of the neutral a point of its skin may be.
_OFF_SURFACE = 0.01
# Fewest matches with which a pose can be followed.
_FEWEST_MATCHES = 12


@dataclass(frozen=True, eq=False)
class Anchors:
    """Points of the surface whose places matches tell.

    Attributes:
        corners: (N, 3) vertices of the triangle that each lies in.
        weights: (N, 3) of those.
        goals: (N, 3) where they are in the pose.
    """

    corners: NDArray[np.int64]
    weights: Points
    goals: Points

    @classmethod
    def of(cls, reference: Reference, start: Points, matches: Matches | None) -> Anchors:
        """Those of the matches that lie on the neutral and agree with their neighbours.

        Raises:
            CaptureError: there are matches, but too few of them are left.
        """
        if matches is None:
            return cls(np.zeros((0, 3), dtype=np.int64), np.zeros((0, 3)), np.zeros((0, 3)))
        surface, extent = reference.surface, reference.extent
        closest = surface.closest(matches.neutral)
        corners = surface.triangles[closest.triangles]
        expected = np.einsum("ni,nij->nj", closest.weights, start[corners])
        lift = matches.neutral - closest.points
        good = closest.distances < _OFF_SURFACE * extent
        good[good] = consistent(matches.chosen(good), (expected + lift)[good], extent)
        if np.count_nonzero(good) < _FEWEST_MATCHES:
            raise CaptureError(
                f"{np.count_nonzero(good)} points of the skin were found both in the neutral and "
                f"in the pose, expected at least {_FEWEST_MATCHES}: are both of one person, "
                "sharp, and lit alike?"
            )
        return cls(corners[good], closest.weights[good], (matches.pose - lift)[good])

    def equations(self, vertices: Points, weight: float, robust: float) -> tuple[Points, Points]:
        """(V, 3, 3) A and (V, 3) b that pull the vertices; beyond `robust`, a length, less."""
        quadratic, linear = np.zeros((len(vertices), 3, 3)), np.zeros_like(vertices)
        off = self.goals - np.einsum("ni,nij->nj", self.weights, vertices[self.corners])
        pull = weight / (1 + (off**2).sum(axis=1) / robust**2) ** 2
        shares = self.weights * pull[:, None]
        for corner, share in zip(self.corners.T, shares.T, strict=True):
            np.add.at(quadratic, corner, share[:, None, None] * np.eye(3))
            np.add.at(linear, corner, share[:, None] * (vertices[corner] + off))
        return quadratic, linear


def begun(reference: Reference, start: Points, anchors: Anchors) -> Points:
    """(V, 3) the surface as matches alone have it, begun at another pose."""
    deformation = reference.deformation.around(start)
    vertices = start
    for robust, bending in _BEGINNING if len(anchors.corners) else ():
        quadratic, linear = anchors.equations(vertices, 1.0, robust * reference.extent)
        vertices = deformation.solve(vertices, quadratic, linear, arap=0.02, bending=bending)
    return vertices


Say = Callable[[str, float], None]

# The other poses, followed by what the neutral's own photographs show.
#
# Matches of single points begin. Then the photographs of the neutral are carried by both surfaces
# into those of the pose and what they miss by is measured, first everywhere at once by optical
# flow in small photographs, then patch by patch in larger ones; a step of Gauss–Newton on all
# photographs with a deformation that is as rigid as possible follows each turn. What is compared
# is always the neutral, so that nothing drifts along a chain of poses.

# Pixels that D is long at in each turn of flow, and residual from which on it counts less.
_FLOWS, _FLOW_ROBUST = (330.0, 330.0, 330.0, 650.0), 4.0
# Of patches also the correlation that is asked for.
_PATCHES = (
    (650.0, 0.5, 6.0),
    (650.0, 0.5, 5.0),
    (1300.0, 0.5, 5.0),
    (1300.0, 0.5, 4.0),
    (1300.0, 0.5, 4.0),
)
# Stiffness beside observations of one pixel² (flow) and of their own spread (patches).
_FLOW_STIFFNESS = (0.02, 0.2)
_PATCH_STIFFNESS = (0.1, 0.5)
# Photographs that have to show a patch to be believed.
_PATCH_SUPPORT = 2
# Weight of a match beside observations, and its reach in pixels.
_ANCHORED, _ANCHOR_REACH = 1.0, 2.0
# Fewest photographs with which a pose can be followed, and part of the skin that has to be found.
_FEWEST_VIEWS, _LEAST_FOUND = 3, 0.1


@dataclass(frozen=True, eq=False)
class TrackedPose:
    """A pose in the topology of the neutral.

    Attributes:
        vertices: (V, 3) in the frame of the neutral.
        views: (V,) photographs in which each was found; 0 where it was only filled in.
        spread: (V,) length, standard deviation that the photographs leave; infinite where fewer
            than two show it.
        confidence: (V,) in [0, 1].
    """

    vertices: Points
    views: NDArray[np.int64]
    spread: Points
    confidence: Points


def follow(
    reference: Reference,
    views: Sequence[View],
    *,
    start: Points | None = None,
    matches: Matches | None = None,
    say: Say = lambda text, part: None,
) -> TrackedPose:
    """Find the vertices of the neutral in photographs of a pose.

    Args:
        reference: the neutral and its photographs.
        views: photographs of the pose, with cameras in the frame of the neutral.
        start: (V, 3) of a pose like it, followed before; unless given the neutral.
        matches: points of the skin in both.
        say: told what is done and which part of it, in [0, 1], lies behind.

    Raises:
        CaptureError: too few photographs or matches, or the heads do not match.
    """
    if len(views) < _FEWEST_VIEWS:
        raise CaptureError(
            f"a pose is followed in at least {_FEWEST_VIEWS} photographs, found {len(views)}"
        )
    vertices = reference.surface.vertices if start is None else start
    anchors = Anchors.of(reference, vertices, matches)
    sizes = _sizes(reference, views)
    turns = _Turns(reference, sizes, anchors, lambda turn: say(*_told(turn)))
    vertices = turns.patched(turns.flowed(begun(reference, vertices, anchors)))
    level, small = sizes[_PATCHES[-1][0]]
    seen = turns.seen
    cameras, deformation = [view.camera for view in small], reference.deformation
    radius = PATCH_RADIUS * level.pixel
    parts = (
        spreads(cameras, vertices, seen),
        contradictions(cameras, vertices, seen, level.pixel),
        stretched(deformation, vertices, radius),
        beside(deformation, reference.touching, radius),
    )
    spread = np.sqrt(sum(part**2 for part in parts))
    rates = filled(deformation, vertices)
    errors = expected_errors(reference.surface, spread, reference.extent, rates)
    return TrackedPose(
        vertices,
        photographs(seen, len(vertices)),
        spread,
        confidences(errors, reference.extent),
    )


def _told(turn: int) -> tuple[str, float]:
    """What is done in a turn, and which part of all lies behind it."""
    return (
        "optical flow" if turn < len(_FLOWS) else "patches",
        turn / (len(_FLOWS) + len(_PATCHES)),
    )


@dataclass(eq=False)
class _Turns:
    """The turns of looking and solving for one pose; `seen` is what the last one saw."""

    reference: Reference
    sizes: dict[float, tuple[Level, list[View]]]
    anchors: Anchors
    say: Callable[[int], None]
    seen: Observations = field(default_factory=Observations.none)

    def flowed(self, vertices: Points) -> Points:
        """(V, 3) where optical flow in small photographs has the vertices.

        Raises:
            CaptureError: the photographs hardly show the skin of the neutral.
        """
        deformation = self.reference.deformation.around(vertices)
        for turn, head in enumerate(_FLOWS):
            self.say(turn)
            level, small = self.sizes[head]
            self.seen = by_flow(level, small, vertices)
            vertices = self._settled(
                deformation, head, vertices, _FLOW_ROBUST, stiffness=_FLOW_STIFFNESS, steps=2
            )
        known = int(np.count_nonzero(level.seen[0].any(axis=0)))
        part = len(np.unique(self.seen.vertices)) / max(1, known)
        if part < _LEAST_FOUND:
            raise CaptureError(
                f"only {part:.0%} of the skin that photographs of the neutral show was found in "
                "those of the pose: are both of one person and head, and the cameras of both in "
                "one frame?"
            )
        return vertices

    def patched(self, vertices: Points) -> Points:
        """(V, 3) where patches in larger photographs have the vertices."""
        surface = self.reference.surface
        # What only the flow reaches stays where that has it.
        before, deformation = vertices, self.reference.deformation.around(vertices)
        for turn, (head, least, robust) in enumerate(_PATCHES, start=len(_FLOWS)):
            self.say(turn)
            level, small = self.sizes[head]
            turned = self.reference.deformation.rotations(vertices)
            self.seen = _by_patches(level, small, vertices, turned, least)
            vertices = self._patches(deformation, head, vertices, robust)
        turned = self.reference.deformation.rotations(vertices)
        over = folded(surface, vertices, turned)
        if over.any():
            # Order is kept: what was seen of vertices that passed each other is not believed.
            self.seen = self.seen.chosen(~over[self.seen.vertices])
            vertices = np.where(over[:, None], before, vertices)
            vertices = self._patches(deformation, head, vertices, robust)
        return vertices

    def _patches(
        self, deformation: Deformation, head: float, vertices: Points, robust: float
    ) -> Points:
        mixing = self.sizes[head][0].patches.mixing
        return self._settled(
            deformation, head, vertices, robust, stiffness=_PATCH_STIFFNESS, steps=1, mixing=mixing
        )

    def _settled(
        self,
        deformation: Deformation,
        head: float,
        vertices: Points,
        robust: float,
        *,
        stiffness: tuple[float, float],
        steps: int,
        mixing: Any = None,
    ) -> Points:
        """(V, 3) where the vertices are after some steps towards what was seen."""
        level, small = self.sizes[head]
        cameras = [view.camera for view in small]
        for _ in range(steps):
            quadratic, linear = normal_equations(
                cameras, vertices, self.seen, unit=level.pixel, robust=robust, mixing=mixing
            )
            held, pull = self.anchors.equations(vertices, _ANCHORED, _ANCHOR_REACH * level.pixel)
            vertices = deformation.solve(
                vertices,
                quadratic + held,
                linear + pull,
                arap=stiffness[0],
                bending=stiffness[1],
                rounds=2,
            )
        return vertices


def _sizes(reference: Reference, views: Sequence[View]) -> dict[float, tuple[Level, list[View]]]:
    """For each length of D: the neutral, and the photographs of the pose, at that size."""
    heads = sorted({*_FLOWS, *(head for head, *_ in _PATCHES)})
    scales = reference.scales(heads)
    small: list[list[View]] = [[] for _ in heads]
    for view in views:
        for scale, kept in zip(scales, small, strict=True):
            kept.append(view.scaled(scale))
    return {
        head: (reference.level(scale), kept)
        for head, scale, kept in zip(heads, scales, small, strict=True)
    }


def _by_patches(
    level: Level, views: Sequence[View], vertices: Points, rotations: Points, least: float
) -> Observations:
    """What patches of the neutral found in each photograph of the pose show.

    For each vertex and photograph the neutral's photograph is the one that looked most alike at
    it, the turn of the skin taken back.
    """
    surface, patches = level.surface, level.patches
    posed = Surface(vertices, surface.triangles)
    visible = level.seen[0]
    shown, known = level.shown
    places = patches.at(vertices)
    corners = surface.triangles[patches.triangles]
    found = []
    for number, view in enumerate(views):
        camera = view.camera
        seen, cosines = level.looked(posed, camera)
        pixels = camera.project(vertices)[0]
        seen &= view.usable(pixels)
        way = camera.position - vertices
        way = np.einsum("nji,nj->ni", rotations, way / np.linalg.norm(way, axis=1, keepdims=True))
        alike = np.einsum("kni,ni->kn", level.ways, way)
        alike[~visible] = -1
        which = np.flatnonzero(seen & visible.any(axis=0))
        chosen = alike.argmax(axis=0)[which]
        got = shifted(
            patches,
            places,
            camera,
            prepared(view.grey),
            (shown, known, chosen),
            np.all(seen[corners], axis=1),
            which,
            cosines[which],
        )
        good = (got.likeness > least) & (np.abs(got.shifts).max(axis=1) < 5)
        good &= got.information[:, 0, 0] > 0
        mine = got.vertices[good]
        found.append(
            Observations(
                np.full(len(mine), number),
                mine,
                pixels[mine] + got.shifts[good],
                got.information[good],
                got.likeness[good],
            )
        )
    return supported(
        Observations.join([Observations.none(), *found]), len(vertices), _PATCH_SUPPORT
    )
