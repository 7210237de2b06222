"""From rough cameras to exact ones: what all features of the photographs say of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.cameras.features import Features
from elastomorph.capturing.cameras.matching import Guide, Pairs, guided, neighbours
from elastomorph.capturing.cameras.sparse import Shots, Sparse
from elastomorph.capturing.geometry.camera import Camera

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
