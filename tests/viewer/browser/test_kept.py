"""What the browser keeps of the work on a rig, and what happens where it cannot."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from faces import Faces, glb
from test_named_poses import BLINK, OPEN, SMILE, told
from visiting import COARSE, Visit, again, beside, state, update, wait

import elastomorph as em
from elastomorph.rig import Rig
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

# What the page would write soon after a change waits until somebody calls it.
HELD = """pose => {
    const later = globalThis.setTimeout;
    globalThis.held = [];
    globalThis.setTimeout = run => held.push(run);
    try { elastomorph.update({poses: [pose]}); } finally { globalThis.setTimeout = later; }
}"""


@pytest.fixture
def scene(faces: Faces, request: pytest.FixtureRequest) -> Scene:
    """A rig that no other test has."""
    return replace(faces.alone, title=request.node.name)


def written(page: Page, words: str, name: str = "") -> None:
    """Waits until the storage holds words for the rig of a page, by its title or a name."""
    called = json.dumps(name) if name else "document.querySelector('h1').textContent"
    wait(
        page,
        f"""Object.entries(localStorage).some(([key, text]) =>
            key.includes({called}) && text.includes({json.dumps(words)}))""",
    )


def changed(page: Page, scene: Scene) -> Page:
    """Another tab of the browser, with another scene in the file of the page."""
    write_viewer(page.url.removeprefix("file://"), scene)
    return beside(page)


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
    written(page, "camera=side")


def test_another_rig_has_its_own(visit: Visit, scene: Scene) -> None:
    page = visit(scene, **KEEPS)
    update(page, poses=[OPEN])
    written(page, "Open")
    other = changed(page, replace(scene, title=f"{scene.title}, another"))
    assert poses(other) == []
    other.close()


def test_a_rig_has_its_poses_whatever_is_done_with_it(
    visit: Visit, scene: Scene, faces: Faces
) -> None:
    """By other methods, and with another target; what a pose moves that is gone is told."""
    page = visit(replace(scene, name="a rig", title=scene.title), **KEEPS)
    update(page, poses=[OPEN, {"name": "Odd", "weights": {"jawOpen": 0.3, "mouthPress": 1}}])
    written(page, "Odd", "a rig")
    compared = replace(faces.together, name="a rig", title="a rig: three methods")
    other = changed(page, compared)
    assert [pose["name"] for pose in poses(other)] == ["Open", "Odd"]
    other.get_by_role("tab", name="Poses").click()
    other.locator(".pose").last.click()
    assert state(other)["weights"] == {"jawOpen": 0.3}
    assert told(other) == "The rig has no slider mouthPress; what else the pose moves is shown."
    other.close()


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
        tab.evaluate(HELD, pose)
    for tab in (page, other):
        tab.evaluate("() => { while (held.length) held.shift()(); }")
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
    # Another rig and back: they last until the page is closed, as it was said.
    tip = em.Mesh(np.vstack([np.zeros(3), np.eye(3)]), [[0, 2, 1], [0, 1, 3], [1, 2, 3]])
    for name, content, kept in (
        ("another.glb", glb(Rig(tip, {})), []),
        (f"{scene.title}.glb", scene.models[0].glb, [OPEN, SMILE]),
    ):
        file = {"name": name, "mimeType": "model/gltf-binary", "buffer": content}
        hindered.locator("input[type=file]").set_input_files(file)
        wait(hindered, f"elastomorph.state().poses.length === {len(kept)}")
        assert poses(hindered) == kept
    hindered.close()


@pytest.mark.parametrize("text", ["{", '{"poses": [{"name": 7}]}', '"a word"'])
def test_storage_that_is_damaged(visit: Visit, scene: Scene, text: str) -> None:
    """It is laid aside, and told; the page begins anew and keeps again."""
    page = visit(scene, **KEEPS)
    update(page, poses=[OPEN])
    written(page, "Open")
    lists = f"key.includes({json.dumps(scene.title)}) && !key.endsWith('view')"
    key = f"Object.keys(localStorage).find(key => {lists})"
    page.evaluate(f"localStorage[{key}] = {json.dumps(text)}")
    again(page)
    assert "What the browser kept for this rig is damaged" in told(page)
    assert poses(page) == []
    assert page.evaluate("Object.values(localStorage)").count(text) == 1
    update(page, poses=[SMILE])
    written(page, "Smile")


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
