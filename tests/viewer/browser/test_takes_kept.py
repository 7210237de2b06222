"""Takes, their edits and sounds are there again after a page is loaded anew."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from faces import Faces, glb
from takes import ASKS, alone, kept, latest, named_rig, open_files, page_title, shelf, told
from test_takes_videos import write_click
from visiting import Visit, again, beside, state, update, wait

import elastomorph as em
from elastomorph.rig import Rig
from elastomorph.viewer import write_viewer

if TYPE_CHECKING:
    from playwright.sync_api import Locator, Page

KEEPS: dict[str, Any] = {"size": (900, 620), "keeps": True}
SLIDERS = ("jawOpen", "browInnerUp_L", "browInnerUp_R", "cheekPuff")
LIVE = "Timecode,BlendShapeCount,JawOpen,BrowInnerUp,TongueOut,HeadYaw"
FORBIDDEN = """Object.defineProperty(window, 'indexedDB', {
    get() { throw new DOMException('The request was denied.', 'SecurityError'); }
});"""
SILENT = "IDBFactory.prototype.open = () => { throw new DOMException('No.', 'UnknownError'); };"
FULL = """IDBObjectStore.prototype.put = function () {
    if (!window.room) throw new DOMException('There is no room.', 'QuotaExceededError');
    return put.apply(this, arguments);
};"""
FULL = f"(() => {{ const put = IDBObjectStore.prototype.put; {FULL} }})();"


@pytest.fixture
def title(request: pytest.FixtureRequest) -> str:
    """Of a rig that no other test has."""
    return str(request.node.name)


@pytest.fixture
def phone(tmp_path: Path) -> Path:
    """A take of a phone, of two seconds."""
    rows = [f"10:00:{i // 60:02d}:{i % 60:02d}.5,4,{i / 120},0.5,0.5,-0.25" for i in range(120)]
    path = tmp_path / "phone.csv"
    path.write_text("\n".join([LIVE, *rows]) + "\n")
    return path


@pytest.fixture
def page(visit: Visit, title: str, phone: Path) -> Page:
    """It is open on a rig."""
    opened = visit(alone(glb(named_rig(SLIDERS)), title), **KEEPS)
    open_files(opened, phone)
    assert told(opened) == []
    return opened


def number(page: Page, name: str) -> Locator:
    return page.get_by_role("spinbutton", name=name, exact=True)


def edit(page: Page, curve: str, value: float, seconds: float = 1.0) -> None:
    """One key of a curve."""
    page.get_by_role("combobox", name="Curve").select_option(curve)
    update(page, clipTime=seconds)
    number(page, "Falloff").fill("0")
    number(page, "Value").fill(str(value))
    number(page, "Value").press("Enter")


def test_a_take_with_its_edits_is_there_again(page: Page) -> None:
    """With what of its file drives nothing, its points, its loop, its speed and its time."""
    edit(page, "browInnerUp_L", 0.875)
    update(page, range=[0.25, 1.5], speed=0.5, repeat="once", clipTime=1.25)
    kept(page)
    before = latest(page)
    rest = "(({names, weights, rate, timecodes}) => [names, [...weights], rate, timecodes])"
    recorded = page.evaluate(f"{rest}(elastomorph.state().takes[0].recorded)")
    view = state(page)
    again(page)
    after = latest(page)
    assert after.name == before.name == "phone"
    np.testing.assert_array_equal(after.times, before.times)
    assert list(after.tracks) == list(before.tracks)
    for slider, track in before.tracks.items():
        np.testing.assert_array_equal(after.tracks[slider], track)
    assert after.tracks["browInnerUp_L"][60] == 0.875
    assert page.evaluate(f"{rest}(elastomorph.state().takes[0].recorded)") == recorded
    fields = ("clip", "clipTime", "range", "speed", "repeat", "weights", "playing")
    found = state(page)
    assert {field: found[field] for field in fields} == {field: view[field] for field in fields}
    assert page.get_by_role("combobox", name="What plays").input_value() == "phone"
    assert not page.evaluate(ASKS), "it is kept"
    page.keyboard.press("Control+z")
    np.testing.assert_array_equal(
        latest(page).tracks["browInnerUp_L"], after.tracks["browInnerUp_L"]
    )


def test_an_edit_writes_only_its_curve(page: Page) -> None:
    kept(page)
    page.evaluate(
        """() => {
            const put = IDBObjectStore.prototype.put;
            window.put = [];
            IDBObjectStore.prototype.put = function (value, key) {
                window.put.push(String(key[2]));
                return put.call(this, value, key);
            };
        }"""
    )
    edit(page, "jawOpen", 0.9)
    kept(page)
    assert page.evaluate("put") == ["jawOpen", "0"]
    again(page)
    assert latest(page).tracks["jawOpen"][60] == pytest.approx(0.9)


def test_its_sound_is_there_again(page: Page, tmp_path: Path) -> None:
    sound = write_click(tmp_path, seconds=2, at=1)
    open_files(page, sound)
    assert told(page) == []
    number(page, "Sound +").fill("0.25")
    number(page, "Sound +").press("Enter")
    for _ in range(2):  # also where it was not touched since
        kept(page, lambda found: "2" in found[0]["parts"] and found[0]["offset"] == 0.25)
        again(page)
        page.get_by_text(f"♪ {sound.name}").wait_for()
        assert number(page, "Sound +").input_value() == "0.25"
        assert told(page) == []


def test_a_take_that_is_closed_is_kept_no_more(page: Page) -> None:
    """Undone it is there again."""
    edit(page, "jawOpen", 0.9)
    kept(page)
    page.get_by_role("button", name="Close take").click()
    assert state(page)["clip"] is None
    kept(page)
    assert shelf(page) == []
    page.keyboard.press("Control+z")
    assert latest(page).tracks["jawOpen"][60] == pytest.approx(0.9)
    kept(page)
    page.get_by_role("button", name="Close take").click()
    kept(page)
    again(page)
    assert page.evaluate("elastomorph.state().takes.length") == 0
    assert told(page) == []


def test_an_edited_clip_of_a_file_is_there_again(visit: Visit, faces: Faces, title: str) -> None:
    """In place of the file's; closed, the file's is there."""
    page = visit(replace(faces.performed, title=title), **KEEPS)
    page.keyboard.press("t")
    page.get_by_role("combobox", name="Curve").select_option("jawOpen")
    update(page, clipTime=0.5)
    number(page, "Value").fill("0.125")
    number(page, "Value").press("Enter")
    kept(page)
    again(page)
    assert latest(page).tracks["jawOpen"][15] == 0.125
    assert state(page)["weights"]["jawOpen"] == pytest.approx(0.125)
    page.keyboard.press("t")
    page.get_by_role("button", name="Close take").click()
    assert state(page)["clip"] == "a take"
    assert state(page)["weights"]["jawOpen"] == pytest.approx(1, abs=1e-3)


def test_another_rig_has_its_own(page: Page, title: str) -> None:
    """And takes go on with another face into what is kept for it."""
    edit(page, "jawOpen", 0.9)
    kept(page)
    other = named_rig(("cheekPuff", "jawOpen"))
    file = {"name": "other.glb", "mimeType": "", "buffer": glb(wider(other))}
    page.locator("input[type=file]").first.set_input_files(file)
    wait(page, "document.querySelector('h1').textContent === 'other'")
    kept(page)
    assert latest(page).tracks["jawOpen"][60] == pytest.approx(0.9)
    assert len(shelf(page, title)) == len(shelf(page)) == 1
    fresh = beside(page)
    assert latest(fresh).tracks["jawOpen"][60] == pytest.approx(0.9)
    fresh.close()


def wider(rig: Rig) -> Rig:
    """The rig with a vertex more."""
    corners = np.vstack([rig.neutral.vertices, [[2.0, 2.0, 0.0]]])
    neutral = em.Mesh(corners, [[0, 1, 3, 2], [1, 4, 3]])
    to = em.prepare(neutral, "linear")
    moved = corners + [0, 0, 0.1]
    return Rig(neutral, {name: to(neutral.with_vertices(moved)) for name in rig.names})


def test_a_rig_with_other_sliders(page: Page, title: str) -> None:
    """More targets, or fewer: the take is matched anew, and edits that no slider shows stay."""
    edit(page, "browInnerUp_L", 0.875)
    kept(page)
    place = page.url.removeprefix("file://")
    for sliders in (("browInnerUp", "tongueOut"), SLIDERS, SLIDERS):
        write_viewer(place, alone(glb(named_rig(sliders)), title))
        again(page)
        assert not any("kept" in words for words in told(page))
        assert set(latest(page).tracks) == set(sliders) - {"cheekPuff"}
        kept(page)
    assert latest(page).tracks["browInnerUp_L"][60] == 0.875


def test_two_tabs_keep_what_both_did(page: Page, tmp_path: Path) -> None:
    """Where both edited one take it is there twice."""
    kept(page)
    other = beside(page)
    for tab, value in ((page, 0.25), (other, 0.75)):
        edit(tab, "jawOpen", value)
    for tab in (page, other):
        wait(tab, f"{ASKS} === false")
    again(page)
    found = {take.name: take.tracks["jawOpen"][60] for take in (latest(page, 0), latest(page, 1))}
    assert set(found) == {"phone", "phone 2"}
    assert set(found.values()) == {0.25, 0.75}
    assert told(page) == []
    other.close()


def test_what_another_tab_edited_is_not_closed(page: Page) -> None:
    kept(page)
    other = beside(page)
    edit(other, "jawOpen", 0.75)
    wait(other, f"{ASKS} === false")
    page.get_by_role("button", name="Close take").click()
    time.sleep(0.8)  # whatever it would do is done
    again(other)
    assert latest(other).tracks["jawOpen"][60] == 0.75
    other.close()


@pytest.mark.parametrize(
    ("script", "words"),
    [(FORBIDDEN, "keeps no takes"), (SILENT, "keeps no takes"), (FULL, "is full")],
    ids=["forbidden", "broken", "full"],
)
def test_a_browser_that_keeps_nothing(page: Page, phone: Path, script: str, words: str) -> None:
    """One sentence, everything else works, and whoever leaves with edits is asked."""
    kept(page)
    page.get_by_role("button", name="Close take").click()
    kept(page)
    hindered = beside(page, script)
    told(hindered)
    open_files(hindered, phone)
    hindered.get_by_role("alert").get_by_text(words).wait_for()
    assert not hindered.evaluate(ASKS), "there is a file of it"
    edit(hindered, "jawOpen", 0.9)
    time.sleep(0.8)  # it tries again
    assert hindered.locator(".alerts .message").count() == 1
    assert hindered.evaluate(ASKS)
    assert latest(hindered).tracks["jawOpen"][60] == pytest.approx(0.9)
    assert shelf(page) == []
    if script == FULL:
        hindered.evaluate("room = true")
        edit(hindered, "jawOpen", 0.8)
        kept(hindered)
    hindered.evaluate("elastomorph.update({takes: []})")
    hindered.close()


def test_a_sound_that_is_too_large_is_said(page: Page, tmp_path: Path) -> None:
    page.evaluate("Object.defineProperty(Blob.prototype, 'size', {get: () => 2 ** 28 + 1})")
    open_files(page, write_click(tmp_path, seconds=2, at=1))
    page.get_by_text("sounds of up to 256 MiB are there again").wait_for()
    kept(page, lambda found: "2" not in found[0]["parts"])
    assert page.locator(".alerts .message").count() == 1


DAMAGES = {
    "a curve is missing": ("jawOpen", "undefined"),
    "a curve is short": ("jawOpen", "value.slice(1)"),
    "a curve is no number": ("jawOpen", "value.fill(NaN)"),
    "there is no base": ("1", "undefined"),
    "what its file held is gone": ("3", "undefined"),
    "the base is a word": ("1", "'word'"),
    "times fall": ("1", "{...value, times: value.times.toReversed()}"),
    "its recording is short": ("3", "value.slice(1)"),
    "turns of the head are missing": ("1", "{...value, heads: [[0, 0, 0]]}"),
    "its head is lost": ("0", "undefined"),
    "its name is a number": ("0", "{...value, name: 5}"),
    "its sound is set off by a word": ("0", "{...value, offset: 'word'}"),
    "its head is of another version": ("0", "{...value, version: 7}"),
}
DAMAGE = """([key, part, change]) => new Promise((done, fail) => {
    const opening = indexedDB.open('elastomorph');
    opening.onsuccess = () => {
        const transaction = opening.result.transaction('takes', 'readwrite');
        const store = transaction.objectStore('takes');
        const place = [...key, /^\\d$/.test(part) ? Number(part) : part];
        const asked = store.get(place);
        asked.onsuccess = () => {
            const value = asked.result;
            const next = CHANGE;
            if (next === undefined) store.delete(place);
            else store.put(next, place);
        };
        transaction.oncomplete = () => (opening.result.close(), done());
        transaction.onabort = () => fail(transaction.error);
    };
})"""


@pytest.mark.parametrize("damage", DAMAGES)
def test_what_is_damaged_is_laid_aside(page: Page, phone: Path, damage: str) -> None:
    """And told once; other takes are there, and the page keeps takes again."""
    kept(page)
    second = phone.with_name("second.csv")
    second.write_text(phone.read_text())
    open_files(page, second)
    kept(page)
    part, change = DAMAGES[damage]
    [key] = [one["key"] for one in shelf(page) if one["name"] == "phone"]
    page.evaluate(DAMAGE.replace("CHANGE", change), [key, part, ""])
    again(page)
    [words] = told(page)
    assert words.startswith("A take that the browser kept for this rig is damaged")
    assert page.evaluate("elastomorph.state().takes.length") == 1
    assert latest(page).name == "second"
    again(page)
    assert told(page) == []
    open_files(page, phone)
    kept(page, lambda found: len(found) == 2)
    assert len(shelf(page, f"{page_title(page)}, 4, damaged")) == 1
