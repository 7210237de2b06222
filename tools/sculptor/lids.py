"""The eyelids: loops laid on spheres around the eyeball, so that a lid can sweep over it.

Around one eye the loops of :data:`layout.EYE` have 26 vertices: 13 steps along the upper lid from
the inner to the outer corner, then 13 back along the lower lid.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sculptor.anatomy import EYE_CENTRE, EYE_RADIUS, LID_THICKNESS
from sculptor.implicit import Points

__all__ = [
    "CLEARANCE",
    "CREASE",
    "INNER_CORNER",
    "MARGIN",
    "OUTER_CORNER",
    "STEPS",
    "lid_rings",
    "place",
    "spherical",
]

INNER_CORNER = 24  # place in a ring
OUTER_CORNER = 11
STEPS = 13  # along each lid
CREASE = 4  # ring where the lid folds under the brow
MARGIN = 6  # ring of the lid's outer edge; the next one is its inner edge
CLEARANCE = 0.03  # between the eyeball and the inner face of a lid


def place(step: int, upper: bool) -> int:
    """Place in a ring of a step (0 … 13) along a lid, counted from the inner corner."""
    return (INNER_CORNER + step if upper else INNER_CORNER - step) % (2 * STEPS)


def spherical(
    azimuth: NDArray[np.float64], elevation: NDArray[np.float64], radius: float
) -> Points:
    """Points around the left eyeball's centre.

    Args:
        azimuth: (N,) degrees from straight ahead towards the temple.
        elevation: (N,) degrees upwards.
        radius: Distance from the centre.
    """
    a, e = np.radians(azimuth), np.radians(elevation)
    direction = np.stack([np.cos(e) * np.sin(a), np.sin(e), np.cos(e) * np.cos(a)], axis=1)
    points: Points = EYE_CENTRE + radius * direction
    return points


def _opening(upper: bool) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Azimuth and elevation, in degrees, of a lid's edge at its steps."""
    share = np.linspace(0.0, 1.0, STEPS + 1)
    azimuth = -57.0 + 119.0 * share
    corners = -5.0 + 8.0 * share
    if upper:
        return azimuth, corners + 21.5 * np.sin(np.pi * share**0.9) ** 0.8
    return azimuth, corners - 18.5 * np.sin(np.pi * share**1.15) ** 0.9


def lid_rings() -> Points:
    """The loops from the crease to the inner end of the lids.

    Returns:
        (6, 26, 3) for the left eye: rings 4 … 9 of the layout.
    """
    rings = np.empty((6, 2 * STEPS, 3))
    share = np.linspace(0.0, 1.0, STEPS + 1)
    belly = np.sin(np.pi * share) ** 0.7
    end = (2.0 * share - 1.0) ** 7  # at the corners the loops part sideways, elsewhere up and down
    apart = 1.0 - np.abs(end)
    outside = EYE_RADIUS + LID_THICKNESS
    inside = EYE_RADIUS + CLEARANCE
    for upper in (True, False):
        azimuth, edge = _opening(upper)
        sign = 1.0 if upper else -1.0
        fold = 4.0 + (15.0 if upper else 13.0) * belly
        # radius, degrees away from the opening between the corners, and degrees at the corners
        loops: tuple[tuple[float, float | NDArray[np.float64], float], ...] = (
            (outside - 0.01, fold, 9.0),
            (outside + 0.03, 0.5 * fold, 4.0),
            (outside - 0.02, 0.8, 0.8),
            (inside, 0.0, 0.0),
            (inside, 2.0 + 14.0 * belly, 2.0),
            (inside, 3.0 + 30.0 * belly, 5.0),
        )
        order = [place(step, upper) for step in range(STEPS + 1)]
        for ring, (radius, away, aside) in enumerate(loops):
            rings[ring, order] = spherical(
                azimuth + aside * end, edge + sign * away * apart, radius
            )
    return rings
