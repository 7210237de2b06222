"""Two models beside each other, over each other, and coloured by how far they are apart."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from faces import Faces, distances
from pictures import differing, picture, skin
from visiting import HALVED, Visit, settled, state, update

if TYPE_CHECKING:
    from playwright.sync_api import Locator

GRAIN = 24  # of 255
HALF_WAY = {"weights": {"jawOpen": 1}, "t": 0.5}


def test_a_swipe_shows_one_left_and_the_other_right(visit: Visit, faces: Faces) -> None:
    """Pixel by pixel what each of them shows alone: one camera for both."""
    page = visit(faces.together)
    update(page, **HALF_WAY, arrangement="single", shown=[0])
    straight = picture(page)
    update(page, shown=[1])
    curved = picture(page)
    assert differing(straight, curved).sum() > 500, "the two look alike: nothing to tell apart"
    width = straight.shape[1]
    for share in (0.35, 0.5, 0.64):
        update(page, arrangement="swipe", shown=[0, 1], swipe=share)
        both = picture(page)
        split = round(share * width)
        assert not differing(both[:, : split - 1], straight[:, : split - 1]).any()
        assert not differing(both[:, split + 1 :], curved[:, split + 1 :]).any()


def test_the_handle_of_a_swipe(visit: Visit, faces: Faces) -> None:
    """Moved by keys and by the mouse, and the picture follows it."""
    page = visit(faces.together, **HALVED)
    page.get_by_role("tab", name="Compare").click()
    page.get_by_role("radio", name="Swipe").check(force=True)
    settled(page)
    handle = page.get_by_role("slider", name="Swipe between linear and beam:2")
    handle.focus()
    page.keyboard.press("ArrowRight")
    assert state(page)["swipe"] == pytest.approx(0.51)
    for _ in range(2):
        page.keyboard.press("PageDown")
    assert state(page)["swipe"] == pytest.approx(0.31)
    settled(page)
    assert handle.get_attribute("aria-valuenow") == "31"
    assert handle.get_attribute("aria-valuetext") == "31 % linear, 69 % beam:2"
    stage = page.locator(".picture").bounding_box()
    held = handle.bounding_box()
    assert stage is not None
    assert held is not None
    middle = held["x"] + held["width"] / 2
    assert middle == pytest.approx(stage["x"] + 0.31 * stage["width"], abs=1.5)
    page.mouse.move(middle, stage["y"] + stage["height"] / 2)
    page.mouse.down()
    page.mouse.move(stage["x"] + 0.7 * stage["width"], stage["y"] + 50, steps=4)
    page.mouse.up()
    assert state(page)["swipe"] == pytest.approx(0.7, abs=0.01)
    for key, end in (("Home", 0), ("End", 1)):
        handle.press(key)
        assert state(page)["swipe"] == end


def test_side_by_side_is_one_camera(visit: Visit, faces: Faces) -> None:
    """At t = 1, where all paths end alike, every part of the picture is the same."""
    page = visit(faces.together, size=(1284, 720))
    update(page, weights={"jawOpen": 1, "mouthSmile_L": 1}, arrangement="side", shown=[0, 1, 2])
    width = page.evaluate("document.querySelector('.picture').clientWidth")
    assert width % 3 == 0, "choose a window whose picture can be cut into three"
    parts = np.split(picture(page), 3, axis=1)
    assert skin(parts[0]).mean() > 0.1
    for other in parts[1:]:
        # The edges of shadows are grainy, and each part has its own grains.
        assert differing(parts[0], other, GRAIN).mean() < 1e-3
    update(page, t=0.5)
    straight, curved, _ = np.split(picture(page), 3, axis=1)
    assert differing(straight, curved).sum() > 300
    page.locator(".picture").focus()
    before = picture(page)
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    update(page, t=1)
    turned = np.split(picture(page), 3, axis=1)
    assert differing(before, np.concatenate(turned, axis=1)).mean() > 0.05
    assert differing(turned[0], turned[1], GRAIN).mean() < 1e-3


def test_models_are_chosen_by_name(visit: Visit, faces: Faces) -> None:
    """Left, middle and right are chosen; a model that is seen already changes places."""
    page = visit(faces.together, **HALVED)
    page.get_by_role("tab", name="Compare").click()
    page.get_by_role("button", name="Remove Middle").click()
    assert state(page)["shown"] == [0, 2]
    settled(page)
    page.get_by_role("combobox", name="Model shown left").select_option("rotation")
    assert state(page)["shown"] == [2, 0]
    settled(page)
    page.get_by_role("button", name="Add a third").click()
    assert state(page)["shown"] == [2, 0, 1]
    settled(page)
    assert page.locator(".model-name").all_inner_texts() == ["rotation", "linear", "beam:2"]


def test_the_heat_map_is_measured_right(visit: Visit, faces: Faces) -> None:
    """Largest and mean distance and the worst vertex are those of the rigs in double precision."""
    page = visit(faces.together, **HALVED)
    update(page, **HALF_WAY, arrangement="side", shown=[0, 1], against=1, heat=True)
    found = page.evaluate("elastomorph.readout()")["heat"]
    one, other = (faces.rigs[name].pose({"jawOpen": 0.5}) for name in ("linear", "beam:2"))
    apart = distances(one, other)
    within = 2e-4 * faces.diameter
    assert found["model"] == 0
    assert found["largest"] == pytest.approx(apart.max(), abs=within)
    assert found["mean"] == pytest.approx(apart.mean(), abs=within)
    assert apart[found["worstVertex"]] == pytest.approx(apart.max(), abs=within)
    assert found["top"] >= found["largest"]


def test_the_heat_map_is_seen_and_explained(visit: Visit, faces: Faces) -> None:
    page = visit(faces.together)
    update(page, **HALF_WAY, arrangement="single", shown=[1], against=1)
    standard = picture(page)
    update(page, shown=[0])
    plain = picture(page)
    page.keyboard.press("h")
    assert state(page)["heat"]
    coloured = picture(page)
    assert differing(plain, coloured)[skin(plain)].mean() > 0.9
    update(page, shown=[1])
    assert not differing(standard, picture(page)).any(), "what is measured from keeps its colours"
    update(page, shown=[0])
    legend = page.get_by_role("group", name="Scale of the heat map")
    heat = page.evaluate("elastomorph.readout()")["heat"]
    words = _words(legend, f"vertex {heat['worstVertex']}")
    assert "Distance from beam:2" in words
    assert "cm" in words
    assert "% of D" in words
    share = 100 * heat["largest"] / faces.diameter
    assert f"Worst {heat['largest']:.3g} cm ({share:.2g} % of D)" in words
    last = legend.locator(".ticks").first.locator("span").last
    assert float(last.inner_text()) == pytest.approx(heat["top"], rel=1e-3)


def test_equal_faces_have_no_distance(visit: Visit, faces: Faces) -> None:
    page = visit(faces.together, **HALVED)
    update(page, weights={"jawOpen": 1}, t=1, shown=[0, 1], against=1, heat=True)
    legend = page.get_by_role("group", name="Scale of the heat map")
    legend.get_by_text("No distance at t = 1: paths meet").wait_for()


def test_a_fixed_scale_keeps_its_last_colour(visit: Visit, faces: Faces) -> None:
    page = visit(faces.together, **HALVED)
    update(page, **HALF_WAY, shown=[0, 1], against=1, heat=True)
    page.get_by_role("tab", name="Compare").click()
    page.get_by_role("switch", name="Fixed scale").check()
    settled(page)
    page.get_by_role("spinbutton", name="Last colour, % of D").fill("8")
    page.keyboard.press("Enter")
    assert state(page)["heatTop"] == pytest.approx(0.08)
    for t in (0.5, 0.2):
        update(page, t=t)
        heat = page.evaluate("elastomorph.readout()")["heat"]
        assert heat["top"] == pytest.approx(0.08 * faces.diameter, rel=1e-4)


def test_ghost_and_inbetweens_are_drawn(visit: Visit, faces: Faces) -> None:
    """The neutral shows where the face has left it; each in-between adds to the picture."""
    page = visit(faces.alone)
    update(page, weights={"jawOpen": 1}, t=1)
    plain = picture(page)
    page.keyboard.press("g")
    haunted = picture(page)
    assert differing(plain, haunted).sum() > 200
    update(page, weights={})
    update(page, ghost=False)
    rest = picture(page)
    update(page, ghost=True)
    # Nothing has moved: the ghost lies within the face.
    assert differing(rest, picture(page), 40).mean() < 0.02
    update(page, weights={"jawOpen": 1}, ghost=False)
    page.get_by_role("tab", name="Compare").click()
    page.get_by_role("slider", name="In-betweens").press("End")
    assert state(page)["onion"] == 9
    assert differing(plain, picture(page)).sum() > 200


def _words(legend: Locator, last: str) -> str:
    """What the legend says, once it says the last of what it is waited for."""
    # Figures are written at most five times a second, so that they can be read.
    legend.get_by_text(last).wait_for()
    return legend.inner_text().replace("\n", " ")
