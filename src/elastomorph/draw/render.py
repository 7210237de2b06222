"""One picture of one mesh, in one call."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from elastomorph.draw.camera import Camera
from elastomorph.draw.framing import View, camera_for
from elastomorph.draw.heat import COLOUR_MAP, heat_colours, round_up
from elastomorph.draw.pictures import write_picture
from elastomorph.draw.stage import Image, Stage
from elastomorph.model.mesh import Mesh

__all__ = ["render"]


def render(
    mesh: Mesh,
    path: str | Path | None = None,
    *,
    size: tuple[int, int] = (720, 900),
    view: View | Camera = "front",
    scalars: ArrayLike | None = None,
    highest: float | None = None,
    colour_map: str = COLOUR_MAP,
    wireframe: bool = False,
    lit: bool = True,
) -> Image:
    """Draw a mesh.

    For several poses of one mesh, `Stage` is quicker and keeps one camera.

    Args:
        mesh: Names of materials or groups tell skin from lips, eyes and teeth.
        path: Picture to write, if any; the suffix chooses the format.
        size: Width and height in pixels.
        view: ``front``, ``three-quarter``, ``side``, ``below``, ``mouth``, ``eyes``; degrees to
            the face's left and up; or a camera.
        scalars: (V,) numbers to draw as a heat map instead.
        highest: Their value at the end of the colour map; their largest, rounded up, by default.
        colour_map: A colour map of matplotlib.
        wireframe: Draw the edges of the polygons.
        lit: False shows bare colours, without light and shade.

    Returns:
        (height, width, 3) uint8.

    Raises:
        ParameterError: No such view or colour map, or scalars that do not fit.
        MissingExtraError: vtk (or matplotlib, for a heat map) is not installed.
    """
    camera = view if isinstance(view, Camera) else camera_for(mesh, view, size=size)
    colours = None
    if scalars is not None:
        top = round_up(float(np.max(scalars))) if highest is None else highest
        colours = heat_colours(scalars, top, colour_map=colour_map)
    with Stage(mesh, camera, size=size) as stage:
        image = stage.picture(colours=colours, wireframe=wireframe, lit=lit)
    if path is not None:
        write_picture(image, path)
    return image
