"""Where head, camera and lamp of one picture are, from the columns of its face.

The world is that of the rig at rest, looking along +Z with +Y up. A camera's own axes are x to the
right, y down and z away from it (as in OpenCV); pixel centres are at whole numbers.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.textures import linear
from elastomorph.farm.pictures.settings import SETTINGS

__all__ = ["Frame", "Scene", "lamp_colour", "scene_of"]

Matrix = NDArray[np.float64]

_TO_SRGB = np.array(  # linear sRGB of CIE XYZ (IEC 61966-2-1)
    [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]
)
_ADAPTED = 0.6
"""How far a camera's white balance follows the lamp: a photograph by a bulb is less yellow."""
_DAYLIGHT = 6504.0


@dataclass(frozen=True, eq=False)
class Frame:
    """What columns count from: the pivot of the head at rest, and D.

    Attributes:
        pivot: (3,) the middle of what the targets move.
        extent: D, in units of the rig.
        size: Height and width of pictures in pixels.
    """

    pivot: Matrix
    extent: float
    size: tuple[int, int]


@dataclass(frozen=True, eq=False)
class Scene:
    """One picture before it is drawn.

    Attributes:
        head: (3, 4) from the rig's coordinates to the world's.
        camera: (3, 4) from the world's to the camera's.
        intrinsics: (3, 3) to pixels.
        lamp: (3,) unit vector to the lamp, in the camera's axes.
        above: (3,) the world's up, in the camera's axes.
        light: (3,) of the lamp, linear.
        ambient: (3,) from all around, linear.
        background: (3,) linear.
    """

    head: Matrix
    camera: Matrix
    intrinsics: Matrix
    lamp: Matrix
    above: Matrix
    light: Matrix
    ambient: Matrix
    background: Matrix

    def seen(self, positions: NDArray[np.floating]) -> Matrix:
        """(V, 3) in the camera's axes, of positions of the rig."""
        turn = self.camera[:, :3] @ self.head[:, :3]
        shift = self.camera[:, :3] @ self.head[:, 3] + self.camera[:, 3]
        # Sums of three, not a product of matrices, which libraries add up in orders of their own.
        x, y, z = positions.astype(np.float64).T
        return np.stack([x * row[0] + y * row[1] + z * row[2] for row in turn], axis=1) + shift

    def pixels(self, seen: Matrix) -> Matrix:
        """(V, 2) x and y in the picture of (V, 3) points in the camera's axes."""
        focal, (x, y) = self.intrinsics[0, 0], self.intrinsics[:2, 2]
        depth = np.where(seen[:, 2] > 0, seen[:, 2], np.nan)
        return np.stack([seen[:, 0] / depth * focal + x, seen[:, 1] / depth * focal + y], axis=1)

    def slopes(self, places: NDArray[np.floating]) -> Matrix:
        """(N, 2) right and down for each length of depth, of rays through (N, 2) places."""
        return np.asarray((places - self.intrinsics[:2, 2]) / self.intrinsics[0, 0])


def scene_of(frame: Frame, values: Mapping[str, float]) -> Scene:
    """The scene that the values of columns say; those that are missing are at rest."""
    said = {name: float(values.get(name, own.rest)) for name, own in SETTINGS.items()}

    def triple(section: str, *names: str) -> Matrix:
        return np.array([said[f"{section}.{name}"] for name in names])

    yaw, pitch, roll = np.radians(triple("head", "yaw", "pitch", "roll"))
    turn = _about(1, yaw) @ _about(0, -pitch) @ _about(2, -roll)
    place = frame.pivot + frame.extent * triple("head", "x", "y", "z")
    azimuth, elevation, tilt = np.radians(triple("camera", "azimuth", "elevation", "roll"))
    back = _towards(azimuth, elevation)
    right = np.array([np.cos(azimuth), 0.0, -np.sin(azimuth)])
    axes = _about(2, tilt) @ np.stack([right, -np.cross(back, right), -back])
    distance = said["camera.distance"]
    eye = frame.pivot + distance * frame.extent * back
    height, width = frame.size
    x, y = triple("camera", "x", "y")
    focal = said["camera.fill"] * distance * height
    centre = (width - 1) / 2 + x * height, (height - 1) / 2 + y * height
    colour = lamp_colour(said["light.temperature"])
    lamp = _towards(*np.radians(triple("light", "azimuth", "elevation")))
    return Scene(
        head=np.column_stack([turn, place - turn @ frame.pivot]),
        camera=np.column_stack([axes, -axes @ eye]),
        intrinsics=np.array([[focal, 0, centre[0]], [0, focal, centre[1]], [0, 0, 1]]),
        lamp=axes @ lamp,
        above=axes[:, 1],
        light=said["light.strength"] * colour,
        # What comes from all around has come off walls: half of its tint is gone.
        ambient=said["light.ambient"] * (1 + colour) / 2,
        background=linear(triple("background", "red", "green", "blue")),
    )


def lamp_colour(kelvin: float) -> Matrix:
    """(3,) linear sRGB of a black body as a camera shows it, of the same brightness as white.

    The chromaticity is the cubic fit of Kim et al. (US patent 7,024,034), from 1,667 to 25,000 K.
    """
    own = _black_body(kelvin) / _black_body(_DAYLIGHT)
    own = np.maximum(own, 0.0) ** (1 - _ADAPTED)
    return np.asarray(own / (own @ [0.2126, 0.7152, 0.0722]))


def _black_body(kelvin: float) -> Matrix:
    t = 1000.0 / kelvin
    if kelvin <= 4000:
        x = -0.2661239 * t**3 - 0.2343589 * t**2 + 0.8776956 * t + 0.179910
    else:
        x = -3.0258469 * t**3 + 2.1070379 * t**2 + 0.2226347 * t + 0.240390
    if kelvin <= 2222:
        y = -1.1063814 * x**3 - 1.34811020 * x**2 + 2.18555832 * x - 0.20219683
    elif kelvin <= 4000:
        y = -0.9549476 * x**3 - 1.37418593 * x**2 + 2.09137015 * x - 0.16748867
    else:
        y = 3.0817580 * x**3 - 5.87338670 * x**2 + 3.75112997 * x - 0.37001483
    return np.asarray(np.maximum(_TO_SRGB @ [x / y, 1.0, (1 - x - y) / y], 1e-3))


def _towards(azimuth: float, elevation: float) -> Matrix:
    """(3,) the direction so many radians to the face's left and up."""
    flat = np.cos(elevation)
    return np.array([np.sin(azimuth) * flat, np.sin(elevation), np.cos(azimuth) * flat])


def _about(axis: int, angle: float) -> Matrix:
    """(3, 3) the turn by an angle about x, y or z, by the right hand."""
    turn = np.eye(3)
    one, other = (axis + 1) % 3, (axis + 2) % 3
    turn[[one, other], [one, other]] = np.cos(angle)
    turn[other, one], turn[one, other] = np.sin(angle), -np.sin(angle)
    return turn
