"""Where somebody would click landmarks in photographs, and the line where lips meet."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from photographs.cameras import Shot
from photographs.rendering import Scene

__all__ = ["clicked", "ict_lip_line"]

_NOISE = 3.0  # standard deviation of a click, in pixels of a photograph 2000 high
_LEAST_COSINE, _BEHIND = 0.2, 0.3  # of the angle to the surface; cm


def ict_lip_line(folder: Path) -> NDArray[np.int64]:
    """(8, 2) vertices of the ICT head at the ends of the pieces of its inner lips."""
    listed = json.loads((folder / "vertex_indices.json").read_text())["idx_to_landmark_verts"]
    ring = np.array(listed[60:68])  # around the opening
    return np.stack([ring, np.roll(ring, -1)], axis=1)


def clicked(
    scene: Scene,
    shots: tuple[Shot, ...],
    files: tuple[str, ...],
    landmarks: dict[str, int],
    random: np.random.Generator,
) -> dict[str, dict[str, tuple[float, float]]]:
    """Clicks in three photographs in which a landmark is seen well.

    Args:
        scene: The posed head.
        shots: Its cameras.
        files: Their photographs.
        landmarks: Vertices of its surface, by name.
        random: Source of how far a click is off.

    Returns:
        Photograph → landmark → (x, y) in pixels.
    """
    found: dict[str, dict[str, tuple[float, float]]] = {}
    cosines = np.stack([scene.facing(shot, list(landmarks.values()), _BEHIND) for shot in shots])
    for column, (name, vertex) in enumerate(landmarks.items()):
        order = np.argsort(-cosines[:, column])
        # The second best is as good as beside the best: every other one sees it from elsewhere.
        seen = [shot for shot in order if cosines[shot, column] > _LEAST_COSINE]
        for shot in seen[:6:2] if len(seen) > 4 else seen[:3]:
            pixel = shots[shot].project(scene.vertices[vertex])
            pixel = pixel + _NOISE * shots[shot].lens.size[1] / 2000 * random.normal(size=2)
            found.setdefault(files[shot], {})[name] = (float(pixel[0]), float(pixel[1]))
    return found
