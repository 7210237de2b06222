"""What the browser keeps of the work on a rig, and what happens where it cannot."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import pytest
from faces import Faces
from test_named_poses import BLINK, OPEN, SMILE, told
from visiting import COARSE, Visit, settled, state, update, wait

from elastomorph.viewer import write_viewer

if TYPE_CHECKING:
    from playwright.sync_api import Page

    from elastomorph.viewer import Scene

KEEPS: dict[str, Any] = {**COARSE, "keeps": True}
FORBIDDEN = """Object.defineProperty(window, 'localStorage', {
    get() { throw new DOMException('The request was denied for this document.', 'SecurityError'); }
});"""
FULL = """Storage.prototype.setItem = () => {
    throw new DOMException('There is no room.', 'QuotaExceededError');
};"""


@pytest.fixture
def scene(faces: Faces, request: pytest.FixtureRequest) -> Scene:
    """A rig that no other test has."""
    return replace(faces.alone, title=request.node.name)


def again(page: Page) -> None:
    page.reload()
    page.evaluate("elastomorph.ready")
    settled(page)


def written(page: Page, words: str) -> None:
    """Waits until the storage holds words for the rig of a page."""
    wait(
        page,
        """Object.entries(localStorage).some(([key, text]) =>
            key.includes(document.querySelector('h1').textContent)"""
        f" && text.includes({json.dumps(words)}))",
    )


def beside(page: Page) -> Page:
    """The same page in another tab of the browser."""
    other = page.context.new_page()
    other.goto(page.url)
    other.evaluate("elastomorph.ready")
    return other


def poses(page: Page) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = state(page)["poses"]
    return found


def test_work_is_there_again(visit: Visit, scene: Scene) -> None:
    """Poses, favourites, folded groups, and the last view with its camera."""
    page = visit(scene, **KEEPS)
    update(page, poses=[OPEN, SMILE], favourites=["jawOpen"], folded=["Lids"])
    update(page, weights={"jawOpen": 0.4}, t=0.5, wireframe=True)
    page.locator(".picture").focus()
    page.keyboard.press("3")
    before = state(page)
    again(page)
    assert state(page) == before
    page.keyboard.press("Control+z")
    assert state(page) == before, "what was done before is no step of this page"
    page.get_by_role("tab", name="Display").click()
    assert page.evaluate("Object.values(localStorage)[0]").count("camera=side") == 1


def test_another_rig_has_its_own(visit: Visit, scene: Scene) -> None:
    page = visit(scene, **KEEPS)
    update(page, poses=[OPEN])
    written(page, "Open")
    other = visit(replace(scene, title=f"{scene.title}, another"), **KEEPS)
    assert poses(other) == []


def test_a_start_that_somebody_asks_for_comes_first(visit: Visit, scene: Scene) -> None:
    """With the poses of both."""
    page = visit(scene, **KEEPS)
    update(page, poses=[OPEN], weights={"jawOpen": 0.4})
    written(page, "Open")
    asked = {"weights": {"mouthFunnel": 1}, "poses": [SMILE, OPEN]}
    write_viewer(page.url.removeprefix("file://"), replace(scene, start=asked))
    again(page)
    assert state(page)["weights"] == {"mouthFunnel": 1}
    assert poses(page) == [OPEN, SMILE]


def test_two_tabs_keep_the_poses_of_both(visit: Visit, scene: Scene) -> None:
    """Each hears of the other, and undoes only its own."""
    page = visit(scene, **KEEPS)
    update(page, poses=[OPEN])
    written(page, "Open")
    other = beside(page)
    assert poses(other) == [OPEN]
    update(other, poses=[OPEN, SMILE], favourites=["jawOpen"])
    wait(page, "elastomorph.state().poses.length === 2")
    assert state(page)["favourites"] == ["jawOpen"]
    update(page, poses=[OPEN, SMILE, BLINK])
    wait(other, "elastomorph.state().poses.length === 3")
    page.evaluate("dispatchEvent(new KeyboardEvent('keydown', {key: 'z', ctrlKey: true}))")
    wait(other, "elastomorph.state().poses.length === 2")
    assert poses(page) == poses(other) == [OPEN, SMILE]
    other.close()


def test_two_tabs_that_change_one_pose(visit: Visit, scene: Scene) -> None:
    """At the same time: neither is lost."""
    page = visit(scene, **KEEPS)
    update(page, poses=[OPEN])
    written(page, "Open")
    other = beside(page)
    wider, narrow = ({"name": "Open", "weights": {"jawOpen": amount}} for amount in (1, 0.5))
    for tab, pose in ((page, wider), (other, narrow)):
        tab.evaluate("pose => { elastomorph.update({poses: [pose]}); }", pose)
    for tab in (page, other):
        wait(tab, "elastomorph.state().poses.length === 2")
    assert poses(page) == poses(other)
    assert [pose["name"] for pose in poses(page)] == ["Open", "Open 2"]
    assert {pose["weights"]["jawOpen"] for pose in poses(page)} == {1, 0.5}
    other.close()


@pytest.mark.parametrize(
    ("script", "words"),
    [(FORBIDDEN, "This browser keeps nothing for this page"), (FULL, "is full")],
    ids=["forbidden", "full"],
)
def test_storage_that_takes_nothing(visit: Visit, scene: Scene, script: str, words: str) -> None:
    """One sentence, once there is something to lose; everything else works."""
    page = visit(scene, **KEEPS)
    hindered = page.context.new_page()
    hindered.add_init_script(script)
    hindered.goto(page.url)
    hindered.evaluate("elastomorph.ready")
    update(hindered, weights={"jawOpen": 0.4})
    hindered.wait_for_timeout(600)
    assert told(hindered) == ""
    update(hindered, poses=[OPEN])
    hindered.get_by_role("alert").get_by_text(words).wait_for()
    update(hindered, poses=[OPEN, SMILE])
    hindered.wait_for_timeout(600)
    assert hindered.locator(".alerts .message").count() == 1
    assert poses(hindered) == [OPEN, SMILE]
    hindered.close()


@pytest.mark.parametrize("text", ["{", '{"poses": [{"name": 7}]}', '"a word"'])
def test_storage_that_is_damaged(visit: Visit, scene: Scene, text: str) -> None:
    """It is laid aside, and told; the page begins anew and keeps again."""
    page = visit(scene, **KEEPS)
    update(page, poses=[OPEN])
    written(page, "Open")
    key = f"Object.keys(localStorage).find(key => key.includes({json.dumps(scene.title)}))"
    blank = page.context.new_page()
    blank.add_init_script(f"localStorage[{key}] = {json.dumps(text)}")
    blank.goto(page.url)
    blank.evaluate("elastomorph.ready")
    assert "What the browser kept for this rig is damaged" in told(blank)
    assert poses(blank) == []
    assert blank.evaluate("Object.values(localStorage)").count(text) == 1
    update(blank, poses=[SMILE])
    written(blank, "Smile")
    blank.close()


def test_a_link_comes_before_the_last_view(visit: Visit, scene: Scene) -> None:
    page = visit(scene, **KEEPS)
    update(page, weights={"jawOpen": 0.4}, poses=[OPEN])
    written(page, "jawOpen:0.4")
    other = page.context.new_page()
    other.goto(f"{page.url}#view=mouthFunnel:0.5")
    other.evaluate("elastomorph.ready")
    assert state(other)["weights"] == {"mouthFunnel": 0.5}
    assert poses(other) == [OPEN]
    other.close()
