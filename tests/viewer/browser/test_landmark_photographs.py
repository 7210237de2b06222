"""Points clicked in photographs are in the file, to a fraction of a pixel."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from placing import NAMES, active, click, dots, opened, saved, seen_dots, write_photograph
from visiting import Visit, wait

from elastomorph.capturing.landmarks import Landmarks, read_landmarks
from elastomorph.viewer import ViewerServer
from elastomorph.viewer.landmarks import landmark_task, serve_landmarks, write_landmark_page
from small_head import head, landmarks

PLACES = {"IMG_1.jpg": dots(1), "IMG_2.jpg": dots(2), "IMG_3.jpg": dots(3, (480, 640))}


@pytest.fixture(scope="module")
def photographs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three, of which the last was taken with the camera held upright."""
    folder = tmp_path_factory.mktemp("photographs") / "neutral"
    folder.mkdir()
    write_photograph(folder / "IMG_1.jpg", PLACES["IMG_1.jpg"])
    write_photograph(folder / "IMG_2.jpg", PLACES["IMG_2.jpg"])
    write_photograph(folder / "IMG_3.jpg", PLACES["IMG_3.jpg"], (480, 640), held=6)
    return folder


@pytest.fixture
def server(photographs: Path, tmp_path: Path) -> Iterator[ViewerServer]:
    with serve_landmarks(landmark_task([photographs]), tmp_path / "landmarks.json") as started:
        yield started


def test_fifteen_points_in_three_photographs(
    visit: Visit, server: ViewerServer, tmp_path: Path
) -> None:
    page = visit.blank(server.address, size=(1100, 760))
    for name in PLACES:
        opened(page, name)
        found = seen_dots(page)
        assert len(found) == len(NAMES)
        for expected, at in zip(NAMES, found, strict=True):
            assert active(page) == expected, "the next point that is missing is chosen"
            click(page, at)
        assert active(page) is None
        count = page.locator(".tile", has_text=name).locator(".badge").inner_text()
        assert count == "15/15"
        page.keyboard.press("]")
    page.get_by_text("Every point is in as many photographs").wait_for()
    saved(page)
    clicked = read_landmarks(tmp_path / "landmarks.json").photographs["neutral"]
    for name, places in PLACES.items():
        found = np.array([clicked[name][point] for point in NAMES])
        assert np.abs(found - places).max() < 0.5


def test_nearer_by_a_tenth_of_a_pixel(visit: Visit, server: ViewerServer, tmp_path: Path) -> None:
    """The wheel goes to the pointer, and there clicks are finer than pixels."""
    page = visit.blank(server.address, size=(1100, 760))
    opened(page, "IMG_1.jpg")
    for point, at in list(zip(NAMES, seen_dots(page), strict=True))[3:6]:
        page.locator(f".point[data-name={point}]").click()
        page.keyboard.press("0")
        page.mouse.move(float(at[0]), float(at[1]))
        for _ in range(6):
            page.mouse.wheel(0, -240)
        near = seen_dots(page)
        click(page, near[np.linalg.norm(near - at, axis=1).argmin()])
    saved(page)
    clicked = read_landmarks(tmp_path / "landmarks.json").photographs["neutral"]["IMG_1.jpg"]
    found = np.array([clicked[point] for point in NAMES[3:6]])
    assert np.abs(found - PLACES["IMG_1.jpg"][3:6]).max() < 0.15


def test_points_are_dragged_nudged_removed_and_brought_back(
    visit: Visit, server: ViewerServer, tmp_path: Path
) -> None:
    page = visit.blank(server.address, size=(1100, 760))
    opened(page, "IMG_1.jpg")

    def placed() -> dict[str, tuple[float, float]]:
        saved(page)
        found = read_landmarks(tmp_path / "landmarks.json").photographs
        return dict(found.get("neutral", {}).get("IMG_1.jpg", {}))

    first, second, third = seen_dots(page)[:3]
    click(page, first)
    click(page, second)
    page.mouse.move(*map(float, second))
    page.mouse.down()
    page.mouse.move(*map(float, (second + third) / 2), steps=4)
    page.mouse.move(*map(float, third), steps=4)
    page.mouse.up()
    goal = PLACES["IMG_1.jpg"][2]
    assert np.abs(np.array(placed()[NAMES[1]]) - goal).max() < 0.5
    before = placed()[NAMES[1]]
    page.locator(".picture").focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowDown")
    assert placed()[NAMES[1]] == pytest.approx((before[0] + 1, before[1] + 1))
    page.keyboard.press("Delete")
    assert list(placed()) == [NAMES[0]]
    assert active(page) == NAMES[1]
    page.keyboard.press("Control+z")
    page.keyboard.press("Control+z")  # both arrows, one after the other at the same point
    assert placed()[NAMES[1]] == pytest.approx(before)
    page.keyboard.press("Control+z")  # the whole drag
    assert np.abs(np.array(placed()[NAMES[1]]) - PLACES["IMG_1.jpg"][1]).max() < 0.5
    page.keyboard.press("Control+z")
    page.keyboard.press("Control+z")
    assert placed() == {}
    for _ in range(3):
        page.keyboard.press("Control+Shift+z")
    assert placed()[NAMES[1]] == pytest.approx(before)


def test_points_may_lie_close_together(visit: Visit, server: ViewerServer, tmp_path: Path) -> None:
    """A click beside a mark places the next point; on it, it takes hold of that one."""
    page = visit.blank(server.address, size=(1100, 760))
    opened(page, "IMG_1.jpg")
    first = seen_dots(page)[0].round()
    click(page, first)
    click(page, first + (8, 0))
    assert active(page) == NAMES[2]
    click(page, first + (1, 0))
    assert active(page) == NAMES[0], "it is chosen, and would be moved"
    saved(page)
    found = read_landmarks(tmp_path / "landmarks.json").photographs["neutral"]["IMG_1.jpg"]
    assert list(found) == list(NAMES[:2])
    apart = np.array(found[NAMES[1]]) - np.array(found[NAMES[0]])
    assert apart[0] == pytest.approx(8 / (0.97 * min(810 / 640, 620 / 480)), rel=0.1)
    assert apart[1] == pytest.approx(0, abs=0.02)


def test_keys_are_enough(visit: Visit, server: ViewerServer, tmp_path: Path) -> None:
    """A point goes where the cross in the middle of the picture is, and arrows move that."""
    page = visit.blank(server.address, size=(1100, 760))
    opened(page, "IMG_1.jpg")
    page.keyboard.press("]")
    opened(page, "IMG_2.jpg")
    while not page.evaluate("document.activeElement.matches('.picture')"):
        page.keyboard.press("Tab")
    page.keyboard.press(".")
    for key in ("+", "+", "ArrowRight", "ArrowRight", "ArrowDown", "Enter"):
        page.keyboard.press(key)
    saved(page)
    clicked = read_landmarks(tmp_path / "landmarks.json").photographs["neutral"]["IMG_2.jpg"]
    assert list(clicked) == [NAMES[1]]
    box = page.locator(".picture").bounding_box()
    assert box is not None
    scale = 0.97 * min(box["width"] / 640, box["height"] / 480) * 1.25**2
    expected = (319.5 + 2 * 24 / scale, 239.5 + 24 / scale)
    assert clicked[NAMES[1]] == pytest.approx(expected, abs=0.02)


def test_what_was_placed_before_is_kept(visit: Visit, photographs: Path, tmp_path: Path) -> None:
    """Points of other poses, scans and templates stay, and those of a photograph are shown."""
    file = tmp_path / "landmarks.json"
    known = {
        "version": 1,
        "vertices": {"chin": 7},
        "photographs": {
            "neutral": {"IMG_1.jpg": {"chin": [10.25, 20.5]}},
            "smile": {"x.jpg": {"chin": [1, 2]}},
        },
        "points": {"scan.ply": {"chin": [1, 2, 3]}},
    }
    file.write_text(json.dumps(known))
    task = landmark_task([photographs], known=read_landmarks(file))
    with serve_landmarks(task, file) as server:
        page = visit.blank(server.address, size=(1100, 760))
        opened(page, "IMG_1.jpg")
        assert page.locator(".tile", has_text="IMG_1.jpg").locator(".badge").inner_text() == "1/15"
        click(page, seen_dots(page)[0])
        saved(page)
    found = json.loads(file.read_text())
    assert found["photographs"]["neutral"]["IMG_1.jpg"].pop("nose_tip")
    assert found == known


def test_left_and_right_exchanged_is_noticed(
    visit: Visit, server: ViewerServer, tmp_path: Path
) -> None:
    """The subject's left is to the right of the picture; one button puts it right."""
    page = visit.blank(server.address, size=(1100, 760))
    opened(page, "IMG_1.jpg")
    places = {
        "left_eye_outer": (420, 250),
        "right_eye_outer": (580, 250),
        "mouth_right": (460, 400),
        "mouth_left": (540, 400),
    }
    for name, at in places.items():
        page.locator(f".point[data-name={name}]").click()
        click(page, np.array(at))
    warning = page.get_by_role("alert").get_by_text("Left and right")
    assert "Right eye outer, Left eye outer." in warning.inner_text()
    assert "Mouth" not in warning.inner_text()
    page.get_by_role("button", name="Exchange them").click()
    warning.wait_for(state="hidden")
    saved(page)
    clicked = read_landmarks(tmp_path / "landmarks.json").photographs["neutral"]["IMG_1.jpg"]
    assert clicked["left_eye_outer"][0] > clicked["right_eye_outer"][0]
    assert clicked["mouth_left"][0] > clicked["mouth_right"][0]


@pytest.mark.parametrize("exchanged", [False, True])
def test_a_face_from_the_side_is_not_taken_for_exchanged(
    visit: Visit, tmp_path: Path, exchanged: bool
) -> None:
    """The points of a head turned by up to 80 degrees; exchanged ones are seen up to 60."""
    own = landmarks()
    vertices = head().vertices[list(own.values())]
    folder = tmp_path / "neutral"
    folder.mkdir()
    clicks = {}
    for number, turn in enumerate((-60, -30, 0, 30, 60) if exchanged else (-80, -40, 0, 40, 80)):
        file = folder / f"IMG_{number}.jpg"
        write_photograph(file, np.zeros((0, 2)), (400, 400))
        c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
        turned = vertices @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
        near = 500 / (60 - turned[:, 2])
        pixels = 200 + np.stack([near * turned[:, 0], -near * (turned[:, 1] + 5)], axis=1)
        names = [other_side(name) if exchanged else name for name in own]
        clicks[file.name] = dict(zip(names, map(tuple, pixels.tolist()), strict=True))
    known = Landmarks(photographs={"neutral": clicks})
    with serve_landmarks(landmark_task([folder], known=known), tmp_path / "l.json") as server:
        page = visit.blank(server.address, size=(700, 500))
        for name in clicks:
            page.locator(".tile", has_text=name).click()
            opened(page, name)
            assert page.locator(".warning").is_visible() == exchanged


def other_side(name: str) -> str:
    swapped = name.replace("right", "LEFT").replace("left", "right")
    return swapped.replace("LEFT", "left")


def test_finish_saves_and_ends(visit: Visit, server: ViewerServer, tmp_path: Path) -> None:
    page = visit.blank(server.address, size=(1100, 760))
    opened(page, "IMG_1.jpg")
    click(page, seen_dots(page)[0])
    page.get_by_role("button", name="Finish").click()
    page.get_by_text("The command has ended").wait_for()
    server.wait()
    found = read_landmarks(tmp_path / "landmarks.json")
    assert list(found.photographs["neutral"]["IMG_1.jpg"]) == [NAMES[0]]


def test_a_command_that_has_ended_is_told_and_nothing_is_lost(
    visit: Visit, photographs: Path, tmp_path: Path
) -> None:
    visit.forgiven = "ERR_CONNECTION_REFUSED"
    with serve_landmarks(landmark_task([photographs]), tmp_path / "landmarks.json") as server:
        page = visit.blank(server.address, size=(1100, 760))
        opened(page, "IMG_1.jpg")
        # Small pictures of the others are there.
        wait(page, "[...document.querySelectorAll('.tile canvas')].every(({width}) => width > 1)")
    at = seen_dots(page)[0]
    click(page, at)
    page.get_by_role("alert").get_by_text("the command that showed this page has ended").wait_for()
    page.get_by_role("button", name="Finish").click()
    with page.expect_download() as download:
        page.get_by_role("button", name="Download").click()
    kept = json.loads(Path(download.value.path()).read_text())
    found = kept["photographs"]["neutral"]["IMG_1.jpg"][NAMES[0]]
    assert np.abs(found - PLACES["IMG_1.jpg"][0]).max() < 0.5


def test_what_cannot_be_written_is_told(visit: Visit, photographs: Path, tmp_path: Path) -> None:
    """Once it can be written again, all is saved."""
    visit.forgiven = "400 (Bad Request)"
    folder = tmp_path / "away"
    folder.mkdir()
    file = folder / "landmarks.json"
    with serve_landmarks(landmark_task([photographs]), file) as server:
        page = visit.blank(server.address, size=(1100, 760))
        opened(page, "IMG_1.jpg")
        folder.rmdir()
        found = seen_dots(page)
        click(page, found[0])
        page.get_by_role("alert").get_by_text("It could not be saved: ").wait_for()
        assert page.locator(".saved").inner_text() == "not saved"
        folder.mkdir()
        page.keyboard.press("Control+s")
        saved(page)
    assert list(read_landmarks(file).photographs["neutral"]["IMG_1.jpg"]) == [NAMES[0]]


def test_names_may_be_any(visit: Visit, photographs: Path, tmp_path: Path) -> None:
    """As phones and people write them; none of it is taken for markup."""
    folder = tmp_path / "<b>Größe & so"
    folder.mkdir()
    name = "I <3 <!-- ü #1 100%.jpg"
    (folder / name).write_bytes((photographs / "IMG_1.jpg").read_bytes())
    task = landmark_task([folder])
    with serve_landmarks(task, tmp_path / "l.json") as server:
        page = visit.blank(server.address, size=(1100, 760))
        opened(page, name)
        click(page, seen_dots(page)[0])
        saved(page)
    (pose,) = read_landmarks(tmp_path / "l.json").photographs
    assert pose == folder.name
    write_landmark_page(tmp_path / "page.html", task)
    opened(visit.blank((tmp_path / "page.html").as_uri(), size=(1100, 760)), name)


def test_a_written_page_hands_out_the_file(visit: Visit, photographs: Path, tmp_path: Path) -> None:
    file = tmp_path / "page.html"
    write_landmark_page(file, landmark_task([photographs]))
    page = visit.blank(file.as_uri(), size=(1100, 760))
    opened(page, "IMG_1.jpg")
    click(page, seen_dots(page)[0])
    with page.expect_download() as download:
        page.get_by_role("button", name="Download").click()
    assert download.value.suggested_filename == "landmarks.json"
    found = read_landmarks(Path(download.value.path())).photographs["neutral"]["IMG_1.jpg"]
    assert np.abs(np.array(found[NAMES[0]]) - PLACES["IMG_1.jpg"][0]).max() < 0.5


def test_a_tiff_is_shown_too(visit: Visit, tmp_path: Path) -> None:
    """Browsers show none; turned as its orientation says, its pixels are those of all stages."""
    folder = tmp_path / "neutral"
    folder.mkdir()
    write_photograph(folder / "IMG_1.tif", PLACES["IMG_3.jpg"], (480, 640), held=6)
    with serve_landmarks(landmark_task([folder]), tmp_path / "landmarks.json") as server:
        page = visit.blank(server.address, size=(1100, 760))
        opened(page, "IMG_1.tif")
        click(page, seen_dots(page)[0])
        saved(page)
    found = read_landmarks(tmp_path / "landmarks.json").photographs["neutral"]["IMG_1.tif"]
    assert np.abs(np.array(found[NAMES[0]]) - PLACES["IMG_3.jpg"][0]).max() < 0.5


def test_a_photograph_that_cannot_be_read_is_named(
    visit: Visit, photographs: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "pose"
    folder.mkdir()
    (folder / "broken.jpg").write_bytes(b"\xff\xd8\xff nothing more")
    (folder / "whole.jpg").write_bytes((photographs / "IMG_1.jpg").read_bytes())
    with serve_landmarks(landmark_task([folder]), tmp_path / "landmarks.json") as server:
        page = visit.blank(server.address, size=(1100, 760))
        page.get_by_role("alert").get_by_text("broken.jpg is no photograph").wait_for()
        page.keyboard.press("Escape")
        page.keyboard.press("]")
        opened(page, "whole.jpg")
        assert len(seen_dots(page)) == len(NAMES)


def test_no_more_is_asked_for_than_is_missing(
    visit: Visit, photographs: Path, tmp_path: Path
) -> None:
    """A point that three photographs have is not asked for in a fourth, but may be placed there."""
    folder = tmp_path / "four"
    folder.mkdir()
    for number in (1, 2, 3, 4):
        content = (photographs / "IMG_1.jpg").read_bytes()
        (folder / f"IMG_{number}.jpg").write_bytes(content)
    most = dict.fromkeys(NAMES[:-1], (9.0, 9.0))
    three = {f"IMG_{number}.jpg": most for number in (1, 2, 3)}
    known = Landmarks(photographs={"four": three})
    with serve_landmarks(landmark_task([folder], known=known), tmp_path / "l.json") as server:
        page = visit.blank(server.address, size=(1100, 760))
        opened(page, "IMG_1.jpg")
        assert active(page) == NAMES[-1]
        page.locator(".tile", has_text="IMG_4.jpg").click()
        opened(page, "IMG_4.jpg")
        assert active(page) == NAMES[-1]
        click(page, seen_dots(page)[0])
        assert active(page) is None
        page.get_by_text("Nothing more is asked for").wait_for()
        page.locator(f".point[data-name={NAMES[3]}]").click()
        click(page, seen_dots(page)[3])
        saved(page)
    found = read_landmarks(tmp_path / "l.json").photographs["four"]["IMG_4.jpg"]
    assert list(found) == [NAMES[-1], NAMES[3]]
