"""One sparse factorisation for many right-hand sides."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

__all__ = ["factored"]


def factored(
    ends: NDArray[np.integer], weights: NDArray[np.float64], diagonal: NDArray[np.float64]
) -> Callable[[NDArray[np.float64]], NDArray[np.float64]]:
    """The inverse of the symmetric matrix with -w off its diagonal at every edge.

    Args:
        ends: (E, 2) rows that an edge joins, each pair once.
        weights: (E,) w ≥ 0.
        diagonal: (N,) more than the sum of the weights at a row.
    """
    from scipy.sparse import coo_array, csc_array
    from scipy.sparse.linalg import splu

    here = np.arange(len(diagonal))
    rows = np.concatenate([ends[:, 0], ends[:, 1], here])
    columns = np.concatenate([ends[:, 1], ends[:, 0], here])
    entries = np.concatenate([-weights, -weights, diagonal])
    matrix = csc_array(coo_array((entries, (rows, columns)), shape=(len(diagonal),) * 2))
    return splu(
        matrix,
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    ).solve
