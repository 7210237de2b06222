"""The sculpture: skull, face and neck as volumes that melt into each other.

Centimetres; x to the character's left, +Y up, +Z out of the face. The eyes are at y = 0, the ear
canals near z = 0.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sculptor.implicit import Points, capsule, ellipsoid, melt, melt_away

__all__ = [
    "EYE_CENTRE",
    "EYE_RADIUS",
    "JAW_AXIS",
    "LID_THICKNESS",
    "MOUTH_HEIGHT",
    "MOUTH_WIDTH",
    "bump",
    "skin",
]

EYE_CENTRE = np.array([3.15, 0.0, 6.92])
EYE_RADIUS = 1.6
LID_THICKNESS = 0.15
MOUTH_HEIGHT = -7.1  # of the lip line
MOUTH_WIDTH = 2.45  # from the midline to a corner
JAW_AXIS = np.array([0.0, -0.9, 1.2])  # a point of the hinge, which runs along x

for _fixed in (EYE_CENTRE, JAW_AXIS):
    _fixed.flags.writeable = False


def bump(offset: Points, width: tuple[float, ...] | float) -> NDArray[np.float64]:
    """A Gaussian hill: 1 at no offset, 0.61 one width away.

    Args:
        offset: (N, d) from the top of the hill.
        width: Standard deviation along each of the d axes.
    """
    scaled = np.asarray(offset) / np.asarray(width)
    hill: NDArray[np.float64] = np.exp(-0.5 * np.einsum("...i,...i->...", scaled, scaled))
    return hill


def skin(points: Points) -> NDArray[np.float64]:
    """The head's volume without ears, nostrils and lips; negative inside.

    Args:
        points: (N, 3) with x ≥ 0.
    """
    p = points.copy()
    p[:, 0] = np.sqrt(points[:, 0] ** 2 + 0.09)  # the two halves melt across the midline
    body = melt(_skull(p), _neck(p), 2.6)
    body = melt(body, _jaw(p), 1.1)
    body = melt(body, capsule(p, (1.3, 1.55, 8.3), (4.9, 1.75, 6.2), (0.85, 0.6)), 1.1)
    body = melt_away(body, ellipsoid(p, (3.3, -0.2, 9.75), (2.1, 1.4, 2.5)), 1.2)
    body = melt(body, ellipsoid(p, (4.5, -2.4, 5.0), (1.75, 1.5, 2.2)), 1.8)
    lids = np.linalg.norm(p - EYE_CENTRE, axis=1) - (EYE_RADIUS + LID_THICKNESS + 0.04)
    body = melt(body, lids, 0.55)
    return _nose(p, body) - _relief(p)


def _relief(p: Points) -> Points:
    """Height of fine forms over the face, in cm: ridges under the nose, the fold of the chin."""
    front = np.clip((p[:, 2] - 7.0) / 2.0, 0.0, 1.0)
    ridge = 0.08 * bump(p[:, :2] - [0.52, -5.7], (0.2, 0.42))
    groove = -0.07 * bump(p[:, :2] - [0.3, -5.75], (0.16, 0.42))  # x is at least 0.3 here
    fold = -0.16 * bump(p[:, :2] - [0.3, -8.6], (1.3, 0.32))
    relief: Points = front * (ridge + groove + fold)
    return relief


def _skull(p: Points) -> Points:
    cranium = ellipsoid(p, (0.0, 3.65, -0.8), (7.3, 7.6, 8.8))
    forehead = ellipsoid(p, (0.0, 3.6, 2.6), (6.3, 6.4, 6.9))
    temples = ellipsoid(p, (0.0, -0.5, 1.2), (6.7, 6.0, 6.0))
    face = ellipsoid(p, (0.0, -3.2, 2.6), (6.0, 8.0, 6.7))
    return melt(melt(melt(cranium, forehead, 1.5), temples, 1.5), face, 1.6)


def _jaw(p: Points) -> Points:
    mandible = capsule(p, (4.25, -6.8, 1.2), (1.25, -9.55, 7.2), (1.25, 1.38))
    ramus = capsule(p, (5.0, -2.0, 1.0), (4.35, -6.4, 1.1), (1.2, 1.25))
    chin = ellipsoid(p, (0.0, -9.95, 8.2), (1.85, 1.5, 1.7))
    muzzle = ellipsoid(p, (0.0, -6.5, 6.3), (3.5, 2.9, 3.9))
    floor = ellipsoid(p, (0.0, -8.4, 4.0), (3.6, 1.9, 5.0))
    jaw = melt(melt(mandible, ramus, 1.0), floor, 1.5)
    return melt(melt(jaw, chin, 1.5), muzzle, 1.2)


def _neck(p: Points) -> Points:
    column = capsule(p, (0.0, -5.0, -1.4), (0.0, -20.0, -3.4), (4.55, 5.0))
    shoulder = capsule(p, (2.0, -21.5, -4.0), (9.0, -22.5, -4.0), (3.6, 2.5))
    strap = capsule(p, (4.6, -5.0, -2.2), (1.3, -18.5, 1.3), (0.9, 0.75))
    return melt(melt(column, strap, 1.2), shoulder, 4.0)


def _nose(p: Points, body: Points) -> Points:
    bridge = capsule(p, (0.0, 0.7, 8.2), (0.0, -3.5, 10.7), (0.62, 0.78))
    tip = ellipsoid(p, (0.0, -3.95, 10.9), (0.92, 0.8, 0.95))
    wing = ellipsoid(p, (1.08, -4.1, 9.8), (0.72, 0.62, 0.95))
    pillar = capsule(p, (0.0, -4.35, 10.6), (0.0, -4.95, 9.6), (0.42, 0.5))
    nose = melt(melt(melt(bridge, tip, 0.7), wing, 0.4), pillar, 0.4)
    return melt(body, nose, 0.32)
