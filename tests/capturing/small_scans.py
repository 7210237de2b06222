"""Scans of the small head for tests: another topology, moved, turned, in other units."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

import elastomorph as em
from elastomorph.capturing.geometry import Surface
from elastomorph.capturing.landmarks import Landmarks
from elastomorph.capturing.scans import registration
from elastomorph.model.surface import triangulate
from small_head import bare_head, landmarks

Points = NDArray[np.float64]


@cache
def rig() -> em.Rig:
    """The small head with five of its shapes."""
    return bare_head().only(
        ["jawOpen", "mouthSmile_L", "mouthSmile_R", "browInnerUp", "mouthPucker"]
    )


@cache
def middle() -> Points:
    """(3,) within the head."""
    return np.asarray(rig().neutral.vertices.mean(axis=0))


def posed(**weights: float) -> Points:
    """(V, 3) the head with straight paths."""
    face = rig().neutral.vertices.copy()
    for name, weight in weights.items():
        face += weight * rig().morphs[name].delta
    return face


def scanned(face: Points, noise: float = 0.01, seed: int = 0, rows: int = 130) -> em.Mesh:
    """The outside of a head as a grid of rays from around it: no vertex is one of the head's."""
    random = np.random.default_rng(seed)
    triangles = triangulate(rig().neutral)[0]
    columns = 2 * rows
    around = np.linspace(0, 2 * np.pi, columns, endpoint=False) + random.uniform(0, 1)
    up = np.linspace(1.3, -0.9, rows)[:, None]
    ways = np.stack(
        [np.sin(around) * np.cos(up), np.sin(up) + 0 * around, np.cos(around) * np.cos(up)], axis=-1
    )
    starts = middle() + 40 * ways
    depths = Surface(face, triangles).cast(starts, -ways).depths
    depths = depths + noise * random.normal(size=depths.shape)
    points = starts - depths[..., None] * ways
    met = np.isfinite(depths)
    number = np.arange(rows * columns).reshape(rows, columns)
    right = np.roll(number, -1, axis=1)
    quads = np.stack([number[:-1], number[1:], right[1:], right[:-1]], axis=-1).reshape(-1, 4)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    faces = faces[met.ravel()[faces].all(axis=1)]
    corners = points.reshape(-1, 3)[faces]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    faces = faces[sides < 4 * np.median(sides)]
    used, faces = np.unique(faces, return_inverse=True)
    return em.Mesh(points.reshape(-1, 3)[used], faces.reshape(-1, 3))


def in_single_steps(patch: pytest.MonkeyPatch) -> None:
    """Templates are drawn onto scans in one step of each stage, for who looks at something else."""
    for name in ("ADAPT", "FOLLOW", "FINISH"):
        steps = tuple(replace(stage, steps=1) for stage in getattr(registration, name))
        patch.setattr(registration, name, steps)


def moved(mesh: em.Mesh, scale: float = 1.0, turn: Points | None = None) -> em.Mesh:
    """A scan in other units and axes."""
    vertices = scale * mesh.vertices @ (np.eye(3) if turn is None else turn).T
    return em.Mesh(vertices, mesh.faces)


def marked(face: Points, name: str = "mesh", off: float = 0.03, seed: int = 1) -> Landmarks:
    """Landmarks of the head, on a scan of it too."""
    random = np.random.default_rng(seed)
    known = landmarks()
    places = {
        key: tuple((face[vertex] + off * random.normal(size=3)).tolist())
        for key, vertex in known.items()
    }
    return Landmarks(known, points={name: places})
