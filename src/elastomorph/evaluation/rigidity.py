"""Whether a path keeps a rigid body rigid: teeth that shrink, or leave their arc."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.curves import region_of
from elastomorph.errors import ParameterError
from elastomorph.model.geometry import fit_rigid, largest_distance
from elastomorph.model.morph import Morph

__all__ = ["Rigidity", "rigidity"]

_MOST_IN_PAIRS = 1500


@dataclass(frozen=True)
class Rigidity:
    """How a path treats vertices known to move as one rigid body, over the times asked for.

    Attributes:
        change: Largest change of the distance between two of the vertices, as a fraction of D.
        off_screw: Largest distance of a vertex from the screw motion between both ends, each
            moment compared with the part of the screw that fits it best, as a fraction of D.
        ends: Largest distance of the target from a rigid motion of the neutral, as a fraction of
            D: where it is large, the vertices are no rigid body.
    """

    change: float
    off_screw: float
    ends: float


def rigidity(morph: Morph, body: ArrayLike | str, times: Iterable[float]) -> Rigidity:
    """Measure how rigid a body stays along a path.

    Pairs are taken among at most 1500 vertices spread evenly over the body.

    Args:
        morph: The path.
        body: Vertex indices, (V,) bool or the name of a group, at least four vertices.
        times: Moments of the path.

    Raises:
        CurveError: A vertex that does not exist.
        ParameterError: Fewer than four vertices.
    """
    from scipy.optimize import minimize_scalar

    vertices = np.flatnonzero(region_of(morph.neutral, body))
    if vertices.size < 4:
        raise ParameterError(f"a rigid body needs at least 4 vertices, found {vertices.size}")
    start, end = morph.neutral.vertices[vertices], morph.target.vertices[vertices]
    screw, residual = fit_rigid(start, end)
    left_over = end - screw.at(1.0, start)
    sample = np.unique(np.linspace(0, vertices.size - 1, _MOST_IN_PAIRS).astype(int))
    at_rest = _distances(start[sample])
    scale = morph.neutral.diameter or largest_distance(morph.target.vertices)
    parts = np.linspace(0.0, 1.0, 201)
    arcs = np.stack([screw.at(float(part), start) + part * left_over for part in parts])
    change = off = 0.0
    for time in times:
        here = morph.at(float(time))[vertices]
        change = max(change, float(np.abs(_distances(here[sample]) - at_rest).max()))
        nearest = int(np.einsum("pvi,pvi->p", arcs - here, arcs - here).argmin())
        bracket = (parts[max(nearest - 1, 0)], parts[min(nearest + 1, len(parts) - 1)])

        def away(part: float, here: NDArray[np.float64] = here) -> NDArray[np.float64]:
            return screw.at(part, start) + part * left_over - here

        best = minimize_scalar(
            lambda part: float((away(part) ** 2).sum()),
            bounds=bracket,
            method="bounded",
            options={"xatol": 1e-12},
        ).x
        off = max(off, float(np.linalg.norm(away(float(best)), axis=1).max()))
    return Rigidity(change / scale, off / scale, float(residual.max()) / scale)


def _distances(points: NDArray[np.float64]) -> NDArray[np.float64]:
    from scipy.spatial.distance import pdist

    return np.asarray(pdist(points))
