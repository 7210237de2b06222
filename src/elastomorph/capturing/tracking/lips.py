"""Where skin touches other skin: lips that are closed, lids.

Upper and lower lip are two surfaces that meet where no photograph looks. No landmark and no name
tells them apart here, only the mesh: vertices that are close in space and far along the surface.
It is the same for a mouth that is a slit with an open border and for one that leads into a bag.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.surface import Surface

Points = NDArray[np.float64]

# Times the distance in space that the way along the surface is longer.
_DETOUR = 4.0
# Vertices whose ways along the surface are held at once.
_ROWS = 256


def touching(surface: Surface, reach: float) -> NDArray[np.bool_]:
    """(V,) vertices within `reach` of a part of the surface that is far from them along it.

    What is matched there by its place alone may belong to either side.
    """
    from scipy.sparse.csgraph import dijkstra
    from scipy.spatial import cKDTree

    vertices = surface.vertices
    found = np.zeros(len(vertices), dtype=bool)
    pairs = cKDTree(vertices).query_pairs(reach, output_type="ndarray")
    facing = np.einsum("ij,ij->i", surface.normals[pairs[:, 0]], surface.normals[pairs[:, 1]])
    # Skin beside skin faces the same way; what touches turns towards each other.
    pairs = pairs[facing < 0.5]
    graph = surface.ways
    first, order = np.unique(pairs[:, 0], return_inverse=True)
    for rows in np.array_split(np.arange(len(first)), len(first) // _ROWS + 1):
        if not len(rows):
            continue
        near: Any = dijkstra(graph, directed=False, indices=first[rows], limit=_DETOUR * reach)
        mine = np.flatnonzero((order >= rows[0]) & (order <= rows[-1]))
        apart = np.isinf(near[order[mine] - rows[0], pairs[mine, 1]])
        found[pairs[mine[apart]].ravel()] = True
    return found


def folded(rest: Surface, vertices: Points, rotations: Points) -> NDArray[np.bool_]:
    """(V,) corners of triangles that were turned over beside their surroundings.

    Along the line where lips meet vertices then have changed their order.
    """
    now = Surface(vertices, rest.triangles).face_normals
    corners = rest.triangles
    expected = np.einsum("nij,nj->ni", rotations[corners].mean(axis=1), rest.face_normals)
    over = np.einsum("ij,ij->i", now, expected) < 0
    found = np.zeros(len(vertices), dtype=bool)
    found[corners[over].ravel()] = True
    return found
