"""Cameras, surfaces and what moves them."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import CaptureError, FormatError, MissingExtraError
from elastomorph.model.cholesky import symmetric_factor
from elastomorph.model.geometry import component_of, sides_of
from elastomorph.model.surface import closest_weights

# Arrays of one length: some of their rows, and those of several tables together.


@dataclass(frozen=True, eq=False)
class Table:
    """A dataclass whose fields are arrays with the same number of rows."""

    def __len__(self) -> int:
        return len(getattr(self, fields(self)[0].name))

    def chosen(self, which: NDArray[Any]) -> Self:
        """Some of the rows."""
        return type(self)(*(getattr(self, each.name)[which] for each in fields(self)))

    @classmethod
    def join(cls, parts: Sequence[Self]) -> Self:
        """The rows of one or more tables."""
        names = [each.name for each in fields(cls)]
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


# Similarities: what brings the points of one frame into another.

Points = NDArray[np.float64]

# Triples of pairs that are tried to find the similarity that most pairs agree with.
_TRIALS = 3000


@dataclass(frozen=True, eq=False)
class Similarity:
    """x ↦ scale · rotation x + shift.

    Attributes:
        scale: larger than 0.
        rotation: (3, 3) orthogonal; of determinant −1 if it mirrors.
        shift: (3,) in the units of the goal.
    """

    scale: float
    rotation: Points
    shift: Points

    @classmethod
    def identity(cls) -> Similarity:
        """What changes nothing."""
        return cls(1.0, np.eye(3), np.zeros(3))

    def __call__(self, points: Points) -> Points:
        """(..., 3) points, moved."""
        return self.scale * points @ self.rotation.T + self.shift

    def inverse(self) -> Similarity:
        """What undoes it."""
        back = self.rotation.T
        return Similarity(1 / self.scale, back, -(back @ self.shift) / self.scale)

    def then(self, other: Similarity) -> Similarity:
        """This one first, the other after it."""
        return Similarity(
            self.scale * other.scale, other.rotation @ self.rotation, other(self.shift)
        )


def fit_similarity(
    source: Points,
    goal: Points,
    weights: NDArray[np.float64] | None = None,
    *,
    rigid: bool = False,
    mirrored: bool | None = False,
) -> Similarity:
    """The similarity of least weighted squares Σ w ‖s R a + t − b‖² (Umeyama, PAMI 13(4), 1991).

    Args:
        source: (N, 3) points a, at least three that are not on one line.
        goal: (N, 3) points b.
        weights: (N,) ≥ 0; all equal unless given.
        rigid: keep the scale at 1.
        mirrored: whether R is a reflection; None lets it be whichever fits better.

    Raises:
        CaptureError: fewer than three points, or all of them on one line.
    """
    w = np.ones(len(source)) if weights is None else weights
    if np.count_nonzero(w) < 3:
        raise CaptureError(f"a similarity needs at least 3 pairs of points, found {len(source)}")
    w = w / w.sum()
    a, b = w @ source, w @ goal
    left, values, right = np.linalg.svd((goal - b).T @ (w[:, None] * (source - a)))
    if values[1] <= 1e-12 * max(values[0], np.finfo(float).tiny):
        raise CaptureError("a similarity needs points that are not all on one line")
    sign = np.sign(np.linalg.det(left @ right))
    last = sign if mirrored is False else (-sign if mirrored else 1.0)
    signs = np.array([1.0, 1.0, last])
    rotation = (left * signs) @ right
    scale = 1.0 if rigid else float(values @ signs / (w @ ((source - a) ** 2).sum(axis=1)))
    return Similarity(scale, rotation, b - scale * rotation @ a)


def agreeing(
    source: Points,
    goal: Points,
    tolerance: float,
    *,
    rigid: bool = False,
) -> tuple[Similarity, NDArray[np.bool_]]:
    """The similarity that most pairs agree with (RANSAC), refitted to those.

    Args:
        source: (N, 3) points.
        goal: (N, 3) points; many pairs may be wrong.
        tolerance: distance at which a pair agrees, in the units of the goal.
        rigid: keep the scale at 1.

    Returns:
        The similarity and (N,) which pairs agree.

    Raises:
        CaptureError: fewer than three pairs agree with any similarity.
    """
    random = np.random.default_rng(0)
    best: NDArray[np.bool_] = np.zeros(len(source), dtype=bool)
    for _ in range(_TRIALS if len(source) >= 3 else 0):
        few = random.choice(len(source), 3, replace=False)
        try:
            found = fit_similarity(source[few], goal[few], rigid=rigid)
        except CaptureError:
            continue
        agree = _within(found, source, goal, tolerance)
        if np.count_nonzero(agree) > np.count_nonzero(best):
            best = agree
    for _ in range(5):
        found = fit_similarity(source[best], goal[best], rigid=rigid)
        again = _within(found, source, goal, tolerance)
        if (again == best).all():
            return found, best
        best = again
    return found, best


def robust_rigid(source: Points, goal: Points, reaches: tuple[float, ...]) -> Similarity:
    """The rigid motion that brings to their goals the points that move as one, others aside.

    Args:
        source: (N, 3) points.
        goal: (N, 3) where each is to be.
        reaches: distances at which a point counts a quarter, one after the other, from rough to
            fine (Geman and McClure's weights).

    Raises:
        CaptureError: fewer than three points count, or all of them are on one line.
    """
    found = Similarity.identity()
    for reach in reaches:
        for _ in range(5):
            off = np.linalg.norm(found(source) - goal, axis=1)
            found = fit_similarity(source, goal, 1 / (1 + (off / reach) ** 2) ** 2, rigid=True)
    return found


def _within(found: Similarity, source: Points, goal: Points, tolerance: float) -> NDArray[np.bool_]:
    distances: NDArray[np.float64] = np.linalg.norm(found(source) - goal, axis=1)
    return distances < tolerance


# Cameras and the photographs that they took, without distortion.


@dataclass(frozen=True, eq=False)
class Camera:
    """A pinhole with one radial term: a point X is at focal · Y₀₁ / Y₂ + centre, Y = R X + t.

    Pixel centres are at integers; the camera looks along +z of its own frame, y points down.

    Attributes:
        name: of the photograph, without its folder.
        size: width and height in pixels, upright.
        focal: focal length in pixels.
        centre: (2,) the principal point in pixels.
        radial: k of the photograph's distortion y ↦ y (1 + k ‖y‖²), y = Y₀₁ / Y₂.
        rotation: (3, 3) R, from the world into the camera.
        translation: (3,) t.
    """

    name: str
    size: tuple[int, int]
    focal: float
    centre: Points
    radial: float
    rotation: Points
    translation: Points

    @property
    def position(self) -> Points:
        """(3,) where it stands in the world."""
        return -self.rotation.T @ self.translation

    def project(self, points: Points) -> tuple[Points, Points]:
        """(..., 2) pixels of (..., 3) points, undistorted, and (...) depths along the axis."""
        local = points @ self.rotation.T + self.translation
        depths = local[..., 2]
        return self.focal * local[..., :2] / depths[..., None] + self.centre, depths

    def jacobian(self, points: Points) -> Points:
        """(N, 2, 3) change of the pixels by that of (N, 3) points."""
        x, y, z = (points @ self.rotation.T + self.translation).T
        change = np.zeros((len(points), 2, 3))
        change[:, 0, 0] = change[:, 1, 1] = self.focal / z
        change[:, 0, 2] = -self.focal * x / z**2
        change[:, 1, 2] = -self.focal * y / z**2
        return change @ self.rotation

    def directions(self, step: int = 1) -> Points:
        """(H, W, 3) of the rays through every step-th pixel, of length 1 along the axis."""
        columns, rows = np.meshgrid(
            np.arange(0, self.size[0], step), np.arange(0, self.size[1], step)
        )
        return self.through(np.stack([columns, rows], axis=-1))

    def through(self, pixels: Points) -> Points:
        """(..., 3) directions of the rays through (..., 2) pixels, of length 1 along the axis."""
        local = np.ones((*pixels.shape[:-1], 3))
        local[..., :2] = (pixels - self.centre) / self.focal
        return local @ self.rotation

    def inside(self, pixels: Points, border: float = 0.0) -> NDArray[np.bool_]:
        """(...) whether (..., 2) pixels are in the photograph and `border` from its edge."""
        last = np.array(self.size) - 1.0 - border
        return np.asarray(((pixels >= border) & (pixels <= last)).all(axis=-1))

    def distorted(self, pixels: Points) -> Points:
        """Where in the photograph as taken are (..., 2) pixels of the one without distortion."""
        local = (pixels - self.centre) / self.focal
        far = (local**2).sum(axis=-1, keepdims=True)
        found: Points = local * (1 + self.radial * far) * self.focal + self.centre
        return found

    def undistorted(self, pixels: Points) -> Points:
        """Where (..., 2) pixels of the photograph as taken are without distortion."""
        goal = (pixels - self.centre) / self.focal
        local = goal
        for _ in range(20):
            local = goal / (1 + self.radial * (local**2).sum(axis=-1, keepdims=True))
        return local * self.focal + self.centre

    def scaled(self, factor: float) -> Camera:
        """The camera of the photograph made smaller by `factor`; pixels stay at integers."""
        width, height = (max(1, round(side * factor)) for side in self.size)
        return replace(
            self,
            size=(width, height),
            focal=self.focal * factor,
            centre=(self.centre + 0.5) * factor - 0.5,
        )

    def without_distortion(self, factor: float) -> Camera:
        """The camera of the photograph without distortion, made smaller by `factor`."""
        return replace(self.scaled(factor), radial=0.0)

    def moved(self, similarity: Similarity) -> Camera:
        """The camera that sees a world moved by a similarity as this one sees it now."""
        rotation = self.rotation @ similarity.rotation.T
        return replace(
            self,
            rotation=rotation,
            translation=similarity.scale * self.translation - rotation @ similarity.shift,
        )


def nearest_to_lines(places: Points, ways: Points) -> Points:
    """(3,) the point nearest to lines through (N, 3) places along (N, 3) ways of length 1."""
    off = np.eye(3) - ways[:, :, None] * ways[:, None, :]
    pulls = np.einsum("nij,nj->i", off, places)
    return np.asarray(np.linalg.lstsq(off.sum(axis=0), pulls, rcond=None)[0], dtype=np.float64)


@dataclass(frozen=True, eq=False)
class View:
    """A photograph without distortion, or a part of one.

    Attributes:
        camera: that took it, or would have taken the part; its `radial` is done with.
        grey: (H, W) uint8.
        mask: (H, W) what may be used; None: all of it.
    """

    camera: Camera
    grey: NDArray[np.uint8]
    mask: NDArray[np.bool_] | None

    def scaled(self, factor: float) -> View:
        """The photograph made smaller by `factor`."""
        import cv2

        if factor == 1:
            return self
        camera, mask = self.camera.scaled(factor), self.mask
        grey = _smaller(self.grey, factor)
        if mask is not None:
            small: Any = cv2.resize(
                mask.astype(np.uint8), camera.size, interpolation=cv2.INTER_NEAREST
            )
            mask = np.asarray(small > 0)
        return View(camera, grey, mask)

    def usable(self, pixels: Points) -> NDArray[np.bool_]:
        """(N,) whether (N, 2) pixels are where the mask, if there is one, leaves them."""
        if self.mask is None:
            return np.ones(len(pixels), dtype=bool)
        last = np.array(self.mask.shape[::-1]) - 1
        column, row = np.clip(np.round(pixels), 0, last).astype(int).T
        found: NDArray[np.bool_] = self.mask[row, column] & self.camera.inside(pixels)
        return found


def open_view(camera: Camera, path: Path, *, scale: float = 1.0, mask: Path | None = None) -> View:
    """Read the photograph of a camera, upright, without distortion and at a scale.

    Raises:
        FormatError: the file is no photograph, or not of the camera's size.
    """
    import cv2

    flat, colours = open_colours(camera, path, scale=scale)
    inside = None
    if mask is not None:
        inside = _flat(camera, _pixels(mask, cv2.IMREAD_GRAYSCALE, camera.size), scale) > 127
    grey: Any = cv2.cvtColor(colours, cv2.COLOR_RGB2GRAY)
    return View(flat, grey, inside)


def open_colours(
    camera: Camera, path: Path, *, scale: float = 1.0
) -> tuple[Camera, NDArray[np.uint8]]:
    """The camera of what `open_view` reads, and (H, W, 3) its colours, red first.

    Raises:
        FormatError: the file is no photograph, or not of the camera's size.
    """
    import cv2

    colours = _flat(camera, _pixels(path, cv2.IMREAD_COLOR_RGB, camera.size), scale)
    return camera.without_distortion(scale), colours


def _pixels(path: Path, kind: int, size: tuple[int, int]) -> NDArray[np.uint8]:
    """The pixels of a file, turned upright as its EXIF data says."""
    import cv2

    try:
        found = cv2.imdecode(np.fromfile(path, dtype=np.uint8), kind)
    except (OSError, cv2.error) as problem:
        raise FormatError(path, f"it cannot be read: {problem}") from problem
    if found is None:
        raise FormatError(path, "it is no picture that can be read")
    if found.shape[1::-1] != size:
        raise FormatError(
            path,
            f"it has {found.shape[1]} × {found.shape[0]} pixels, expected {size[0]} × {size[1]}",
        )
    return np.asarray(found, dtype=np.uint8)


def _flat(camera: Camera, taken: NDArray[np.uint8], scale: float) -> NDArray[np.uint8]:
    """The pixels without distortion, made smaller."""
    import cv2

    pixels: Any = taken
    focal, (x, y) = camera.focal, camera.centre
    if camera.radial:
        lens = np.array([[focal, 0, x], [0, focal, y], [0, 0, 1]])
        pixels = cv2.undistort(pixels, lens, np.array([camera.radial, 0, 0, 0, 0]))
    return np.asarray(pixels) if scale == 1 else _smaller(pixels, scale)


def _smaller(pixels: Any, factor: float) -> NDArray[np.uint8]:
    import cv2

    # Given the factor rather than the size, its rounding moves nothing.
    return np.asarray(cv2.resize(pixels, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA))


# A surface of triangles that rays and points can be asked of.

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
        from scipy.sparse import coo_array

        first, second = edges_of(self.triangles).T
        count = len(self.vertices)
        lengths = np.linalg.norm(self.vertices[first] - self.vertices[second], axis=1)
        lengths = np.maximum(lengths, np.finfo(float).tiny)
        return coo_array((lengths, (first, second)), shape=(count, count)).tocsr()

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


# Values of pictures between their pixels, and pictures made ready for that.

Single = NDArray[np.float32]

# Blur of photographs before they are compared, in pixels.
_BLUR = 0.8


def pixel_grid(width: int, height: int) -> tuple[Single, Single]:
    """(H, W) the columns and (H, W) the rows of all pixels."""
    columns, rows = np.meshgrid(
        np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32)
    )
    return columns, rows


def sampled(picture: NDArray[Any], pixels: Points) -> NDArray[Any]:
    """(N,) or (N, C) values of a picture at (N, 2) pixels."""
    import cv2

    # A row of a picture made by `remap` has to be shorter than 2¹⁵.
    width = 1 << 12
    short = -len(pixels) % width
    where = np.pad(pixels.astype(np.float32), ((0, short), (0, 0)), constant_values=-9)
    grid = where.reshape(-1, width, 2)
    rows: Any = [
        cv2.remap(picture, part[..., 0], part[..., 1], cv2.INTER_LINEAR)
        for part in np.array_split(grid, len(grid) // 8192 + 1)
    ]
    found = np.concatenate(rows)
    return np.asarray(found.reshape(-1, *picture.shape[2:])[: len(pixels)])


def blurred(grey: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """A picture with less noise."""
    import cv2

    found: Any = cv2.GaussianBlur(grey, (0, 0), _BLUR)
    return np.asarray(found)


def prepared(grey: NDArray[np.uint8]) -> Single:
    """(H, W, 3) a photograph with less noise, and its changes along x and y."""
    import cv2

    smooth = blurred(grey).astype(np.float32)
    across: Any = cv2.Scharr(smooth, cv2.CV_32F, 1, 0, scale=1 / 32)
    down: Any = cv2.Scharr(smooth, cv2.CV_32F, 0, 1, scale=1 / 32)
    return np.dstack([smooth, across, down])


# Two pictures compared: what has moved between them, and how alike they are.

Picture = NDArray[np.uint8]

# Pixels of the Gaussian in which pictures are correlated.
_WINDOW = 3.0


def flow_engine() -> Any:
    """OpenCV's dense inverse search (Kroeger et al., ECCV 2016), to the pixel and refined."""
    import cv2

    library: Any = cv2
    engine = library.DISOpticalFlow_create(library.DISOPTICAL_FLOW_PRESET_MEDIUM)
    engine.setFinestScale(0)
    engine.setVariationalRefinementIterations(3)
    return engine


def correlation(one: Picture, other: Picture) -> NDArray[np.float32]:
    """(H, W) how two pictures correlate around each pixel; noise alone is 0."""
    import cv2

    def mean(values: Any) -> Any:
        return cv2.GaussianBlur(values, (0, 0), _WINDOW)

    a, b = one.astype(np.float32), other.astype(np.float32)
    mean_a, mean_b = mean(a), mean(b)
    own_a, own_b = mean(a * a) - mean_a**2, mean(b * b) - mean_b**2
    product = mean(a * b) - mean_a * mean_b
    found = product / np.sqrt(np.maximum(own_a, 2) * np.maximum(own_b, 2))
    return np.asarray(found, dtype=np.float32)


# The parts of a template: the skin, which photographs are compared with, and what goes along.
#
# Eyes, teeth, lashes and the like are surfaces of their own. Photographs show little of them, and
# what they show lies behind glass, lids and lips: they are carried by the skin around them.


# Vertices of the skin that carry a part, or a single vertex of one that is open.
_AROUND, _BESIDE = 60, 8


@dataclass(frozen=True, eq=False)
class Parts:
    """A template at rest, taken apart.

    Attributes:
        rest: (V, 3) positions.
        skin: (S,) int64 vertices of the part that holds the landmarks.
        place: (V,) int64 of each vertex in ``skin``; -1 for those of other parts.
        triangles: (T, 3) int64 of the skin, indices into ``skin``.
        solid: vertices of each closed part, an eye or a tooth, and (N,) the vertices, as indices
            into ``skin``, that carry it.
        loose: (L,) all other vertices.
        beside: (L, K) what carries each of them, indices into ``skin``.
        shares: (L, K) how much, rows of sum 1.
    """

    rest: Points
    skin: NDArray[np.int64]
    place: NDArray[np.int64]
    triangles: NDArray[np.int64]
    solid: tuple[tuple[NDArray[np.int64], NDArray[np.int64]], ...]
    loose: NDArray[np.int64]
    beside: NDArray[np.int64]
    shares: Points

    @classmethod
    def of(cls, rest: Points, triangles: NDArray[np.integer], landmarks: ArrayLike) -> Parts:
        """The parts of (V, 3) vertices and (T, 3) triangles; the skin holds (K,) the landmarks.

        Raises:
            CaptureError: Most landmarks are not on one part.
        """
        from scipy.spatial import cKDTree

        triangles = np.asarray(triangles, dtype=np.int64)
        sides = sides_of(triangles)
        part = component_of(len(rest), sides)
        votes = np.bincount(part[np.asarray(landmarks, dtype=np.int64)], minlength=part.max() + 1)
        chosen = int(votes.argmax())
        skin = np.flatnonzero(part == chosen)
        if 2 * votes[chosen] <= votes.sum() or len(skin) < 3:
            raise CaptureError(
                f"the template's landmarks are spread over {np.count_nonzero(votes)} parts that "
                "hang together with nothing: most of them have to be on one, the skin of the face"
            )
        place = np.full(len(rest), -1)
        place[skin] = np.arange(len(skin))
        mine = place[triangles[part[triangles[:, 0]] == chosen]]
        tree = cKDTree(rest[skin])
        solid, loose = [], []
        for vertices in _others(part, chosen):
            if len(vertices) > 3 and _closed(sides[part[sides[:, 0]] == part[vertices[0]]]):
                middle = rest[vertices].mean(axis=0)
                around = np.atleast_1d(tree.query(middle, k=min(_AROUND, len(skin)))[1])
                solid.append((vertices, around.astype(np.int64)))
            else:
                loose.append(vertices)
        others: NDArray[np.int64] = np.concatenate([np.zeros(0, dtype=np.int64), *loose])
        far, beside = tree.query(rest[others], k=min(_BESIDE, len(skin)))
        # What lies on a vertex of the skin goes exactly with it.
        shares = 1 / np.maximum(far, 1e-9 * np.ptp(rest)) ** 2
        shares /= shares.sum(axis=1, keepdims=True)
        near = np.asarray(beside, dtype=np.int64)
        return cls(rest, skin, place, mine, tuple(solid), others, near, shares)

    def carried(self, skin: Points) -> Points:
        """(V, 3) all vertices, from (S, 3) those of the skin."""
        vertices = self.rest.copy()
        vertices[self.skin] = skin
        before = self.rest[self.skin]
        for mine, around in self.solid:
            # Closed parts keep shape and size: eyes are balls, and teeth are hard.
            move = fit_similarity(before[around], skin[around], rigid=True)
            vertices[mine] = move(self.rest[mine])
        moved = (skin - before)[self.beside]
        vertices[self.loose] += np.einsum("lk,lkj->lj", self.shares, moved)
        return vertices


def _others(part: NDArray[np.int32], chosen: int) -> list[NDArray[np.int64]]:
    """Vertices of each part but the chosen one."""
    order = np.argsort(part, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(part[order])) + 1)
    return [group for group in groups if part[group[0]] != chosen]


def _closed(sides: NDArray[np.int64]) -> bool:
    """Whether each edge of a part is between two triangles."""
    counts = np.unique(np.sort(sides, axis=1), axis=0, return_counts=True)[1]
    return len(counts) > 0 and bool((counts == 2).all())


# Surfaces that bend as little as what is known of them allows.
#
# The energy of positions V with a rotation R_i at each vertex is
#
#     Σ_i (v_iᵀ A_i v_i − 2 b_iᵀ v_i) + a Σ_ij ‖v_i − v_j − (R_i + R_j)/2 (p_i − p_j)‖²
#                                     + β Σ_i ‖(L V)_i − R_i (L P)_i‖²
#
# with the rest positions P, edges ij and the mean-of-neighbours Laplacian L: as rigid as possible
# (Sorkine and Alexa, SGP 2007) with bending. Rotations and positions are found in turns.


# What holds vertices that nothing else holds to where they are, beside the stiffness of an edge.
_HOLD = 1e-7
# Pairs of vertices by which a part is tied to the rest.
_TIES = 12


class Deformation:
    """A surface at rest, prepared for many solutions.

    Parts that hang together with nothing are tied to the nearest vertices of the largest part, so
    that what is not seen, an eye or teeth, goes along.
    """

    def __init__(self, rest: Points, triangles: NDArray[np.integer]) -> None:
        from scipy.sparse import coo_array, diags_array, eye_array

        count = len(rest)
        edges = edges_of(triangles)
        self.rest = rest
        self.edges = np.concatenate([edges, _ties(rest, edges)])
        first, second = self.edges.T
        ones = np.ones(len(self.edges))
        joined = coo_array((ones, (first, second)), shape=(count, count))
        self.neighbours = (joined + joined.T).tocsr()
        degrees = self.neighbours.sum(axis=1)
        laplacian = diags_array(degrees) - self.neighbours
        mean = diags_array(1 / np.maximum(degrees, 1)) @ laplacian
        self._laplacian, self._mean = laplacian.tocsr(), mean.tocsr()
        self._bending = (mean.T @ mean).tocsr()
        self._curvature = mean @ rest
        self._order = _order(self._bending)
        self._smoothing = diags_array(1 / (degrees + 1)) @ (self.neighbours + eye_array(count))

    def around(self, rest: Points) -> Deformation:
        """The same surface with another shape at rest, without preparing it again."""
        other = copy(self)
        other.rest, other._curvature = rest, self._mean @ rest
        return other

    def smoothed(self, values: Points, rounds: int = 1) -> Points:
        """(V, ...) values at the vertices, each made the mean of itself and its neighbours."""
        for _ in range(rounds):
            values = self._smoothing @ values
        return values

    def rotations(self, vertices: Points, smoothing: int = 2) -> Points:
        """(V, 3, 3) rotations of the surroundings of each vertex from rest to (V, 3) vertices."""
        first, second = self.edges.T
        before = self.rest[first] - self.rest[second]
        after = vertices[first] - vertices[second]
        products = (after[:, :, None] * before[:, None, :]).reshape(-1, 9)
        total = np.zeros((len(vertices), 9))
        np.add.at(total, first, products)
        np.add.at(total, second, products)
        left, _, right = np.linalg.svd(self.smoothed(total, smoothing).reshape(-1, 3, 3))
        left[:, :, 2] *= np.sign(np.linalg.det(left @ right))[:, None]
        found: Points = left @ right
        return found

    def solve(
        self,
        vertices: Points,
        quadratic: Points,
        linear: Points,
        *,
        arap: float,
        bending: float,
        rounds: int = 3,
    ) -> Points:
        """(V, 3) positions of least energy, begun at `vertices`.

        Args:
            vertices: (V, 3) to start from.
            quadratic: (V, 3, 3) A, symmetric.
            linear: (V, 3) b.
            arap: a, how much edges are kept.
            bending: β, how much curvature is kept.
            rounds: turns of rotations and positions.
        """
        hold = _HOLD * max(arap, bending)
        factor = self._factor(quadratic + hold * np.eye(3), arap, bending)
        first, second = self.edges.T
        edges = self.rest[first] - self.rest[second]
        for _ in range(rounds):
            turned = self.rotations(vertices)
            pull = 0.5 * np.einsum("eij,ej->ei", turned[first] + turned[second], edges)
            right = linear + hold * vertices
            np.add.at(right, first, arap * pull)
            np.add.at(right, second, -arap * pull)
            right += bending * (self._mean.T @ np.einsum("nij,nj->ni", turned, self._curvature))
            found = factor.solve(right[self._order].reshape(-1, 1))
            vertices = np.empty_like(vertices)
            vertices[self._order] = found.reshape(-1, 3)
        return vertices

    def _factor(self, quadratic: Points, arap: float, bending: float) -> Any:
        """Of the matrix of 3 V unknowns in order, x, y and z of a vertex after each other."""
        from scipy.sparse import bsr_array, eye_array, kron

        stiffness = (arap * self._laplacian + bending * self._bending)[self._order][:, self._order]
        count = len(self.rest)
        blocks = bsr_array(
            (quadratic[self._order], np.arange(count), np.arange(count + 1)),
            shape=(3 * count, 3 * count),
        )
        matrix = kron(stiffness, eye_array(3)) + blocks
        return symmetric_factor(matrix.tocsc(), ordered=True)


def _order(pattern: Any) -> NDArray[np.int64]:
    """(V,) vertices in the order in which a symmetric matrix of this pattern is eliminated.

    The minimum degree order suits surfaces with many layers, a mouth within a head: its factor
    has a fraction of the entries that cuts along planes leave.
    """
    from scipy.sparse import eye_array

    factor = symmetric_factor((pattern + eye_array(pattern.shape[0])).tocsc())
    return np.argsort(factor.perm_c)


def _ties(rest: Points, edges: NDArray[np.integer]) -> NDArray[np.int64]:
    """(E, 2) pairs of near vertices that join each part to the largest one."""
    from scipy.spatial import cKDTree

    parts = component_of(len(rest), edges)
    sizes = np.bincount(parts)
    main = np.flatnonzero(parts == sizes.argmax())
    tree = cKDTree(rest[main])
    ties = [np.empty((0, 2), dtype=np.int64)]
    for part in np.flatnonzero((sizes > 1) & (np.arange(len(sizes)) != sizes.argmax())):
        mine = np.flatnonzero(parts == part)
        far, nearest = (np.asarray(found) for found in tree.query(rest[mine]))
        few = np.argsort(far, kind="stable")[:_TIES]
        ties.append(np.stack([mine[few], main[nearest[few]]], axis=1))
    return np.concatenate(ties)


# What draws a surface to points in space: robust closest points, and places that are known.


def robust(residuals: Points, width: float) -> Points:
    """Weights in (0, 1] of residuals: half of it at 0.64 widths, next to nothing beyond three.

    That of Geman and McClure: the sum of r² / (r² + width²) is what becomes least.
    """
    weights: Points = 1 / (1 + (residuals / width) ** 2) ** 2
    return weights


def along_normals(surface: Surface, weights: Points, offsets: Points) -> tuple[Points, Points]:
    """Quadratic (V, 3, 3) and linear (V, 3) terms that move (V,) vertices along their normals."""
    normals = surface.normals
    quadratic = weights[:, None, None] * (normals[:, :, None] * normals[:, None, :])
    goal = np.einsum("ij,ij->i", surface.vertices, normals) + offsets
    return quadratic, normals * (weights * goal)[:, None]


def to_places(
    count: int, vertices: NDArray[np.integer], places: Points, weight: float
) -> tuple[Points, Points]:
    """Quadratic (V, 3, 3) and linear (V, 3) terms that draw some vertices to (K, 3) places."""
    quadratic, linear = np.zeros((count, 3, 3)), np.zeros((count, 3))
    np.add.at(quadratic, vertices, weight * np.eye(3))
    np.add.at(linear, vertices, weight * places)
    return quadratic, linear


def to_points(
    surface: Surface, points: Points, chosen: NDArray[np.bool_], *, width: float, reach: float
) -> tuple[Points, Points]:
    """Quadratic (V, 3, 3) and linear (V, 3) terms that draw a surface to (N, 3) points.

    Each point draws the triangle that is nearest to it, along the normals of its corners.

    Args:
        surface: what is drawn.
        points: near it; any others do nothing.
        chosen: (V,) which vertices may be drawn; a triangle needs one.
        width: of `robust`, in the units of the surface.
        reach: farther points do nothing.
    """
    near = surface.closest(points)
    corners = surface.triangles[near.triangles]
    use = (near.distances < reach) & chosen[corners].any(axis=1)
    corners, shares = corners[use], near.weights[use]
    away = points[use] - near.points[use]
    weights = shares * robust(near.distances[use], width)[:, None]
    normals = surface.normals[corners]
    goals = np.einsum("ncj,ncj->nc", surface.vertices[corners], normals)
    goals += np.einsum("nj,ncj->nc", away, normals)
    quadratic = np.zeros((len(surface.vertices), 3, 3))
    linear = np.zeros((len(surface.vertices), 3))
    products = weights[..., None, None] * (normals[..., :, None] * normals[..., None, :])
    np.add.at(quadratic, corners, products)
    np.add.at(linear, corners, (weights * goals)[..., None] * normals)
    return quadratic, linear
