"""What the joints of a skeleton do to the vertices they hold (linear blend skinning), at rest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_ALIKE = 1e-4  # single precision, through a chain of joints


def common_matrix(held: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """The (4, 4) matrix that (J, 4, 4) all are to rounding, exactly the unit where they are that.

    None where they differ.
    """
    unit = np.eye(4)
    apart = _ALIKE * max(float(np.abs(held[0]).max()), 1e-30)
    if not np.abs(held - held[0]).max() <= apart:
        return None
    return unit if np.abs(held[0] - unit).max() <= apart else held[0]


def blended_matrices(
    held: NDArray[np.float64], joints: NDArray[np.int64], weights: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(N, 4, 4) of vertices that (N, K) joints hold with these weights; (J, 4, 4) one a joint."""
    matrices = np.zeros((len(joints), 4, 4))
    for joint, weight in zip(joints.T, weights.T, strict=True):
        matrices += weight[:, None, None] * held[joint]
    return matrices
