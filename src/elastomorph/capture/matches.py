"""Points of two poses that show the same skin, found by their descriptors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]

# Rows of products that are held at once.
_ROWS = 2000
# The next best descriptor must be this much farther off.
_RATIO = 0.85
# Neighbours that a match is compared with, and how far off their middle it may be in units of
# their own spread and in parts of the cloud's extent.
_NEIGHBOURS, _OUTLIER, _SLACK = 10, 5.0, 0.006


@dataclass(frozen=True, eq=False)
class Matches:
    """Points of the neutral's skin and where the same skin is in a pose.

    Attributes:
        neutral: (N, 3) in the frame of the neutral.
        pose: (N, 3) in the same frame.
    """

    neutral: Points
    pose: Points

    def __len__(self) -> int:
        return len(self.neutral)

    def chosen(self, which: NDArray[np.bool_]) -> Matches:
        """Some of them."""
        return Matches(self.neutral[which], self.pose[which])


def matched(neutral: NDArray[np.float32], pose: NDArray[np.float32]) -> NDArray[np.int64]:
    """(M, 2) pairs of like descriptors, each the other's nearest and clearly so.

    Args:
        neutral: (N, C) of length 1.
        pose: (P, C) of length 1.
    """
    if min(len(neutral), len(pose)) < 2:
        return np.zeros((0, 2), dtype=np.int64)
    there, clear = _nearest(neutral, pose)
    back, clear_back = _nearest(pose, neutral)
    own = np.arange(len(neutral))
    kept = clear & clear_back[there] & (back[there] == own)
    return np.stack([own[kept], there[kept]], axis=1)


def _nearest(
    asked: NDArray[np.float32], among: NDArray[np.float32]
) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """The nearest of others to each descriptor, and whether the next one is clearly farther."""
    nearest, clear = [], []
    for rows in np.array_split(asked, len(asked) // _ROWS + 1):
        products = rows @ among.T
        best = products.argmax(axis=1)
        first = np.take_along_axis(products, best[:, None], axis=1)[:, 0]
        np.put_along_axis(products, best[:, None], -1.0, axis=1)
        second = products.max(axis=1)
        nearest.append(best)
        clear.append((1 - first) < _RATIO**2 * (1 - second))
    return np.concatenate(nearest).astype(np.int64), np.concatenate(clear)


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
