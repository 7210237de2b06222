"""Where photographs of a pose show vertices, and what that says of their places."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.camera import Camera
from elastomorph.capturing.geometry.table import Table

Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Observations(Table):
    """Where photographs of a pose show vertices.

    Attributes:
        views: (N,) which photograph.
        vertices: (N,) which vertex.
        pixels: (N, 2) where it is there.
        information: (N, 2, 2) inverse covariance, per pixel².
        likeness: (N,) correlation of what the neutral and the pose show around it.
    """

    views: NDArray[np.int64]
    vertices: NDArray[np.int64]
    pixels: Points
    information: Points
    likeness: Points

    @classmethod
    def none(cls) -> Observations:
        """Nothing seen."""
        no = np.zeros(0, dtype=np.int64)
        return cls(no, no, np.zeros((0, 2)), np.zeros((0, 2, 2)), np.zeros(0))


def photographs(seen: Observations, count: int) -> NDArray[np.int64]:
    """(V,) in how many photographs each of `count` vertices was seen."""
    width = 1 + int(seen.views.max(initial=0))
    pairs = np.unique(seen.vertices * width + seen.views)
    return np.bincount(pairs // width, minlength=count)


def supported(seen: Observations, count: int, fewest: int | NDArray[np.float64]) -> Observations:
    """Those of vertices that so many photographs, (V,) or one number, show."""
    return seen.chosen((photographs(seen, count) >= fewest)[seen.vertices])


def residuals(cameras: Sequence[Camera], vertices: Points, seen: Observations) -> Points:
    """(N, 2) pixels from where the vertices are to where they were seen."""
    off = np.zeros((len(seen.views), 2))
    for number, camera in enumerate(cameras):
        mine = seen.views == number
        off[mine] = seen.pixels[mine] - camera.project(vertices[seen.vertices[mine]])[0]
    return off


def disagreement(off: Points, information: Points) -> Points:
    """(N,) squares of residuals (N, 2) in units of their spread."""
    found: Points = np.einsum("ni,nij,nj->n", off, information, off)
    return found


def normal_equations(
    cameras: Sequence[Camera],
    vertices: Points,
    seen: Observations,
    *,
    unit: float,
    robust: float,
    mixing: Any = None,
) -> tuple[Points, Points]:
    """(V, 3, 3) A and (V, 3) b of one step of Gauss–Newton on what was seen.

    Args:
        cameras: of the photographs.
        vertices: (V, 3) so far.
        seen: what the photographs show.
        unit: length that makes A a number: what a pixel shows.
        robust: residual, in units of its spread, from which on it counts less (Geman–McClure).
        mixing: (V, V) sparse, rows that add up to 1; what was seen is not a vertex but this
            mixture of them. A then bounds the true one, (Σ m x)ᵀ A (Σ m x) ≤ Σ m xᵀ A x, which
            shortens the step where vertices differ from their mixture and leads to the same end.
    """
    quadratic, pulls = np.zeros((len(vertices), 3, 3)), np.zeros((len(vertices), 3))
    off = residuals(cameras, vertices, seen)
    weights = unit**2 / (1 + disagreement(off, seen.information) / robust**2) ** 2
    for number, camera in enumerate(cameras):
        mine = seen.views == number
        which = seen.vertices[mine]
        change = camera.jacobian(vertices[which])
        information = seen.information[mine] * weights[mine][:, None, None]
        pull = np.einsum("nji,njk->nik", change, information)
        np.add.at(quadratic, which, pull @ change)
        np.add.at(pulls, which, np.einsum("nij,nj->ni", pull, off[mine]))
    if mixing is not None:
        pulls = mixing.T @ pulls
        quadratic = (mixing.T @ quadratic.reshape(-1, 9)).reshape(-1, 3, 3)
    return quadratic, pulls + np.einsum("nij,nj->ni", quadratic, vertices)
