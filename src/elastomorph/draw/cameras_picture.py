"""The cameras of photographs around the head that they show."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.capturing.geometry import camera as photographs
from elastomorph.draw.actors import Lines
from elastomorph.draw.camera import Camera
from elastomorph.draw.pictures import Image, written
from elastomorph.draw.stage import Stage
from elastomorph.errors import ParameterError
from elastomorph.model.mesh import Mesh
from elastomorph.model.polygons import Polygons

__all__ = ["cameras_picture"]

CAMERA = (0.12, 0.42, 0.78)
CLAY = (0.80, 0.67, 0.60)
_DARK = (0.12, 0.14, 0.17)
_LENGTH = 0.09  # of a camera's pyramid over its distance from the middle of the head


def cameras_picture(
    mesh: Mesh,
    cameras: Sequence[photographs.Camera],
    path: str | Path | None = None,
    *,
    colours: ArrayLike | None = None,
    shades: ArrayLike | None = None,
    view: str | tuple[float, float] = (38.0, 28.0),
    size: tuple[int, int] = (1000, 800),
) -> Image:
    """Draw a head with a pyramid for each camera: its tip is where the lens is.

    Args:
        mesh: The head, looking along +Z with +Y up, in the frame of the cameras' world.
        cameras: Those of its photographs.
        path: Where the picture is written, if it is.
        colours: (N, 3) red, green, blue of each camera from 0 to 1, as from
            `elastomorph.draw.heat_colours` of their errors.
        shades: (V, 3) those of the vertices, as of their confidence.
        view: A name of `elastomorph.draw.VIEWS`, or degrees to the face's left and up.
        size: Width and height in pixels.

    Returns:
        (H, W, 3) uint8.

    Raises:
        ParameterError: There are no cameras, or other numbers of colours.
    """
    if not cameras:
        raise ParameterError("there are no cameras to draw; solve some first")
    own = np.broadcast_to(CAMERA, (len(cameras), 3)) if colours is None else np.asarray(colours)
    skin = np.broadcast_to(CLAY, mesh.vertices.shape) if shades is None else np.asarray(shades)
    for found, expected, what in (
        (own, (len(cameras), 3), "cameras"),
        (skin, mesh.vertices.shape, "vertices"),
    ):
        if found.shape != expected:
            raise ParameterError(f"colours of {what} must be {expected}, found {found.shape}")
    middle = (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0)) / 2
    pyramids = np.stack([_pyramid(each, middle) for each in cameras])
    first = len(mesh.vertices) + 5 * np.arange(len(cameras))[:, None]
    scene = _scene(mesh, pyramids.reshape(-1, 3), first)
    painted = np.concatenate([skin, np.repeat(own, 5, axis=0)])
    outline = np.concatenate([first + [0, 1, 2, 0, 3, 4, 0], first + [1, 2, 3, 4, 1, 2, 3]])
    lines = Lines(outline, np.broadcast_to(_DARK, (len(outline), 3)), 1.2)
    aim = Camera.framing(scene.vertices, view, size=size)
    with Stage(scene, aim, size=size) as stage:
        return written(stage.picture(colours=painted, lines=[lines]), path)


def _pyramid(camera: photographs.Camera, middle: NDArray[np.float64]) -> NDArray[np.float64]:
    """(5, 3) the lens, and the corners of what it sees a short way before it."""
    width, height = camera.size
    corners = np.array([[0, 0], [width - 1, 0], [width - 1, height - 1], [0, height - 1]], float)
    length = _LENGTH * float(np.linalg.norm(camera.position - middle))
    return np.vstack([camera.position, camera.position + length * camera.through(corners)])


def _scene(mesh: Mesh, pyramids: NDArray[np.float64], first: NDArray[np.int64]) -> Mesh:
    """The head and the pyramids as one mesh; what parts of the head are called does not count."""
    sides = [first + corners for corners in ([0, 2, 1], [0, 3, 2], [0, 4, 3], [0, 1, 4])]
    triangles = np.concatenate(sides)
    backs = first + [1, 2, 3, 4]
    indices = np.concatenate([mesh.faces.indices, triangles.ravel(), backs.ravel()])
    sizes = np.concatenate([mesh.faces.sizes, np.full(len(triangles), 3), np.full(len(backs), 4)])
    offsets = np.concatenate([[0], np.cumsum(sizes)])
    return Mesh(np.concatenate([mesh.vertices, pyramids]), Polygons(indices, offsets))
