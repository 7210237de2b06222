"""Painted surfaces and their photographs, drawn from what is known of both."""

import numpy as np
from scipy.spatial.transform import Rotation

from elastomorph.capturing.geometry import Camera, Surface, View


def grid(count: int, curve: float = 0.15) -> tuple[np.ndarray, np.ndarray]:
    """A curved square from −1 to 1: (V, 3) vertices and (T, 3) triangles, seen from +z."""
    x, y = np.meshgrid(np.linspace(-1, 1, count), np.linspace(-1, 1, count))
    vertices = np.stack([x.ravel(), y.ravel(), -curve * (x**2 + y**2).ravel()], axis=1)
    index = np.arange(count * count).reshape(count, count)
    a, b, c, d = (
        part.ravel() for part in (index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1])
    )
    return vertices, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def ring(size: tuple[int, int], count: int, distance: float = 6.0, seed: int = 3) -> list[Camera]:
    """Cameras on a cap around +z that all look at the origin, which D = 2.8 fills."""
    random = np.random.default_rng(seed)
    cameras = []
    for number in range(count):
        turn = 2 * np.pi * number / count
        tilt = np.radians(8 + 14 * (number % 3)) + random.normal(0, 0.03)
        away = Rotation.from_euler("zx", [turn, tilt]).as_matrix() @ [0, 0, 1]
        position = distance * away
        forward = -away
        right = np.cross(forward, [0, 1, 0])
        right /= np.linalg.norm(right)
        rotation = np.stack([right, np.cross(forward, right), forward])
        focal = 0.36 * size[0] * distance
        centre = np.array(size) / 2 + random.normal(0, 3, 2)
        cameras.append(
            Camera(f"{number}.png", size, focal, centre, 0.0, rotation, -rotation @ position)
        )
    return cameras


def paint(seed: int = 0):
    """A colour (grey value) for (..., 3) places of the skin at rest: noise of all lengths."""
    random = np.random.default_rng(seed)
    waves = random.normal(size=(80, 3)) * [1, 1, 0.2]
    lengths = np.geomspace(4, 60, 80)[:, None]
    waves *= lengths / np.linalg.norm(waves, axis=1, keepdims=True)
    phases = random.uniform(0, 2 * np.pi, 80)

    def colour(places: np.ndarray) -> np.ndarray:
        return 128 + 8 * np.sin(places @ waves.T + phases).sum(axis=-1)

    return colour


def photograph(
    camera: Camera, surface: Surface, rest: np.ndarray, colour, noise: float = 1.5, seed: int = 0
) -> View:
    """What a camera sees of a painted surface under light from the front."""
    hits = surface.seen(camera)
    light = surface.at(hits, surface.normals)[..., 2]
    grey = np.full(camera.size[::-1], 60.0)
    met = hits.met
    grey[met] = colour(surface.at(hits, rest)[met]) * (0.6 + 0.4 * light[met])
    grey += np.random.default_rng([seed, int(camera.name.split(".")[0])]).normal(
        0, noise, grey.shape
    )
    grey8 = np.clip(np.round(grey), 0, 255).astype(np.uint8)
    return View(camera, grey8, None)
