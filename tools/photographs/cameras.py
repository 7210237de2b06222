"""Cameras in rings around a head, and their lens.

A point X of the world is at Y = R X + t of a camera, which looks along +z with y down. Its pixel is
focal · (1 + k1 r²) · (x, y) + centre with (x, y) = Y[:2] / Y[2] and r² = x² + y²; the centre of the
first pixel is (0, 0).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

__all__ = ["RINGS", "Lens", "Shot", "Spread", "around"]

RINGS = (-14.0, 8.0, 32.0)  # degrees of elevation; one at -35 shows what is under the chin
_ROUNDS = 12  # of the fixed point that undoes the distortion: each takes off two digits or more


@dataclass(frozen=True)
class Lens:
    """The inner parameters of a camera.

    Attributes:
        size: Width and height in pixels.
        focal: Focal length in pixels.
        centre: Principal point in pixels, x and y.
        radial: k1, dimensionless.
    """

    size: tuple[int, int]
    focal: float
    centre: tuple[float, float]
    radial: float = 0.0

    @classmethod
    def of_size(cls, width: int, height: int, radial: float = -0.04) -> Lens:
        """The lens of a phone held upright: 45 mm equivalent, the principal point off centre."""
        centre = (width * (757 / 1500) - 0.5, height * (992 / 2000) - 0.5)
        return cls((width, height), 1.3 * height, centre, radial)

    def pixels(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., 2) pixels of points (..., 3) in the frame of the camera."""
        plane = points[..., :2] / points[..., 2:]
        stretch = 1 + self.radial * (plane**2).sum(axis=-1, keepdims=True)
        return self.focal * stretch * plane + np.array(self.centre)

    def directions(self, samples: int = 1) -> NDArray[np.float32]:
        """(H·samples, W·samples, 3) directions through every sample of every pixel, with z = 1."""
        return _directions(self, samples)


@cache
def _directions(lens: Lens, samples: int) -> NDArray[np.float32]:
    width, height = (samples * side for side in lens.size)
    across = (np.arange(width) + 0.5) / samples - 0.5
    down = (np.arange(height) + 0.5) / samples - 0.5
    seen = np.stack(np.meshgrid(across, down), axis=-1)
    seen = (seen - np.array(lens.centre)) / lens.focal
    plane = seen
    for _ in range(_ROUNDS):
        plane = seen / (1 + lens.radial * (plane**2).sum(axis=-1, keepdims=True))
    found = np.concatenate([plane, np.ones((*plane.shape[:2], 1))], axis=-1).astype(np.float32)
    found.flags.writeable = False
    return found


@dataclass(frozen=True, eq=False)
class Shot:
    """A lens at a place: from the world to its photograph.

    Attributes:
        lens: The inner parameters.
        rotation: (3, 3) from the world to the camera.
        position: (3,) of the camera in the world.
    """

    lens: Lens
    rotation: NDArray[np.float64]
    position: NDArray[np.float64]

    @property
    def translation(self) -> NDArray[np.float64]:
        """(3,) t of Y = R X + t."""
        return -self.rotation @ self.position

    def beside(self, turn: NDArray[np.float64], shift: NDArray[np.float64]) -> Shot:
        """The shot of X that sees what this one sees of turn X + shift."""
        return Shot(self.lens, self.rotation @ turn, turn.T @ (self.position - shift))

    def project(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., 2) pixels of points (..., 3) of the world, with the distortion of the lens."""
        return self.lens.pixels((points - self.position) @ self.rotation.T)


@dataclass(frozen=True)
class Spread:
    """Where cameras stand.

    Attributes:
        rings: Elevation of each ring in degrees; cameras are shared out evenly.
        azimuth: Each ring goes from minus to plus this angle, in degrees.
        jitter: How far places and aims are from even ones: 1 is by hand, 0 exact.
        distance: From the head, in cm.
        aim: (3,) where the axes meet, in cm.
    """

    rings: tuple[float, ...] = RINGS
    azimuth: float = 90.0
    jitter: float = 1.0
    distance: float = 57.0
    aim: tuple[float, float, float] = (0.0, -1.5, 1.0)


def around(
    lens: Lens, count: int, spread: Spread, seed: int | Sequence[int] = 0
) -> tuple[Shot, ...]:
    """Cameras on rings around a head that looks along +z with +y up."""
    random = np.random.default_rng(seed)
    shots = []
    for ring, angles in enumerate(np.array_split(np.arange(count), len(spread.rings))):
        places = np.linspace(-spread.azimuth, spread.azimuth, len(angles))
        step = places[1] - places[0] if len(places) > 1 else 0.0
        # Rings are set against each other, as a walker's steps are.
        places = places + step * (0.15 if ring % 2 else -0.15)
        for azimuth in places:
            off = spread.jitter * random.normal(size=8)
            shots.append(_shot(lens, spread, azimuth + 2.5 * off[0], ring, off[1:]))
    return tuple(shots)


def _shot(lens: Lens, spread: Spread, azimuth: float, ring: int, off: NDArray[np.float64]) -> Shot:
    """A camera that is off by some standard deviations in elevation, distance, aim and roll."""
    elevation, across = np.radians(spread.rings[ring] + 2 * off[0]), np.radians(azimuth)
    aim = np.array(spread.aim) + 0.6 * off[2:5]
    way = np.array(
        [
            np.sin(across) * np.cos(elevation),
            np.sin(elevation),
            np.cos(across) * np.cos(elevation),
        ]
    )
    right = np.cross(-way, [0.0, 1.0, 0.0])
    right /= np.linalg.norm(right)
    upright = np.stack([right, np.cross(-way, right), -way])
    roll = np.radians(2 * off[5])
    turn = np.array(
        [[np.cos(roll), -np.sin(roll), 0], [np.sin(roll), np.cos(roll), 0], [0, 0, 1.0]]
    )
    distance = spread.distance * (1 + 0.035 * off[1])
    return Shot(lens, turn @ upright, aim + distance * way)
