"""A capture whose stages take no time: each makes numbers of what it depends on, and is counted."""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import elastomorph as em
from elastomorph.capturing.cameras.frames import Frame
from elastomorph.capturing.cameras.models import SolvedPose
from elastomorph.capturing.geometry import Camera, Similarity
from elastomorph.capturing.landmarks import _TYPICAL, LANDMARKS, Landmarks
from elastomorph.capturing.neutral import Painted
from elastomorph.capturing.photographs import Photograph, Photographs
from elastomorph.capturing.work.capture import made
from elastomorph.capturing.work.captured import Captured
from elastomorph.capturing.work.makers import Makers, Placed, Posed
from elastomorph.capturing.work.request import requested
from elastomorph.capturing.work.stages import content_digest, packed

POSES = ("a", "neutral", "b", "c")
COUNT = 6
GRID, APART = 12, 7


def template() -> em.Mesh:
    x, y = np.meshgrid(np.arange(GRID), np.arange(GRID))
    z = 0.3 * np.sin(x) * np.cos(y)
    rows = np.arange(GRID * (GRID - 1)).reshape(GRID - 1, GRID)[:, :-1].ravel()
    faces = np.stack([rows, rows + 1, rows + GRID + 1, rows + GRID], axis=1)
    vertices = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    for k, name in enumerate(LANDMARKS):  # they, and what is next to them, where a face has them
        vertices[[APART * k, APART * k + 1]] = GRID * np.array(_TYPICAL[name])
    return em.Mesh(vertices, faces)


def write_photographs(folder: Path, poses: tuple[str, ...] = POSES) -> Path:
    for pose in poses:
        (folder / pose).mkdir(parents=True)
        for k in range(COUNT):
            (folder / pose / f"{k}.jpg").write_text(f"{pose} {k}")
    return folder


def landmarks() -> Landmarks:
    clicks = {name: (float(k), float(k)) for k, name in enumerate(LANDMARKS)}
    return Landmarks(
        {name: APART * k for k, name in enumerate(LANDMARKS)},
        {"neutral": {"0.jpg": clicks, "1.jpg": clicks}},
    )


def numbers(*of: object) -> np.random.Generator:
    """Numbers that differ wherever results do."""
    text = repr([each if isinstance(each, str) else content_digest(packed(each)) for each in of])
    return np.random.default_rng(list(hashlib.sha256(text.encode()).digest()))


@dataclass
class Counted(Makers):
    """Makers that note what they are asked for."""

    calls: list[str]
    before: Callable[[str], None] = lambda stage: None
    version: str = "1"

    def note(self, stage: str) -> None:
        self.before(stage)
        self.calls.append(stage)

    def photographs(self, pose: str, files: Any, masks: Any) -> Photographs:
        self.note(f"photographs/{pose}")
        taken = [
            Photograph(
                file, (40, 30), None, "", "lens", hashlib.sha256(file.read_bytes()).hexdigest()
            )
            for file in files
        ]
        return Photographs(pose, tuple(taken))

    def cameras(self, photographs: Photographs, like: Any, say: Any) -> SolvedPose:
        self.note(f"cameras/{photographs.pose}")
        say("finding cameras", 0.5)
        return self._solved(photographs, *([] if like is None else [like]))

    def given(self, photographs: Photographs, cameras: Any, say: Any) -> SolvedPose:
        self.note(f"given/{photographs.pose}")
        return replace(self._solved(photographs, cameras), cameras=cameras[0])

    def rig(self, poses: Any, neutral: str, say: Any) -> dict[str, SolvedPose]:
        self.note("rig")
        of = ([p.digest for p in own.taken] for own in poses.values())
        return {neutral: self._solved(poses[neutral], *of)}

    def in_rig(self, poses: Any, neutral: str, pose: str, rig: SolvedPose, say: Any) -> SolvedPose:
        self.note(f"cameras/{pose}")
        return self._solved(poses[pose], rig)

    def _solved(self, photographs: Photographs, *of: Any) -> SolvedPose:
        random = numbers([p.digest for p in photographs.taken], *of)
        cameras = tuple(
            Camera(p.name, p.size, 50.0, np.array([19.5, 14.5]), 0.0, np.eye(3), random.random(3))
            for p in photographs.taken
        )
        looks = random.random((5, 128)).astype(np.float32)
        errors, remarks = {c.name: 0.3 for c in cameras}, ("one camera",)
        return SolvedPose(cameras, random.random((5, 3)), looks, errors, remarks=remarks)

    def placed(self, solved: Any, shape: Any, points: Any, pose: str) -> Placed:
        self.note("placed")
        random = numbers(solved, shape.work.vertices, dict(points.vertices), points.distances)
        similarity = Similarity(1 + random.random(), np.eye(3), random.random(3))
        return Placed(similarity, {"chin": random.random(3)}, {"chin": 1.0}, {})

    def neutral(
        self, shape: Any, where: Any, solved: Any, points: Any, views: Any, say: Any
    ) -> Posed:
        self.note("neutral")
        found = self._found(shape.work.vertices, numbers(solved, where, shape.work.vertices))
        return replace(found, figures={"remarks": ["the chin lacks"]})

    def texture(
        self, shape: Any, neutral: Any, cameras: Any, photographs: Any, say: Any
    ) -> dict[str, Painted]:
        self.note("texture")
        assert sorted(photographs) == sorted(camera.name for camera in cameras)
        random = numbers(neutral, list(cameras), shape.mesh.uv.coordinates)
        names = ("",) if shape.mesh.materials is None else shape.mesh.materials.names[:1]
        image = random.integers(255, size=(16, 16, 3)).astype(np.uint8)
        seen = np.arange(256).reshape(16, 16) < 64
        return {name: Painted(image, seen, np.ones((16, 16), dtype=bool)) for name in names}

    def framed(
        self,
        neutral: Any,
        solved: Any,
        name: str,
        face: Any,
        shape: Any,
        points: Any,
        stayed: bool,
    ) -> Frame:
        self.note("frames")
        random = numbers(neutral, solved, face, dict(points.vertices), name, str(stayed))
        similarity = Similarity(1.0, np.eye(3), random.random(3))
        pairs = random.integers(5, size=(4, 2))
        return Frame(similarity, pairs, pairs[:, 0] > 1, random.random())

    def reference(self, shape: Any, neutral: Any, views: Any) -> Any:
        return neutral

    def pose(self, reference: Any, before: Any, matches: Any, views: Any, say: Any) -> Posed:
        self.note("poses")
        say("tracking", 0.5)
        return self._found(before, numbers(reference, before, matches, views.cameras))

    def _found(self, vertices: Any, random: np.random.Generator) -> Posed:
        count = len(vertices)
        return Posed(vertices + 0.1 * random.random((count, 3)), random.random(count))


def run(photos: Path, output: Path, counted: Counted, **options: Any) -> Captured:
    given: dict[str, Any] = {
        "neutral": None,
        "landmarks": landmarks(),
        "distance": None,
        "rig": "walking",
        "masks": None,
        "to": "poses",
        "working": None,
    }
    shape = options.pop("template", template())
    request = requested(photos, shape, output=output, **given | options)
    return made(request, counted, lambda _: None)


def slow(stage: str) -> None:
    """Something to be killed in."""
    print(stage, flush=True)
    time.sleep(0.02)
