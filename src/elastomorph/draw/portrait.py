"""Faces drawn alike: with the same lines, colours, background and legend in every pose."""

from __future__ import annotations

from dataclasses import dataclass
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.camera import Camera
from elastomorph.draw.curves_picture import CLAY
from elastomorph.draw.extras import imported
from elastomorph.draw.grid import ColourScale, picture_grid
from elastomorph.draw.heat import heat_colours
from elastomorph.draw.stage import BACKGROUND, Image, Lines, Stage
from elastomorph.errors import ParameterError
from elastomorph.model.mesh import Mesh

__all__ = ["RGB", "Finish", "Portrait", "colour_named", "legend_height", "with_legend"]

RGB = tuple[float, float, float]

LARGE = 2048
"""Sides from which a pixel is one sample, for a window of four times as many would not fit."""
_LETTERS = 40
"""The letters of a legend are at least this much smaller than the picture is wide."""
_SMALLEST = 7
_BLACK, _WHITE = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Finish:
    """How faces are drawn, whatever their pose.

    Attributes:
        wireframe: Draw the edges of the polygons.
        lines: Curves on the surface, which is then of clay; see `network_lines`.
        background: Red, green, blue from 0 to 1; None is transparent.
        scale: Legend of the heat map, for faces that come with distances.
    """

    wireframe: bool = False
    lines: tuple[Lines, ...] = ()
    background: RGB | None = BACKGROUND
    scale: ColourScale | None = None


class Portrait:
    """A stage and a finish; use as a context manager.

    Args:
        mesh: The polygons and the names of the parts.
        camera: Where the pictures are taken from.
        size: Width and height of a face in pixels.
        finish: How it is drawn.

    Raises:
        MeshError: The mesh has no polygons.
        MissingExtraError: vtk is not installed.
        ElastomorphError: The machine has no OpenGL that works without a display.
    """

    def __init__(
        self, mesh: Mesh, camera: Camera, size: tuple[int, int], finish: Finish | None = None
    ) -> None:
        self._finish = finish or Finish()
        self._clay = np.full(mesh.vertices.shape, CLAY) if self._finish.lines else None
        samples = 1 if max(size) > LARGE else 2
        self._stage = Stage(mesh, camera, size=size, supersampling=samples)

    def picture(
        self, positions: NDArray[np.float64], distances: NDArray[np.float64] | None = None
    ) -> Image:
        """One pose.

        Args:
            positions: (V, 3).
            distances: (V,) of the heat map, in the unit of the finish's scale.

        Returns:
            (height, width, 3) uint8, or (height, width, 4) where the background is transparent.

        Raises:
            MeshError: Positions that do not fit the mesh.
            ParameterError: Distances without a scale.
        """
        colours = self._clay
        if distances is not None:
            scale = self._finish.scale
            if scale is None:
                raise ParameterError("a heat map needs a scale for its colours")
            colours = heat_colours(distances, scale.highest, colour_map=scale.colour_map)
        background = self._finish.background
        if background is not None:
            return self._drawn(positions, colours, background)
        return _cut_out(
            self._drawn(positions, colours, _BLACK), self._drawn(positions, colours, _WHITE)
        )

    def close(self) -> None:
        """Give the render window back."""
        self._stage.close()

    def __enter__(self) -> Portrait:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _drawn(
        self, positions: NDArray[np.float64], colours: NDArray[np.float64] | None, background: RGB
    ) -> Image:
        return self._stage.picture(
            positions,
            colours=colours,
            lines=self._finish.lines,
            wireframe=self._finish.wireframe,
            background=background,
        )


def colour_named(text: str) -> RGB:
    """A colour by its name in HTML, or as #rrggbb.

    Returns:
        Red, green, blue from 0 to 1.

    Raises:
        ParameterError: No such colour.
        MissingExtraError: Pillow is not installed.
    """
    try:
        red, green, blue = imported("PIL.ImageColor").getrgb(text.strip())[:3]
    except ValueError:
        raise ParameterError(
            f"background {text!r}: expected transparent, a name such as white, or #rrggbb"
        ) from None
    return red / 255, green / 255, blue / 255


def with_legend(image: Image, scale: ColourScale | None) -> Image:
    """A face above the legend of its colours: `legend_height` more pixels, of the same width."""
    if scale is None:
        return image
    letters = _letters(image.shape[1], scale)
    return picture_grid([[image]], scale=scale, text_size=letters, gap=0)


def legend_height(width: int, scale: ColourScale | None) -> int:
    """How much higher `with_legend` makes a picture of this width."""
    return 0 if scale is None else round(4.2 * _letters(width, scale))


def _letters(width: int, scale: ColourScale) -> int:
    """Height of the letters such that the words of the legend fit into its width."""
    return max(_SMALLEST, min(width // _LETTERS, 2 * width // max(len(scale.label), 1)))


def _cut_out(on_black: Image, on_white: Image) -> Image:
    """What hides the background, and how much: a colour C with opacity a is aC and aC + (1 - a)."""
    shine_through = np.subtract(on_white, on_black, dtype=np.int16).mean(axis=2)
    opacity = np.clip(255.0 - shine_through, 0.0, 255.0)
    share = np.where(opacity > 0, opacity, 255.0)[..., None] / 255.0
    colour = np.where(opacity[..., None] > 0, on_black / share, 0.0)
    whole = np.concatenate([colour, opacity[..., None]], axis=2)
    return np.asarray(np.clip(np.rint(whole), 0, 255), dtype=np.uint8)
