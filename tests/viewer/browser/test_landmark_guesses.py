"""Cameras that are known say where a point is in the other photographs, and how far off it is."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from numpy.typing import NDArray
from placing import NAMES, active, click, opened, saved, seen_dots, write_photograph
from visiting import Visit

from elastomorph.capturing.geometry import Camera
from elastomorph.capturing.landmarks import read_landmarks, triangulated
from elastomorph.viewer import ViewerServer
from elastomorph.viewer.landmarks import landmark_task, serve_landmarks

if TYPE_CHECKING:
    from playwright.sync_api import Page

SIZE = (640, 480)
FILES = ("IMG_1.jpg", "IMG_2.jpg", "IMG_3.jpg")


def camera(name: str, turn: float) -> Camera:
    """One on a circle of 40 about the origin, with a lens that bends lines."""
    c, s = np.cos(turn), np.sin(turn)
    rotation = np.array([[c, 0, -s], [0, -1, 0], [-s, 0, -c]])
    return Camera(
        name, SIZE, 700.0, np.array([322.5, 238.0]), -0.25, rotation, np.array([0, 0, 40.0])
    )


CAMERAS = [camera(name, turn) for name, turn in zip(FILES, (-0.4, 0.0, 0.5), strict=True)]
POINTS = np.array([[2.0, 3.0, 4.0], [-4.0, -1.0, 2.0]])


def seen(index: int) -> NDArray[np.float64]:
    own = CAMERAS[index]
    return own.distorted(own.project(POINTS)[0])


@pytest.fixture
def server(tmp_path: Path) -> Iterator[ViewerServer]:
    folder = tmp_path / "neutral"
    folder.mkdir()
    for index, name in enumerate(FILES):
        write_photograph(folder / name, seen(index))
    task = landmark_task([folder], cameras={"neutral": CAMERAS})
    with serve_landmarks(task, tmp_path / "landmarks.json") as started:
        yield started


def clicked(tmp_path: Path) -> dict[str, dict[str, tuple[float, float]]]:
    found = read_landmarks(tmp_path / "landmarks.json").photographs["neutral"]
    return {name: dict(places) for name, places in found.items()}


def at(page: Page, point: int, index: int) -> NDArray[np.float64]:
    """Where the dot of a point is on the page."""
    found = seen_dots(page)
    return found[np.argsort(np.argsort(seen(index)[:, 1]))[point]]


def residual(page: Page, name: str) -> str:
    return page.locator(f".point[data-name={name}] .residual").inner_text()


def test_two_photographs_say_where_it_is_in_the_third(
    visit: Visit, server: ViewerServer, tmp_path: Path
) -> None:
    page = visit.blank(server.address, size=(1100, 760))
    for index in (0, 1):
        opened(page, FILES[index])
        for point in (0, 1):
            assert active(page) == NAMES[point]
            click(page, at(page, point, index))
        assert residual(page, NAMES[0]) == ("" if index == 0 else residual(page, NAMES[0]))
        page.keyboard.press("]")
    assert float(residual(page, NAMES[0]).removesuffix(" px") or 0) < 1
    opened(page, FILES[2])
    page.keyboard.press("g")
    page.keyboard.press("g")
    saved(page)
    found = np.array(list(clicked(tmp_path)[FILES[2]].values()))
    assert np.abs(found - seen(2)).max() < 1
    points, residuals = triangulated(clicked(tmp_path), {own.name: own for own in CAMERAS})
    assert np.abs(np.array([points[name] for name in NAMES[:2]]) - POINTS).max() < 0.05
    # The same distance, root mean square of three photographs, as Python has it.
    own = []
    for _ in FILES:
        own.append(float(residual(page, NAMES[0]).removesuffix(" px")))
        page.keyboard.press("]")
        page.wait_for_timeout(50)
    assert np.sqrt(np.mean(np.square(own))) == pytest.approx(residuals[NAMES[0]], abs=0.08)


def test_one_photograph_says_on_which_line_it_is(
    visit: Visit, server: ViewerServer, tmp_path: Path
) -> None:
    """The line of sight, drawn in blue, runs through the dot in the other photograph."""
    page = visit.blank(server.address, size=(1100, 760))
    opened(page, FILES[0])
    click(page, at(page, 0, 0))
    page.keyboard.press("]")
    opened(page, FILES[1])
    page.locator(f".point[data-name={NAMES[0]}]").click()
    dot = at(page, 0, 1)
    box = page.locator(".picture").bounding_box()
    assert box is not None
    blue = page.evaluate(
        """([x, y]) => {
            const canvas = document.querySelector('canvas.over');
            const around = canvas.getContext('2d').getImageData(x - 12, y - 12, 25, 25).data;
            const found = [];
            for (let i = 0; i < around.length; i += 4)
                if (around[i] < 130 && around[i + 1] > 180 && around[i + 2] > 210)
                    found.push(Math.hypot((i / 4) % 25 - 12, Math.floor(i / 100) - 12));
            return found;
        }""",
        [round(float(dot[0] - box["x"] - 0.5)), round(float(dot[1] - box["y"] - 0.5))],
    )
    assert blue
    assert min(blue) < 1.5
    assert len(blue) < 120, "a line, not an area"
    page.keyboard.press("g")
    assert active(page) == NAMES[0], "a line is no place"


def test_a_point_far_off_is_told(visit: Visit, server: ViewerServer, tmp_path: Path) -> None:
    page = visit.blank(server.address, size=(1100, 760))
    for index in (0, 1, 2):
        opened(page, FILES[index])
        page.locator(f".point[data-name={NAMES[0]}]").click()
        click(page, at(page, 0, index) + (0, 40 if index == 2 else 0))
        if index < 2:
            page.keyboard.press("]")
    row = page.locator("li", has=page.locator(f".point[data-name={NAMES[0]}]"))
    assert row.get_attribute("data-off") == "true"
    assert float(residual(page, NAMES[0]).removesuffix(" px")) > 8
    page.locator(f".point[data-name={NAMES[0]}]").click()
    click(page, at(page, 0, 2))
    saved(page)
    assert row.get_attribute("data-off") == "false"
    assert np.abs(clicked(tmp_path)[FILES[2]][NAMES[0]] - seen(2)[0]).max() < 0.6
