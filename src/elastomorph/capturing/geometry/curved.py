"""A finer surface through the same vertices, curved as their normals say."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.surface import Surface


def curved(surface: Surface) -> Surface:
    """The surface with each triangle made four; its own vertices come first and stay.

    A template has few vertices for a round face: its flat triangles run below the skin between
    them, by more than photographs can tell. The middle of each edge is put on the curve that
    leaves both ends at right angles to their normals (the edges of Vlachos et al., Curved PN
    triangles, I3D 2001):

        m = (a + b)/2 − ((e·n_a) n_a − (e·n_b) n_b)/8,  e = b − a
    """
    count = len(surface.vertices)
    triangles = surface.triangles
    sides = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    edges, numbers = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True)
    middles = count + numbers.reshape(-1, 3)
    (a, b), (first, second) = (
        np.moveaxis(values[edges], 1, 0) for values in (surface.vertices, surface.normals)
    )
    at_first = np.einsum("ij,ij->i", b - a, first)[:, None] * first
    at_second = np.einsum("ij,ij->i", b - a, second)[:, None] * second
    points = (a + b) / 2 - (at_first - at_second) / 8
    corner, middle = triangles.T, middles.T
    fine: list[tuple[NDArray[np.int64], ...]] = [
        (corner[k], middle[k], middle[k - 1]) for k in range(3)
    ]
    fine.append((middle[0], middle[1], middle[2]))
    return Surface(
        np.concatenate([surface.vertices, points]),
        np.concatenate([np.stack(each, axis=1) for each in fine]),
    )
