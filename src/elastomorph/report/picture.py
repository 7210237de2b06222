"""Pictures of pixels inside a page."""

from __future__ import annotations

from base64 import b64encode
from dataclasses import dataclass
from io import BytesIO

import numpy as np

from elastomorph.draw.pictures import Image, imported
from elastomorph.report.markup import Markup, element

__all__ = ["Picture", "picture_figure"]

QUALITY = 82
"""Of WebP: at 82 no edge of a shaded face frays, at a tenth of the size of a PNG."""


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture and the words that go with it.

    Attributes:
        title: Its heading.
        image: (H, W, 3) uint8.
        alt: What is seen, for those who do not see it.
        caption: What to look at.
        wide: Whether it is better scrolled than shrunk on a narrow screen.
        name: Of its file, without suffix, where it is one of those that are also written as files.
    """

    title: str
    image: Image
    alt: str
    caption: str
    wide: bool = True
    name: str = ""


def picture_figure(picture: Picture) -> Markup:
    """A picture with its caption; the picture itself is inside, as WebP.

    Raises:
        MissingExtraError: Pillow is not installed.
    """
    height, width = picture.image.shape[:2]
    image = element(
        "img",
        src=f"data:image/webp;base64,{b64encode(_webp(picture.image)).decode('ascii')}",
        alt=picture.alt,
        width=width,
        height=height,
    )
    card = element("div", image, class_="card")
    if picture.wide:
        card = element(
            "div",
            image,
            class_="card scroll",
            tabindex=0,
            role="region",
            aria_label=f"{picture.title} (picture, scrolls)",
        )
    return element("figure", card, element("figcaption", picture.caption))


def _webp(image: Image) -> bytes:
    file = BytesIO()
    picture = imported("PIL.Image").fromarray(np.ascontiguousarray(image))
    picture.save(file, format="WEBP", quality=QUALITY, method=4)
    return file.getvalue()
