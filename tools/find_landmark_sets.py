"""Find the vertices of MediaPipe's 478 face landmarks on the built-in head, ICT FaceKit's.

    python tools/find_landmark_sets.py --model face_landmarker.task

The head is drawn in one colour from three sides, MediaPipe's face landmarker finds its points in
the pictures, each goes back along its ray to the surface, and the nearest vertex of the skin to the
median of the views is taken. Writes `src/elastomorph/capturing/landmark_sets.json`. Needs the
packages mediapipe and embreex, and the model.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from numpy.typing import NDArray
from scipy.spatial import cKDTree

import elastomorph as em
from elastomorph.model.geometry import connected_parts
from elastomorph.model.polygons import polygon_normals
from elastomorph.samples import head

SETS = Path(__file__).parents[1] / "src/elastomorph/capturing/landmark_sets.json"
YAWS = (0.0, -25.0, 25.0)
PIXELS = 700
SKIN, LIGHT = np.array([225.0, 180.0, 155.0]), np.array([0.3, 0.4, 0.86])
Points = NDArray[np.float64]


def drawn(mesh: em.Mesh, yaw: float) -> tuple[NDArray[np.uint8], Points]:
    """A picture from in front, turned by some degrees, and the (H, W, 3) point each pixel sees."""
    turn = np.radians(yaw)
    rotation = np.array(
        [[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]]
    )
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    middle, size = (low + high) / 2, 1.15 * float((high - low)[:2].max())
    turned = (mesh.vertices - middle) @ rotation.T
    triangles = mesh.faces.triangles()
    scene = EmbreeScene()
    TriangleMesh(scene, turned[triangles].astype(np.float32))
    steps = (np.arange(PIXELS) + 0.5) / PIXELS - 0.5
    x, y = np.meshgrid(size * steps, -size * steps)
    origins = np.stack([x, y, np.full_like(x, turned[:, 2].max() + size)], -1).reshape(-1, 3)
    ways = np.tile([0.0, 0.0, -1.0], (len(origins), 1))
    met = scene.run(origins.astype(np.float32), ways.astype(np.float32), output=True)
    seen = met["primID"] >= 0
    points = np.full(origins.shape, np.nan)
    points[seen] = origins[seen] + met["tfar"][seen, None] * ways[seen]
    flat = polygon_normals(turned, mesh.faces)
    normals = np.zeros_like(turned)
    np.add.at(normals, mesh.faces.indices, flat[mesh.faces.corner_faces])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    u, v = met["u"][seen, None], met["v"][seen, None]
    a, b, c = (normals[triangles[met["primID"][seen], corner]] for corner in range(3))
    shade = 0.25 + 0.75 * np.clip(((1 - u - v) * a + u * b + v * c) @ LIGHT, 0, 1)
    picture = np.full(origins.shape, 235, dtype=np.uint8)
    picture[seen] = (shade[:, None] * SKIN).astype(np.uint8)
    shape = (PIXELS, PIXELS, 3)
    return picture.reshape(shape), (points @ rotation + middle).reshape(shape)


def found(mesh: em.Mesh, model: Path) -> list[int]:
    """The vertex of each of the 478 landmarks."""
    import mediapipe
    from mediapipe.tasks import python as tasks
    from mediapipe.tasks.python import vision

    options = vision.FaceLandmarkerOptions(
        base_options=tasks.BaseOptions(model_asset_path=str(model)),
        num_faces=1,
        min_face_detection_confidence=0.3,
    )
    landmarker = vision.FaceLandmarker.create_from_options(options)
    views = []
    for yaw in YAWS:
        picture, points = drawn(mesh, yaw)
        image = mediapipe.Image(image_format=mediapipe.ImageFormat.SRGB, data=picture)
        for face in landmarker.detect(image).face_landmarks:
            at = np.array([[each.x, each.y] for each in face]) * PIXELS
            column, row = np.clip(at.astype(int), 0, PIXELS - 1).T
            views.append(points[row, column])
    places = np.nanmedian(views, axis=0)
    skin = max(connected_parts(len(mesh.vertices), mesh.edges), key=len)
    vertices = skin[cKDTree(mesh.vertices[skin]).query(np.nan_to_num(places))[1]]
    print(f"{len(views)} of {len(YAWS)} views, {np.isnan(places[:, 0]).sum()} beside the head")
    return [int(vertex) for vertex in vertices]


def main() -> None:
    """Write the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--model", type=Path, required=True)
    chosen = parser.parse_args()
    SETS.write_text(json.dumps(found(head(), chosen.model)) + "\n")


if __name__ == "__main__":
    main()
