"""Meshes small enough to see what becomes of each vertex."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.mesh import Mesh

__all__ = ["grid"]


def grid(
    columns: int,
    rows: int,
    height: Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]] | None = None,
) -> Mesh:
    """Quads between columns × rows vertices at whole x and y, numbered row by row.

    They lie at z = 0, or at a height that depends on x and y.
    """
    y, x = (axis.ravel() for axis in np.mgrid[0.0:rows, 0.0:columns])
    corner = np.arange(rows * columns).reshape(rows, columns)[:-1, :-1].reshape(-1, 1)
    z = 0.0 * x if height is None else height(x, y)
    return Mesh(np.stack([x, y, z], axis=1), corner + [0, 1, columns + 1, columns])
