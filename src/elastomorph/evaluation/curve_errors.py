"""The error of the paper: how far the vertices of every curve are from where they were captured."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import CurveError, MeshError


class HasVertices(Protocol):
    """Anything with the vertex indices of a curve, in order."""

    @property
    def vertices(self) -> NDArray[np.integer]:
        """(M,) vertex indices."""


@dataclass(frozen=True, eq=False)
class CurveVertices:
    """The vertices of all curves one after another, so that all curves are measured at once."""

    indices: NDArray[np.int64]  # (N,) int64 vertex indices
    starts: NDArray[np.int64]  # (C,) int64, where each curve starts in ``indices``
    counts: NDArray[np.int64]  # (C,) int64 vertices of each curve

    @classmethod
    def of(cls, curves: Iterable[HasVertices], vertex_count: int) -> CurveVertices:
        """Flatten curves of a mesh with ``vertex_count`` vertices."""
        parts = [np.asarray(curve.vertices, dtype=np.int64) for curve in curves]
        counts = np.array([part.size for part in parts], dtype=np.int64)
        if counts.size == 0 or counts.min() == 0:
            raise CurveError(
                "errors are measured along curves, but there is none: give curves=… "
                "(a mesh without polygons has no edges to trace them along)"
                if counts.size == 0
                else f"curve {int(counts.argmin())} has no vertices"
            )
        indices = np.concatenate(parts)
        if indices.min() < 0 or indices.max() >= vertex_count:
            raise CurveError(
                f"the curves name vertices {indices.min()} to {indices.max()}, but the mesh has "
                f"{vertex_count:,} vertices (0 to {vertex_count - 1:,})"
            )
        return cls(indices, np.cumsum(counts) - counts, counts)


def curve_errors(
    positions: NDArray[np.float64],
    captured: NDArray[np.float64],
    curves: CurveVertices,
    diameter: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """E_A and E_M, (C,) fractions of D, of curves at one time (Eq. 35, with the norm it lacks).

        E_A = 1/M Σ_m ‖w̄_m - w_m‖ / D        E_M = max_m ‖w̄_m - w_m‖ / D

    w̄ are (V, 3) vertices as interpolated, w as captured, in the unit of D.
    """
    if not diameter > 0:
        raise MeshError(
            "all vertices of the neutral are at one place, so its diameter D is 0 and errors "
            "cannot be given as a fraction of it"
        )
    offsets = positions[curves.indices] - captured[curves.indices]
    distances = np.sqrt(np.einsum("ni,ni->n", offsets, offsets)) / diameter
    average = np.add.reduceat(distances, curves.starts) / curves.counts
    return average, np.maximum.reduceat(distances, curves.starts)
