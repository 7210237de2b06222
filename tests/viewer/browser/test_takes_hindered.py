"""Takes are kept as far as a browser lets them be, and nothing else stops where it does not."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from faces import glb
from takes import ASKS, alone, kept, latest, named_rig, open_files, page_title, shelf, told
from test_takes_kept import KEEPS, SLIDERS, edit, number, phone, title, wider
from test_takes_videos import write_click
from visiting import Visit, again, beside, settled, state, update, wait

import streams
from elastomorph.draw.head import neck_of
from elastomorph.io.gltf import write_glb
from elastomorph.rig.performance import HeadTurn

if TYPE_CHECKING:
    from playwright.sync_api import Page

__all__ = ["phone", "title"]

# What is waited for a browser that does not answer passes at once.
IMPATIENT = """(() => {
    const later = setTimeout;
    window.setTimeout = (run, ms, ...rest) => later(run, ms === 15000 ? 50 : ms, ...rest);
})();"""
OPENS_NEVER = IMPATIENT + "IDBFactory.prototype.open = () => ({});"
WRITES_NEVER = (
    IMPATIENT + "IDBObjectStore.prototype.put = () => (window.writing = {result: undefined});"
)
DELETES_NOTHING = """IDBObjectStore.prototype.delete = () => {
    throw new DOMException('No.', 'UnknownError');
};"""
UNREADABLE = """Blob.prototype.arrayBuffer = () =>
    Promise.reject(new DOMException('It is gone.', 'NotFoundError'));"""
# The first sound is read when release() is called.
READS_LATE = """(() => {
    const read = AudioContext.prototype.decodeAudioData;
    const held = new Promise(release => { window.release = release; });
    AudioContext.prototype.decodeAudioData = function (bytes) {
        const found = read.call(this, bytes);
        if (window.first) return found;
        window.first = held.then(() => found);
        return window.first;
    };
})();"""


def open_another_face(page: Page) -> None:
    name = f"{page_title(page)} other"  # that no other test has
    file = {"name": f"{name}.glb", "mimeType": "", "buffer": glb(wider(named_rig(SLIDERS)))}
    page.locator("input[type=file]").first.set_input_files(file)
    wait(page, "document.querySelector('h1').textContent.endsWith(' other')")


def test_other_faces_open_where_the_browser_does_not_answer(
    visit: Visit, title: str, phone: Path
) -> None:
    """It is said once."""
    page = visit(alone(glb(named_rig(SLIDERS)), title), **KEEPS)
    hindered = beside(page, OPENS_NEVER)
    open_files(hindered, phone)
    hindered.get_by_role("alert").get_by_text("keeps no takes").wait_for()
    edit(hindered, "jawOpen", 0.9)
    assert hindered.evaluate(ASKS)
    open_another_face(hindered)
    assert latest(hindered).tracks["jawOpen"][60] == pytest.approx(0.9)
    assert hindered.locator(".alerts .message").count() == 1
    hindered.evaluate("elastomorph.update({takes: []})")
    hindered.close()


def test_other_faces_open_while_a_take_is_written(visit: Visit, title: str, phone: Path) -> None:
    page = visit(alone(glb(named_rig(SLIDERS)), title), **KEEPS)
    hindered = beside(page, WRITES_NEVER)
    open_files(hindered, phone)
    wait(hindered, "window.writing")
    open_another_face(hindered)
    assert latest(hindered).name == "phone"
    hindered.close()


def test_takes_are_there_where_nothing_can_be_deleted(
    visit: Visit, title: str, phone: Path
) -> None:
    """Two tabs opened one file, of which one is enough."""
    page = visit(alone(glb(named_rig(SLIDERS)), title), **KEEPS)
    other = beside(page)
    for tab in (page, other):
        open_files(tab, phone)
    streams.wait(lambda: len(shelf(page)) == 2)
    other.close()
    hindered = beside(page, DELETES_NOTHING)
    assert hindered.evaluate("elastomorph.state().takes.length") == 1
    hindered.close()
    again(page)
    assert page.evaluate("elastomorph.state().takes.length") == 1
    kept(page)


def test_an_edited_clip_that_turns_the_head_turns_it_again(
    visit: Visit, title: str, tmp_path: Path
) -> None:
    rig = named_rig(("jawOpen", "mouthFunnel"))
    angles = np.array([[0, 0, 0], [0.4, -0.2, 0.1], [-0.6, 0.3, 0.2]])
    turn = HeadTurn(neck_of(rig.neutral, rig.morphs.values()), angles)
    weights = np.array([[0.1, 0.0], [0.2, 0.5], [0.4, 1.0]])
    write_glb(tmp_path / "a.glb", rig, animation=(np.arange(3) / 30, weights, "talk"), turn=turn)
    page = visit(alone((tmp_path / "a.glb").read_bytes(), title), **KEEPS)
    update(page, clip="talk")
    page.keyboard.press("t")
    edit(page, "jawOpen", 0.9, 1 / 30)
    kept(page)
    again(page)
    assert latest(page).tracks["jawOpen"][1] == pytest.approx(0.9)
    np.testing.assert_allclose(
        page.evaluate("elastomorph.state().takes[0].heads"), angles, atol=1e-6
    )


def with_sound(visit: Visit, title: str, phone: Path) -> tuple[Page, Path]:
    page = visit(alone(glb(named_rig(SLIDERS)), title), **KEEPS)
    sound = write_click(phone.parent, seconds=2, at=1)
    open_files(page, phone)
    open_files(page, sound)
    assert told(page) == []
    kept(page, lambda found: "2" in found[0]["parts"])
    return page, sound


def test_a_sound_that_is_added_stays_over_one_that_comes_later(
    visit: Visit, title: str, phone: Path
) -> None:
    page, sound = with_sound(visit, title, phone)
    other = beside(page, READS_LATE)
    second = sound.rename(sound.with_name("second.wav"))
    wait(other, "window.first")
    open_files(other, second)
    other.get_by_text("♪ second.wav").wait_for()
    other.evaluate("release(), first")
    settled(other)
    assert other.get_by_text("♪ second.wav").is_visible()
    other.close()


def test_a_sound_that_cannot_be_read_any_more_is_named(
    visit: Visit, title: str, phone: Path
) -> None:
    page, sound = with_sound(visit, title, phone)
    other = beside(page, UNREADABLE)
    other.get_by_role("alert").get_by_text(sound.name).wait_for()
    assert latest(other).name == "phone"
    other.close()


def test_sounds_stay_set_off_on_another_face(visit: Visit, title: str, phone: Path) -> None:
    """Also those of takes that do not play."""
    page, _ = with_sound(visit, title, phone)
    number(page, "Sound +").fill("0.25")
    number(page, "Sound +").press("Enter")
    update(page, clip=None)
    open_another_face(page)
    assert state(page)["soundOffsets"] == {"phone": 0.25}


def test_the_take_that_plays_goes_on_beside_one_of_its_name(
    visit: Visit, title: str, phone: Path
) -> None:
    """That was kept for the other face: where it is the same it is there once."""
    page = visit(alone(glb(named_rig(SLIDERS)), title), **KEEPS)
    open_files(page, phone)
    edit(page, "jawOpen", 0.25)
    kept(page)
    first = page.url
    for value, names in ((0.25, ["phone"]), (0.25, ["phone"]), (0.75, ["phone", "phone 2"])):
        page.goto(first)
        page.evaluate("elastomorph.ready")
        settled(page)
        edit(page, "jawOpen", value)
        kept(page)
        open_another_face(page)
        found = page.evaluate("elastomorph.state().takes.map(({name}) => name)")
        assert found == names
        assert state(page)["clip"] == names[-1]
        assert latest(page).tracks["jawOpen"][60] == value
        kept(page)
    page.evaluate("elastomorph.update({takes: []})")
    kept(page)
