"""Graphs of matplotlib as SVG inside a page."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

from elastomorph.report.markup import Markup

__all__ = ["inline_graph"]

_REFERENCE = re.compile(r"url\(#([^)]+)\)")
_NUMBER = re.compile(r"-?\d+\.\d{3,}")
# Named last where a machine lacks the font that matplotlib measured: Verdana has its widths.
_FONT = "'DejaVu Sans'"
_FALLBACKS = f"{_FONT}, Verdana, sans-serif"


def inline_graph(draw: Callable[[Path], None], name: str, alt: str) -> Markup:
    """A graph as one ``svg`` element that may stand beside others in a page.

    Its ids begin with ``name``, its style touches nothing else, its words stay words, and it
    refers to nothing outside.

    Args:
        draw: Draws the graph into a file ending in .svg.
        name: A name of its own among the graphs of a page.
        alt: What the graph shows, for those who do not see it.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "graph.svg"
        draw(file)
        root = ElementTree.fromstring(file.read_bytes())
    return _inlined(root, name, alt)


def _inlined(root: ElementTree.Element, name: str, alt: str) -> Markup:
    for parent in list(root.iter()):
        for child in list(parent):
            # The style speaks of every element of a page, the metadata to no reader of it.
            if _local(child.tag) in ("metadata", "style"):
                parent.remove(child)
    used = set()
    for node in root.iter():
        for key, value in node.attrib.items():
            used.update(_REFERENCE.findall(value))
            if _local(key) == "href":
                used.add(value.removeprefix("#"))
    for node in root.iter():
        node.tag = _local(node.tag)
        node.attrib = dict(_kept(node, used, name))
        if not (node.text or "").strip():
            node.text = None
        if not (node.tail or "").strip():
            node.tail = None
    for key in ("width", "height", "version"):
        root.attrib.pop(key, None)
    root.attrib.update({"role": "img", "aria-label": alt, "class": "graph"})
    return Markup(ElementTree.tostring(root, encoding="unicode"))


def _kept(node: ElementTree.Element, used: set[str], name: str) -> list[tuple[str, str]]:
    """The attributes of a node as the page needs them."""
    found = []
    for key, value in node.attrib.items():
        local = _local(key)
        if local == "id":
            if value in used:
                found.append(("id", f"{name}-{value}"))
        elif local == "href":
            found.append(("href", f"#{name}-{value.removeprefix('#')}"))
        else:
            text = _REFERENCE.sub(rf"url(#{name}-\1)", value).replace(_FONT, _FALLBACKS)
            if local in ("d", "x", "y", "transform", "points"):
                text = " ".join(_NUMBER.sub(_rounded, text).split())
            found.append((local, text))
    return found


def _rounded(number: re.Match[str]) -> str:
    """Hundredths of a point are finer than any screen shows."""
    return f"{float(number[0]):.2f}".rstrip("0").rstrip(".")


def _local(name: str) -> str:
    """A name without its namespace: inside a page SVG needs none."""
    return name.rpartition("}")[2]
