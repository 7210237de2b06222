"""Cameras and the photographs that they took, without distortion."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.similarity import Similarity
from elastomorph.errors import FormatError

Points = NDArray[np.float64]


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
