"""From rough cameras to exact ones: what all features of the photographs say of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.cameras.features import Features, Guide, Pairs, guided, neighbours
from elastomorph.capturing.geometry import Camera

# Cameras and points of one or more photographs, numbered in the order given, and their lenses.


@dataclass(frozen=True, eq=False)
class Lens:
    """What photographs taken with one lens share: size in pixels, focal length, centre, k."""

    size: tuple[int, int]
    focal: float
    centre: NDArray[np.float64]
    radial: float = 0.0

    @classmethod
    def of(cls, camera: Camera) -> Lens:
        """The lens of a camera."""
        return cls(camera.size, camera.focal, camera.centre, camera.radial)

    @classmethod
    def plain(cls, size: tuple[int, int], focal: float) -> Lens:
        """A lens without distortion whose axis meets the middle of the photograph."""
        return cls(size, focal, (np.array(size, dtype=np.float64) - 1) / 2)

    @property
    def parameters(self) -> list[float]:
        """As pycolmap has them: the centre of the first pixel is at one half."""
        x, y = self.centre + 0.5
        return [self.focal, float(x), float(y), self.radial]


@dataclass(frozen=True, eq=False)
class Shots:
    """Photographs as pycolmap sees them.

    Attributes:
        names: of the photographs, each once.
        places: of each, (N, 2) pixels of its features, pixel centres at integers.
        lens_of: of each, the number of its lens.
    """

    names: Sequence[str]
    places: Sequence[NDArray[np.float64]]
    lens_of: Sequence[int]


@dataclass(frozen=True, eq=False)
class Sparse:
    """Cameras and points.

    Attributes:
        cameras: of each photograph, or None where it was not found.
        points: (N, 3).
        errors: (N,) mean distance of a point's features from where it is seen, px.
        owners: (M,) the point of each observation.
        seen: (M, 2) photograph and feature of each observation.
    """

    cameras: tuple[Camera | None, ...]
    points: NDArray[np.float64]
    errors: NDArray[np.float64]
    owners: NDArray[np.int64]
    seen: NDArray[np.int64]

    @property
    def found(self) -> int:
        """How many cameras were found."""
        return sum(camera is not None for camera in self.cameras)

    @property
    def error(self) -> float:
        """Mean distance of features from where their points are seen, px."""
        counts = np.bincount(self.owners, minlength=len(self.points))
        return float((self.errors * counts).sum() / max(counts.sum(), 1))

    def seen_by(self, photograph: int) -> NDArray[np.float64]:
        """(K, 3) the points that a photograph shows."""
        found: NDArray[np.float64] = self.points[self.owners[self.seen[:, 0] == photograph]]
        return found

    def residuals(self, shots: Shots) -> NDArray[np.float64]:
        """(M,) distance of each observation from where its point is seen, px."""
        found = np.zeros(len(self.owners))
        for k, camera in enumerate(self.cameras):
            mine = self.seen[:, 0] == k
            if camera is None or not mine.any():
                continue
            pixels, _ = camera.project(self.points[self.owners[mine]])
            seen = shots.places[k][self.seen[mine, 1]]
            found[mine] = np.linalg.norm(camera.distorted(pixels) - seen, axis=1)
        return found


_FEWEST_POINTS = 40
_FEWER, _WORSE = 0.15, 3.0  # points and error of a photograph against the middle one
_CLOUD_TRACK, _CLOUD_ERROR = 3, 1.5
_WITHIN, _AT_SIZE = 2.0, 2000  # px that a feature may be off in a photograph of this longer side


def farthest_off(cameras: Sequence[Camera | None]) -> float:
    """How far a feature may be from where its point is seen, px."""
    return _WITHIN * max(0.5, _longest(cameras) / _AT_SIZE)


def matched(rough: Sparse, features: Sequence[Features]) -> Pairs:
    """Matches of all features between neighbouring cameras that are known roughly."""
    guides = {
        k: Guide(camera, features[k], seen)
        for k, camera in enumerate(rough.cameras)
        if camera is not None and len(seen := rough.seen_by(k))
    }
    middle = np.median(rough.points, axis=0)
    cameras = [camera if k in guides else None for k, camera in enumerate(rough.cameras)]
    return {(i, j): guided(guides[i], guides[j]) for i, j in neighbours(cameras, middle)}


def misfits(sparse: Sparse, shots: Shots, expected: float | None = None) -> dict[str, str]:
    """Photographs that do not fit the others, and why.

    Args:
        sparse: Cameras and points.
        shots: The photographs.
        expected: Error of a photograph that fits, px; that of the middle one unless given.
    """
    errors = reprojection(sparse, shots)
    middle = float(np.median(list(errors.values()))) if expected is None else expected
    counts = np.bincount(sparse.seen[:, 0], minlength=len(shots.names))
    usual = float(np.median([counts[k] for k, c in enumerate(sparse.cameras) if c is not None]))
    bad = {}
    for k, camera in enumerate(sparse.cameras):
        if camera is None:
            continue
        if counts[k] < max(_FEWEST_POINTS, _FEWER * usual):
            bad[camera.name] = (
                f"only {counts[k]:,} points of it agree with other photographs, {usual:,.0f} do in "
                "the middle one of them: the face or the camera moved, or it is blurred"
            )
        elif errors[camera.name] > _WORSE * middle:
            bad[camera.name] = (
                f"its features are {errors[camera.name]:.2f} px from where they should be, "
                f"{middle:.2f} px is usual: the face or the camera moved, or it is blurred"
            )
    return bad


def reprojection(sparse: Sparse, shots: Shots) -> dict[str, float]:
    """Photograph → mean distance of its features from where their points are seen, px."""
    residuals = sparse.residuals(shots)
    found = {}
    for k, camera in enumerate(sparse.cameras):
        mine = sparse.seen[:, 0] == k
        if camera is not None:
            found[camera.name] = float(residuals[mine].mean()) if mine.any() else float("inf")
    return found


def cloud(
    sparse: Sparse, features: Sequence[Features]
) -> tuple[NDArray[np.float64], NDArray[np.float32]]:
    """The points that are seen well, (N, 3), and the mean look of each, (N, 128)."""
    count = len(sparse.points)
    sums = np.zeros((count, 128), dtype=np.float32)
    for k, each in enumerate(features):
        mine = sparse.seen[:, 0] == k
        looks = each.unit[sparse.seen[mine, 1]]
        np.add.at(sums, sparse.owners[mine], looks)
    good = well_seen(sparse)
    length = np.linalg.norm(sums[good], axis=1, keepdims=True)
    mean = sums[good] / np.maximum(length, 1e-9)
    return sparse.points[good], np.asarray(mean, dtype=np.float32)


def well_seen(sparse: Sparse) -> NDArray[np.bool_]:
    """Which points three photographs or more agree on, (N,)."""
    limit = _CLOUD_ERROR * max(1.0, _longest(sparse.cameras) / _AT_SIZE)
    seen = np.bincount(sparse.owners, minlength=len(sparse.points))
    return np.asarray((seen >= _CLOUD_TRACK) & (sparse.errors <= limit))


def _longest(cameras: Sequence[Camera | None]) -> int:
    return max(max(camera.size) for camera in cameras if camera is not None)
