"""The main states of the page, each of which must be in order at every size and in both themes."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from faces import Faces
from visiting import update

if TYPE_CHECKING:
    from playwright.sync_api import Page

SMILE = {"mouthSmile_L": 0.9, "mouthSmile_R": 0.9, "browInnerUp": 0.6, "jawOpen": 0.25}
JAW = {"weights": {"jawOpen": 1}, "t": 0.5}
CALM = {
    **{"weights": {}, "t": 1, "playing": False, "clip": None, "mirror": False, "range": None},
    **{"arrangement": "single", "shown": [1], "swipe": 0.5, "ghost": False, "onion": 0},
    **{
        "grab": False,
        "pins": [],
        "orbits": False,
        "picked": [],
        "heat": False,
        "against": 1,
        "heatTop": None,
    },
    **{"wireframe": False, "loops": False, "shading": "smooth", "light": "studio"},
    **{"poses": [], "favourites": [], "folded": [], "correctivesOff": []},
}


def _show(page: Page, tab: str, **patch: object) -> None:
    """A tab of the panel and a state, calm but for what is said: one change, one drawing."""
    strip = page.get_by_role("tab", name=tab)
    if strip.get_attribute("aria-selected") != "true":
        strip.click()
    update(page, **{**CALM, **patch})


def _sliders(page: Page, faces: Faces) -> None:
    _show(page, "Sliders", weights=SMILE)


def _search(page: Page, faces: Faces) -> None:
    _show(page, "Sliders", weights=SMILE, mirror=True)
    page.get_by_role("searchbox").fill("smile")


def _correctives(page: Page, faces: Faces) -> None:
    folded = ["Lids", "Brows", "Jaw", "Mouth", "Other"]
    _show(page, "Sliders", weights=SMILE, correctivesOff=["squash"], folded=folded)
    opener = page.get_by_role("button", name="Correctives")
    if opener.get_attribute("aria-expanded") == "false":
        opener.click()


def _poses(page: Page, faces: Faces) -> None:
    weights = {"jawOpen": 0.4, "mouthSmile_L": 0.8, "mouthSmile_R": 0.8, "browInnerUp": 0.3}
    poses = [
        {"name": "Open", "weights": {"jawOpen": 1}},
        {"name": "A laugh with a name that is too long for the panel", "weights": weights},
    ]
    _show(page, "Poses", poses=poses)
    page.locator(".pose").last.click()


def _side(page: Page, faces: Faces) -> None:
    side = {"arrangement": "side", "shown": [0, 2], "heat": True, "against": 2}
    _show(page, "Compare", **JAW, **side, picked=[faces.chin], orbits=True)


def _three(page: Page, faces: Faces) -> None:
    three = {"arrangement": "side", "shown": [0, 1, 2]}
    _show(page, "Compare", weights=SMILE, t=0.6, **three, ghost=True)


def _swipe(page: Page, faces: Faces) -> None:
    _show(page, "Compare", **JAW, arrangement="swipe", shown=[0, 2], swipe=0.55)


def _heat(page: Page, faces: Faces) -> None:
    _show(page, "Sliders", **JAW, shown=[0], against=2, heat=True)


def _fixed_heat(page: Page, faces: Faces) -> None:
    _show(page, "Compare", **JAW, shown=[0], against=2, heat=True, heatTop=0.02)


def _orbits(page: Page, faces: Faces) -> None:
    picked = [faces.chin, 1110, 300]
    _show(page, "Compare", weights={"jawOpen": 1}, picked=picked, orbits=True, onion=4)


def _grab(page: Page, faces: Faces) -> None:
    """A chin pulled farther than it goes, with two pins."""
    _show(page, "Sliders", grab=True, pins=[faces.chin, 300])
    field = page.get_by_role("spinbutton", name="Vertex").first
    field.fill(str(faces.chin))
    field.press("Enter")
    for _ in range(30):
        page.keyboard.press("Shift+ArrowDown")
    page.locator(".slider-list").evaluate("list => (list.scrollTop = 0)")


def _lines(page: Page, faces: Faces) -> None:
    lines = {"wireframe": True, "loops": True, "shading": "flat", "light": "matcap"}
    _show(page, "Display", weights=SMILE, **lines)


def _take(page: Page, faces: Faces) -> None:
    _show(page, "Sliders", clip="a take", clipTime=0.5)


def _timeline(page: Page, faces: Faces) -> None:
    _show(page, "Sliders", clip="a take", clipTime=0.5, range=[0.2, 0.8])
    page.get_by_role("button", name="Timeline").click()
    page.get_by_role("combobox", name="Curve").select_option("jawOpen")


def _video(page: Page, faces: Faces) -> None:
    _show(page, "Sliders", clip="a take")
    page.get_by_role("button", name="Timeline").click()
    page.get_by_role("button", name="Video…").click()


def _keys(page: Page, faces: Faces) -> None:
    _show(page, "Sliders")
    page.get_by_role("button", name="Keys (?)").click()


def _alert(page: Page, faces: Faces) -> None:
    _show(page, "Sliders")
    page.locator("input[type=file]").set_input_files(
        {"name": "meeting notes.glb", "mimeType": "", "buffer": b"Meeting at nine."}
    )
    page.get_by_role("alert").locator(".message").wait_for()


View = Callable[["Page", Faces], None]
VIEWS: dict[str, View] = {
    "sliders": _sliders,
    "search": _search,
    "correctives": _correctives,
    "poses": _poses,
    "side by side": _side,
    "three": _three,
    "swipe": _swipe,
    "heat": _heat,
    "fixed heat": _fixed_heat,
    "orbits": _orbits,
    "grab": _grab,
    "lines": _lines,
    "take": _take,
    "timeline": _timeline,
    "video": _video,
    "keys": _keys,
    "alert": _alert,
}


def close_all(page: Page) -> None:
    """Closes what a view has opened, and opens the panel that gave way to it."""
    page.evaluate("document.querySelector('dialog[open]')?.close()")
    page.evaluate("document.querySelector('.unfold[aria-expanded=true]')?.click()")
    if page.locator("[data-panel=closed]").count():
        page.get_by_role("tab", selected=True).click()
    page.evaluate("document.querySelectorAll('.message button').forEach(b => b.click())")
    search = page.get_by_role("searchbox")
    if search.is_visible() and search.input_value():
        search.fill("")
    page.evaluate("document.activeElement?.blur()")
