"""The scale of photographs by distances that were measured: on the face, or by a ruler beside it.

Photographs alone have no scale. Without a known distance a subject is as large as the template by
its landmarks; with one, l between two points of which the photographs say that they are d apart in
their own unit, the factor is that of least squares, f = Σ d l / Σ d².
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.similarity import Similarity, fit_similarity
from elastomorph.capturing.landmarks.landmarks import Distance, fit_landmarks
from elastomorph.errors import CaptureError

_DISAGREE = 0.05
_FARTHEST_FROM_TEMPLATE = 2.0

Points = NDArray[np.float64]


def factor_of(points: Mapping[str, Points], distances: Sequence[Distance], where: str) -> float:
    """Units of the measured distances in one unit of the photographs.

    Args:
        points: Name → (3,) in the unit of the photographs.
        distances: Names of two points and how far they are from each other.
        where: The photographs are from, for messages.

    Raises:
        CaptureError: None of the distances is between points that are known, or they contradict
            each other.
    """
    known = [(one, other, length) for one, other, length in distances if {one, other} <= {*points}]
    if not known:
        one, other, _ = distances[0]
        raise CaptureError(
            f"{where}: the distance from {one} to {other} is given, but not both are clicked in "
            "two photographs, or cameras that were found; place them, or take the distance out of "
            "the landmarks"
        )
    found = np.array([float(np.linalg.norm(points[a] - points[b])) for a, b, _ in known])
    given = np.array([length for _, _, length in known])
    if (found <= 0).any():
        raise CaptureError(f"{where}: two points a distance apart are clicked at the same place")
    factor = float(found @ given / (found @ found))
    off = np.abs(factor * found / given - 1)
    worst = int(off.argmax())
    if off[worst] > _DISAGREE:
        one, other, length = known[worst]
        raise CaptureError(
            f"{where}: by the other distances {one} and {other} are {factor * found[worst]:.3g} "
            f"apart and not {length:g}; measure or click them again"
        )
    return factor


def fit_to_scale(
    template: Mapping[str, Points],
    found: Mapping[str, Points],
    distances: Sequence[Distance],
    where: str,
) -> Similarity:
    """The similarity that brings photographs to a template; its scale by distances if there are.

    Args:
        template: Landmark → (3,) on the template.
        found: Landmark, end of a ruler or camera → (3,) in the unit of the photographs.
        distances: In the unit of the template.
        where: The photographs are from, for messages.

    Raises:
        CaptureError: The landmarks or the distances cannot be right.
    """
    similarity = fit_landmarks(template, found, where).inverse()
    if not distances:
        return similarity
    factor = factor_of(found, distances, where)
    larger = factor / similarity.scale
    if not 1 / _FARTHEST_FROM_TEMPLATE < larger < _FARTHEST_FROM_TEMPLATE:
        raise CaptureError(
            f"{where}: by the distances given, the face is {larger:.3g} times as large as the "
            "template; give them in the template's unit"
        )
    names = [name for name in template if name in found]
    source = factor * np.array([found[name] for name in names])
    rigid = fit_similarity(source, np.array([template[name] for name in names]), rigid=True)
    return Similarity(factor, rigid.rotation, rigid.shift)
