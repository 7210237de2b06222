"""Methods in the viewer: chosen, seen beside the present ones, measured, saved and taken back."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from faces import Faces, distances
from serving import serving, write_folder
from test_looks import LAYOUT, needs_axe, violations
from visiting import COARSE, SMALL, Visit, positions, settled, state, update, wait

import elastomorph as em
from elastomorph.viewer import ViewerServer
from small_head import head

if TYPE_CHECKING:
    from playwright.sync_api import Page

COMMENTED = '# as on set\n[methods]\neyeBlink_L = "arc"  # for now\n'


@pytest.fixture(scope="module")
def meshes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_folder(tmp_path_factory.mktemp("rigs") / "Ada")


@pytest.fixture
def folder(meshes: Path, tmp_path: Path) -> Path:
    place = Path(shutil.copytree(meshes, tmp_path / "Ada"))
    (place / "elastomorph.toml").write_text(COMMENTED)
    return place


@pytest.fixture
def server(folder: Path) -> Iterator[ViewerServer]:
    with serving(folder) as started:
        yield started


def opened(page: Page) -> Page:
    """The tab of methods, with its table."""
    page.get_by_role("tab", name="Methods").click()
    page.get_by_role("columnheader", name="Target").wait_for()
    return page


def choose(page: Page, target: str, method: str) -> None:
    page.get_by_role("button", name=target, exact=True).click()
    page.get_by_label("Method", exact=True).select_option(method)
    wait(page, f"elastomorph.models().some(({{name}}) => name === '{target}: {method}')")


def test_a_method_beside_the_present_one(
    visit: Visit, server: ViewerServer, folder: Path, keep: Callable[[Page, str], None]
) -> None:
    page = opened(visit(server.address, **COARSE))
    assert page.get_by_role("row", name="eyeBlink_L").inner_text().split()[:2] == [
        "eyeBlink_L",
        "arc",
    ]
    choose(page, "jawOpen", "beam:2")
    now = state(page)
    assert now["methods"] == {"jawOpen": "beam:2"}
    assert (now["weights"], now["t"]) == ({"jawOpen": 1}, 0.5)
    assert (now["arrangement"], now["shown"]) == ("side", [0, 1])
    rig = em.read_rig(folder)
    truth = em.interpolate(rig.neutral, rig["jawOpen"].target, "beam:2").at(0.5)
    found = positions(page, 1, len(truth))
    assert distances(found, truth).max() < 1e-4 * rig.neutral.diameter
    figures = page.locator(".figures-table")
    words = figures.inner_text().replace("\xa0", " ")
    assert "Chosen" in words
    chosen = figures.get_by_role("row", name="Extra targets").inner_text().split()[-1]
    costs = page.locator("[data-target=jawOpen] td").all_inner_texts()
    assert costs[:2] == ["→ beam:2", chosen], "the list says what the chosen path costs"
    assert "% of D" in words
    page.get_by_label("The straight line beside it").check()
    wait(page, "elastomorph.models().length === 3")
    straight = em.interpolate(rig.neutral, rig["jawOpen"].target, "linear").at(0.5)
    assert distances(positions(page, 2, len(truth)), straight).max() < 1e-4 * rig.neutral.diameter
    settled(page)
    keep(page, "methods-beside")
    assert (folder / "elastomorph.toml").read_text() == COMMENTED


def test_saved_as_every_verb_reads_it(visit: Visit, server: ViewerServer, folder: Path) -> None:
    """Comments stay; the face shows the new path, after a reload too."""
    page = opened(visit(server.address, **COARSE))
    choose(page, "eyeBlink_L", "beam:2")
    choose(page, "jawOpen", "ease:2")
    page.get_by_role("button", name="Save all 2").click()
    page.get_by_text("Written to").wait_for()
    text = (folder / "elastomorph.toml").read_text()
    assert 'eyeBlink_L = "beam:2"  # for now\n' in text
    assert 'jawOpen = "ease:2"\n' in text
    assert text.startswith("# as on set\n[methods]\n")
    assert state(page)["methods"] == {}
    assert page.evaluate("elastomorph.models().length") == 1
    rig = em.read_rig(folder)  # without settings: the shapes
    truth = em.interpolate(rig.neutral, rig["eyeBlink_L"].target, "beam:2").at(0.5)
    for reload in (False, True):
        if reload:
            page.reload()
            page.evaluate("elastomorph.ready")
        update(page, weights={"eyeBlink_L": 1}, t=0.5)
        found = positions(page, 0, len(truth))
        assert distances(found, truth).max() < 1e-4 * rig.neutral.diameter
    assert "beam" in opened(page).get_by_role("row", name="eyeBlink_L").inner_text()


def test_choices_are_undone_and_taken_back(visit: Visit, server: ViewerServer) -> None:
    page = opened(visit(server.address, size=SMALL, **COARSE))
    choose(page, "jawOpen", "arc")
    page.locator(".picture").focus()
    page.keyboard.press("Control+z")
    wait(page, "elastomorph.models().length === 1")
    assert state(page)["methods"] == {}
    page.keyboard.press("Control+Shift+z")
    wait(page, "elastomorph.models().length === 2")
    assert state(page)["methods"] == {"jawOpen": "arc"}
    page.get_by_role("button", name="Take back").click()
    wait(page, "elastomorph.models().length === 1")
    assert state(page)["methods"] == {}


def test_a_method_of_ones_own_words(visit: Visit, server: ViewerServer) -> None:
    """By keys alone; one that does not exist is told, and nothing is chosen."""
    page = opened(visit(server.address, size=SMALL, **COARSE))
    page.get_by_role("button", name="jawOpen", exact=True).focus()
    page.keyboard.press("Enter")
    page.get_by_label("Method", exact=True).select_option("other")
    field = page.get_by_label("Another method")
    field.fill("beam:3:rest")
    field.press("Enter")
    wait(page, "elastomorph.models().length === 2")
    assert state(page)["methods"] == {"jawOpen": "beam:3:rest"}
    field.fill("bend")
    field.press("Enter")
    page.get_by_role("alert").get_by_text("method must be one of linear").wait_for()
    wait(page, "Object.keys(elastomorph.state().methods).length === 0")
    assert page.evaluate("elastomorph.models().length") in (1, 2)


def test_the_last_choice_counts(visit: Visit, server: ViewerServer) -> None:
    """What is under way for the one before is given up."""
    page = opened(visit(server.address, size=SMALL, **COARSE))
    page.get_by_role("button", name="jawOpen", exact=True).click()
    for method in ("rotation", "plate:2", "arc", "linear"):
        page.get_by_label("Method", exact=True).select_option(method)
    wait(page, "elastomorph.models().some(({name}) => name === 'jawOpen: straight line')")
    settled(page)
    assert page.evaluate("elastomorph.models().length") == 2


def test_changed_meanwhile_by_an_editor(visit: Visit, server: ViewerServer, folder: Path) -> None:
    page = opened(visit(server.address, size=SMALL, **COARSE))
    choose(page, "eyeBlink_L", "rotation")
    theirs = COMMENTED.replace('"arc"', '"linear"')
    (folder / "elastomorph.toml").write_text(theirs)
    page.get_by_role("button", name="Save").click()
    page.get_by_role("alert").get_by_text("it now says 'linear'").wait_for()
    assert (folder / "elastomorph.toml").read_text() == theirs
    assert state(page)["methods"] == {"eyeBlink_L": "rotation"}
    (folder / "elastomorph.toml").write_text(COMMENTED)
    page.get_by_role("button", name="Save").click()
    page.get_by_text("Written to").wait_for()


def test_a_command_that_has_ended(visit: Visit, folder: Path) -> None:
    with serving(folder) as server:
        visit.forgiven = "Failed to load resource"
        page = opened(visit(server.address, size=SMALL, **COARSE))
    page.get_by_role("button", name="jawOpen", exact=True).click()
    page.get_by_label("Method", exact=True).select_option("arc")
    page.get_by_role("alert").get_by_text("has ended").wait_for()
    assert state(page)["methods"] == {}


def test_a_page_alone_says_which_command(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, size=SMALL)
    page.get_by_role("tab", name="Methods").click()
    page.get_by_text("Methods are chosen where the command line").wait_for()


def test_a_file_by_itself_is_compared_and_not_saved(
    visit: Visit, meshes: Path, tmp_path: Path
) -> None:
    file = tmp_path / "Ada.glb"
    em.write(file, em.read_rig(meshes))
    with serving(file) as server:
        page = opened(visit(server.address, size=SMALL, **COARSE))
        choose(page, "jawOpen", "arc")
        assert page.get_by_role("button", name="Save").is_disabled()
        page.get_by_text("elastomorph init FOLDER").wait_for()


def test_by_touch(visit: Visit, server: ViewerServer) -> None:
    """Rows are as high as a fingertip."""
    page = visit(server.address, size=(390, 800), has_touch=True, is_mobile=True, **COARSE)
    page.get_by_role("tab", name="Methods").tap()
    row = page.get_by_role("button", name="jawOpen", exact=True)
    row.tap()
    box = row.bounding_box()
    assert box is not None
    assert box["height"] >= 44
    page.get_by_label("Method", exact=True).select_option("arc")
    wait(page, "elastomorph.models().length === 2")


@needs_axe
@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("size", [(1440, 900), (900, 700), (390, 800)])
def test_everybody_can_use_it(
    visit: Visit,
    server: ViewerServer,
    size: tuple[int, int],
    theme: str,
    keep: Callable[[Page, str], None],
) -> None:
    page = opened(visit(server.address, size=size, color_scheme=theme, **COARSE))
    choose(page, "jawOpen", "rotation")
    settled(page)
    assert violations(page) == []
    assert page.evaluate(LAYOUT) == []
    keep(page, f"methods-{size[0]}-{theme}")
    assert np.isfinite(positions(page, 0, len(head().vertices))).all()
