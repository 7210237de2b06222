"""A spotted egg before cameras: features whose places are projections and whose looks are known."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from elastomorph.capturing.cameras.features import Features
from elastomorph.capturing.geometry import Camera, fit_similarity
from elastomorph.capturing.photographs import Photograph, Photographs

SIZE = (750, 1000)
FOCAL = 1300.0
OFF = np.array([30.0, -45.0])  # of the lens's axis from the middle, px
RADIAL = -0.04
AXES = np.array([7.0, 10.0, 8.0])
NOISE = 0.15


@dataclass(frozen=True, eq=False)
class Egg:
    """Spots on an egg.

    Attributes:
        points: (N, 3).
        normals: (N, 3) where it faces.
        looks: (N, 128) before noise.
    """

    points: np.ndarray
    normals: np.ndarray
    looks: np.ndarray

    def moved(self, shift: np.ndarray, turn: np.ndarray | None = None) -> Egg:
        """As another pose holds it."""
        turn = np.eye(3) if turn is None else turn
        return Egg(self.points @ turn.T + shift, self.normals @ turn.T, self.looks)


def egg(seed: int = 0, count: int = 1400) -> Egg:
    random = np.random.default_rng(seed)
    sphere = random.normal(size=(count, 3))
    sphere /= np.linalg.norm(sphere, axis=1, keepdims=True)
    normals = sphere / AXES
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Egg(sphere * AXES, normals, np.abs(random.normal(size=(count, 128))))


def cameras(count: int = 12, seed: int = 1, widest: float = 70.0) -> list[Camera]:
    """Two rings of cameras that look at the middle."""
    random = np.random.default_rng(seed)
    found = []
    for k in range(count):
        azimuth = np.radians(np.linspace(-widest, widest, count)[k] + random.normal() * 2)
        height = np.radians((14.0 if k % 2 else -8.0) * min(1.0, widest / 30) + random.normal())
        away = np.array(
            [
                np.sin(azimuth) * np.cos(height),
                np.sin(height),
                np.cos(azimuth) * np.cos(height),
            ]
        )
        place = (56 + random.normal()) * away
        z = random.normal(size=3) * 0.4 - place
        z /= np.linalg.norm(z)
        x = np.cross(z, [0.0, 1.0, 0.0])
        x /= np.linalg.norm(x)
        roll = 0.15 * random.normal()  # Held by hand; without it the lens's centre is not fixed
        x = np.cos(roll) * x + np.sin(roll) * np.cross(z, x)
        rotation = np.stack([x, np.cross(z, x), z])
        centre = (np.array(SIZE) - 1) / 2 + OFF
        found.append(
            Camera(f"{k:02d}.jpg", SIZE, FOCAL, centre, RADIAL, rotation, -rotation @ place)
        )
    return found


def seen(camera: Camera, of: Egg, seed: int, noise: float = NOISE) -> Features:
    """What is found in a photograph of it, in an order of its own, with a few that are nothing."""
    random = np.random.default_rng([seed, 77])
    pixels, _ = camera.project(of.points)
    towards = camera.position - of.points
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    pixels = camera.distorted(pixels)
    visible = np.flatnonzero(((of.normals * towards).sum(axis=1) > 0.35) & camera.inside(pixels))
    visible = random.permutation(visible)
    looks = of.looks[visible] + 0.08 * random.normal(size=(len(visible), 128))
    places = pixels[visible] + noise * random.normal(size=(len(visible), 2))
    places = np.concatenate([places, random.uniform(0, SIZE, size=(60, 2))])
    looks = np.concatenate([looks, np.abs(random.normal(size=(60, 128)))]).clip(0)
    looks *= 512 / np.linalg.norm(looks, axis=1, keepdims=True)
    sizes = 2 + 3 * random.random(len(places))
    shapes = sizes[:, None] * np.array([1.0, 0, 0, 1.0])
    return Features(places, shapes.astype(np.float32), looks.clip(0, 255).astype(np.uint8))


def taken(by: Sequence[Camera], pose: str = "neutral", focal: float | None = FOCAL) -> Photographs:
    """Photographs that need no files."""
    return Photographs(
        pose,
        tuple(
            Photograph(Path(pose) / camera.name, camera.size, focal, "", "X1", f"{pose}{k}")
            for k, camera in enumerate(by)
        ),
    )


def finder(views: dict[str, dict[str, Features]]) -> Callable[..., list[Features]]:
    """Stands for `find_features`: pose → photograph → what is found in it."""

    def find(
        photographs: Sequence[Photograph],
        *,
        fine: bool = False,
        done: Callable[[int], None] = lambda count: None,
    ) -> list[Features]:
        done(len(photographs))
        return [views[photograph.path.parent.name][photograph.name] for photograph in photographs]

    return find


def centres_off(found: Sequence[Camera], true: Sequence[Camera]) -> float:
    """Mean distance of camera centres from the true ones, in the unit of the egg."""
    places = {camera.name: camera.position for camera in true}
    goal = np.array([places[camera.name] for camera in found])
    source = np.array([camera.position for camera in found])
    return float(np.linalg.norm(fit_similarity(source, goal)(source) - goal, axis=1).mean())


def renamed(by: Sequence[Camera], prefix: str) -> list[Camera]:
    return [replace(camera, name=f"{prefix}{camera.name}") for camera in by]
