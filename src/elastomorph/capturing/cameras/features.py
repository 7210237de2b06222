"""Features of photographs (SIFT): places that are found again in others, and how they look.

Photographs smaller than the features need are looked at enlarged, larger ones reduced; what is
found is told in pixels of the photograph itself, upright, their centres at integers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from elastomorph.capturing.geometry import Camera, Table
from elastomorph.capturing.photographs import Photograph, read_mask, read_upright
from elastomorph.errors import MissingExtraError

_MOST = 8192
_PEAK = 0.003  # half of what pycolmap asks for: skin has little contrast
_ENLARGED_BELOW = 1400  # px, longer side
_LONGEST = 2400
_AT_ONCE = 2


@dataclass(frozen=True, eq=False)
class Features(Table):
    """What was found in one photograph.

    Attributes:
        places: (N, 2) float64 pixels.
        shapes: (N, 4) float32 affine shape of each, row by row, in pixels.
        descriptors: (N, 128) uint8, of length about 512.
    """

    places: NDArray[np.float64]
    shapes: NDArray[np.float32]
    descriptors: NDArray[np.uint8]

    @property
    def sizes(self) -> NDArray[np.float64]:
        """(N,) of each, in pixels."""
        a, b, c, d = self.shapes.T.astype(np.float64)
        found: NDArray[np.float64] = np.sqrt(np.abs(a * d - b * c))
        return found

    @property
    def unit(self) -> NDArray[np.float32]:
        """(N, 128) descriptors of length 1."""
        found = self.descriptors.astype(np.float32)
        length = np.linalg.norm(found, axis=1, keepdims=True)
        return np.asarray(found / np.maximum(length, 1e-9), dtype=np.float32)


@contextmanager
def quiet_pycolmap() -> Iterator[Any]:
    """Pycolmap, which says nothing meanwhile.

    Raises:
        MissingExtraError: It is not installed.
    """
    try:
        import pycolmap
    except ModuleNotFoundError as error:
        raise MissingExtraError("pycolmap", "capture") from error
    level = pycolmap.logging.minloglevel
    pycolmap.logging.minloglevel = 3
    try:
        yield pycolmap
    finally:
        pycolmap.logging.minloglevel = level


def find_features(
    photographs: Sequence[Photograph],
    *,
    fine: bool = False,
    done: Callable[[int], None] = lambda count: None,
) -> list[Features]:
    """Features of photographs, in their order; the same each time.

    Args:
        photographs: Where a mask is given, only its features are kept.
        fine: Look at them enlarged twice, for what is smaller than two pixels.
        done: Called with how many are done.
    """
    found: list[Features] = []
    with quiet_pycolmap(), ThreadPoolExecutor(_AT_ONCE) as pool:
        try:
            for features in pool.map(lambda photograph: _of(photograph, fine), photographs):
                found.append(features)
                done(len(found))
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    return found


def seen_enlarged(photograph: Photograph) -> bool:
    """Whether it is looked at enlarged in any case, being small."""
    return max(photograph.size) < _ENLARGED_BELOW


def _of(photograph: Photograph, fine: bool) -> Features:
    with quiet_pycolmap() as pycolmap:
        options = pycolmap.FeatureExtractionOptions()
        options.num_threads = 1
        options.use_gpu = False
        options.sift.peak_threshold = _PEAK
        options.sift.max_num_features = _MOST
        options.sift.first_octave = -1 if fine or seen_enlarged(photograph) else 0
        extractor = pycolmap.FeatureExtractor.create(options, pycolmap.Device.cpu)
        pixels = read_upright(photograph.path, grey=True)
        factor = min(1.0, _LONGEST / max(photograph.size))
        if factor < 1.0:
            pixels = _reduced(pixels, factor)
        keypoints, descriptors = extractor.extract_from_uint8_array(pixels)
        values = np.array(
            [(k.x, k.y, k.a11, k.a12, k.a21, k.a22) for k in keypoints], dtype=np.float64
        ).reshape(-1, 6)
        looks = np.array(descriptors.data, dtype=np.uint8).reshape(-1, 128)
    # Pycolmap has the centre of the first pixel at one half.
    places = values[:, :2] / factor - 0.5
    found = Features(places, (values[:, 2:] / factor).astype(np.float32), looks)
    if photograph.mask is None:
        return found
    mask = read_mask(photograph.mask, photograph.size)
    last = np.array(photograph.size) - 1
    columns, rows = np.clip(np.rint(places).astype(np.int64), 0, last).T
    return found.chosen(mask[rows, columns])


def _reduced(pixels: NDArray[np.uint8], factor: float) -> NDArray[np.uint8]:
    import cv2

    height, width = pixels.shape
    size = (round(width * factor), round(height * factor))
    return np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)


# Which features of two photographs show the same place.
#
# Before cameras are known the strongest features of all pairs are compared, a tenth of the work,
# and a fundamental or essential matrix decides (RANSAC). Once cameras are known roughly, so is
# where a feature must be in another photograph: features around it have their depth, it is
# projected there, and only the few features near that place and near its epipolar line are
# compared. This finds three times as many matches of all features in a tenth of the time.

# Photograph and photograph, the second later → (M, 2) uint32 features of each.
Pairs = dict[tuple[int, int], NDArray[np.uint32]]

_RATIO, _FARTHEST = 0.8, 0.7  # of descriptors: best against second, and best
_AROUND = 0.008  # how far from where it is expected a feature is looked for, in focal lengths
_CANDIDATES = 12
_NEIGHBOURS = 6
_STEP = 0.1  # of the depth: points that differ by more are not on one piece of surface
_OFF_LINE = 0.001  # from the epipolar line, in focal lengths


def strongest(features: Features, most: int) -> NDArray[np.int64]:
    """The `most` largest features, in their order: those found again in the most photographs."""
    return np.sort(np.argsort(-features.sizes, kind="stable")[:most])


def compared(first: NDArray[np.float32], second: NDArray[np.float32]) -> NDArray[np.uint32]:
    """Matches of (N, 128) and (M, 128) unit descriptors: mutually nearest and distinct, (K, 2)."""
    if len(first) < 2 or len(second) < 2:
        return np.zeros((0, 2), dtype=np.uint32)
    alike = first @ second.T
    rows = np.arange(len(first))
    best = alike.argmax(axis=1)
    back = alike.argmax(axis=0)
    nearest = alike[rows, best].copy()
    alike[rows, best] = -1.0
    next_best = alike.max(axis=1)
    good = (back[best] == rows) & _distinct(nearest, next_best)
    return np.stack([rows[good], best[good]], axis=1).astype(np.uint32)


class Guide:
    """A photograph of known camera: its features as directions, with depths where known.

    Args:
        camera: That took it.
        features: Found in it.
        points: (K, 3) places in the world that it sees.
    """

    def __init__(self, camera: Camera, features: Features, points: NDArray[np.float64]) -> None:
        self.camera = camera
        self.descriptors = features.unit
        self.rays = _rays(camera, features.places)
        plane = self.rays[:, :2]
        self.tree = cKDTree(plane)
        depths = _depths(plane, points @ camera.rotation.T + camera.translation)
        self.places = (self.rays * depths[:, None] - camera.translation) @ camera.rotation


def _depths(plane: NDArray[np.float64], local: NDArray[np.float64]) -> NDArray[np.float64]:
    """Depths (N,) at places (N, 2) of the plane z = 1, by (K, 3) points in the camera's frame.

    Of the points around a place the inverse depth is fitted as linear, as it is of a plane; a
    median around it where they do not spread enough for that, or where one of them is far off.
    """
    beside = local[:, :2] / local[:, 2:]
    near = cKDTree(beside).query(plane, k=min(_NEIGHBOURS, len(local)))[1].reshape(len(plane), -1)
    inverse = 1.0 / local[:, 2][near]
    middle = np.median(inverse, axis=1)
    off = beside[near] - plane[:, None]
    columns = np.concatenate([np.ones((*off.shape[:2], 1)), off], axis=2)
    normal = np.einsum("nki,nkj->nij", columns, columns)
    # Held to a constant, weakly: enough where the points lie on a line, little elsewhere.
    reach = np.square(off).sum(axis=(1, 2))
    normal[:, [1, 2], [1, 2]] += 0.05 * np.maximum(reach, 1e-12)[:, None]
    right = np.einsum("nki,nk->ni", columns, inverse)
    fitted = np.linalg.solve(normal, right[..., None])[:, 0, 0]
    lowest, highest = inverse.min(axis=1), inverse.max(axis=1)
    apart = highest - lowest
    good = (fitted > lowest - apart) & (fitted < highest + apart) & (apart < _STEP * middle)
    return np.asarray(1.0 / np.where(good, fitted, middle))


def guided(first: Guide, second: Guide) -> NDArray[np.uint32]:
    """Matches of two photographs of known cameras, (K, 2), both ways the same."""
    there = _towards(first, second)
    back = _towards(second, first)
    found = np.flatnonzero(there >= 0)
    found = found[back[there[found]] == found]
    return np.stack([found, there[found]], axis=1).astype(np.uint32)


def _towards(one: Guide, other: Guide) -> NDArray[np.int64]:
    """The feature of the other photograph that shows each feature of this one, or -1."""
    local = one.places @ other.camera.rotation.T + other.camera.translation
    with np.errstate(divide="ignore", invalid="ignore"):
        expected = np.where(local[:, 2:] > 0, local[:, :2] / local[:, 2:], 1e6)
    distances, near = other.tree.query(
        expected, k=min(_CANDIDATES, len(other.rays)), distance_upper_bound=_AROUND
    )
    none = ~np.isfinite(distances).reshape(len(expected), -1)
    near = np.where(none, 0, near.reshape(len(expected), -1))
    lines = _lines(one.camera, other.camera, one.rays)
    none |= np.abs(np.einsum("nc,nkc->nk", lines, other.rays[near])) > _OFF_LINE
    alike = np.einsum("nc,nkc->nk", one.descriptors, other.descriptors[near])
    alike[none] = -1.0
    rows = np.arange(len(alike))
    best = alike.argmax(axis=1)
    nearest = alike[rows, best].copy()
    alike[rows, best] = -1.0
    good = (nearest > 0) & _distinct(nearest, alike.max(axis=1))
    return np.where(good, near[rows, best], -1)


def off_lines(
    one: Camera, other: Camera, first: NDArray[np.float64], second: NDArray[np.float64]
) -> NDArray[np.float64]:
    """How far (N, 2) pixels of a camera are from the epipolar lines of another's, focal lengths."""
    lines = _lines(one, other, _rays(one, first))
    found: NDArray[np.float64] = np.abs((lines * _rays(other, second)).sum(axis=1))
    return found


def _lines(one: Camera, other: Camera, rays: NDArray[np.float64]) -> NDArray[np.float64]:
    """Epipolar lines (N, 3) in the other camera's plane of (N, 3) rays; first two of length 1."""
    turn = other.rotation @ one.rotation.T
    x, y, z = other.translation - turn @ one.translation
    essential = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ turn
    lines: NDArray[np.float64] = rays @ essential.T
    lines /= np.maximum(np.linalg.norm(lines[:, :2], axis=1, keepdims=True), 1e-12)
    return lines


def _rays(camera: Camera, places: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 3) directions in the camera's own frame of (N, 2) pixels as taken, z = 1."""
    plane = (camera.undistorted(places) - camera.centre) / camera.focal
    return np.concatenate([plane, np.ones((len(plane), 1))], axis=1)


def _distinct(nearest: NDArray[np.float32], next_best: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Whether the best is near, and clearly nearer than the second; given as cosines."""
    best, second = (np.sqrt(np.maximum(2.0 - 2.0 * g, 0.0)) for g in (nearest, next_best))
    return np.asarray((best < _FARTHEST) & (best < _RATIO * second))


def neighbours(
    cameras: Sequence[Camera | None], middle: NDArray[np.float64], widest: float = 40.0
) -> list[tuple[int, int]]:
    """Pairs of cameras that see a point from directions at most `widest` degrees apart."""
    seen_from = {
        k: (camera.position - middle) / np.linalg.norm(camera.position - middle)
        for k, camera in enumerate(cameras)
        if camera is not None
    }
    least = np.cos(np.radians(widest))
    return [
        (i, j)
        for i in seen_from
        for j in seen_from
        if i < j and seen_from[i] @ seen_from[j] > least
    ]
