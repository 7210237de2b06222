"""Small meshes to draw, and where a camera sees their points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastomorph.mesh import FaceLabels, Mesh
from elastomorph.report.camera import Camera

__all__ = ["ball", "joined", "seen_at"]


def ball(
    radius: float = 1.0,
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0),
    rings: int = 12,
    meridians: int = 24,
) -> Mesh:
    """A sphere of quads and triangles, wound outwards, its poles on the z axis."""
    polar = np.linspace(0, np.pi, rings + 1)[1:-1]
    around = np.arange(meridians) * 2 * np.pi / meridians
    points = np.stack(
        [
            np.outer(np.sin(polar), np.cos(around)),
            np.outer(np.sin(polar), np.sin(around)),
            np.outer(np.cos(polar), np.ones(meridians)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    north, south = len(points), len(points) + 1
    points = np.concatenate([points, [[0, 0, 1], [0, 0, -1]]]) * radius + np.array(centre)
    faces: list[list[int]] = []
    last = (rings - 2) * meridians
    for k in range(meridians):
        after = (k + 1) % meridians
        faces.append([north, k, after])
        faces.append([south, last + after, last + k])
        for ring in range(rings - 2):
            a = ring * meridians
            faces.append([a + k, a + meridians + k, a + meridians + after, a + after])
    return Mesh(points, faces)


def joined(**parts: Mesh) -> Mesh:
    """Several meshes as one, with a material for each."""
    vertices, faces, label = [], [], []
    start = 0
    for number, mesh in enumerate(parts.values()):
        vertices.append(mesh.vertices)
        faces += [(face + start).tolist() for face in mesh.faces]
        label += [number] * len(mesh.faces)
        start += len(mesh.vertices)
    names = FaceLabels(tuple(parts), np.array(label, dtype=np.int32))
    return Mesh(np.concatenate(vertices), faces, materials=names)


def seen_at(camera: Camera, points: NDArray[np.float64], size: tuple[int, int]) -> NDArray:
    """(N, 2) column and row at which a camera sees points: the projection, written out once more.

    0, 0 is the upper left corner of the picture.
    """
    eye, focus = np.array(camera.position), np.array(camera.focus)
    back = (eye - focus) / np.linalg.norm(eye - focus)
    right = np.cross(camera.up, back)
    right /= np.linalg.norm(right)
    above = np.cross(back, right)
    offset = np.atleast_2d(points) - eye
    depth = -(offset @ back)
    focal = size[1] / 2 / np.tan(np.radians(camera.angle) / 2)
    column = size[0] / 2 + focal * (offset @ right) / depth
    row = size[1] / 2 - focal * (offset @ above) / depth
    return np.stack([column, row], axis=1)
