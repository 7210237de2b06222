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
CONTACT = 9  # ring where the lips meet
_GAP = 0.003  # half the slit between closed lips

# Mouth bag behind the contact ring: height above and below, behind the skin or the contact
# where that is less, and width, all in cm.
_BAG = (
    (0.32, 0.34, 0.30, 2.40),
    (1.50, 1.32, 0.36, 2.85),
    (2.05, 2.20, 2.40, 3.45),
    (1.10, 1.20, 6.40, 2.10),
)
# The red of a lip from its border to the inner roll: share of the border's height over the line,
# and how far in front of the skin, upper and lower lip; then how far aside at the corner.
_RED = (
    (1.00, 0.12, 0.11, 0.16),
    (0.80, 0.27, 0.31, 0.12),
    (0.54, 0.37, 0.45, 0.09),
    (0.28, 0.34, 0.44, 0.06),
    (0.09, 0.17, 0.25, 0.03),
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
    height = np.array(borders) - line
    skirt = np.broadcast_to(x + 0.34 * wide, height.shape)

    # from the skin to the inner roll: x, y and how far in front of the skin, each (6, 2, 10)
    share, *swell, aside = np.array(_RED).T
    lip_x = np.stack([skirt, *(np.broadcast_to(x + a * wide, height.shape) for a in aside)])
    lip_y = np.stack(
        [line + height + sign * 0.27 * (1.0 - wide), *(line + height * a for a in share)]
    )
    out = np.array(swell).T[:, :, None] * full - 0.05 * ((1.0 - share) ** 2)[:, None, None] * wide
    out = np.concatenate([np.broadcast_to(0.02 * full, out.shape[1:])[None], out])
    bag = np.array(_BAG)[..., None]  # (4, 4, 1)
    bag_x = np.broadcast_to((bag[:, 3] * across)[:, None], (len(bag), *height.shape))
    bag_y = line + sign * bag[:, :2] * (1.0 - across**3)
    depths = skin_depth(
        np.concatenate([lip_x.ravel(), x, bag_x.ravel()]),
        np.concatenate([lip_y.ravel(), line, bag_y.ravel()]),
    )
    lip_z, line_z, bag_z = np.split(depths, [lip_x.size, lip_x.size + x.size])
    gap = np.where(step < 1.0, _GAP, 0.0)
    contact_z = line_z - 0.10 - 0.16 * across**4
    bag_z = np.minimum(contact_z, bag_z.reshape(bag_x.shape)) - bag[:, 2, None]

    lips = np.stack([lip_x, lip_y, lip_z.reshape(lip_x.shape) + out], axis=3)
    inner = len(lips)  # the ring where the lips meet
    rings = np.empty((inner + 1 + len(_BAG), 2 * STEPS + 1, 3))
    for lip, order in enumerate((slice(0, STEPS + 1), slice(2 * STEPS, STEPS - 1, -1))):
        rings[:inner, order] = lips[:, lip]
        rings[inner, order] = np.stack([x, line + sign[lip] * gap, contact_z], axis=1)
        rings[inner + 1 :, order] = np.stack([bag_x, bag_y, bag_z], axis=3)[:, lip]
    return rings
