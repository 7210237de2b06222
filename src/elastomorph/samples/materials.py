"""What the parts of the built-in head look like, in plain glTF terms: no extension is needed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from elastomorph.model.appearance import Finish, Material, Opacity, Texture

SKIN = (204, 158, 136)
"""Red, green and blue of a screen, to which the painted skin fades where the scalp begins."""


def materials(images: Mapping[str, bytes]) -> dict[str, Material]:
    """The looks of the head's materials, by name.

    ``unseen`` are shells that only a game engine's own shaders use; over painted eyes they would be
    a film. Irises are painted on the ``sclera``, and ``iris`` is inside: both may be left out.

    Args:
        images: PNG images as ``tools/paint_head.py`` names them: "skin", "shine", "eye", "mouth",
            "teeth", "lashes" and "shadow".
    """

    def painted(
        name: str, roughness: float, opacity: Opacity = "opaque", double_sided: bool = False
    ) -> Material:
        texture, finish = Texture(images[name], name), Finish(roughness)
        return Material(texture=texture, opacity=opacity, double_sided=double_sided, finish=finish)

    shine = Texture(images["shine"], "shine")
    lit = Finish(layers={"finish": shine, "creases": shine})
    return {
        "skin": Material(texture=Texture(images["skin"], "skin"), finish=lit),
        "scalp": replace(_plain(SKIN, 0.58), double_sided=True),  # open below
        "mouth": _plain((72, 25, 23), 0.7),
        "gums": painted("mouth", 0.5),
        "tongue": painted("mouth", 0.5),
        "teeth": painted("teeth", 0.22),
        "sclera": painted("eye", 0.06),
        "iris": _plain((20, 14, 12), 0.5),
        "occlusion": painted("shadow", 1.0, "blend"),
        "lashes": painted("lashes", 0.8, "blend", double_sided=True),
        "unseen": Material((1, 1, 1, 0), opacity="mask"),
    }


def _plain(shown: tuple[int, int, int], roughness: float) -> Material:
    """One colour, told as a screen shows it."""
    red, green, blue = (
        part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4
        for part in (value / 255 for value in shown)
    )
    return Material((red, green, blue, 1.0), finish=Finish(roughness))
