"""Normals of polygons of any size, flat or not."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.polygons import Polygons

__all__ = ["polygon_normals"]


def polygon_normals(vertices: NDArray[np.float64], faces: Polygons) -> NDArray[np.float64]:
    """Area-weighted normals: n = ½ Σ_c p_c × p_{c+1} over the corners c (Newell).

    Args:
        vertices: (V, 3) positions.
        faces: Polygons of three or more vertices, flat or not.

    Returns:
        (F, 3) normals, as long as the area of the polygon projected along them.
    """
    if not len(faces):
        return np.zeros((0, 3))
    corners = vertices[faces.indices]
    # Counted from a corner of the polygon, so that a face far from the origin loses no digits.
    corners -= corners[faces.offsets[:-1]][faces.corner_faces]
    x, y, z = corners.T
    x1, y1, z1 = corners[faces.next_corners].T
    crossed = np.stack([y * z1 - z * y1, z * x1 - x * z1, x * y1 - y * x1], axis=1)
    return 0.5 * np.add.reduceat(crossed, faces.offsets[:-1], axis=0)
