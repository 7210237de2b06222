"""Cameras and points of one or more photographs, numbered in the order given, and their lenses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.camera import Camera


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
