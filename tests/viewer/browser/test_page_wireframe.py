"""Lines of the file's own polygons, to be seen on whatever they lie on."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from pictures import picture
from test_page_materials import UNLIT, Cards, seen
from visiting import FRAME, Visit, empty_page, update

if TYPE_CHECKING:
    from playwright.sync_api import Page


def diagonal(page: Page, folder: Path, grey: int, *, polygons: bool) -> int:
    """How far a line in the middle of a card of two triangles is from the grey of the card."""
    cards = Cards()
    base = {"baseColorTexture": cards.pixels([[(grey, grey, grey)]])}
    cards.card({"pbrMetallicRoughness": base, "extensions": UNLIT})
    if polygons:
        cards.use("FB_ngon_encoding")
        cards.json["meshes"][0]["primitives"][0]["extensions"] = {"FB_ngon_encoding": {}}
    seen(page, cards, folder)
    update(page, wireframe=True)
    pixels = picture(page)
    height, width = pixels.shape[:2]
    middle = pixels[height // 2 - 3 : height // 2 + 4, width // 2 - 3 : width // 2 + 4]
    off = (middle - grey).reshape(-1)
    return int(off[np.abs(off).argmax()])


def test_lines_are_dark_on_light_and_light_on_dark(visit: Visit, tmp_path: Path) -> None:
    """And where a file tells its polygons, a square has no diagonal."""
    page = visit(empty_page(), size=FRAME)
    assert diagonal(page, tmp_path, 200, polygons=False) < -40
    assert diagonal(page, tmp_path, 20, polygons=False) > 40
    assert diagonal(page, tmp_path, 200, polygons=True) == 0
