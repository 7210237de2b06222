"""Where the head of a whole character is: what its targets move tells, and the hair around that."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.camera import drawn_vertices
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph

_BODY = 3.5
"""A mesh so many times as large as what its targets move is more than a head and its shoulders."""
_HEAD = 1 / 9
"""The least size of a head over that of its body, where targets move only a part of the face."""
_MOVED = 0.05
"""Motion, over the largest, below which a vertex is carried along: at the foot of the neck."""
_ABOVE, _BESIDE, _BELOW = 0.7, 0.35, 0.15
"""How far hair and shoulders are shown beyond the face, over its size."""
_NECK = 0.25
"""Height of the point that a head turns about, over that of the head."""


def head_of(mesh: Mesh, morphs: Iterable[Morph]) -> NDArray[np.int64] | None:
    """(N,) vertices of the head and what is around it; None where the mesh is no more than that.

    A mesh of which nothing is known but its shape counts as a head.
    """
    if mesh.appearance is None:
        return None
    motion = np.zeros(len(mesh.vertices))
    for morph in morphs:
        np.maximum(motion, np.linalg.norm(morph.delta, axis=1), out=motion)
    if not motion.any():
        return None
    face = mesh.vertices[motion > _MOVED * motion.max()]
    low, high = face.min(axis=0), face.max(axis=0)
    size, whole = float((high - low).max()), float(np.ptp(mesh.vertices, axis=0).max())
    if whole < _BODY * size:
        return None
    size = max(size, _HEAD * whole)
    middle = (low + high) / 2
    low, high = np.minimum(low, middle - size / 2), np.maximum(high, middle + size / 2)
    low = low - size * np.array([_BESIDE, _BELOW, _ABOVE])
    high = high + size * np.array([_BESIDE, _ABOVE, _ABOVE])
    inside = ((mesh.vertices >= low) & (mesh.vertices <= high)).all(axis=1)
    return np.flatnonzero(inside)


def neck_of(mesh: Mesh, morphs: Iterable[Morph]) -> NDArray[np.float64]:
    """(3,) the point that the head turns about, as in the viewer page.

    It is in the middle of the box round what is drawn of the head, a quarter of the way up.
    """
    shown = drawn_vertices(mesh)
    if mesh.appearance is not None and len(mesh.faces):  # whose materials are all drawn
        shown = np.unique(mesh.faces.indices).astype(np.int64)
    head = head_of(mesh, morphs)
    if head is not None and np.intersect1d(shown, head).size:
        shown = np.intersect1d(shown, head)
    low, high = mesh.vertices[shown].min(axis=0), mesh.vertices[shown].max(axis=0)
    neck: NDArray[np.float64] = (low + high) / 2
    neck[1] = low[1] + _NECK * (high[1] - low[1])
    return neck
