"""Points of two poses that show the same skin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.table import Table

Points = NDArray[np.float64]

# Neighbours that a match is compared with, and how far off their middle it may be in units of
# their own spread and in parts of the cloud's extent.
_NEIGHBOURS, _OUTLIER, _SLACK = 10, 5.0, 0.006


@dataclass(frozen=True, eq=False)
class Matches(Table):
    """Points of the neutral's skin and where the same skin is in a pose.

    Attributes:
        neutral: (N, 3) in the frame of the neutral.
        pose: (N, 3) in the same frame.
    """

    neutral: Points
    pose: Points


def consistent(matches: Matches, expected: Points, extent: float) -> NDArray[np.bool_]:
    """Which matches move as those around them do, beside what is expected of each.

    Args:
        matches: of which some are wrong.
        expected: (N, 3) where the pose is thought to have the points.
        extent: of the face, in the units of the points.
    """
    from scipy.spatial import cKDTree

    off = matches.pose - expected
    kept = np.ones(len(off), dtype=bool)
    for _ in range(3):
        if np.count_nonzero(kept) <= _NEIGHBOURS:
            return kept
        tree = cKDTree(matches.neutral[kept])
        _, near = tree.query(matches.neutral, k=_NEIGHBOURS + 1)
        around = off[kept][near]
        middle = np.median(around, axis=1)
        spread = np.median(np.linalg.norm(around - middle[:, None], axis=2), axis=1)
        far = np.linalg.norm(off - middle, axis=1)
        kept = far < _OUTLIER * spread + _SLACK * extent
    return kept
