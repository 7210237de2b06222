"""Targets with another number of vertices: an exporter split or welded them, the polygons tell."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.findings import Outcome, counted, finding, listed
from elastomorph.model.mesh import Mesh

__all__ = ["rejoined"]

Corners = NDArray[np.int32]


def rejoined(neutral: Mesh, target: Mesh, file: str, near: float) -> Outcome | None:
    """Look for vertices that were split or welded while the polygons stayed in their order.

    Args:
        neutral: The neutral.
        target: A target with another number of vertices.
        file: Its file.
        near: Distance up to which positions are one.

    Returns:
        The target with the vertices of the neutral, or without a mesh where positions were lost;
        None where the polygons do not tell.
    """
    ours, theirs = neutral.faces.indices, target.faces.indices
    if not np.array_equal(neutral.faces.offsets, target.faces.offsets):
        triangles = neutral.faces.triangles()
        if len(target.faces) != len(triangles) or (target.faces.sizes != 3).any():
            return None
        ours = triangles.ravel()
    joined = _split if len(target.vertices) > len(neutral.vertices) else _welded
    return joined(neutral, target, ours, theirs, file, near)


def _image(start: Corners, end: Corners, count: int) -> NDArray[np.int64] | None:
    """For each of ``count`` vertices the one it always meets; None where it meets two, or none."""
    image = np.full(count, -1, dtype=np.int64)
    image[start] = end
    return image if np.array_equal(image[start], end) and (image >= 0).all() else None


def _split(
    neutral: Mesh, target: Mesh, ours: Corners, theirs: Corners, file: str, near: float
) -> Outcome | None:
    origin = _image(theirs, ours, len(target.vertices))
    if origin is None:
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
    found = finding("split-vertices", file, message, vertices=split)
    return Outcome(neutral.with_vertices(points), (found,), "split vertices joined")


def _welded(
    neutral: Mesh, target: Mesh, ours: Corners, theirs: Corners, file: str, near: float
) -> Outcome | None:
    now = _image(ours, theirs, len(neutral.vertices))
    if now is None or len(np.unique(now)) != len(target.vertices):
        return None
    welded = np.flatnonzero(np.bincount(now)[now] > 1)
    message = (
        f"{len(target.vertices):,} vertices instead of {len(neutral.vertices):,}: "
        f"{len(welded):,} of the neutral were welded into {len(np.unique(now[welded])):,}: "
        f"{listed(welded)}"
    )
    found = finding("welded-vertices", file, message, vertices=welded)
    # Those at one place in the neutral were put together because they were at one place here too.
    first = np.unique(now, return_index=True)[1]
    if (np.abs(neutral.vertices[first[now]] - neutral.vertices) > near).any():
        return Outcome(None, (found,))
    return Outcome(neutral.with_vertices(target.vertices[now]), (found,), "welded vertices parted")
