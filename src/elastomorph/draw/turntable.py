"""A head that is turned round in front of a camera that stays where it is.

The light stays with the camera, so a turn shows the shape as a sculptor's turntable does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.draw.camera import Camera
from elastomorph.draw.framing import CLOSE_UPS, View, head_points
from elastomorph.errors import ParameterError
from elastomorph.model.mesh import Mesh

__all__ = ["Turntable", "turn_angles"]

FULL_TURN = 360.0
_MOST_FRAMED = 72
"""Angles at which the camera makes sure that everything is seen; between them little changes."""


@dataclass(frozen=True)
class Turntable:
    """The camera and the vertical axis that a head turns round.

    Attributes:
        camera: Sees everything at every angle from one distance, so the head keeps its size.
        axis: x and z of the axis.
    """

    camera: Camera
    axis: tuple[float, float]

    @classmethod
    def around(
        cls,
        mesh: Mesh,
        angles: ArrayLike,
        view: View = "front",
        *,
        poses: ArrayLike | None = None,
        size: tuple[int, int] = (720, 900),
        margin: float = 0.04,
    ) -> Turntable:
        """The turntable for the angles that will be shown.

        Args:
            mesh: The head.
            angles: (N,) degrees that it will be turned by.
            view: As for `camera_for`, of the whole head: the view at angle 0.
            poses: (..., V, 3) positions that must all fit; those of the mesh by default.
            size: Width and height of the picture in pixels.
            margin: Empty border, as a fraction of the picture.

        Raises:
            ParameterError: No such view, or a close-up.
        """
        if isinstance(view, str) and view in CLOSE_UPS:
            raise ParameterError(
                f"a turntable shows the whole head, so it cannot start with the close-up {view!r}; "
                "take front, three-quarter, side, below or degrees such as 30,10"
            )
        seen = head_points(mesh, poses)
        x, _, z = (seen[0].min(axis=0) + seen[0].max(axis=0)) / 2
        turns = np.asarray(angles, dtype=np.float64)
        framed = turns[np.linspace(0, len(turns) - 1, min(len(turns), _MOST_FRAMED)).astype(int)]
        corners = _outermost(seen.reshape(-1, 3))
        axis = (float(x), float(z))
        cloud = np.stack([_turned(corners, angle, axis) for angle in framed.tolist()])
        return cls(Camera.framing(cloud, view, size=size, margin=margin), axis)

    def turned(self, positions: NDArray[np.float64], degrees: float) -> NDArray[np.float64]:
        """Positions seen by `camera` as by one that went round the head to the face's left.

        Args:
            positions: (V, 3).
            degrees: How far it went.
        """
        return _turned(positions, degrees, self.axis)


def turn_angles(count: int, degrees: float = FULL_TURN) -> NDArray[np.float64]:
    """Degrees of each frame of a turn.

    Whole turns leave out their last angle, which is the first again, so a loop does not stop
    there. Other turns end at their last angle.

    Args:
        count: Number of frames, at least 1.
        degrees: The whole turn; negative ones go to the face's right.

    Returns:
        (count,) from 0.

    Raises:
        ParameterError: No frames, or an angle that is 0 or not finite.
    """
    if count < 1:
        raise ParameterError(f"a turn needs at least 1 frame, found {count}")
    if not np.isfinite(degrees) or degrees == 0:
        raise ParameterError(f"a turn needs an angle other than 0, found {degrees:g} degrees")
    whole = degrees % FULL_TURN == 0
    return np.linspace(0.0, degrees, count, endpoint=not whole)


def _turned(
    positions: NDArray[np.float64], degrees: float, axis: tuple[float, float]
) -> NDArray[np.float64]:
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    x, z = positions[:, 0] - axis[0], positions[:, 2] - axis[1]
    turned = positions.copy()
    turned[:, 0] = axis[0] + cosine * x - sine * z
    turned[:, 2] = axis[1] + sine * x + cosine * z
    return turned


def _outermost(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """The corners of the convex hull: whatever sees them sees all points."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        return np.asarray(points[ConvexHull(points).vertices])
    except QhullError:  # flat, or too few: all of them are as good, only slower
        return points
