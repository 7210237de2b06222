"""How tests read a page: by an HTML parser, as far from the writer as can be."""

from __future__ import annotations

import base64
import json
import zlib
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import elastomorph as em
from elastomorph.rig import Rig

STAND_IN = """<!doctype html>
<html lang="en">
  <head>
    <meta charset="utf-8" />
    <title>elastomorph</title>
    <!-- elastomorph scene -->
    <script type="module">const marks = "<b>&amp;</b>";</script>
    <style>main { color: red }</style>
  </head>
  <body><main id="viewer"></main></body>
</html>
"""


class Elements(HTMLParser):
    """Names, attributes and texts of the elements of a page."""

    def __init__(self, page: str) -> None:
        super().__init__(convert_charrefs=True)
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.texts: dict[str, str] = {}
        self._id: str | None = None
        self.feed(page)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))
        self._id = dict(attrs).get("id")

    def handle_endtag(self, tag: str) -> None:
        self._id = None

    def handle_data(self, data: str) -> None:
        if self._id is not None:
            self.texts[self._id] = self.texts.get(self._id, "") + data


def scene_in(page: str) -> tuple[dict[str, Any], list[bytes]]:
    """The scene of a self-contained page, and the GLB file of each of its models."""
    texts = Elements(page).texts
    scene = json.loads(texts["elastomorph-scene"])
    glbs = []
    for model in scene["models"]:
        assert model["glb"].startswith("#")
        packed = base64.b64decode(texts[model["glb"][1:]], validate=True)
        glbs.append(zlib.decompress(packed))
    return scene, glbs


def read_back(glb: bytes, folder: Path) -> Rig:
    """The rig in the bytes of a GLB file."""
    path = folder / "model.glb"
    path.write_bytes(glb)
    return em.read_rig(path)
