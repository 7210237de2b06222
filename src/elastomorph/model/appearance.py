"""What the materials of a mesh look like: base colours, textures, opacity, finish."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

Wrap = Literal["repeat", "mirror", "clamp"]
Opacity = Literal["opaque", "mask", "blend"]
Layer = Literal["bumps", "glow", "finish", "creases", "shade"]

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
class Toon:
    """Light and shade as two flat colours with an edge between: MToon, of VRM.

    Attributes:
        shade: The colour in shade, linear; that in light is the base colour.
        shift: What is added to the cosine between surface and light.
        toony: How sharp the edge is: 1 for a line, 0 for a slope over all cosines.
        covers: Whether what blends hides what is behind it and drawn later.
        queue: What blends is drawn in this order, lower numbers first.
    """

    shade: tuple[float, float, float] = (0.0, 0.0, 0.0)
    shift: float = 0.0
    toony: float = 0.9
    covers: bool = False
    queue: int = 0


@dataclass(frozen=True)
class Finish:
    """How a surface takes light, beside its base colour.

    Attributes:
        roughness: From 0, a mirror, to 1.
        metal: 1 where it reflects in its own colour and in no other way.
        glow: Light of its own, linear red, green and blue.
        bump: How high the bumps are.
        crease: How dark the creases are, to 1.
        layers: Images, which numbers and colours are multiplied with: ``bumps`` is a normal map,
            ``glow`` in sRGB, ``finish`` has roughness in green and metal in blue, ``creases`` are
            in red, ``shade`` is that of a toon, in sRGB.
        toon: Where light and shade are flat.
    """

    roughness: float = 1.0
    metal: float = 0.0
    glow: tuple[float, float, float] = (0.0, 0.0, 0.0)
    bump: float = 1.0
    crease: float = 1.0
    layers: Mapping[Layer, Texture] = field(default_factory=dict, hash=False)
    toon: Toon | None = None


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
        finish: How it takes light beside that, as the viewer shows it.
    """

    colour: tuple[float, float, float, float] = WHITE
    texture: Texture | None = None
    opacity: Opacity = "opaque"
    cutoff: float = 0.5
    double_sided: bool = False
    unlit: bool = False
    finish: Finish | None = None

    @property
    def plain(self) -> bool:
        """Whether it is grey all over, as materials are that nobody has looked after."""
        red, green, blue, alpha = self.colour
        return self.texture is None and red == green == blue and alpha == 1.0
