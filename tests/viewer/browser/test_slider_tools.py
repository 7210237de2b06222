"""What is done to many sliders at once, and which of them are shown."""

from __future__ import annotations

from typing import TYPE_CHECKING

from faces import Faces
from test_sliders import assert_posed, slider
from visiting import COARSE, PHONE, Visit, settled, state, update

import elastomorph as em
from elastomorph.rig import Rig
from elastomorph.viewer import rig_scene
from small_head import shapes

if TYPE_CHECKING:
    from playwright.sync_api import Page

SIDES = {"mouthSmile_L": 0.7, "eyeBlink_L": 0.2, "eyeBlink_R": 0.5, "jawOpen": 0.3}
SWAPPED = {"mouthSmile_R": 0.7, "eyeBlink_R": 0.2, "eyeBlink_L": 0.5, "jawOpen": 0.3}


def random(page: Page) -> dict[str, float]:
    page.get_by_role("button", name="Random").click()
    found: dict[str, float] = state(page)["weights"]
    return found


def visible(page: Page) -> list[str]:
    settled(page)
    rows = page.locator(".slider:visible").all()
    return [row.get_attribute("data-slider") or "" for row in rows]


def test_left_and_right_are_swapped(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **COARSE)
    update(page, weights=SIDES)
    settled(page)
    page.get_by_role("button", name="Swap left and right").click()
    assert state(page)["weights"] == SWAPPED
    assert_posed(page, faces)
    page.keyboard.press("x")
    assert state(page)["weights"] == SIDES
    page.keyboard.press("Control+z")
    assert state(page)["weights"] == SWAPPED


def test_a_way_to_one_side_becomes_that_to_the_other(visit: Visit, faces: Faces) -> None:
    """Though the two do not move together: a jaw cannot go both ways."""
    targets = {name: shapes()[name] for name in ("jawLeft", "jawRight")}
    to = em.prepare(faces.neutral, "linear")
    rig = Rig(faces.neutral, {name: to(target) for name, target in targets.items()})
    page = visit(rig_scene(rig, name="jaw", title="A jaw"), **COARSE)
    slider(page, "jawLeft").press("End")
    page.keyboard.press("m")
    slider(page, "jawLeft").press("ArrowLeft")
    page.keyboard.press("x")
    assert state(page)["weights"] == {"jawRight": 0.99}


def test_a_face_by_lot(visit: Visit, faces: Faces) -> None:
    """Within the limits of the sliders, another one each time, and undone to the last digit."""
    page = visit(faces.alone, **COARSE)
    drawn = [random(page) for _ in range(4)]
    for one in drawn:
        assert 2 < len(one) <= 6
        assert all(0 < weight <= 1 for weight in one.values())
    assert len({str(one) for one in drawn}) == 4
    for expected in (drawn[2], drawn[1], drawn[0], {}):
        page.keyboard.press("Control+z")
        assert state(page)["weights"] == expected
    for expected in drawn:
        page.keyboard.press("Control+y")
        assert state(page)["weights"] == expected
    page.get_by_role("checkbox", name="Beyond 1").check()
    beyond = [random(page) for _ in range(6)]
    amounts = [weight for one in beyond for weight in one.values()]
    assert -0.5 <= min(amounts) < 0
    assert 1 < max(amounts) <= 1.5


def test_pairs_are_drawn_together(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **COARSE)
    page.get_by_role("switch", name="Mirror").check()
    pairs = 0
    for _ in range(5):
        drawn = random(page)
        for stem in ("mouthSmile", "eyeBlink"):
            assert drawn.get(f"{stem}_L") == drawn.get(f"{stem}_R")
            pairs += f"{stem}_L" in drawn
    assert pairs > 0


def test_only_what_is_shown_is_drawn(visit: Visit, faces: Faces) -> None:
    """Neither what the search leaves out nor what is folded away."""
    page = visit(faces.alone, **COARSE)
    update(page, weights={"jawOpen": 0.25})
    page.get_by_role("searchbox", name="Search sliders").fill("smile")
    settled(page)
    drawn = random(page)
    assert set(drawn) == {"jawOpen", "mouthSmile_L", "mouthSmile_R"}
    assert drawn["jawOpen"] == 0.25
    page.get_by_role("searchbox", name="Search sliders").fill("")
    update(page, weights={}, folded=["Mouth", "Brows", "Other", "Lids"])
    settled(page)
    assert set(random(page)) == {"jawOpen"}


def test_a_group_back_to_zero(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **COARSE)
    update(page, weights=SIDES)
    settled(page)
    page.get_by_role("button", name="Lids: all to 0").click()
    assert state(page)["weights"] == {"mouthSmile_L": 0.7, "jawOpen": 0.3}
    page.keyboard.press("Control+z")
    assert state(page)["weights"] == SIDES


def test_folded_groups_are_undone_and_open_for_a_search(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **COARSE)
    page.get_by_role("button", name="Lids", exact=True).click()
    assert state(page)["folded"] == ["Lids"]
    assert "eyeBlink_L" not in visible(page)
    page.get_by_role("searchbox", name="Search sliders").fill("blink")
    assert visible(page) == ["eyeBlink_L", "eyeBlink_R"]
    page.keyboard.press("Escape")
    assert "eyeBlink_L" not in visible(page)
    page.locator(".picture").focus()
    page.keyboard.press("Control+z")
    assert "eyeBlink_L" in visible(page)


def test_favourites(visit: Visit, faces: Faces) -> None:
    """Starred by the mouse and by a key, and shown alone."""
    page = visit(faces.alone, **COARSE)
    only = page.get_by_role("button", name="Favourites only")
    only.click()
    assert visible(page) == []
    assert page.get_by_text("No slider is a favourite: its star makes it one.").is_visible()
    only.click()
    page.locator("[data-slider=jawOpen]").hover()
    page.get_by_role("button", name="jawOpen, favourite").click()
    slider(page, "mouthSmile_R").press("s")
    assert state(page)["favourites"] == ["jawOpen", "mouthSmile_R"]
    only.click()
    page.locator(".picture").focus()
    assert visible(page) == ["jawOpen", "mouthSmile_R"]
    page.keyboard.press("Control+z")
    assert visible(page) == ["jawOpen"]


def test_by_touch(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, size=PHONE, has_touch=True, is_mobile=True, **COARSE)
    page.get_by_role("button", name="jawOpen, favourite").tap()
    assert state(page)["favourites"] == ["jawOpen"]
    update(page, weights=SIDES)
    settled(page)
    page.get_by_role("button", name="Swap left and right").tap()
    assert state(page)["weights"] == SWAPPED
