"""How well registered poses agree with what photographs show: surface and correspondence, apart.

A mesh may slide along the skin and still lie on it everywhere, so that a small distance from the
surface says nothing of where skin went. Both are measured by features of the photographs, whose
places in space were found without the mesh.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.surface import Surface
from elastomorph.capturing.tracking.matches import Matches, consistent

Points = NDArray[np.float64]

_NEAR = 0.02
"""Of the extent: points farther off are of hair, clothes or the background."""
_FEWEST = 20


def surface_agreement(points: Points, surface: Surface, extent: float) -> dict[str, Any]:
    """How far (N, 3) points that photographs show are from a pose's surface, parts of its extent.

    Returns:
        ``points``, how many are near enough to be of the head; ``median`` and ``p95`` of their
        distances. Nothing where they are too few.
    """
    if len(points) < _FEWEST:
        return {}
    away = surface.closest(points).distances / extent
    return _spread(away[away < _NEAR], "points")


def skin_agreement(
    neutral: Surface, pose: Surface, matches: Matches, extent: float
) -> dict[str, Any]:
    """How far a pose has skin of the neutral from where photographs show it, parts of its extent.

    Each matched point of the neutral is held by the triangle it is nearest to, with its distance
    from it, and compared with its match where that triangle is in the pose. Matches that move
    unlike all around them are of other skin.

    Args:
        neutral: The surface of the neutral, (V, 3).
        pose: The same triangles in the pose, (V, 3).
        matches: Points of the skin in both, in their frame.
        extent: Of the face, in the same units.

    Returns:
        ``matches``, how many were compared; ``median`` and ``p95`` of the distances. Nothing where
        they are too few.
    """
    if len(matches) < _FEWEST:
        return {}
    held = neutral.closest(matches.neutral)
    lifted = np.einsum("ni,ni->n", matches.neutral - held.points, neutral.at(held, neutral.normals))
    expected = pose.at(held, pose.vertices) + lifted[:, None] * pose.at(held, pose.normals)
    near = held.distances < _NEAR * extent
    near[near] = consistent(matches.chosen(near), expected[near], extent)
    away = np.linalg.norm(expected - matches.pose, axis=1) / extent
    return _spread(away[near], "matches")


def _spread(away: Points, name: str) -> dict[str, Any]:
    if len(away) < _FEWEST:
        return {}
    middle, most = np.quantile(away, [0.5, 0.95])
    return {name: len(away), "median": float(middle), "p95": float(most)}
