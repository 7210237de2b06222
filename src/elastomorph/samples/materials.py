"""What the parts of the built-in head look like, in plain glTF terms: no extension is needed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from elastomorph.model.appearance import Finish, Material, Opacity, Texture

IMAGES = (
    "skin.jpg", "shine.png", "eye.jpg", "mouth.jpg", "teeth.jpg", "lashes.png", "shadow.png",
)  # fmt: skip
"""The files of the images, which ``tools/paint_head.py`` paints."""

SKIN = (204, 158, 136)
"""Red, green and blue of a screen, to which painted skin fades at the back of the head."""


def materials(images: Mapping[str, bytes]) -> dict[str, Material]:
    """The looks of the head's materials by name, of the content of `IMAGES`.

    Irises are painted on the ``sclera``, the shell that bulges as a cornea does.
    """
    textures = {name.partition(".")[0]: Texture(content, name) for name, content in images.items()}

    def painted(
        name: str, roughness: float, opacity: Opacity = "opaque", double_sided: bool = False
    ) -> Material:
        texture, finish = textures[name], Finish(roughness)
        return Material(texture=texture, opacity=opacity, double_sided=double_sided, finish=finish)

    lit = Finish(layers={"finish": textures["shine"], "creases": textures["shine"]})
    return {
        "skin": Material(texture=textures["skin"], finish=lit),
        "head": replace(_plain(SKIN, 0.58), double_sided=True),  # open below
        "mouth": _plain((72, 25, 23), 0.7),
        "gums": painted("mouth", 0.5),
        "tongue": painted("mouth", 0.5),
        "teeth": painted("teeth", 0.22),
        "sclera": painted("eye", 0.06),
        "occlusion": painted("shadow", 1.0, "blend"),
        "lashes": painted("lashes", 0.8, "blend", double_sided=True),
    }


def _plain(shown: tuple[int, int, int], roughness: float) -> Material:
    """One colour, told as a screen shows it."""
    red, green, blue = (
        part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4
        for part in (value / 255 for value in shown)
    )
    return Material((red, green, blue, 1.0), finish=Finish(roughness))
