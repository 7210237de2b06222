"""Implicit volumes: ellipsoids and capsules that melt into each other, and rays that find them.

A volume is a function of (N, 3) points that is negative inside, positive outside and close to
the distance near its surface.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

__all__ = ["Field", "Points", "capsule", "cast", "ellipsoid", "melt", "melt_away", "settle"]

Points = NDArray[np.float64]
Field = Callable[[Points], NDArray[np.float64]]


def ellipsoid(points: Points, centre: tuple[float, ...], radii: tuple[float, ...]) -> Points:
    """Approximate signed distance to an axis-aligned ellipsoid.

    Args:
        points: (N, 3).
        centre: Its centre.
        radii: Its three half axes.
    """
    offset = (points - np.array(centre)) / np.array(radii)
    level = np.sqrt(np.einsum("ij,ij->i", offset, offset)) + 1e-12
    slope = offset / np.array(radii)
    distance: Points = level * (level - 1.0) / np.sqrt(np.einsum("ij,ij->i", slope, slope) + 1e-12)
    return distance


def capsule(
    points: Points,
    start: tuple[float, ...],
    end: tuple[float, ...],
    radii: tuple[float, float],
) -> Points:
    """Signed distance to a segment thickened by a radius that runs from one end to the other.

    Args:
        points: (N, 3).
        start: One end of the segment.
        end: The other end.
        radii: Thickness at the two ends.
    """
    along = np.array(end) - np.array(start)
    offset = points - np.array(start)
    place = np.clip(offset @ along / (along @ along), 0.0, 1.0)
    nearest = offset - place[:, None] * along
    distance: Points = np.sqrt(np.einsum("ij,ij->i", nearest, nearest)) - (
        radii[0] + (radii[1] - radii[0]) * place
    )
    return distance


def melt(first: Points, second: Points, width: float) -> Points:
    """Union of two volumes whose seam is rounded over a width (a polynomial smooth minimum)."""
    mix = np.clip(0.5 + 0.5 * (second - first) / width, 0.0, 1.0)
    joined: Points = second + (first - second) * mix - width * mix * (1.0 - mix)
    return joined


def melt_away(body: Points, tool: Points, width: float) -> Points:
    """The body without the tool, with a rounded edge."""
    return -melt(-body, tool, width)


def cast(field: Field, start: Points, end: Points, steps: int = 40) -> Points:
    """The first points of a volume that rays meet on their way from start to end.

    Args:
        field: The volume.
        start: (N, 3) points outside.
        end: (N, 3) points inside.
        steps: Steps of sphere tracing.

    Returns:
        (N, 3) points on the surface; ``end`` where a ray never meets it.
    """
    way = end - start
    length = np.sqrt(np.einsum("ij,ij->i", way, way))
    way = way / length[:, None]
    travelled = np.zeros(len(start))
    for _ in range(steps):
        travelled += 0.85 * field(start + travelled[:, None] * way)
        np.clip(travelled, 0.0, length, out=travelled)
    met: Points = start + travelled[:, None] * way
    return met


def settle(field: Field, points: Points, steps: int = 2) -> Points:
    """Points moved along the gradient of a volume onto its surface (Newton steps)."""
    reach = 1e-4
    for _ in range(steps):
        value = field(points)
        gradient = np.stack(
            [(field(points + reach * axis) - value) / reach for axis in np.eye(3)], axis=1
        )
        size = np.maximum(np.einsum("ij,ij->i", gradient, gradient), 0.05)
        points = points - np.clip(value / size, -0.6, 0.6)[:, None] * gradient
    return points
