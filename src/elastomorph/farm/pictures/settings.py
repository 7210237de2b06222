"""What of a picture a recipe may vary: the columns, their ranges and their limits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

LARGEST = 4096
"""Most pixels that a picture has on a side."""

ARRAYS = ("colour", "depth", "normals", "parts", "landmarks", "camera")
"""What may be made of each picture; the camera is three arrays: camera, head and intrinsics."""


@dataclass(frozen=True)
class Setting:
    """One column of pictures.

    Attributes:
        low: Where its range begins if the recipe says nothing.
        high: Where it ends.
        least: What no recipe may go below.
        most: What none may go above.
        rest: The value where there is no such column.
        meaning: With its unit, for messages and documentation.
    """

    low: float
    high: float
    least: float
    most: float
    rest: float
    meaning: str


SETTINGS: Mapping[str, Setting] = {
    "head.yaw": Setting(-30, 30, -180, 180, 0, "turn of the head to its left, in degrees"),
    "head.pitch": Setting(-15, 15, -90, 90, 0, "nod of the head upwards, in degrees"),
    "head.roll": Setting(-10, 10, -180, 180, 0, "tilt to its left shoulder, in degrees"),
    "head.x": Setting(0, 0, -2, 2, 0, "how far the head is to its left, in D"),
    "head.y": Setting(0, 0, -2, 2, 0, "how far the head is up, in D"),
    "head.z": Setting(0, 0, -2, 2, 0, "how far the head is forward, in D"),
    "camera.azimuth": Setting(-20, 20, -180, 180, 0, "camera to the face's left, in degrees"),
    "camera.elevation": Setting(-10, 15, -89, 89, 0, "camera above the face, in degrees"),
    "camera.roll": Setting(-5, 5, -180, 180, 0, "turn of the picture clockwise, in degrees"),
    "camera.distance": Setting(2.5, 6, 1, 1000, 4, "from the middle of the head, in D"),
    "camera.fill": Setting(0.7, 0.95, 0.05, 20, 0.85, "part of the picture's height D takes"),
    "camera.x": Setting(-0.05, 0.05, -1, 1, 0, "middle of the head to the right, in heights"),
    "camera.y": Setting(-0.05, 0.05, -1, 1, 0, "middle of the head downwards, in heights"),
    "light.azimuth": Setting(-70, 70, -180, 180, 30, "lamp to the face's left, in degrees"),
    "light.elevation": Setting(-10, 60, -90, 90, 35, "lamp above the face, in degrees"),
    "light.strength": Setting(0.6, 1.2, 0, 10, 1, "of the lamp; 1 is a picture well exposed"),
    "light.temperature": Setting(3500, 8500, 1700, 25000, 6500, "colour of the lamp, in kelvin"),
    "light.ambient": Setting(0.25, 0.6, 0, 10, 0.4, "light from all around, as strength"),
    "background.red": Setting(0.1, 0.9, 0, 1, 0.6, "of the background, in sRGB"),
    "background.green": Setting(0.1, 0.9, 0, 1, 0.6, "of the background, in sRGB"),
    "background.blue": Setting(0.1, 0.9, 0, 1, 0.6, "of the background, in sRGB"),
}
"""All columns of pictures, in their order in a row.

The camera looks at the middle of what the targets move, as it is at rest: the pivot of the head.
D is the extent of that, as for errors. A focal length follows from fill and distance: it is their
product, times the height of the picture.
"""
