"""Small meshes to draw, a small evaluation, and where a camera sees their points."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from elastomorph.curves import Curve, CurveNetwork
from elastomorph.draw.camera import Camera
from elastomorph.evaluation import Evaluation, evaluate
from elastomorph.model.mesh import FaceLabels, Mesh
from elastomorph.model.sequence import MeshSequence

__all__ = ["ball", "evaluation", "joined", "rings", "seen_at", "sphere"]


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


@pytest.fixture(scope="session")
def sphere() -> Mesh:
    """The unit sphere."""
    return ball(rings=24, meridians=48)


@pytest.fixture(scope="session")
def rings() -> CurveNetwork:
    """The parallels of a small ball as closed curves, its poles as curves of one vertex."""
    curves = [Curve(np.arange(24) + 24 * ring, True) for ring in range(11)]
    return CurveNetwork([*curves, Curve([264]), Curve([265])], 266)


@pytest.fixture(scope="session")
def evaluation(rings: CurveNetwork) -> Evaluation:
    """A ball that grows and moves aside, compared with a few methods."""
    mesh = ball()
    times = np.linspace(0.0, 1.0, 5)
    push = np.array([0.6, 0.0, 0.2]) + 0.3 * mesh.vertices * (1 + mesh.vertices[:, :1])
    frames = [mesh.vertices + time**1.5 * push for time in times]
    methods = ["linear", "ease:2", "beam:1", "beam:2", "beam:2:unforced"]
    return evaluate(MeshSequence(mesh, np.stack(frames), times), methods, rings)
