"""Sliders under real keys and a real mouse."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from faces import Faces, distances
from visiting import COARSE, Visit, positions, settled, state, update

import elastomorph as em
from elastomorph.viewer.rig_scenes import rig_scene
from small_meshes import grid

if TYPE_CHECKING:
    from playwright.sync_api import Locator, Page

WITHIN = 1e-4  # of D


def slider(page: Page, name: str) -> Locator:
    return page.get_by_role("slider", name=name, exact=True)


def assert_posed(page: Page, faces: Faces) -> None:
    """The vertices are where `Rig.pose` puts them under the weights of the state."""
    rig, now = faces.rigs["beam:2"], state(page)
    weights = {name: now["t"] * weight for name, weight in now["weights"].items()}
    found = positions(page, 0, len(rig.neutral.vertices))
    assert distances(found, rig.pose(weights)).max() < WITHIN * faces.diameter


def test_by_keys(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **COARSE)
    slider(page, "jawOpen").focus()
    for _ in range(7):
        page.keyboard.press("ArrowRight")
    assert state(page)["weights"] == {"jawOpen": pytest.approx(0.07)}
    assert_posed(page, faces)
    page.keyboard.press("End")
    page.keyboard.press("ArrowLeft")
    assert state(page)["weights"] == {"jawOpen": pytest.approx(0.99)}
    assert_posed(page, faces)
    page.keyboard.press("Home")
    assert state(page)["weights"] == {}
    assert_posed(page, faces)


def test_by_the_mouse(visit: Visit, faces: Faces) -> None:
    """Several sliders are dragged one after another, and all of them count."""
    page = visit(faces.alone, **COARSE)
    for name, share in (("jawOpen", 0.7), ("mouthSmile_L", 0.4), ("eyeBlink_L", 0.9)):
        slider(page, name).scroll_into_view_if_needed()
        box = slider(page, name).bounding_box()
        assert box is not None
        middle = box["y"] + box["height"] / 2
        knob = 6
        page.mouse.move(box["x"] + knob, middle)
        page.mouse.down()
        page.mouse.move(box["x"] + 0.5 * box["width"], middle, steps=3)
        page.mouse.move(box["x"] + knob + share * (box["width"] - 2 * knob), middle, steps=3)
        page.mouse.up()
        assert state(page)["weights"][name] == pytest.approx(share, abs=0.05)
    assert len(state(page)["weights"]) == 3
    assert_posed(page, faces)


def test_by_numbers_beyond_one(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **COARSE)
    page.get_by_role("checkbox", name="Beyond 1").check()
    for name, weight in (("jawOpen", "1.35"), ("mouthFunnel", "-0.4")):
        page.get_by_role("spinbutton", name=f"{name}, value").fill(weight)
    settled(page)
    assert state(page)["weights"] == {"jawOpen": 1.35, "mouthFunnel": -0.4}
    assert slider(page, "jawOpen").input_value() == "1.35"
    assert_posed(page, faces)
    page.get_by_role("checkbox", name="Beyond 1").uncheck()
    assert state(page)["weights"] == {"jawOpen": 1}, "sliders must not hold what they cannot show"


def test_between_zero_and_one_by_numbers(visit: Visit, faces: Faces) -> None:
    """Without leave to go beyond, a number is brought back to the end of the slider."""
    page = visit(faces.alone, **COARSE)
    page.get_by_role("spinbutton", name="jawOpen, value").fill("3")
    assert state(page)["weights"] == {"jawOpen": 1}


def test_master_t_by_keys(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **COARSE)
    update(page, weights={"jawOpen": 0.8, "mouthSmile_L": 0.5}, t=1)
    time = page.get_by_role("slider", name="Master time t")
    time.focus()
    page.keyboard.press("Home")
    for _ in range(9):
        page.keyboard.press("PageUp")
    now = state(page)["t"]
    assert 0.2 < now < 1
    assert_posed(page, faces)


def test_search(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **COARSE)
    search = page.get_by_role("searchbox", name="Search sliders")
    search.fill("smile r")
    assert _visible(page) == ["mouthSmile_R"]
    search.fill("SMILE")
    assert _visible(page) == ["mouthSmile_L", "mouthSmile_R"]
    search.fill("nose")
    assert _visible(page) == []
    assert page.get_by_text("No slider is called “nose”.").is_visible()
    search.press("Escape")
    assert len(_visible(page)) == len(faces.rigs["beam:2"].names)


def test_only_the_active_ones(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **COARSE)
    update(page, weights={"jawOpen": 0.2, "eyeBlink_R": 0.1})
    page.get_by_role("checkbox", name="Active only").check()
    assert sorted(_visible(page)) == ["eyeBlink_R", "jawOpen"]


def test_groups(visit: Visit, faces: Faces) -> None:
    """Those of the file come first, then parts of the face; each opens and closes."""
    page = visit(faces.alone, **COARSE)
    headings = page.locator(".group h2").all_inner_texts()
    names = [heading.split("\n")[0].strip() for heading in headings]
    assert names == ["Lids", "Brows", "Jaw", "Mouth", "Other", "Correctives"]
    lids = page.get_by_role("button", name="Lids")
    assert lids.get_attribute("aria-expanded") == "true"
    lids.focus()
    page.keyboard.press("Enter")
    settled(page)
    assert lids.get_attribute("aria-expanded") == "false"
    assert not slider(page, "eyeBlink_L").is_visible()
    assert slider(page, "jawOpen").is_visible()
    lids.click()
    settled(page)
    assert slider(page, "eyeBlink_L").is_visible()


def test_mirror(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **COARSE)
    page.get_by_role("switch", name="Mirror").check()
    slider(page, "mouthSmile_L").focus()
    for _ in range(3):
        page.keyboard.press("ArrowRight")
    slider(page, "jawOpen").press("ArrowRight")
    assert state(page)["weights"] == pytest.approx(
        {"mouthSmile_L": 0.03, "mouthSmile_R": 0.03, "jawOpen": 0.01}
    )
    page.get_by_role("switch", name="Mirror").uncheck()
    slider(page, "mouthSmile_R").press("Home")
    assert "mouthSmile_L" in state(page)["weights"]
    assert "mouthSmile_R" not in state(page)["weights"]


def test_back_to_zero(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **COARSE)
    update(page, weights={"jawOpen": 0.2, "eyeBlink_R": 0.1})
    page.get_by_role("button", name="jawOpen to 0").click()
    assert state(page)["weights"] == {"eyeBlink_R": 0.1}
    page.get_by_role("button", name="Reset all").click()
    assert state(page)["weights"] == {}
    assert_posed(page, faces)
    settled(page)
    assert page.get_by_role("button", name="Reset all").is_disabled()
    assert slider(page, "eyeBlink_R").input_value() == "0"


def test_a_slider_wakes_a_face_at_rest(visit: Visit, faces: Faces) -> None:
    """At t = 0 nothing would move: whoever moves a slider wants to see it move."""
    page = visit(faces.alone, **COARSE)
    update(page, t=0)
    slider(page, "jawOpen").press("End")
    assert state(page)["t"] == 1
    assert_posed(page, faces)


def _visible(page: Page) -> list[str]:
    settled(page)
    rows = page.locator(".slider:visible")
    return [row.get_attribute("data-slider") or "" for row in rows.all()]


EVERY_OBJECT_HAS = ("constructor", "toString", "__proto__", "hasOwnProperty", "valueOf")


def test_names_that_every_object_has(visit: Visit) -> None:
    """Sliders are called as their authors like, also as what JavaScript calls its own."""
    neutral = grid(6, 5)
    raised = {
        name: em.interpolate(neutral, neutral.with_vertices(neutral.vertices + [0, 0, h]), "beam:2")
        for h, name in enumerate((*EVERY_OBJECT_HAS, "smile"), start=1)
    }
    rig = em.Rig(neutral, raised)
    page = visit(rig_scene(rig, name="own", title="Own", unit="cm"), **COARSE)
    assert sorted(_visible(page)) == sorted(rig.names)
    for name in rig.names:
        assert slider(page, name).input_value() == "0"
    for number, name in enumerate(rig.names, start=1):
        page.get_by_role("spinbutton", name=f"{name}, value", exact=True).fill(f"0.{number}")
        settled(page)
        assert slider(page, name).input_value() == f"0.{number}"
    weights = {name: number / 10 for number, name in enumerate(rig.names, start=1)}
    found = positions(page, 0, len(neutral.vertices))
    assert distances(found, rig.pose(weights)).max() < WITHIN * neutral.diameter
    page.get_by_role("button", name="Reset all").click()
    settled(page)
    assert distances(positions(page, 0, len(neutral.vertices)), neutral.vertices).max() == 0


def test_a_comma_is_a_point(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **COARSE)
    number = page.get_by_role("spinbutton", name="jawOpen, value")
    number.focus()
    page.keyboard.press("Control+A")
    page.keyboard.type("0,5")
    settled(page)
    assert state(page)["weights"] == {"jawOpen": 0.5}
    assert slider(page, "jawOpen").input_value() == "0.5"


def test_the_thumb_goes_back_with_the_face(visit: Visit, faces: Faces) -> None:
    """Where something else holds the weight, the thumb does not stay where it was let go."""
    page = visit(faces.alone, **COARSE)
    update(page, weights={"jawOpen": 0.5})
    settled(page)
    slider(page, "jawOpen").evaluate("range => { range.value = '0.9' }")  # as a browser restores it
    update(page, weights={"jawOpen": 0.5, "mouthSmile_L": 0.1})
    settled(page)
    assert slider(page, "jawOpen").input_value() == "0.5"
