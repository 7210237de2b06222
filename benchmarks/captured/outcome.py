"""What `elastomorph capture` and `register` wrote, and what its cameras are worth."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from captured.geometry import Similar, closest, similarity
from photographs.truth import Truth

__all__ = [
    "Outcome",
    "Positions",
    "by_surface",
    "camera_errors",
    "frame_errors",
    "into_truth",
    "read_bundle",
]

Points = NDArray[np.float64]
Positions = dict[str, Points]  # photograph → (3,) of its camera
_ROUNDS = 30


@dataclass(frozen=True, eq=False)
class Outcome:
    """A folder of results.

    Attributes:
        poses: Pose → (N, 3) vertices.
        confidence: Pose → (N,).
        cameras: Pose → photograph → position of the camera.
        focal: Pose → photograph → focal length in pixels.
        figures: All of ``capture.json``.
    """

    poses: dict[str, Points]
    confidence: dict[str, Points]
    cameras: dict[str, Positions]
    focal: dict[str, dict[str, float]]
    figures: dict[str, Any]

    @classmethod
    def read(cls, folder: Path) -> Outcome:
        """What is there of it."""
        kept = folder / "capture.json"
        figures = json.loads(kept.read_text()) if kept.exists() else {}
        confidence = {}
        if (folder / "confidence.npz").exists():
            with np.load(folder / "confidence.npz") as file:
                confidence = {name: file[name].astype(float) for name in file.files}
        cameras, focal = {}, {}
        for pose, own in figures.get("cameras", {}).items():
            cameras[pose] = {
                name: -np.array(camera["rotation"]).T @ np.array(camera["translation"])
                for name, camera in own.items()
            }
            focal[pose] = {name: float(camera["focal"]) for name, camera in own.items()}
        poses = {path.stem: _vertices(path) for path in sorted(folder.glob("*.obj"))}
        return cls(poses, confidence, cameras, focal, figures)


def _vertices(path: Path) -> Points:
    """(N, 3) of an OBJ."""
    rows = [line.split()[1:4] for line in path.read_text().splitlines() if line.startswith("v ")]
    return np.array(rows, dtype=float)


def _both(found: Positions, true: Positions) -> tuple[Points, Points]:
    names = sorted(set(found) & set(true))
    return np.array([found[name] for name in names]), np.array([true[name] for name in names])


def true_positions(truth: Truth, pose: str) -> Positions:
    """Where cameras of a pose stand, in the frame of the neutral's head."""
    return {
        file: truth.in_neutral(pose, shot.position)
        for file, shot in zip(truth.files, truth.cameras[pose], strict=True)
    }


def camera_errors(found: Positions, true: Positions) -> Points:
    """(n,) distances of cameras from the true ones, after the best similarity of them."""
    own, goal = _both(found, true)
    return np.linalg.norm(similarity(own, goal)(own) - goal, axis=1)


def into_truth(outcome: Outcome, truth: Truth, first: str = "p00") -> Similar:
    """From the frame of a result to that of the truth, by cameras of the neutral."""
    return similarity(*_both(outcome.cameras[first], true_positions(truth, first)))


def frame_errors(outcome: Outcome, truth: Truth, pose: str, first: str = "p00") -> Points:
    """(n,) how far the frame of a pose carries points of the head from where they are, in cm.

    The true frame of a pose is the similarity from its cameras, as found, to the true ones; that of
    the neutral likewise. Without an error both are one.
    """
    own, goal = _both(outcome.cameras[pose], true_positions(truth, pose))
    back = similarity(goal, own)
    head = truth.vertices[pose][truth.of_template]
    return np.linalg.norm(into_truth(outcome, truth, first)(back(head)) - head, axis=1)


def by_surface(vertices: Points, truth: Truth, first: str = "p00") -> Similar:
    """From the frame of a registered neutral to that of the truth, by the closest surface.

    It starts from the template's own vertices and needs no cameras.
    """
    rest = truth.vertices[first]
    found = similarity(vertices, rest[truth.of_template])
    for _ in range(_ROUNDS):
        moved = found(vertices)
        near = closest(moved, rest, truth.triangles)
        close = near.distances < np.quantile(near.distances, 0.8)
        goal = near.on(rest, truth.triangles)
        found = similarity(vertices[close], goal[close])
    return found


def read_bundle(folder: Path) -> tuple[Positions, float]:
    """Positions of the cameras of a Bundler file and their focal length in pixels.

    ``cameras.out`` and ``ordered_filenames.txt``: of each camera f k1 k2, R, t with Y = R X + t.
    """
    lines = (folder / "cameras.out").read_text().splitlines()[1:]
    _, *names = (folder / "ordered_filenames.txt").read_text().split()  # their number comes first
    count = int(lines[0].split()[0])
    numbers = np.array(" ".join(lines[1 : 1 + 5 * count]).split(), dtype=float).reshape(count, 15)
    positions = {
        name: -row[3:12].reshape(3, 3).T @ row[12:]
        for name, row in zip(names, numbers, strict=True)
    }
    return positions, float(np.median(numbers[:, 0]))
