"""How far each vertex of a registered scan is to be trusted, and what says so.

The error of a vertex is estimated in two parts. Across the surface it is what the scan shows: the
distance to it, or where the scan shows nothing, how far the next vertex is at which it does. Along
the surface a scan without colours shows nothing: there the error grows with how far the vertex has
moved, less beside landmarks, and less where a rig's expressions say how skin moves.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.scans.correspondence import ScanPoints
from elastomorph.capturing.scans.nonrigid import Elastic, Held
from elastomorph.capturing.tracking.confidence import confidences

Points = NDArray[np.float64]

# Reach of a point that says where a vertex is, in parts of the extent, and least cosine.
_NEAR, _SAME = 0.006, 0.7
# Error a length away from what the scan shows, in parts of that length.
_UNSEEN = 0.12
# Slide along the surface in parts of the movement: plain, beside a landmark, by a rig's
# expressions, and of what these leave over.
_SLIDE, _AT_LANDMARK, _BY_RIG, _LEFT = 0.9, 0.28, 0.15, 1.0
# How far a landmark helps, in parts of the extent.
_HELPS = 0.06


@dataclass(frozen=True, eq=False)
class Trust:
    """What is known of a registered scan, vertex by vertex.

    Attributes:
        distance: (V,) to the scan, in parts of the extent.
        shown: (V,) whether the scan shows it: no hole, border or hidden place.
        confidence: (V,) in [0, 1].
    """

    distance: Points
    shown: NDArray[np.bool_]
    confidence: Points

    def figures(self, extent_unit: float) -> dict[str, Any]:
        """Numbers over all vertices; distances in % of the extent, which is in template units."""
        own = 100 * self.distance[self.shown]
        return {
            "extent": extent_unit,
            "surface_mean": float(own.mean()) if len(own) else None,
            "surface_p95": float(np.percentile(own, 95)) if len(own) else None,
            "shown": float(self.shown.mean()),
            "flagged": float((self.confidence < 0.5).mean()),
        }


def trusted(
    elastic: Elastic,
    vertices: Points,
    scan: ScanPoints,
    along: Points,
) -> Trust:
    """The confidence of a template drawn onto a scan.

    Args:
        elastic: the template.
        vertices: (V, 3) where it is drawn to.
        scan: in the same place and size.
        along: (V,) error expected along the surface, in parts of the extent.
    """
    size = elastic.size
    found = elastic.matches(vertices, scan, _NEAR)
    distance = found.distances / size
    shown = elastic.outer & ~found.border & (found.cosines > _SAME) & (distance < _NEAR)
    unseen = _way(elastic, vertices, np.flatnonzero(shown)) / size
    across = np.where(shown, distance, _UNSEEN * unseen)
    error = np.hypot(elastic.deformation.smoothed(across, 2), along)
    return Trust(distance, shown, confidences(error, 1.0))


def slide(
    elastic: Elastic, vertices: Points, neutral: Points, held: Held, expected: Points | None
) -> Points:
    """(V,) error expected along the surface where nothing was followed on it.

    Args:
        elastic: the template.
        vertices: (V, 3) where it is drawn to.
        neutral: (V, 3) where it was.
        held: landmarks.
        expected: (V, 3) where a rig's expressions put it, if there is a rig.
    """
    moved = np.linalg.norm(vertices - neutral, axis=1)
    if expected is not None:
        left = np.linalg.norm(vertices - expected, axis=1)
        return elastic.deformation.smoothed(_BY_RIG * moved + _LEFT * left, 2) / elastic.size
    far = np.full(len(vertices), np.inf)
    if len(held.vertices):
        far = _way(elastic, vertices, held.vertices) / elastic.size
    share = _AT_LANDMARK + (_SLIDE - _AT_LANDMARK) * (1 - np.exp(-((far / _HELPS) ** 2)))
    return elastic.deformation.smoothed(share * moved, 2) / elastic.size


def _way(elastic: Elastic, vertices: Points, start: NDArray[np.integer]) -> Points:
    """(V,) length of the way along edges to the nearest of some vertices; the extent at most."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra

    if not len(start):
        return np.full(len(vertices), elastic.size)
    first, second = elastic.deformation.edges.T
    lengths = np.maximum(np.linalg.norm(vertices[first] - vertices[second], axis=1), 1e-12)
    count = len(vertices)
    graph = coo_array((lengths, (first, second)), shape=(count, count)).tocsr()
    found = dijkstra(graph, directed=False, indices=start, min_only=True)
    return np.asarray(np.minimum(found, elastic.size), dtype=np.float64)
