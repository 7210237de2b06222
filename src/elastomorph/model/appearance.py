"""What the materials of a mesh look like: base colours, textures, opacity."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Wrap = Literal["repeat", "mirror", "clamp"]
Opacity = Literal["opaque", "mask", "blend"]

WHITE = (1.0, 1.0, 1.0, 1.0)


@dataclass(frozen=True, eq=False, repr=False)
class Texture:
    """An image on a surface, by the texture coordinates of the mesh.

    Where a point of the surface has the coordinates (u, v), v from the bottom of the image, it
    shows the image at ``offset + R(rotation) · scale · (u, 1 - v)``, counted from the top.

    Attributes:
        image: The content of an image file, not decoded; empty where there is none to be had.
        name: What the image is called, for messages.
        problem: Why there is no image.
        wrap: What is beside the image, across and down.
        offset: Where the transform puts the corner of the image.
        rotation: In radians, counter-clockwise as seen on the image.
        scale: By how much coordinates are multiplied, across and down.
        smooth: Whether colours between pixels are mixed.
    """

    image: bytes
    name: str
    problem: str = ""
    wrap: tuple[Wrap, Wrap] = ("repeat", "repeat")
    offset: tuple[float, float] = (0.0, 0.0)
    rotation: float = 0.0
    scale: tuple[float, float] = (1.0, 1.0)
    smooth: bool = True

    def __repr__(self) -> str:
        return f"Texture({self.name!r}, {len(self.image):,} bytes)"


@dataclass(frozen=True)
class Material:
    """How a surface looks in even light.

    Attributes:
        colour: Red, green, blue and opacity from 0 to 1, the colours linear as light is; what the
            texture is multiplied with.
        texture: The base colour, in sRGB, if it is an image.
        opacity: ``opaque``; ``mask`` shows what reaches the cutoff and nothing of the rest;
            ``blend`` lets shine through what is behind.
        cutoff: The least opacity that a mask shows.
        double_sided: Whether it is seen from behind too.
        unlit: Whether light and shade leave it as it is.
    """

    colour: tuple[float, float, float, float] = WHITE
    texture: Texture | None = None
    opacity: Opacity = "opaque"
    cutoff: float = 0.5
    double_sided: bool = False
    unlit: bool = False

    @property
    def plain(self) -> bool:
        """Whether it is grey all over, as materials are that nobody has looked after."""
        red, green, blue, alpha = self.colour
        return self.texture is None and red == green == blue and alpha == 1.0
