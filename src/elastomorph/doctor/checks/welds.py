"""Vertices that an exporter split at seams, or welded: the polygons still say which is which."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.findings import Finding, finding
from elastomorph.doctor.words import counted, listed
from elastomorph.model.mesh import Mesh

__all__ = ["Rejoined", "examine_welds"]


@dataclass(frozen=True, eq=False)
class Rejoined:
    """A target with another number of vertices but the polygons of the neutral.

    Attributes:
        finding: What happened to which vertices.
        mesh: The target with the vertices of the neutral; None where positions were lost.
        repair: What was done, in a few words.
    """

    finding: Finding
    mesh: Mesh | None
    repair: str


def examine_welds(neutral: Mesh, target: Mesh, file: str, near: float) -> Rejoined | None:
    """Look for vertices that were split or welded while the polygons stayed in their order.

    Args:
        neutral: The neutral.
        target: A target with another number of vertices.
        file: Its file.
        near: Distance up to which positions are one.

    Returns:
        None where the polygons do not tell.
    """
    corners = _corners(neutral, target)
    if corners is None:
        return None
    ours, theirs = corners
    if len(target.vertices) > len(neutral.vertices):
        return _split(neutral, target, ours, theirs, file, near)
    return _welded(neutral, target, ours, theirs, file, near)


def _corners(neutral: Mesh, target: Mesh) -> tuple[NDArray[np.int32], NDArray[np.int32]] | None:
    """The vertices of both at the same corners of the same polygons, split or not."""
    if np.array_equal(neutral.faces.offsets, target.faces.offsets):
        return neutral.faces.indices, target.faces.indices
    triangles = neutral.faces.triangles()
    if len(target.faces) == len(triangles) and (target.faces.sizes == 3).all():
        return triangles.ravel(), target.faces.indices
    return None


def _image(
    start: NDArray[np.int32], end: NDArray[np.int32], count: int
) -> NDArray[np.int64] | None:
    """For each of ``count`` vertices the one that it always meets; None where it meets two."""
    image = np.full(count, -1, dtype=np.int64)
    image[start] = end
    return image if np.array_equal(image[start], end) else None


def _split(
    neutral: Mesh,
    target: Mesh,
    ours: NDArray[np.int32],
    theirs: NDArray[np.int32],
    file: str,
    near: float,
) -> Rejoined | None:
    origin = _image(theirs, ours, len(target.vertices))
    if origin is None or (origin < 0).any():
        return None
    copies = np.bincount(origin, minlength=len(neutral.vertices))
    if not copies.all():
        return None
    points = np.empty_like(neutral.vertices)
    points[origin] = target.vertices
    if (np.abs(points[origin] - target.vertices) > near).any():
        return None
    split = np.flatnonzero(copies > 1)
    message = (
        f"{len(target.vertices):,} vertices instead of {len(neutral.vertices):,}: "
        f"{counted(split, 'vertex is', 'vertices are')} there more than once, at seams: "
        f"{listed(split)}"
    )
    found = finding("split-vertices", file, message, vertices=split.tolist())
    return Rejoined(found, neutral.with_vertices(points), "split vertices joined")


def _welded(
    neutral: Mesh,
    target: Mesh,
    ours: NDArray[np.int32],
    theirs: NDArray[np.int32],
    file: str,
    near: float,
) -> Rejoined | None:
    now = _image(ours, theirs, len(neutral.vertices))
    if now is None or (now < 0).any() or len(np.unique(now)) != len(target.vertices):
        return None
    welded = np.flatnonzero(np.bincount(now)[now] > 1)
    message = (
        f"{len(target.vertices):,} vertices instead of {len(neutral.vertices):,}: "
        f"{len(welded):,} of the neutral were welded into {len(np.unique(now[welded])):,}: "
        f"{listed(welded)}"
    )
    found = finding("welded-vertices", file, message, vertices=welded.tolist())
    # Those at one place in the neutral were put together because they were at one place here too.
    first = np.full(len(target.vertices), -1, dtype=np.int64)
    first[now[::-1]] = np.arange(len(now))[::-1]
    together = np.abs(neutral.vertices[first[now]] - neutral.vertices) <= near
    if not together.all():
        return Rejoined(found, None, "")
    return Rejoined(found, neutral.with_vertices(target.vertices[now]), "welded vertices parted")
