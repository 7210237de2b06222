"""The lips and the mouth bag: loops from the red border inwards.

Around the mouth the half loops of :data:`layout.MOUTH` have 19 vertices: 9 steps from the middle
of the upper lip to the corner, 9 more back to the middle of the lower lip.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sculptor.anatomy import MOUTH_HEIGHT, MOUTH_WIDTH, skin
from sculptor.implicit import Points, cast

__all__ = ["BORDER", "CONTACT", "CORNER", "STEPS", "lip_rings", "skin_depth"]

STEPS = 9
CORNER = 9  # place in a half ring
BORDER = 4  # ring where the red of the lips begins
CONTACT = 7  # ring where the lips meet
_GAP = 0.003  # half the slit between closed lips

# Mouth bag behind the contact ring: height above, height below, depth, width, all in cm.
_BAG = (
    (0.05, 0.05, 0.40, 2.38),
    (0.75, 0.80, 0.62, 2.45),
    (1.75, 1.85, 0.85, 2.95),
    (2.00, 2.15, 2.20, 3.45),
    (1.80, 2.00, 4.20, 3.30),
    (1.10, 1.20, 6.40, 2.10),
)


def skin_depth(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """z of the skin, without lips, seen from the front.

    Args:
        x: Any shape.
        y: The same shape.
    """
    start = np.stack([x.ravel(), y.ravel(), np.full(x.size, 16.0)], axis=1)
    return cast(skin, start, start * [1.0, 1.0, 0.0])[:, 2].reshape(x.shape)


def _outline(across: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
    """Heights of the lip line, the upper and the lower red border.

    Args:
        across: (N,) 0 at the midline, 1 at the corner.
    """
    line = MOUTH_HEIGHT - 0.05 * np.exp(-((across / 0.25) ** 2)) + 0.17 * across**3
    bow = 0.15 * np.exp(-((across / 0.13) ** 2))
    upper = line + 0.80 * (1.0 - across**1.9) ** 0.95 - bow + 0.05
    lower = line - 0.92 * (1.0 - across**2.3) ** 0.85
    return line, upper, lower


def lip_rings() -> Points:
    """The loops from just outside the red border to the back of the mouth bag.

    Returns:
        (11, 19, 3) for the left half: rings 3 … 13 of the layout.
    """
    step = np.arange(STEPS + 1) / STEPS
    across = np.sin(0.5 * np.pi * step) ** 1.08
    line, *borders = _outline(across)
    x = MOUTH_WIDTH * across
    full = (1.0 - across**2.2) ** 0.8
    wide = across**6
    sign = np.array([[1.0], [-1.0]])  # the upper and the lower lip
    swell = np.array([[0.34], [0.44]])
    border = np.array(borders)
    height = border - line

    # from the skin to the inner roll: x, y and how far in front of the skin, each (4, 2, 10)
    lip_x = x + np.array([0.42, 0.16, 0.06, 0.02])[:, None, None] * wide + 0.0 * border
    lip_y = np.array(
        [
            border + sign * 0.27 * (1.0 - wide),
            border,
            line + 0.55 * height,
            line + 0.16 * height,
        ]
    )
    out = np.array(
        [
            0.02 * full + 0.0 * border,
            0.13 * full + 0.0 * border,
            swell * full,
            (swell - 0.04) * full - 0.05 * wide,
        ]
    )
    bag_x = np.array(_BAG)[:, 3, None] * across
    depths = skin_depth(
        np.concatenate([lip_x.ravel(), x, bag_x.ravel()]),
        np.concatenate([lip_y.ravel(), line, np.tile(line, len(_BAG))]),
    )
    lip_z, line_z, bag_z = np.split(depths, [lip_x.size, lip_x.size + x.size])
    gap = np.where(step < 1.0, _GAP, 0.0)
    contact_z = line_z - 0.10 - 0.16 * across**4

    rings = np.empty((11, 2 * STEPS + 1, 3))
    lips = np.stack([lip_x, lip_y, lip_z.reshape(lip_x.shape) + out], axis=3)
    for lip, order in enumerate((slice(0, STEPS + 1), slice(2 * STEPS, STEPS - 1, -1))):
        way = float(sign[lip, 0])
        rings[:4, order] = lips[:, lip]
        rings[4, order] = np.stack([x, line + way * gap, contact_z], axis=1)
        for ring, entry in enumerate(_BAG):
            opening = way * entry[lip] * (1.0 - across**3)
            z = np.minimum(contact_z, bag_z.reshape(bag_x.shape)[ring]) - entry[2]
            rings[5 + ring, order] = np.stack([bag_x[ring], line + opening, z], axis=1)
    return rings
