"""How far off a vertex of a followed pose is expected to be, and the confidence that follows.

What photographs leave open at a vertex is the covariance of the last step of Gauss–Newton, larger
where they contradict each other more than their own noise explains. A vertex that fewer than two
of them show was only filled in from those around it: its error grows along the surface with the
distance to vertices that were found. With the expected error e, the confidence is
1 / (1 + (e / 0.005 D)²): 0.5 where 0.5 % of D is expected.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

from elastomorph.capture.camera import Camera
from elastomorph.capture.observations import (
    Observations,
    disagreement,
    photographs,
    residuals,
)
from elastomorph.capture.surface import Surface

Points = NDArray[np.float64]

# Of D: the error at which a vertex is as likely trusted as not.
FLAGGED = 0.005
# Error that filling in adds for each length of the way from the nearest vertex that was found.
_FILLED = 0.15


def spreads(cameras: Sequence[Camera], vertices: Points, seen: Observations) -> Points:
    """(V,) standard deviation, a length; infinite where fewer than two photographs show it."""
    count = len(vertices)
    information = np.zeros((count, 3, 3))
    for number, camera in enumerate(cameras):
        mine = seen.views == number
        change = camera.jacobian(vertices[seen.vertices[mine]])
        own = np.einsum("nji,njk,nkl->nil", change, seen.information[mine], change)
        np.add.at(information, seen.vertices[mine], own)
    views = photographs(seen, count)
    off = disagreement(residuals(cameras, vertices, seen), seen.information)
    excess = np.bincount(seen.vertices, off, count) / np.maximum(2 * views - 3, 1)
    found = np.full(count, np.inf)
    known = views >= 2
    values = np.maximum(np.linalg.eigvalsh(information[known]), 1e-300)
    found[known] = np.sqrt((1 / values).sum(axis=1) * np.maximum(excess[known], 1))
    return found


def expected_errors(neutral: Surface, spread: Points, extent: float) -> Points:
    """(V,) lengths: the spread, or what filling in from better vertices leaves if that is less."""
    from scipy.sparse.csgraph import dijkstra

    faces, count = neutral.triangles, len(neutral.vertices)
    ends = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    ends = np.unique(ends, axis=0)
    far = np.linalg.norm(neutral.vertices[ends[:, 0]] - neutral.vertices[ends[:, 1]], axis=1)
    # A vertex more, joined to each that was found by a way as long as its own error.
    known = np.flatnonzero(np.isfinite(spread))
    rows = np.concatenate([ends[:, 0], np.full(len(known), count)])
    columns = np.concatenate([ends[:, 1], known])
    costs = np.concatenate([_FILLED * far, spread[known]])
    graph = sparse.coo_array(
        (np.maximum(costs, 1e-12 * extent), (rows, columns)), shape=(count + 1, count + 1)
    ).tocsr()
    found: Points = dijkstra(graph, directed=False, indices=[count])[0, :count]
    return found


def confidences(errors: Points, extent: float) -> Points:
    """(V,) in [0, 1] from expected errors; 0.5 at 0.5 % of D, the extent."""
    ratio = np.minimum(errors / (FLAGGED * extent), 1e6)
    found: Points = 1 / (1 + ratio**2)
    return found
