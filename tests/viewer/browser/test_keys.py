"""Every key of the list does what it says, and none of them while somebody types."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import pytest
from faces import Faces
from pictures import differing, picture
from visiting import HALVED, Visit, settled, state, update

if TYPE_CHECKING:
    from playwright.sync_api import Page


def flips(field: str, key: str) -> Callable[[Page], None]:
    def check(page: Page) -> None:
        before = state(page)[field]
        page.keyboard.press(key)
        assert state(page)[field] != before
        page.keyboard.press(key)
        assert state(page)[field] == before

    return check


def steps(page: Page) -> None:
    update(page, t=0.5)
    page.keyboard.press("]")
    assert state(page)["t"] == pytest.approx(0.55)
    page.keyboard.press("[")
    assert state(page)["t"] == pytest.approx(0.5)


def marks(page: Page) -> None:
    """Points are set where the clock stands, and undone as everything is."""
    update(page, clip="a take", clipTime=0.75, range=None)
    page.keyboard.press("}")
    update(page, clipTime=0.25)
    page.keyboard.press("{")
    assert state(page)["range"] == [0.25, 0.75]
    update(page, clip=None, range=None, weights={})


def unfolds(page: Page) -> None:
    update(page, clip="a take")
    timeline = page.get_by_role("region", name="Timeline")
    assert not timeline.is_visible()
    page.keyboard.press("t")
    settled(page)
    assert timeline.is_visible()
    page.keyboard.press("t")
    settled(page)
    assert not timeline.is_visible()
    update(page, clip=None, weights={})


def zeroes(page: Page) -> None:
    update(page, weights={"jawOpen": 1})
    page.keyboard.press("0")
    assert state(page)["weights"] == {}


def undoes(page: Page) -> None:
    page.keyboard.press("g")
    page.keyboard.press("Control+z")
    assert not state(page)["ghost"]
    page.keyboard.press("Control+Shift+z")
    assert state(page)["ghost"]
    page.keyboard.press("g")


def redoes(page: Page) -> None:
    page.keyboard.press("w")
    page.keyboard.press("Control+z")
    page.keyboard.press("Control+y")
    assert state(page)["wireframe"]
    page.keyboard.press("w")


def swaps(page: Page) -> None:
    update(page, weights={"mouthSmile_L": 0.5})
    page.keyboard.press("x")
    assert state(page)["weights"] == {"mouthSmile_R": 0.5}


def draws(page: Page) -> None:
    page.keyboard.press("r")
    assert len(state(page)["weights"]) > 2
    page.keyboard.press("0")


def stars(page: Page) -> None:
    page.get_by_role("slider", name="jawOpen").focus()
    page.keyboard.press("s")
    assert state(page)["favourites"] == ["jawOpen"]
    page.keyboard.press("s")
    assert state(page)["favourites"] == []
    page.locator(".picture").focus()


def links(page: Page) -> None:
    page.keyboard.press("l")
    said = page.locator("[role=status], [role=alert]").filter(has_text="clipboard")
    said.first.wait_for()
    page.keyboard.press("Escape")


def names(page: Page) -> None:
    page.keyboard.press("p")
    page.keyboard.type("Calm")
    page.keyboard.press("Enter")
    assert [pose["name"] for pose in state(page)["poses"]] == ["Calm"]
    page.get_by_role("tab", name="Sliders").click()
    page.locator(".picture").focus()


def searches(page: Page) -> None:
    page.get_by_role("tab", name="Display").click()
    page.keyboard.press("/")
    page.keyboard.type("jaw")
    assert page.get_by_role("searchbox").input_value() == "jaw"
    page.keyboard.press("Escape")
    page.locator(".picture").focus()


def looks(page: Page) -> None:
    seen = []
    for key in "4321":
        page.keyboard.press(key)
        seen.append(picture(page))
    for one, other in itertools.pairwise(seen):
        assert differing(one, other).mean() > 0.05
    page.keyboard.press("1")
    assert not differing(seen[-1], picture(page)).any()


def turns(page: Page) -> None:
    for there, back in (("ArrowLeft", "ArrowRight"), ("ArrowUp", "ArrowDown")):
        before = picture(page)
        page.keyboard.press(there)
        assert differing(before, picture(page)).mean() > 0.01
        page.keyboard.press(back)
        assert differing(before, picture(page), 40).mean() < 1e-3


def zooms(page: Page) -> None:
    page.keyboard.press("1")
    before = picture(page)
    wall = before[0, 0]
    page.keyboard.press("-")
    page.keyboard.press("-")
    farther = picture(page)
    assert _face(farther, wall) < 0.9 * _face(before, wall)
    page.keyboard.press("+")
    page.keyboard.press("=")
    assert differing(before, picture(page), 40).mean() < 1e-3


def closes(page: Page) -> None:
    page.locator("input[type=file]").set_input_files(
        {"name": "note.glb", "mimeType": "", "buffer": b"hello"}
    )
    page.get_by_role("alert").get_by_text("note.glb").wait_for()
    page.keyboard.press("Escape")
    assert page.get_by_role("alert").get_by_text("note.glb").count() == 0


def lists(page: Page) -> None:
    page.keyboard.press("?")
    dialog = page.get_by_role("dialog", name="Keys")
    assert dialog.is_visible()
    page.keyboard.press("g")
    assert not state(page)["ghost"], "behind the list nothing happens"
    page.keyboard.press("Escape")
    assert not dialog.is_visible()


CHECKS: dict[str, Callable[[Page], None]] = {
    "Space": flips("playing", "Space"),
    "[ ]": steps,
    "{ }": marks,
    "T": unfolds,
    "0": zeroes,
    "Ctrl Z": undoes,
    "Ctrl Y": redoes,
    "M": flips("mirror", "m"),
    "X": swaps,
    "R": draws,
    "S": stars,
    "P": names,
    "L": links,
    "/": searches,
    "1 2 3 4": looks,
    "← → ↑ ↓": turns,
    "+ −": zooms,
    "D": flips("grab", "d"),
    "G": flips("ghost", "g"),
    "H": flips("heat", "h"),
    "O": flips("orbits", "Shift+O"),
    "W": flips("wireframe", "w"),
    "F": flips("shading", "f"),
    "Esc": closes,
    "?": lists,
}


def test_every_key_of_the_list(visit: Visit, faces: Faces) -> None:
    page = visit(faces.together, size=(760, 480), **HALVED)
    update(page, arrangement="single", shown=[0])
    page.get_by_role("button", name="Keys (?)").click()
    rows = page.locator("dialog dl.keys > div")
    listed = [" ".join(row.locator("kbd").all_inner_texts()) for row in rows.all()]
    page.get_by_role("button", name="Close").click()
    assert listed == list(CHECKS), "a key was added or taken away: say here what it does"
    for check in CHECKS.values():
        page.locator(".picture").focus()
        check(page)


def test_no_key_fires_while_somebody_types(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **HALVED)
    update(page, weights={"jawOpen": 0.5}, t=0.5)
    letters = " []0mpxrsl/1234+-=ghowf?"
    search = page.get_by_role("searchbox", name="Search sliders")
    for field in (
        page.get_by_role("spinbutton", name="jawOpen, value"),
        page.get_by_role("spinbutton", name="Seconds from t = 0 to 1"),
        search,  # last: what is written there hides sliders
    ):
        field.focus()
        before, view = state(page), picture(page)
        for letter in letters:
            # What a field of numbers takes as a number is its own affair.
            if field.get_attribute("type") == "search" or not letter.isdigit():
                page.keyboard.press("Space" if letter == " " else letter)
        now = state(page)
        assert {**now, "weights": 0} == {**before, "weights": 0}
        assert not page.get_by_role("dialog").is_visible()
        assert not differing(view, picture(page)).any()
    assert search.input_value() == letters


def test_keys_that_controls_need_are_theirs(visit: Visit, faces: Faces) -> None:
    """Space presses the button in focus, arrows move the slider in focus; the face stays."""
    page = visit(faces.alone, **HALVED)
    update(page, weights={"jawOpen": 0.5})
    settled(page)
    mirror = page.get_by_role("switch", name="Mirror")
    mirror.focus()
    page.keyboard.press("Space")
    assert state(page)["mirror"]
    assert not state(page)["playing"]
    before = picture(page)
    search = page.get_by_role("searchbox", name="Search sliders")
    search.focus()
    for key in ("ArrowLeft", "ArrowUp"):
        page.keyboard.press(key)
    assert not differing(before, picture(page)).any()


def test_everything_is_reached_by_tab(visit: Visit, faces: Faces) -> None:
    """From the top of the page to its end, and where the focus is can be seen."""
    page = visit(faces.alone, **HALVED)
    page.evaluate("document.activeElement?.blur()")
    names: list[str] = []
    for _ in range(120):
        page.keyboard.press("Tab")
        found = page.evaluate(
            """() => {
                const e = document.activeElement;
                if (!e || e === document.body) return null;
                const box = e.getBoundingClientRect();
                const look = getComputedStyle(e);
                const label = getComputedStyle(e.closest('label') ?? e);
                const after = getComputedStyle(e, '::after');
                const seen = [look, label, after].some(s =>
                    (s.outlineStyle !== 'none' && parseFloat(s.outlineWidth) > 0)
                    || s.boxShadow !== 'none');
                return {name: e.getAttribute('aria-label') ?? e.labels?.[0]?.textContent
                    ?? e.textContent, seen, area: box.width * box.height};
            }"""
        )
        if found is None:
            break
        names.append(found["name"])
        assert found["seen"], f"nothing shows that {found['name']!r} has the focus"
    for wanted in ("Open a GLB…", "Search sliders", "jawOpen", "Play", "Timing"):
        assert wanted in names, f"{wanted!r} is not reached; {names}"
    assert any("The face" in name for name in names)


def _face(pixels: np.ndarray, wall: np.ndarray) -> float:
    return float((np.abs(pixels - wall).max(axis=-1) > 60).mean())
