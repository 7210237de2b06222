"""The page of landmarks can be read, reached and used in both themes and on a narrow window."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from placing import NAMES, click, dots, opened, saved, seen_dots, write_photograph
from test_looks import LOW
from visiting import DESK, PHONE, Visit

import elastomorph as em
from elastomorph.capturing.landmarks import Landmarks
from elastomorph.viewer import ViewerServer
from elastomorph.viewer.landmarks import landmark_task, serve_landmarks
from needs import MODULES, NO_NODE
from small_head import head, landmarks

if TYPE_CHECKING:
    from playwright.sync_api import Page

AXE = MODULES / "axe-core" / "axe.min.js"


@pytest.fixture
def server(tmp_path: Path) -> Iterator[ViewerServer]:
    folder = tmp_path / "neutral"
    folder.mkdir()
    for number in (1, 2, 3, 4):
        write_photograph(folder / f"IMG_{number}.jpg", dots(number))
    em.write(tmp_path / "head.obj", head())
    known = Landmarks(vertices=landmarks())
    task = landmark_task([folder], tmp_path / "head.obj", known=known)
    with serve_landmarks(task, tmp_path / "landmarks.json") as started:
        yield started


@pytest.mark.skipif(not AXE.is_file(), reason=NO_NODE)
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_bars_the_way(
    visit: Visit, server: ViewerServer, scheme: str, keep: Callable[[Page, str], None]
) -> None:
    page = visit.blank(server.address, size=DESK, color_scheme=scheme)
    opened(page, "IMG_1.jpg")
    for at in seen_dots(page)[:9]:  # left and right are exchanged among them
        click(page, at)
    saved(page)
    keep(page, f"landmarks-{scheme}")
    page.evaluate(AXE.read_text(encoding="utf-8") + "; undefined")
    found: list[dict[str, Any]] = page.evaluate(
        "axe.run(document, {resultTypes: ['violations'], iframes: false})"
        ".then(({violations}) => violations)"
    )
    assert [(one["id"], [node["html"] for node in one["nodes"]]) for one in found] == []
    page.get_by_role("button", name="Light or dark").click()
    other = {"light": "dark", "dark": "light"}[scheme]
    assert page.evaluate("document.documentElement.dataset.theme") == other


def test_a_narrow_window_holds_everything(visit: Visit, server: ViewerServer) -> None:
    page = visit.blank(server.address, size=PHONE)
    opened(page, "IMG_1.jpg")
    assert len(seen_dots(page)) == len(NAMES)
    click(page, seen_dots(page)[0])
    page.locator(f".point[data-name={NAMES[-1]}]").scroll_into_view_if_needed()
    assert page.locator(f".point[data-name={NAMES[-1]}]").is_visible()
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE[0]
    assert page.get_by_role("button", name="Finish").is_visible()


def test_for_fingers(visit: Visit, server: ViewerServer) -> None:
    """Everything that is pressed is high enough, and a point can be taken away again."""
    page = visit.blank(server.address, size=PHONE, has_touch=True, is_mobile=True)
    opened(page, "IMG_1.jpg")
    page.touchscreen.tap(*map(float, seen_dots(page)[0]))
    cross = page.get_by_role("button", name="Remove Nose tip here")
    cross.wait_for()
    assert page.evaluate(LOW) == []
    cross.tap()
    cross.wait_for(state="hidden")
    page.get_by_role("button", name="Keys").tap()
    assert page.evaluate(LOW) == []


def test_keys_are_listed(visit: Visit, server: ViewerServer) -> None:
    page = visit.blank(server.address)
    opened(page, "IMG_1.jpg")
    page.keyboard.press("?")
    listed = page.get_by_role("dialog", name="Keys")
    assert listed.is_visible()
    page.keyboard.press("]")
    assert page.get_by_role("application", name="IMG_1.jpg").is_visible(), (
        "behind it nothing happens"
    )
    page.keyboard.press("Escape")
    page.keyboard.press("]")  # at once: no key of a fast hand is lost
    opened(page, "IMG_2.jpg")
    page.keyboard.press("[")
    page.keyboard.press("[")
    opened(page, "head.obj")
    page.keyboard.press(".")
    assert page.locator(".point[aria-current]").get_attribute("data-name") == NAMES[0]


def test_points_of_the_drawing_and_small_pictures_are_chosen(
    visit: Visit, server: ViewerServer, tmp_path: Path
) -> None:
    page = visit.blank(server.address, size=DESK)
    opened(page, "IMG_1.jpg")
    page.locator(".drawing circle").nth(NAMES.index("chin")).click()
    click(page, seen_dots(page)[3])
    page.locator(".tile", has_text="IMG_3.jpg").click()
    opened(page, "IMG_3.jpg")
    saved(page)
    found = json.loads((tmp_path / "landmarks.json").read_text())["photographs"]["neutral"]
    assert {name: list(places) for name, places in found.items()} == {"IMG_1.jpg": ["chin"]}
