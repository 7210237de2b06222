"""How far off a vertex of a followed pose is expected to be, and the confidence that follows.

Four things are expected to be wrong:

- what photographs leave open: the covariance of the last step of Gauss–Newton from the noise that
  was left in each patch, larger where photographs contradict each other more than that explains;
- what they contradict each other by: where patches hold on to something else that looks alike,
  each photograph has the vertex elsewhere, and more of them do not make their mean any better;
- what a patch cannot follow: where the skin is stretched or compressed much, as around lips that
  part, a patch is a bad picture of itself, by a part of its radius for each strain; and where
  skin touches skin, as closed lips in the neutral, it reaches to one side only;
- what no photographs show: a vertex that fewer than two found is filled in, and its error grows
  along the surface with the way to vertices that were found, by as much as the surface is
  anything but rigid on that way: the back of a head goes where its front goes, a cheek does not.

With the expected error e, the confidence is 1 / (1 + (e / 0.005 D)²): 0.5 where 0.5 % of D is
expected.

Where photographs of a pose show vertices, and what that says of their places.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

from elastomorph.capturing.geometry.camera import Camera
from elastomorph.capturing.geometry.deformation import Deformation
from elastomorph.capturing.geometry.surface import Surface
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


# Of D: the error at which half of the confidence is gone.
_HALF = 0.005
# Error that filling in adds for each length of the way from the nearest vertex that was found: of a
# surface of which nothing else is known, and for each part by which edges there are not rigid.
_FILLED, _BENT = 0.3, 0.5
# Error for each length by which photographs contradict each other.
_CONTRADICTED = 6.0
# Strain that patches follow without harm, and the part of their radius that each more costs.
_STRAIN, _STRETCHED = 0.15, 2.0
# Part of the radius of a patch that it costs to lie where skin touches skin.
_BESIDE = 0.5


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


def contradictions(
    cameras: Sequence[Camera], vertices: Points, seen: Observations, pixel: float
) -> Points:
    """(V,) lengths: what is expected where photographs contradict each other; 0 where none show.

    Args:
        cameras: of the photographs.
        vertices: (V, 3).
        seen: what the photographs show.
        pixel: length on the surface that a pixel shows.
    """
    count = len(vertices)
    squares = (residuals(cameras, vertices, seen) ** 2).sum(axis=1)
    total = np.bincount(seen.vertices, squares, count)
    times = np.maximum(np.bincount(seen.vertices, minlength=count), 1)
    found: Points = _CONTRADICTED * pixel * np.sqrt(total / times)
    return found


def stretched(deformation: Deformation, vertices: Points, radius: float) -> Points:
    """(V,) lengths: what strain of the surface adds to the error of patches of a radius.

    The strain of a vertex is the mean of |ln(length / length at rest)| over the edges around it.
    """
    first, second = deformation.edges.T
    rest = np.linalg.norm(deformation.rest[first] - deformation.rest[second], axis=1)
    now = np.linalg.norm(vertices[first] - vertices[second], axis=1)
    tiny = np.finfo(float).tiny
    strain = np.abs(np.log(np.maximum(now, tiny) / np.maximum(rest, tiny)))
    around = _around(deformation, strain)
    found: Points = _STRETCHED * radius * np.maximum(around - _STRAIN, 0)
    return found


def beside(deformation: Deformation, touching: NDArray[np.bool_], radius: float) -> Points:
    """(V,) lengths: what closed lips and lids add to the error of patches of a radius.

    A patch beside the line where skin meets skin reaches to one side only.
    """
    part = deformation.smoothed(touching.astype(np.float64), 2)
    found: Points = _BESIDE * radius * np.clip(2 * part, 0, 1)
    return found


def filled(deformation: Deformation, vertices: Points) -> Points:
    """(V,) errors for each length of the way over a vertex that filling in adds.

    By the part of their length that the edges around it are off where rotations of the surface at
    rest have them, as in the energy of surfaces that are as rigid as possible.
    """
    first, second = deformation.edges.T
    turned = deformation.rotations(vertices)
    before = deformation.rest[first] - deformation.rest[second]
    expected = np.einsum("eij,ej->ei", (turned[first] + turned[second]) / 2, before)
    off = np.linalg.norm(vertices[first] - vertices[second] - expected, axis=1)
    parts = off / np.maximum(np.linalg.norm(before, axis=1), np.finfo(float).tiny)
    return _BENT * _around(deformation, parts)


def expected_errors(
    neutral: Surface, spread: Points, extent: float, rates: Points | None = None
) -> Points:
    """(V,) lengths: the spread, or what filling in from better vertices leaves if that is less.

    Args:
        neutral: the surface along which is filled in.
        spread: (V,) lengths, infinite where too few photographs show a vertex.
        extent: D.
        rates: (V,) as `filled` gives them; without, those of a surface of which nothing is known.
    """
    from scipy.sparse.csgraph import dijkstra

    count = len(neutral.vertices)
    edges = neutral.ways.tocoo()
    # A vertex more, joined to each that was found by a way as long as its own error.
    known = np.flatnonzero(np.isfinite(spread))
    rows = np.concatenate([edges.row, np.full(len(known), count)])
    columns = np.concatenate([edges.col, known])
    rates = np.full(count, _FILLED) if rates is None else rates
    ways = (rates[edges.row] + rates[edges.col]) / 2 * edges.data
    costs = np.concatenate([ways, spread[known]])
    graph = sparse.coo_array(
        (np.maximum(costs, 1e-12 * extent), (rows, columns)), shape=(count + 1, count + 1)
    ).tocsr()
    found: Points = dijkstra(graph, directed=False, indices=[count])[0, :count]
    return found


def confidences(errors: Points, extent: float) -> Points:
    """(V,) in [0, 1] from expected errors; 0.5 at 0.5 % of D, the extent."""
    ratio = np.minimum(errors / (_HALF * extent), 1e6)
    found: Points = 1 / (1 + ratio**2)
    return found


def _around(deformation: Deformation, values: Points) -> Points:
    """(V,) means of (E,) values of the edges around each vertex, smoothed."""
    both, count = deformation.edges.T.ravel(), len(deformation.rest)
    total = np.bincount(both, np.concatenate([values, values]), count)
    mean = total / np.maximum(np.bincount(both, minlength=count), 1)
    return deformation.smoothed(deformation.smoothed(mean))
