"""Pictures of pixels and graphs of lines as they stand inside a page."""

from __future__ import annotations

import re
import tempfile
from base64 import b64encode
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from markupsafe import Markup

from elastomorph.draw.pictures import Image, imported
from elastomorph.report.document import Section

# Of WebP: at 82 no edge of a shaded face frays, at a tenth of the size of a PNG.
_QUALITY = 82
_REFERENCE = re.compile(r"url\(#([^)]+)\)")
_NUMBER = re.compile(r"-?\d+\.\d{3,}")
# Named last where a machine lacks the font that matplotlib measured: Verdana has its widths.
_FONT = "'DejaVu Sans'"
_FALLBACKS = f"{_FONT}, Verdana, sans-serif"


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

    @property
    def source(self) -> str:
        """The picture itself as a ``data:`` address of WebP."""
        file = BytesIO()
        picture = imported("PIL.Image").fromarray(np.ascontiguousarray(self.image))
        picture.save(file, format="WEBP", quality=_QUALITY, method=4)
        return f"data:image/webp;base64,{b64encode(file.getvalue()).decode('ascii')}"


def picture_sections(faces: Sequence[Picture], more: Sequence[Picture]) -> list[Section]:
    """Pictures that show what was found, and in the appendix those that show more."""
    found = []
    if faces:
        found.append(Section("faces", "Faces", {"pictures": faces}))
    if more:
        found.append(Section("more", "More pictures", {"pictures": more}, appendix=True))
    return found


@dataclass(frozen=True, eq=False)
class Graph:
    """A graph of matplotlib and the words that go with it.

    Attributes:
        title: Its heading.
        svg: The graph, see `inline_svg`.
        caption: What to look at.
    """

    title: str
    svg: Markup
    caption: str

    @classmethod
    def drawn(
        cls, draw: Callable[[Path], None], name: str, title: str, alt: str, caption: str
    ) -> Graph:
        """Draw a graph; arguments and errors are those of `inline_svg`."""
        return cls(title, inline_svg(draw, name, alt), caption)


def inline_svg(draw: Callable[[Path], None], name: str, alt: str) -> Markup:
    """A graph as one ``svg`` element that may stand beside others in a page.

    Its ids begin with ``name``, its own on a page, its style touches nothing else, its words stay
    words, and it refers to nothing outside. ``draw`` draws it into a file ending in .svg.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "graph.svg"
        draw(file)
        root = ElementTree.fromstring(file.read_bytes())
    for parent in list(root.iter()):
        for child in list(parent):
            # The style speaks of every element of a page, the metadata to no reader of it.
            if _local(child.tag) in ("metadata", "style"):
                parent.remove(child)
    values = [value for node in root.iter() for value in node.attrib.values()]
    used = {reference for value in values for reference in _REFERENCE.findall(value)}
    used |= {value[1:] for value in values if value.startswith("#")}
    for node in root.iter():
        node.tag = _local(node.tag)
        pairs = [_kept(_local(key), value, used, name) for key, value in node.attrib.items()]
        node.attrib = dict(pair for pair in pairs if pair)
        node.text = node.text if (node.text or "").strip() else None
        node.tail = node.tail if (node.tail or "").strip() else None
    for key in ("width", "height", "version"):
        root.attrib.pop(key, None)
    root.attrib.update({"role": "img", "aria-label": alt, "class": "graph"})
    return Markup(ElementTree.tostring(root, encoding="unicode"))


def _kept(key: str, value: str, used: set[str], name: str) -> tuple[str, str] | None:
    """An attribute of a node as the page needs it, if it does."""
    if key == "id":
        return ("id", f"{name}-{value}") if value in used else None
    if key == "href":
        return "href", f"#{name}-{value.removeprefix('#')}"
    text = _REFERENCE.sub(rf"url(#{name}-\1)", value).replace(_FONT, _FALLBACKS)
    if key in ("d", "x", "y", "transform", "points"):
        text = " ".join(_NUMBER.sub(_rounded, text).split())
    return key, text


def _rounded(number: re.Match[str]) -> str:
    """Hundredths of a point are finer than any screen shows."""
    return f"{float(number[0]):.2f}".rstrip("0").rstrip(".")


def _local(name: str) -> str:
    """A name without its namespace: inside a page SVG needs none."""
    return name.rpartition("}")[2]
