"""Landmarks of the subjects, and where somebody would click them in photographs."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from photographs.cameras import Shot
from photographs.rendering import Scene

__all__ = ["both_sides", "clicked", "ict", "ict_lip_line"]

# Vertices of the built-in head; what is on the left has a partner on the right.
_BUILT_IN = {
    "nose_tip": 476,
    "left_eye_inner": 1627,
    "left_eye_outer": 1614,
    "nose_bridge": 318,
    "left_nostril": 640,
    "mouth_left": 1968,
    "upper_lip": 1959,
    "lower_lip": 1977,
    "chin": 912,
    "left_jaw": 738,
}
# Places among the 68 landmarks of the ICT rig, which are those of iBUG's 300-W.
_OF_68 = {
    "nose_tip": 30,
    "right_eye_outer": 36,
    "right_eye_inner": 39,
    "left_eye_inner": 42,
    "left_eye_outer": 45,
    "nose_bridge": 27,
    "right_nostril": 31,
    "left_nostril": 35,
    "mouth_right": 48,
    "mouth_left": 54,
    "upper_lip": 51,
    "lower_lip": 57,
    "chin": 8,
    "right_jaw": 2,
    "left_jaw": 14,
}
_LEAST_COSINE, _BEHIND = 0.2, 0.3  # of the angle to the surface; cm


def ict(folder: Path) -> dict[str, int]:
    """Vertices of the ICT head, by name of the landmark."""
    listed = json.loads((folder / "vertex_indices.json").read_text())["idx_to_landmark_verts"]
    return {name: int(listed[place]) for name, place in _OF_68.items()}


def ict_lip_line(folder: Path) -> NDArray[np.int64]:
    """(8, 2) vertices of the ICT head at the ends of the pieces of its inner lips."""
    listed = json.loads((folder / "vertex_indices.json").read_text())["idx_to_landmark_verts"]
    ring = np.array(listed[60:68])  # around the opening
    return np.stack([ring, np.roll(ring, -1)], axis=1)


def both_sides(vertices: NDArray[np.float64]) -> dict[str, int]:
    """Vertices of the built-in head, by name of the landmark."""
    own = dict(_BUILT_IN)
    for name, vertex in _BUILT_IN.items():
        if "left" in name:
            mirrored = vertices[vertex] * [-1, 1, 1]
            nearest = np.linalg.norm(vertices - mirrored, axis=1).argmin()
            own[name.replace("left", "right")] = int(nearest)
    return own


def clicked(
    scene: Scene,
    shots: tuple[Shot, ...],
    files: tuple[str, ...],
    landmarks: dict[str, int],
    random: np.random.Generator,
    noise: float = 3.0,
) -> dict[str, dict[str, tuple[float, float]]]:
    """Clicks in three photographs in which a landmark is seen well.

    Args:
        scene: The posed head.
        shots: Its cameras.
        files: Their photographs.
        landmarks: Vertices of its surface, by name.
        random: Source of how far a click is off.
        noise: Standard deviation of that, in pixels of a photograph 2000 high.

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
            pixel = pixel + noise * shots[shot].lens.size[1] / 2000 * random.normal(size=2)
            found.setdefault(files[shot], {})[name] = (float(pixel[0]), float(pixel[1]))
    return found
