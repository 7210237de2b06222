"""Poses under their names: saved, found again, blended, put in order, carried as text and files."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from faces import Faces
from pictures import differing, picture
from test_sliders import assert_posed, slider
from visiting import COARSE, PHONE, Visit, settled, state, update, wait

import elastomorph as em
from elastomorph.rig.performance import fitted_poses

if TYPE_CHECKING:
    from playwright.sync_api import Locator, Page

OPEN = {"name": "Open", "weights": {"jawOpen": 0.8}}
SMILE = {"name": "Smile", "weights": {"mouthSmile_L": 0.7, "mouthSmile_R": 0.6}}
BLINK = {"name": "Blink", "weights": {"eyeBlink_L": 1, "eyeBlink_R": 1}}


def poses_tab(page: Page, *poses: dict[str, Any]) -> None:
    page.get_by_role("tab", name="Poses").click()
    update(page, poses=list(poses))
    settled(page)


def names(page: Page) -> list[str]:
    """As the list shows them, which must be as the state has them."""
    settled(page)
    shown = page.locator(".pose-name").all_inner_texts()
    assert shown == [pose["name"] for pose in state(page)["poses"]]
    return shown


def row(page: Page, name: str) -> Locator:
    return page.locator(f'.pose[data-pose="{name}"]')


def act(page: Page, words: str) -> None:
    page.get_by_role("toolbar", name="The chosen pose").get_by_role("button", name=words).click()


def told(page: Page) -> str:
    return " ".join(page.locator(".alerts .message p").all_inner_texts())


def paste(page: Page, text: str) -> None:
    """As the browser does at its own key, which needs nobody's leave."""
    page.evaluate(
        """text => {
            const clipboardData = new DataTransfer();
            clipboardData.setData('text', text);
            const options = {clipboardData, bubbles: true, cancelable: true};
            document.activeElement.dispatchEvent(new ClipboardEvent('paste', options));
        }""",
        text,
    )


def test_saved_and_loaded(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **COARSE)
    slider(page, "jawOpen").press("End")
    page.keyboard.press("p")
    page.keyboard.type("  Wide\topen ")
    page.keyboard.press("Enter")
    assert state(page)["poses"] == [{"name": "Wide open", "weights": {"jawOpen": 1}}]
    page.keyboard.press("0")  # the keys are those of the page again
    page.get_by_role("button", name="Save", exact=True).click()
    assert names(page) == ["Wide open", "Pose 2"], "without a name it gets one"
    page.get_by_role("button", name="Save", exact=True).dblclick()
    assert names(page) == ["Wide open", "Pose 2"], "which it has, then"
    row(page, "Wide open").click()
    assert state(page)["weights"] == {"jawOpen": 1}
    assert_posed(page, faces)
    page.keyboard.press("Control+z")
    assert state(page)["weights"] == {}
    update(page, weights={"mouthFunnel": 0.5})
    page.get_by_role("textbox", name="Name of the pose").fill("Wide open")
    page.get_by_role("button", name="Replace").click()
    assert state(page)["poses"][0] == {"name": "Wide open", "weights": {"mouthFunnel": 0.5}}
    assert names(page) == ["Wide open", "Pose 2"]


def test_a_pose_takes_over_from_a_performance(visit: Visit, faces: Faces) -> None:
    page = visit(faces.performed, **COARSE)
    poses_tab(page, OPEN)
    update(page, clip="a take", clipTime=0.3)
    row(page, "Open").click()
    assert state(page)["clip"] is None
    assert state(page)["weights"] == {"jawOpen": 0.8}


def test_renamed_copied_moved_and_deleted(visit: Visit, faces: Faces) -> None:
    """By the buttons, and undone."""
    page = visit(faces.alone, **COARSE)
    poses_tab(page, OPEN, SMILE, BLINK)
    row(page, "Smile").click()
    act(page, "Rename")
    field = page.get_by_role("textbox", name="New name of Smile")
    field.fill("Grin")
    field.press("Enter")
    assert names(page) == ["Open", "Grin", "Blink"]
    act(page, "Duplicate")
    assert names(page) == ["Open", "Grin", "Grin 2", "Blink"]
    act(page, "Move down")
    assert names(page) == ["Open", "Grin", "Blink", "Grin 2"]
    settled(page)
    assert page.get_by_role("button", name="Move down").is_disabled()
    row(page, "Open").click()
    act(page, "Delete")
    assert names(page) == ["Grin", "Blink", "Grin 2"]
    for expected in (["Open", "Grin", "Blink", "Grin 2"], ["Open", "Grin", "Blink", "Grin 2"]):
        page.keyboard.press("Control+z")
        assert names(page) == expected  # the deletion, then the loading of what was deleted
    page.keyboard.press("Control+z")
    assert names(page) == ["Open", "Grin", "Grin 2", "Blink"]


def test_by_keys(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **COARSE)
    poses_tab(page, OPEN, SMILE, BLINK)
    row(page, "Open").focus()
    page.keyboard.press("ArrowDown")
    page.keyboard.press("Enter")
    assert state(page)["weights"] == SMILE["weights"]
    page.keyboard.press("Alt+ArrowUp")
    assert names(page) == ["Smile", "Open", "Blink"]
    page.keyboard.press("Control+d")
    assert names(page) == ["Smile", "Smile 2", "Open", "Blink"]
    page.keyboard.press("Delete")
    assert names(page) == ["Smile", "Open", "Blink"]
    page.keyboard.press("F2")
    page.keyboard.type("Wide")
    page.keyboard.press("Escape")
    assert names(page) == ["Smile", "Open", "Blink"]
    page.keyboard.press("F2")
    page.keyboard.type("Wide")
    page.keyboard.press("Enter")
    assert names(page) == ["Smile", "Wide", "Blink"]
    page.keyboard.press("Space")
    assert state(page)["weights"] == OPEN["weights"], "the focus stays with the pose"


def test_by_touch(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, size=PHONE, has_touch=True, **COARSE)
    poses_tab(page, OPEN, SMILE)
    row(page, "Smile").tap()
    assert state(page)["weights"] == SMILE["weights"]
    page.get_by_role("button", name="Move up").tap()
    assert names(page) == ["Smile", "Open"]
    box = row(page, "Smile").bounding_box()
    assert box is not None
    assert box["height"] >= 44


def test_a_name_is_typed_while_another_tab_changes_the_list(visit: Visit, faces: Faces) -> None:
    """The field stays; where its own pose goes, so does it. A click elsewhere is a click there."""
    page = visit(faces.alone, **COARSE)
    poses_tab(page, OPEN, SMILE, BLINK)
    row(page, "Smile").click()
    act(page, "Rename")
    page.keyboard.type("Gr")
    update(page, poses=[BLINK, SMILE, OPEN])
    settled(page)
    page.keyboard.type("in")
    row(page, "Open").click()
    assert names(page) == ["Blink", "Grin", "Open"]
    assert state(page)["weights"] == OPEN["weights"]
    act(page, "Rename")
    page.keyboard.type("Wide")
    update(page, poses=[BLINK, SMILE])
    assert names(page) == ["Blink", "Smile"]


def test_a_name_that_is_taken(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **COARSE)
    poses_tab(page, OPEN, SMILE)
    row(page, "Smile").click()
    act(page, "Rename")
    field = page.get_by_role("textbox", name="New name of Smile")
    field.fill("Open")
    field.press("Enter")
    assert names(page) == ["Open", "Smile"]
    assert told(page) == "Another pose is called “Open” already."


def test_blended(visit: Visit, faces: Faces) -> None:
    """A part of the way to a pose, and on top of another."""
    page = visit(faces.alone, **COARSE)
    poses_tab(page, OPEN, SMILE)
    update(page, weights={"jawOpen": 0.4})
    row(page, "Smile").click()
    strength = page.get_by_role("slider", name="Strength of the pose")
    strength.fill("0.5")
    update(page, weights={"jawOpen": 0.4})
    row(page, "Smile").dblclick()
    assert state(page)["weights"] == pytest.approx(
        {"jawOpen": 0.2, "mouthSmile_L": 0.35, "mouthSmile_R": 0.3}
    )
    page.get_by_role("checkbox", name="On top").check()
    assert state(page)["weights"] == pytest.approx(
        {"jawOpen": 0.4, "mouthSmile_L": 0.35, "mouthSmile_R": 0.3}
    )
    row(page, "Open").click()
    assert state(page)["weights"]["jawOpen"] == pytest.approx(0.8)
    strength.fill("1")
    assert state(page)["weights"]["jawOpen"] == 1, "not beyond what a slider reaches"
    slider_now = {**state(page)["weights"], "mouthFunnel": 0.3}
    update(page, weights=slider_now)
    strength.fill("0.2")
    assert state(page)["weights"] == slider_now, "somebody has moved on: the pose stays as it is"


def test_pictures(visit: Visit, faces: Faces) -> None:
    """Each pose has its own, and the large picture is as it was."""
    page = visit(faces.alone)
    before = picture(page)
    poses_tab(page, OPEN, {"name": "Calm", "weights": {}})
    wait(page, "document.querySelectorAll('.portrait canvas').length === 2")
    pixels = page.evaluate(
        """[...document.querySelectorAll('.portrait canvas')].map(canvas =>
            [...canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data])"""
    )
    wide, calm = (np.reshape(one, (112, 112, 4)).astype(int) for one in pixels)
    moved = differing(wide, calm, 30)
    assert 0.01 < moved.mean() < 0.5
    rows = np.flatnonzero(moved.any(axis=1))
    assert rows.mean() > 56, "the jaw is in the lower half"
    assert not differing(before, picture(page)).any()


def test_pictures_of_what_is_in_sight(visit: Visit, faces: Faces) -> None:
    """Of hundreds of poses a few are drawn, and then nothing more."""
    page = visit(faces.alone, **COARSE)
    poses_tab(page, *({"name": f"Pose {i}", "weights": {"jawOpen": i / 600}} for i in range(600)))
    page.locator(".pose-scroll").evaluate("list => (list.scrollTop = list.scrollHeight)")
    wait(page, "document.querySelector('.pose-list li:last-child canvas')")
    assert page.locator(".portrait canvas").count() < 40


def test_text_of_one_pose(visit: Visit, faces: Faces) -> None:
    """Copied, and pasted into another page: JSON that people can read."""
    page = visit(faces.alone, permissions=["clipboard-read", "clipboard-write"], **COARSE)
    poses_tab(page, OPEN, SMILE)
    row(page, "Smile").click()
    act(page, "Copy as text")
    page.get_by_text("“Smile” is on the clipboard").wait_for()
    text = page.evaluate("navigator.clipboard.readText()")
    assert json.loads(text) == {"format": "elastomorph poses", "version": 1, "poses": [SMILE]}
    update(page, poses=[OPEN])
    page.get_by_role("button", name="Paste").click()
    page.get_by_text("“Smile” is here").wait_for()
    assert state(page)["poses"] == [OPEN, SMILE]
    page.get_by_role("button", name="Paste").click()
    settled(page)
    assert state(page)["poses"] == [OPEN, SMILE], "what is there already is not there twice"


def test_pasted_by_the_browsers_key(visit: Visit, faces: Faces) -> None:
    """Also into the field of the name, for who has no key for it; other fields keep theirs."""
    page = visit(faces.alone, **COARSE)
    poses_tab(page)
    page.locator(".picture").focus()
    paste(page, json.dumps({"Smile": SMILE["weights"]}))
    assert state(page)["poses"] == [SMILE]
    page.get_by_role("textbox", name="Name of the pose").focus()
    paste(page, json.dumps({"Smile": OPEN["weights"]}))
    assert names(page) == ["Smile", "Smile 2"], "another of that name: nothing is lost"
    paste(page, "A plain name")
    assert names(page) == ["Smile", "Smile 2"]
    page.get_by_role("tab", name="Sliders").click()
    page.get_by_role("searchbox", name="Search sliders").focus()
    paste(page, json.dumps({"Open": OPEN["weights"]}))
    assert len(state(page)["poses"]) == 2


def test_sliders_that_the_rig_does_not_have(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **COARSE)
    poses_tab(page, OPEN)
    paste(page, json.dumps({"Odd": {"jawOpen": 0.3, "gill": 1, "fin": 0.5}}))
    assert state(page)["poses"] == [OPEN, {"name": "Odd", "weights": {"jawOpen": 0.3}}]
    assert told(page) == (
        "The rig has none of the sliders gill and fin; what else the poses move is kept."
    )


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("{", "this is no JSON, or only a part of it"),
        ("[1, 2]", "this is no object with poses"),
        ("{}", "there are no poses in it"),
        ('{"poses": [{"weights": {}}]}', "a pose has no name"),
        ('{"poses": [{"name": "Odd"}]}', "“Odd” has no weights"),
        ('{"Odd": {"jawOpen": "wide"}}', 'the weight of jawOpen in “Odd” is "wide"'),
        ('{"format": "elastomorph poses", "version": 7, "poses": []}', "version 7 of poses"),
        ('{"format": "a pizza", "poses": []}', 'the format is "a pizza"'),
    ],
)
def test_text_that_is_none(visit: Visit, faces: Faces, text: str, problem: str) -> None:
    page = visit(faces.alone, **COARSE)
    poses_tab(page, OPEN)
    with page.expect_file_chooser() as chosen:
        page.get_by_role("button", name="Open…").click()
    chosen.value.set_files(
        {"name": "odd.json", "mimeType": "application/json", "buffer": text.encode()}
    )
    page.get_by_role("alert").locator(".message").wait_for()
    assert told(page).startswith("odd.json: ")
    assert problem in told(page)
    assert state(page)["poses"] == [OPEN]


def test_files(visit: Visit, faces: Faces, tmp_path: Path) -> None:
    """All poses as JSON and as a table, and from JSON again."""
    page = visit(faces.alone, **COARSE)
    poses = [OPEN, {"name": 'Say "a, b"', "weights": {"jawOpen": 0.25}}, SMILE]
    poses_tab(page, *poses)
    saved = {}
    for kind, suffix in (("JSON", "json"), ("CSV", "csv")):
        with page.expect_download() as download:
            page.get_by_role("button", name=kind, exact=True).click()
        assert download.value.suggested_filename == f"Built-in head poses.{suffix}"
        saved[suffix] = tmp_path / f"poses.{suffix}"
        download.value.save_as(saved[suffix])
    assert json.loads(saved["json"].read_text(encoding="utf-8"))["poses"] == poses
    with saved["csv"].open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [
        {"name": one.pop("pose"), "weights": {n: float(w) for n, w in one.items() if float(w)}}
        for one in rows
    ] == poses
    for file in saved.values():
        assert em.read_poses(file) == {pose["name"]: pose["weights"] for pose in poses}
        update(page, poses=[])
        page.locator("input[type=file]").set_input_files(file)
        wait(page, "elastomorph.state().poses.length === 3")
        assert state(page)["poses"] == poses


def test_a_table_of_another_program(visit: Visit, faces: Faces, tmp_path: Path) -> None:
    """Names in ARKit's spelling and cells as a sheet copies them mean the same as in Python."""
    page = visit(faces.alone, **COARSE)
    poses_tab(page)
    text = "pose\tjawOpen\tmouthSmileLeft\teyeBlink\tgill\nWide\t0,5\t\t\t1\nSly\t\t0,25\t1\t\n"
    paste(page, text)
    assert state(page)["poses"] == [
        {"name": "Wide", "weights": {"jawOpen": 0.5}},
        {"name": "Sly", "weights": {"mouthSmile_L": 0.25, "eyeBlink_L": 1, "eyeBlink_R": 1}},
    ]
    assert told(page) == "The rig has no slider gill; what else the poses move is kept."
    file = tmp_path / "sheet.csv"
    file.write_text(text, encoding="utf-8")
    with pytest.warns(em.ElastomorphWarning, match="tabs"):
        poses = em.read_poses(file)
    fit = fitted_poses(poses, faces.rigs["beam:2"].names)
    assert [{"name": name, "weights": own} for name, own in fit.poses.items()] == state(page)[
        "poses"
    ]
    assert fit.unknown == ("gill",)
