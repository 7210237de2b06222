"""Where a picture is taken from, and how a face is made to fill it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import ParameterError

VIEWS: dict[str, tuple[float, float]] = {
    "front": (0.0, 0.0),
    "three-quarter": (35.0, 4.0),
    "side": (90.0, 0.0),
    "below": (0.0, -35.0),
    "mouth": (0.0, 0.0),
    "eyes": (0.0, 0.0),
    "whole": (0.0, 0.0),
}
"""Degrees round the vertical axis to the face's left, and up, of each view by name."""

TINY = 1e-12
LENS = 14.0
"""Vertical angle of view in degrees: a long portrait lens, which does not swell the nose."""


@dataclass(frozen=True)
class Camera:
    """A camera that looks at a face. Pictures to be compared share one.

    The face looks along +Z and its top is +Y, as in the formats that say so (glTF) and by
    convention in the others.

    Attributes:
        position: Where the camera stands.
        focus: The point in the middle of the picture.
        up: The direction that is up in the picture.
        angle: Vertical angle of view in degrees.
    """

    position: tuple[float, float, float]
    focus: tuple[float, float, float]
    up: tuple[float, float, float]
    angle: float = LENS

    @classmethod
    def framing(
        cls,
        points: ArrayLike,
        view: str | tuple[float, float] = "front",
        *,
        size: tuple[int, int] = (720, 900),
        margin: float = 0.04,
    ) -> Camera:
        """The camera for which all (..., 3) points just fill a picture of this size in pixels.

        The view is a name of `VIEWS`, or degrees to the face's left and up; the margin is a
        fraction of the picture's width and height on each side.
        """
        cloud = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        if not len(cloud) or not np.isfinite(cloud).all():
            raise ParameterError("a camera needs at least one point, with finite coordinates")
        if min(size) < 1 or not 0 <= margin < 0.5:
            raise ParameterError(
                f"a picture needs a size of at least 1 × 1 and a margin from 0 to 0.5, "
                f"found {size} and {margin}"
            )
        right, up, back = axes = _axes(view)
        # In the camera's axes, a point (x, y, z) at eye (a, b, c) is seen at slope
        # (x - a)/(c - z), and the picture spans slopes ± tan(angle/2)·(aspect, 1).
        x, y, z = axes @ cloud.T
        tall = np.tan(np.radians(LENS / 2)) * (1 - 2 * margin)
        wide = tall * size[0] / size[1]
        a, depth_x = _fit(x, z, wide)
        b, depth_y = _fit(y, z, tall)
        eye = max(depth_x, depth_y)
        # Points all on one ray would put the eye among them.
        gap = max(
            1e-3 * float(np.ptp(cloud, axis=0).max()), 1e-9 * float(np.abs(cloud).max()), TINY
        )
        eye = max(eye, float(z.max()) + gap)
        middle = float(z.min() + z.max()) / 2
        a, b = _centre(x, z, eye, a), _centre(y, z, eye, b)
        return cls(
            position=_triple(a * right + b * up + eye * back),
            focus=_triple(a * right + b * up + middle * back),
            up=_triple(up),
        )

    def towards(self, points: NDArray[np.float64], fraction: float) -> NDArray[np.float64]:
        """The points moved towards the camera, for lines to stay free: by a fraction of the way."""
        eye = np.array(self.position)
        rays = eye - points
        step = fraction * np.linalg.norm(eye - np.array(self.focus))
        lengths = np.linalg.norm(rays, axis=-1, keepdims=True)
        return np.asarray(points + rays / lengths * step)

    def seen(self, points: NDArray[np.float64], size: tuple[int, int]) -> NDArray[np.float64]:
        """(N, 2) column and row at which (N, 3) points are seen in a picture of this size.

        They count from its upper left corner.
        """
        back = np.array(self.position) - np.array(self.focus)
        back /= np.linalg.norm(back)
        right = np.cross(self.up, back)
        right /= np.linalg.norm(right)
        axes = np.stack([right, np.cross(back, right), back])
        across, above, behind = axes @ (points - np.array(self.position)).T
        focal = size[1] / 2 / np.tan(np.radians(self.angle / 2))
        columns = size[0] / 2 - focal * across / behind
        rows = size[1] / 2 + focal * above / behind
        return np.stack([columns, rows], axis=1)


def _axes(view: str | tuple[float, float]) -> NDArray[np.float64]:
    """Rows: right, up and back of the camera."""
    if isinstance(view, str):
        if view not in VIEWS:
            raise ParameterError(f"view must be one of {', '.join(VIEWS)}, found {view!r}")
        view = VIEWS[view]
    turn, rise = np.radians(view)
    back = np.array([np.sin(turn) * np.cos(rise), np.sin(rise), np.cos(turn) * np.cos(rise)])
    right = np.array([np.cos(turn), 0.0, -np.sin(turn)])
    return np.stack([right, np.cross(back, right), back])


def _fit(
    across: NDArray[np.float64], depth: NDArray[np.float64], slope: float
) -> tuple[float, float]:
    """Where the eye stands across and in depth so that |across - a| ≤ slope·(eye - depth)."""
    high = float((across + slope * depth).max())
    low = float((across - slope * depth).min())
    return (high + low) / 2, (high - low) / (2 * slope)


def _centre(
    across: NDArray[np.float64], depth: NDArray[np.float64], eye: float, start: float
) -> float:
    """Where the eye stands across so that the outermost points are seen equally far out."""
    a = start
    for _ in range(20):
        seen = (across - a) / (eye - depth)
        outer, inner = int(seen.argmax()), int(seen.argmin())
        # equal and opposite slopes of these two points
        near, far = eye - depth[outer], eye - depth[inner]
        a = float((across[outer] * far + across[inner] * near) / (near + far))
    return a


def _triple(point: NDArray[np.float64]) -> tuple[float, float, float]:
    return float(point[0]), float(point[1]), float(point[2])
