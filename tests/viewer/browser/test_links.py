"""A view as an address: copied, read by people, opened again, also inside a report."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any
from urllib.parse import unquote

import numpy as np
import pytest
from faces import Faces
from pictures import differing, picture
from test_named_poses import told
from visiting import HALVED, Visit, settled, state, update, wait

from elastomorph.evaluation import Evaluation
from elastomorph.report import About, report_page

if TYPE_CHECKING:
    from playwright.sync_api import Frame, Page

MAY_COPY = {"permissions": ["clipboard-read", "clipboard-write"]}
# Everything a link holds, all of it different from how a page starts.
VIEW: dict[str, Any] = {
    **{"weights": {"jawOpen": 0.7, "mouthSmile_L": 0.25}, "t": 0.6, "mirror": True},
    **{"arrangement": "swipe", "shown": [2, 0], "swipe": 0.4, "ghost": True, "onion": 3},
    **{"orbits": True, "picked": [1110, 300], "heat": True, "against": 2, "heatTop": 0.02},
    **{"wireframe": True, "loops": True, "shading": "flat", "light": "matcap"},
    **{"repeat": "loop", "timing": "minimum-jerk", "seconds": 3},
}


def copied(page: Page) -> str:
    page.get_by_role("tab", name="Display").click()
    page.get_by_role("button", name="Copy link").click()
    page.get_by_text("A link to this view is on the clipboard").wait_for()
    link: str = page.evaluate("navigator.clipboard.readText()")
    return link


def opened(visit: Visit, link: str, **options: Any) -> Page:
    page = visit.blank(link, **{**HALVED, **options})
    page.evaluate("elastomorph.ready")
    settled(page)
    return page


def test_a_view_comes_back(visit: Visit, faces: Faces) -> None:
    """With everything that is seen, from where it is seen."""
    page = visit(faces.together, **MAY_COPY, **HALVED)
    update(page, **VIEW)
    page.locator(".picture").focus()
    for key in ("2", "ArrowLeft", "ArrowUp", "-"):
        page.keyboard.press(key)
    before, link = picture(page), copied(page)
    assert "#view=jawOpen:0.7,mouthSmile_L:0.25&" in link
    assert "&shown=2,0&" in link
    assert len(link.partition("#")[2]) < 420
    again = opened(visit, link, **MAY_COPY)
    assert {field: state(again)[field] for field in VIEW} == VIEW
    assert differing(before, picture(again), 40).mean() < 1e-3
    assert copied(again).partition("#")[2] == link.partition("#")[2]


def test_a_view_is_short_and_by_name(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **MAY_COPY, **HALVED)
    page.locator(".picture").focus()
    page.keyboard.press("3")
    assert copied(page).partition("#")[2] == "view=&camera=side"


def test_a_moment_of_a_performance(visit: Visit, faces: Faces) -> None:
    page = visit(faces.performed, **MAY_COPY, **HALVED)
    update(page, clip="a take", clipTime=0.4)
    link = copied(page)
    assert link.endswith("&clipTime=0.4"), "it is this performance that the page starts with"
    again = opened(visit, link)
    assert state(again)["clip"] == "a take"
    assert state(again)["weights"] == state(page)["weights"]


def test_another_link_in_the_same_page(visit: Visit, faces: Faces) -> None:
    """Followed when it is pasted into the line of the address, and undone."""
    page = visit(faces.alone, **HALVED)
    update(page, weights={"jawOpen": 1})
    page.evaluate("location.hash = '#view=mouthFunnel:0.5&t=0.5&camera=side'")
    wait(page, "elastomorph.state().t === 0.5")
    assert state(page)["weights"] == {"mouthFunnel": 0.5}
    page.keyboard.press("Control+z")
    assert state(page)["weights"] == {"jawOpen": 1}
    assert "#" not in page.url, "who goes on from a link does not come back to it"


@pytest.mark.parametrize(
    ("fragment", "problem"),
    [
        ("view=jawOpen:0.5,gill:1", "The link moves gill, which this rig lacks."),
        ("view=jawOpen:0.5&moon=1", "The link asks for what there is not: 'moon' is not part of"),
        ("view=jawOpen:0.5&clip=away", "The view is of the take away, which is not kept"),
        ("view=jawOpen:0.5&constructor=1", "'constructor' is not part of the view"),
        ("view=jawOpen:0.5&light=noon", "'light' must be one of studio, matcap; found"),
        ("view=jawOpen:0.5&t=half", "'t' must be a number; found"),
        ("view=jawOpen", "The link to this view is damaged"),
        ("view=jaw%E0:1", "The link to this view is damaged"),
        ("view=&camera=1,2,3", "The link to this view is damaged"),
    ],
)
def test_links_that_are_damaged(visit: Visit, faces: Faces, fragment: str, problem: str) -> None:
    """What of them can be understood is shown."""
    page = visit(faces.alone, **HALVED)
    again = opened(visit, f"{page.url}#{fragment}")
    assert problem in told(again)
    understood = "damaged" not in problem
    assert state(again)["weights"] == ({"jawOpen": 0.5} if understood else {})


def test_a_report_is_opened_at_a_view(visit: Visit, evaluation: Evaluation, tmp_path: Path) -> None:
    """Its viewer has no address of its own: the link is the report's."""
    file = tmp_path / "report.html"
    file.write_text(report_page(evaluation, About("a tip", unit="cm")), encoding="utf-8")
    page = visit.blank(file.as_uri())
    frame = _viewer(page)
    slider = frame.evaluate("Object.keys(elastomorph.state().weights)[0]")
    weights = {slider: 0.35}
    frame.evaluate("weights => elastomorph.update({weights, t: 0.75})", weights)
    frame.locator(".picture").focus()
    page.keyboard.press("l")
    frame.get_by_text("A link to this view is on the clipboard").wait_for()
    page.evaluate("document.body.append(document.createElement('textarea'))")
    page.locator("textarea").focus()
    page.keyboard.press("Control+v")
    link = page.locator("textarea").input_value()
    assert link.startswith(f"{file.as_uri()}#view=")
    assert f"{slider}:0.35" in unquote(link)
    again = _viewer(visit.blank(link))
    wait(again, "elastomorph.state().t === 0.75")
    assert again.evaluate("elastomorph.state().weights") == weights
    box = again.page.locator("iframe").bounding_box()
    assert box is not None
    assert 0 <= np.round(box["y"]) < 400, "the report is turned to its viewer"


def _viewer(page: Page) -> Frame:
    page.locator("iframe").scroll_into_view_if_needed()
    frame = page.frames[1]
    wait(frame, "window.elastomorph")
    frame.evaluate("elastomorph.ready")
    return frame
