"""The eyeballs: spheres with loops at the pupil and the iris."""

from __future__ import annotations

import numpy as np

from sculptor import groups
from sculptor.anatomy import EYE_CENTRE, EYE_RADIUS
from sculptor.implicit import Points

__all__ = ["eyeball"]

_SECTORS = 24
# Angle of each loop from the line of sight, in degrees: pupil, iris, then the white.
_LOOPS = (5.0, 9.5, 12.0, 17.0, 22.5, 24.5, 40.0, 58.0, 78.0, 100.0, 125.0, 155.0)
_PUPIL, _IRIS = 2, 5  # cells up to these loops


def eyeball(side: str) -> tuple[Points, list[list[int]], list[str]]:
    """The left eyeball, with the group names of one side.

    Args:
        side: "L" or "R".

    Returns:
        (N, 3) vertices, polygons counter-clockwise seen from outside, and a group for each.
    """
    turn = 2.0 * np.pi * np.arange(_SECTORS) / _SECTORS
    vertices = [[0.0, 0.0, 1.0]]
    for angle in np.radians(_LOOPS):
        vertices += [
            [np.sin(angle) * np.cos(t), np.sin(angle) * np.sin(t), np.cos(angle)] for t in turn
        ]
    vertices.append([0.0, 0.0, -1.0])
    faces: list[list[int]] = []
    names: list[str] = []
    back = len(vertices) - 1
    last = back - _SECTORS
    for k in range(0, _SECTORS, 2):  # pairs of sectors: quads up to the pole
        a, b, c = 1 + k, 2 + k, 1 + (k + 2) % _SECTORS
        faces.append([0, a, b, c])
        names.append(groups.PUPILS[side])
    for loop in range(len(_LOOPS) - 1):
        group = groups.EYES if loop >= _IRIS else groups.IRISES if loop >= _PUPIL else groups.PUPILS
        for k in range(_SECTORS):
            near, far = 1 + loop * _SECTORS, 1 + (loop + 1) * _SECTORS
            n = (k + 1) % _SECTORS
            faces.append([near + k, far + k, far + n, near + n])
            names.append(group[side])
    for k in range(0, _SECTORS, 2):
        a, b, c = last + k, last + k + 1, last + (k + 2) % _SECTORS
        faces.append([back, c, b, a])
        names.append(groups.EYES[side])
    return EYE_CENTRE + EYE_RADIUS * np.array(vertices), faces, names
