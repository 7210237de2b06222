"""Rigid motion between two positions of the same points, and the screw it follows in between."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Screw", "fit_rigid"]


@dataclass(frozen=True, eq=False)
class Screw:
    """A turn about an axis and a slide along it.

    Attributes:
        axis: (3,) unit vector.
        angle: Turn about the axis, radians from 0 to π.
        centre: (3,) a point on the axis.
        slide: Distance moved along the axis.
    """

    axis: NDArray[np.float64]
    angle: float
    centre: NDArray[np.float64]
    slide: float

    def at(self, part: float, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) the points after a part of the motion: 0 none, 1 all of it."""
        arms = points - self.centre
        angle = part * self.angle
        along = arms @ self.axis
        turned = (
            np.cos(angle) * arms
            + np.sin(angle) * np.cross(self.axis, arms)
            + ((1.0 - np.cos(angle)) * along)[:, None] * self.axis
        )
        return np.asarray(self.centre + turned + part * self.slide * self.axis)


def fit_rigid(
    start: NDArray[np.float64], end: NDArray[np.float64]
) -> tuple[Screw, NDArray[np.float64]]:
    """The rigid motion nearest to a motion of points in least squares (Kabsch, Chasles).

    Args:
        start: (N, 3) positions before, not all on one line.
        end: (N, 3) positions after.

    Returns:
        The screw, and (N,) the distance of each end point from where the screw leads.
    """
    start_mean, end_mean = start.mean(axis=0), end.mean(axis=0)
    left, _, right = np.linalg.svd((start - start_mean).T @ (end - end_mean))
    mirror = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    rotation = (left @ mirror @ right).T
    screw = _screw(rotation, end_mean - rotation @ start_mean, start_mean)
    return screw, np.linalg.norm(screw.at(1.0, start) - end, axis=1)


def _screw(
    rotation: NDArray[np.float64], offset: NDArray[np.float64], near: NDArray[np.float64]
) -> Screw:
    """The screw of x → rotation x + offset; its centre is the point of the axis nearest to one."""
    skew = (rotation - rotation.T) / 2.0
    sine_axis = np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
    cosine = (np.trace(rotation) - 1.0) / 2.0
    angle = float(np.arctan2(np.linalg.norm(sine_axis), cosine))
    moved = rotation @ near + offset - near
    if angle < 1e-9:
        slide = float(np.linalg.norm(moved))
        axis = moved / slide if slide > 0 else np.array([0.0, 0.0, 1.0])
        return Screw(axis, 0.0, near, slide)
    # At half a turn the antisymmetric part vanishes, the symmetric part keeps the axis.
    symmetric = (rotation + rotation.T) / 2.0 - cosine * np.eye(3)
    column = symmetric[:, int(np.argmax(np.diag(symmetric)))]
    axis = column / np.linalg.norm(column)
    if axis @ sine_axis < 0:
        axis = -axis
    slide = float(axis @ moved)
    across = moved - slide * axis
    # In the plane across the axis, (I - R) arm = across: half the chord, and its right angle.
    arm = across / 2.0 + np.cross(axis, across) / (2.0 * np.tan(angle / 2.0))
    return Screw(axis, angle, near + arm, slide)
