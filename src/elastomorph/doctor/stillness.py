"""The rigid motion of what should be still: fitted to chosen vertices, or to the stillest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.rigid import Screw, fit_rigid

__all__ = ["QUARTER", "steady_motion", "stillest_quarter", "without_motion"]

QUARTER = 0.25
"""Part of a face that no expression moves: skull, back of the head, a good part of the brow."""

_ROUNDS = 60
# Vertices are weighed by (r² + s²)^(-3/4), which lets the many that agree outvote the few that
# move far; s falls from the size of the motion to that of noise.
_FALL = 0.8
_SAMPLE = 6000


def stillest_quarter(before: NDArray[np.float64], after: NDArray[np.float64]) -> float:
    """How far the stillest quarter of the vertices moves at most."""
    return float(np.quantile(np.linalg.norm(after - before, axis=1), QUARTER))


def without_motion(points: NDArray[np.float64], motion: Screw) -> NDArray[np.float64]:
    """(N, 3) points before a motion that ended where they are."""
    back = Screw(motion.axis, -motion.angle, motion.centre, -motion.slide)
    return back.at(1.0, points)


def steady_motion(before: NDArray[np.float64], after: NDArray[np.float64], noise: float) -> Screw:
    """The rigid motion that as many vertices as possible follow.

    Least squares reweighted so that Σ (r² + s²)^(1/4) of the distances r left over falls; s goes
    down from the median motion to the noise.

    Args:
        before: (N, 3) positions in the neutral.
        after: (N, 3) in the target.
        noise: Distance up to which vertices agree.
    """
    if len(before) > _SAMPLE:
        step = -(-len(before) // _SAMPLE)
        before, after = before[::step], after[::step]
    rotation, offset = _weighted(before, after, np.ones(len(before)))
    left = np.linalg.norm(before @ rotation.T + offset - after, axis=1)
    soft = max(float(np.median(left)), noise)
    for _ in range(_ROUNDS):
        weights = (left**2 + soft**2) ** -0.75
        rotation, offset = _weighted(before, after, weights / weights.max())
        left = np.linalg.norm(before @ rotation.T + offset - after, axis=1)
        if soft == noise:
            break
        soft = max(_FALL * soft, noise)
    return fit_rigid(before, before @ rotation.T + offset)[0]


def _weighted(
    before: NDArray[np.float64], after: NDArray[np.float64], weights: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Rotation and offset of the nearest rigid motion in weighted least squares (Kabsch)."""
    weights = weights / weights.sum()
    mine, their = weights @ before, weights @ after
    products = (before - mine).T @ ((after - their) * weights[:, None])
    left, _, right = np.linalg.svd(products)
    mirror = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    rotation = (left @ mirror @ right).T
    return rotation, their - rotation @ mine
