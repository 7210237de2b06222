"""A capture of a ball whose photographs are drawn, to be reported."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from elastomorph.capturing.geometry import Camera, Surface
from elastomorph.capturing.work.captured import Captured
from elastomorph.capturing.work.registered import Registered
from elastomorph.model.mesh import FaceLabels, Mesh
from scenes import ball

SIZE = (180, 240)
SKIN, WALL = (200, 150, 120), (60, 70, 90)


def camera(name: str, turn: float, radial: float = 0.0) -> Camera:
    """One that looks at the ball from a distance of 6, off its middle."""
    cos, sin = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    ahead = np.array([-sin, 0.0, -cos])
    rotation = np.stack([np.cross([0, -1.0, 0], ahead), [0, -1.0, 0], ahead])
    position = -6.0 * ahead + [0.2, 0.1, 0]
    centre = np.array([93.0, 116.0])
    return Camera(name, SIZE, 420.0, centre, radial, rotation, -rotation @ position)


def template() -> Mesh:
    """A ball with a face, a nose and what has no name."""
    mesh = ball(rings=24, meridians=48)
    middles = np.array([mesh.vertices[face].mean(axis=0) for face in mesh.faces])
    part = np.where(middles[:, 2] > 0.9, 1, np.where(middles[:, 2] > -0.5, 0, -1))
    return Mesh(mesh.vertices, mesh.faces, groups=FaceLabels(("face", "nose"), part.astype("i4")))


def photograph(path: Path, camera: Camera, vertices: np.ndarray, triangles: np.ndarray) -> None:
    """As the camera takes the ball, through its lens."""
    import cv2

    columns, rows = np.meshgrid(np.arange(SIZE[0]), np.arange(SIZE[1]))
    pixels = np.stack([columns, rows], axis=-1).astype(float)
    rays = camera.through(camera.undistorted(pixels))
    hits = Surface(vertices, triangles).cast(camera.position, rays)
    colour = np.where(hits.met[..., None], SKIN, WALL).astype(np.uint8)
    assert cv2.imwrite(str(path), colour[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 97])


def capture(folder: Path, *, radial: float = 0.1, figures: Any = None) -> Captured:
    """Two poses, the second longer; the nose of it is not to be trusted."""
    mesh = template()
    poses, cameras, photographs, measured = {}, {}, {}, {}
    for pose, stretch in (("rest", 1.0), ("long & <b>", 1.2)):
        vertices = mesh.vertices * [1, stretch, 1]
        confidence = np.where(vertices[:, 2] > (0.95 if stretch > 1 else 9), 0.3, 0.9)
        poses[pose] = Registered.of(mesh, vertices, confidence)
        cameras[pose] = tuple(camera(f"{k}.jpg", turn, radial) for k, turn in enumerate((-40, 0)))
        photographs[pose] = {}
        for own in cameras[pose]:
            file = folder / f"{len(photographs)}-{own.name}"
            photograph(file, own, vertices, mesh.faces.triangles())
            photographs[pose][own.name] = file
        measured[pose] = {
            "photographs": 3,
            "cameras": 2,
            "points": 1234,
            "reprojection": {"0.jpg": 0.25, "1.jpg": 0.5},
            "rejected": {"2.jpg": "it shows <nothing>"},
            "remarks": [],
            "surface": {"points": 1200, "median": 0.0003, "p95": 0.0011},
        }
    measured["long & <b>"] |= {
        "correspondence": {"matches": 900, "median": 0.0042, "p95": 0.0123, "seen": 0.875},
        "frame": {"rms": 0.01, "rms_of_extent": 0.0034, "agreeing": 77},
        "remarks": ["there are few photographs"],
    }
    found = {
        "poses": measured,
        "landmarks": {"nose_tip": 1.25},
        "seconds": {"cameras/rest": 61.0, "neutral": 9.0},
    }
    return Captured(poses, cameras, photographs, "rest", found if figures is None else figures)
