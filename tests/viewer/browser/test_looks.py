"""Nothing overlaps, nothing is cut off, the face fills the view, and everybody can use it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from faces import Faces
from pictures import picture, skin
from views import CALM, VIEWS, close_all
from visiting import (
    COARSE,
    DESK,
    FRAME,
    HALVED,
    NARROW,
    PHONE,
    Visit,
    empty_page,
    settled,
    state,
    update,
    wait,
)

from elastomorph.viewer import serve
from needs import MODULES, NO_NODE

if TYPE_CHECKING:
    from playwright.sync_api import Frame, Page

AXE = MODULES / "axe-core" / "axe.min.js"
LAYOUT = Path(__file__).with_name("layout.js").read_text(encoding="utf-8")
SIZES = {"desk": DESK, "phone": PHONE, "frame": FRAME}
EVERY_SIZE = {**SIZES, "narrow": NARROW}

needs_axe = pytest.mark.skipif(not AXE.is_file(), reason=NO_NODE)


def violations(page: Page | Frame) -> list[str]:
    """What axe-core finds wrong, whatever its impact."""
    if not page.evaluate("'axe' in window"):
        page.evaluate(AXE.read_text(encoding="utf-8") + ";0")
    found: list[dict[str, Any]] = page.evaluate(
        "axe.run(document, {resultTypes: ['violations'], iframes: false})"
        ".then(found => found.violations.map(v => ({...v, nodes: v.nodes.map(n => n.html)})))"
    )
    return [f"{v['impact']}: {v['id']} at {', '.join(v['nodes'][:3])[:400]}" for v in found]


def written(page: Page | Frame) -> None:
    """Waits for the figures of a picture, which are written a little after it."""
    wait(
        page,
        """document.querySelector('.status').textContent !== '' &&
        (document.querySelector('.legend').hidden ||
        document.querySelector('.worst').textContent !== '')""",
    )


@pytest.mark.slow
@pytest.mark.parametrize("size", [*SIZES, "narrow"])
def test_every_view(
    visit: Visit, faces: Faces, keep: Callable[[Page, str], None], size: str
) -> None:
    page = visit(faces.together, size=EVERY_SIZE[size], **COARSE)
    # Where there is no room for more, the theme changes nothing but colours seen elsewhere.
    themes = ["light", "dark"] if size in SIZES else ["light"]
    wrong = []
    for name, view in VIEWS.items():
        close_all(page)
        view(page, faces)
        settled(page)
        written(page)
        wrong += [f"{name}: {words}" for words in page.evaluate(LAYOUT)]
        for theme in themes:
            page.emulate_media(color_scheme=theme)
            settled(page)
            if AXE.is_file():
                wrong += [f"{name}, {theme}: {words}" for words in violations(page)]
            keep(page, f"{name.replace(' ', '-')}-{size}-{theme}")
        themes.reverse()  # the next view begins with the theme that is shown
    assert wrong == []


@needs_axe
def test_the_welcome(visit: Visit, keep: Callable[[Page, str], None]) -> None:
    page = visit(empty_page())
    for size, (width, height) in SIZES.items():
        page.set_viewport_size({"width": width, "height": height})
        for theme in ("light", "dark"):
            page.emulate_media(color_scheme=theme)
            settled(page)
            keep(page, f"welcome-{size}-{theme}")
            assert page.evaluate(LAYOUT) == []
            assert violations(page) == []


def test_the_face_fills_the_view(visit: Visit, faces: Faces) -> None:
    """Alone or beside others, the head reaches over most of its part of the picture."""
    page = visit(faces.together, **HALVED)
    for size, (width, height) in SIZES.items():
        page.set_viewport_size({"width": width, "height": height})
        # Several faces on a phone are as small as they must be.
        for shown in ([1],) if size == "phone" else ([1], [0, 1], [0, 1, 2]):
            arrangement = "single" if len(shown) == 1 else "side"
            update(page, **{**CALM, "shown": shown, "arrangement": arrangement})
            settled(page)
            whole = picture(page)
            part = whole[:, : whole.shape[1] // len(shown)]
            face = skin(part)
            rows, columns = np.flatnonzero(face.any(axis=1)), np.flatnonzero(face.any(axis=0))
            spans = max(np.ptp(rows) / part.shape[0], np.ptp(columns) / part.shape[1])
            words = f"{len(shown)} on a {size}"
            assert spans > 0.85, f"{words}: the face spans {spans:.0%}"
            assert rows[0] > 0, f"{words}: the top of the head is cut off"
            assert rows[-1] < part.shape[0] - 1, f"{words}: the neck is cut off"
            assert columns[0] > 0, f"{words}: the head is cut off on the left"
            assert columns[-1] < part.shape[1] - 1, f"{words}: the head is cut off on the right"


def test_the_face_is_seen_on_a_phone(visit: Visit, faces: Faces) -> None:
    """Above the sheet with the sliders: at least a third of the window's height."""
    page = visit(faces.alone, size=PHONE)
    box = page.locator(".picture").bounding_box()
    assert box is not None
    assert box["height"] > PHONE[1] / 3
    assert box["width"] == PHONE[0]
    assert skin(picture(page)).mean() > 0.15
    page.get_by_role("tab", name="Sliders").click()  # closes the sheet
    settled(page)
    taller = page.locator(".picture").bounding_box()
    assert taller is not None
    assert taller["height"] > 1.5 * box["height"]


# Controls lower or narrower than a finger needs, with the labels that are pressed for them.
LOW = """() => [...document.querySelectorAll('button, select, input:not([type=file])')]
    .filter(e => e.checkVisibility({checkOpacity: true, checkVisibilityCSS: true}))
    .map(e => e.matches('[type=checkbox], [type=radio]') ? e.closest('label, .row') : e)
    .filter(e => {
        const { width, height } = e.getBoundingClientRect();
        return height < 44 || width < 24;
    })
    .map(e => e.outerHTML.slice(0, 120))"""


@pytest.mark.parametrize("size", ["phone", "narrow"])
def test_for_fingers(visit: Visit, faces: Faces, size: str) -> None:
    """Everything is high enough, nothing is cut off, and a list has the sheet to itself."""
    page = visit(faces.alone, size=EVERY_SIZE[size], has_touch=True, is_mobile=True, **COARSE)
    jaw = {"name": "Open", "weights": {"jawOpen": 1}}
    update(page, weights={"jawOpen": 0.5}, poses=[{**jaw, "name": f"Pose {i}"} for i in range(9)])
    for tab in ("Display", "Compare", "Poses", "Sliders"):
        page.get_by_role("tab", name=tab).tap()
        settled(page)
        assert page.evaluate(LOW) == []
        assert page.evaluate(LAYOUT) == []
    page.get_by_role("slider", name="mouthSmile_R").scroll_into_view_if_needed()
    assert not page.get_by_role("searchbox", name="Search sliders").evaluate(
        "field => field.getBoundingClientRect().bottom > "
        "document.querySelector('[role=tablist]').getBoundingClientRect().bottom"
    )


def test_the_theme_is_chosen(visit: Visit, faces: Faces) -> None:
    """As the system has it, until somebody says otherwise."""
    page = visit(faces.alone, color_scheme="dark")
    dark = picture(page)[0, 0]
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"
    page.get_by_role("tab", name="Display").click()
    page.get_by_role("radio", name="Light").check(force=True)
    settled(page)
    assert state(page)["theme"] == "light"
    assert page.evaluate("document.documentElement.dataset.theme") == "light"
    light = picture(page)[0, 0]
    assert light.mean() > dark.mean() + 80
    page.get_by_role("radio", name="System").check(force=True)
    settled(page)
    assert page.evaluate("document.documentElement.dataset.theme") == "dark"
    page.emulate_media(color_scheme="light")
    settled(page)
    assert page.evaluate("document.documentElement.dataset.theme") == "light"


def test_in_a_frame(visit: Visit, faces: Faces, keep: Callable[[Page, str], None]) -> None:
    """As reports embed it: 800 by 500, in order, and wheel and keys reach it."""
    from elastomorph.viewer import viewer_page
    from elastomorph.viewer.listening import Resource
    from elastomorph.viewer.server import ViewerServer

    around = (
        '<!doctype html><html lang="en"><meta charset="utf-8" /><title>around</title>'
        '<link rel="icon" href="data:," />'
        '<iframe title="face" src="inner" style="border: 0; width: 800px; height: 500px">'
    )
    html, anything = "text/html; charset=utf-8", "frame-ancestors 'self'"
    resources = {
        "": Resource(html, around.encode(), anything),
        "inner": Resource(html, viewer_page(faces.together).encode(), anything),
    }
    with ViewerServer(resources) as server:
        page = visit.blank(server.address)
        frame = page.frames[1]
        frame.evaluate("elastomorph.ready")
        frame.evaluate("elastomorph.update({weights: {jawOpen: 1}, t: 0.5, heat: true})")
        written(frame)
        assert frame.evaluate(LAYOUT) == []
        keep(page, "in-a-frame")


def test_a_stranger_sees_nothing(visit: Visit, faces: Faces) -> None:
    """The page that is served may not be framed, so that nobody can lure clicks onto it."""
    with serve(faces.alone) as server:
        asked = visit(server.address).context.request.get(server.address)
    assert "frame-ancestors 'none'" in asked.headers["content-security-policy"]
