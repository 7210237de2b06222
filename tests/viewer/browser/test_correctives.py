"""Correctives by every law and pair bends: posed, grabbed, played, listed and switched off."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from faces import distances, glb, twice
from takes import open_files
from test_grab import assert_solved, telling
from test_positions import rewritten
from test_takes_saved import SIZE, save
from visiting import COARSE, SMALL, Visit, positions, settled, state, update

import elastomorph as em
from elastomorph import Corrective
from elastomorph.io.performance import write_performance_csv
from elastomorph.rig import Rig
from elastomorph.rig.laws import LAWS
from elastomorph.rig.performance import Performance, slider_weights
from elastomorph.viewer import Scene, SceneModel
from elastomorph.viewer.file_scenes import read_scene
from foreign_files import write_foreign_glb
from small_head import head, shapes, straight

if TYPE_CHECKING:
    from pathlib import Path

    from playwright.sync_api import Page

WITHIN = 1e-4  # of D
PAIR = "jawOpen_mouthClose"
MOVED = ("cheekPuff", "noseSneer_L", "mouthLeft", "jawLeft", "tongueOut", "mouthPucker")
DRIVERS = ("mouthSmile_L", "jawOpen", "browInnerUp")
NUMBERS = {"softmin": (3.0,), "hinge": (0.9, 0.8, 0.5)}


@cache
def lawful() -> Rig:
    """Two targets that meet, a corrective for each law, and one that has a slider of its own."""
    neutral, found = head(), shapes()
    targets = {name: found[name] for name in (*DRIVERS, "mouthClose", "eyeSquint_L")}
    rig = Rig(neutral, targets)
    assert [*rig.pair_bends()] == [PAIR]
    morphs, driven = dict(rig.morphs), dict(rig.sliders.correctives)
    for i, law in enumerate(LAWS):
        moved = found[MOVED[i % len(MOVED)]].vertices - neutral.vertices
        shape = neutral.with_vertices(neutral.vertices + (0.5 - 0.1 * i) * moved)
        morphs[f"by {law}"] = em.interpolate(neutral, shape, "linear")
        driven[f"by {law}"] = Corrective(DRIVERS, law, NUMBERS.get(law, ()))
    driven["eyeSquint_L"] = Corrective(("mouthSmile_L", "eyeSquint_L"), "min")
    return Rig(neutral, morphs, correctives=driven)


def scene(content: bytes) -> Scene:
    return Scene((SceneModel("laws", "rig", content),), "Laws", "cm")


def off(page: Page, pose: np.ndarray) -> float:
    """How far the face is from a pose at most, fraction of D."""
    found = positions(page, 0, len(pose))
    return float(distances(found, pose).max()) / head().diameter


def without(rig: Rig, *names: str) -> Rig:
    """A rig as if some of its correctives had never been."""
    kept = {name: morph for name, morph in rig.morphs.items() if name not in names}
    laws = {name: own for name, own in rig.sliders.correctives.items() if name not in names}
    return Rig(rig.neutral, kept, correctives=laws)


POSES: dict[str, tuple[float, ...]] = {  # in the order of the sliders
    "rest": (0, 0, 0, 0, 0),
    "all": (0.7, 0.4, 0.9, 0.6, 0.8),
    "on the diagonal": (0.5, 0.5, 0.5, 0.5, 0.5),
    "at the ends": (1, 1, 1, 1, 1),
    "one of them at rest": (0.7, 0, 0.9, 0.6, 0.5),
    "beyond": (1.3, 1.1, 1.2, 1.4, 1.2),
    "below": (-0.3, 0.8, 0.7, -0.2, -0.4),
}


def test_poses_of_every_law(visit: Visit) -> None:
    rig = lawful()
    page = visit(scene(glb(rig)), size=SMALL)
    for name, weights in POSES.items():
        for t in (1.0, 0.6):
            given = dict(zip(rig.names, weights, strict=True))
            update(page, weights=given, t=t)
            expected = rig.pose({slider: t * weight for slider, weight in given.items()})
            assert off(page, expected) < WITHIN, name


def test_meshes_of_one_face_join_their_pair_bends(visit: Visit) -> None:
    """Each of two meshes describes the whole of it, in another order."""
    rig = lawful()

    page = visit(scene(rewritten(glb(rig), twice)), size=SMALL)
    pose = {"jawOpen": 0.8, "mouthClose": 0.7, "mouthSmile_L": 0.6}
    update(page, weights=pose, t=1)
    count = page.evaluate("elastomorph.models()[0].vertices") // 2
    found = positions(page, 0, 2 * count)
    expected = rig.pose(pose)
    for half in (found[: len(expected)], found[count:][: len(expected)]):
        assert distances(half, expected).max() < WITHIN * rig.neutral.diameter


def test_laws_of_an_older_version_are_products(visit: Visit) -> None:
    """Version 2 knows no laws: readers of then multiplied, and so does everybody now."""
    rig = without(lawful(), PAIR)

    def older(document: dict[str, Any]) -> None:
        document["meshes"][0]["extras"]["elastomorph"]["version"] = 2

    laws = {name: Corrective(own.drivers) for name, own in rig.sliders.correctives.items()}
    multiplied = Rig(rig.neutral, rig.morphs, correctives=laws)
    page = visit(scene(rewritten(glb(rig), older)), size=SMALL)
    pose = dict(zip(rig.names, POSES["all"], strict=True))
    update(page, weights=pose, t=1)
    assert off(page, multiplied.pose(pose)) < WITHIN
    assert off(page, rig.pose(pose)) > 10 * WITHIN


def test_a_take_plays_by_laws_and_is_saved_so(visit: Visit, tmp_path: Path) -> None:
    """Weights of targets in a file become sliders again, of a corrective by its law too."""
    rig = lawful()
    times = np.arange(13) / 12
    curves = [np.abs(np.sin((2 + k) * times + k)) for k in range(len(rig.names))]
    take = Performance(rig.names, times, np.column_stack(curves), 12.0)
    page = visit(scene(glb(rig, take)), size=SIZE)
    assert state(page)["clip"] == "a take"
    for frame in (0, 4, 9):
        update(page, clipTime=float(times[frame]))
        expected = rig.pose(dict(zip(rig.names, take.weights[frame], strict=True)))
        assert off(page, expected) < WITHIN
    write_performance_csv(tmp_path / "own.csv", take)
    open_files(page, tmp_path / "own.csv")
    back = em.read_performance(save(page, "Save GLB", tmp_path), clip="own")
    found, expected = slider_weights(rig, back), slider_weights(rig, take)
    for frame in range(len(times)):
        apart = distances(rig.pose(found[frame]), rig.pose(expected[frame]))
        assert apart.max() < WITHIN * rig.neutral.diameter


def test_a_character_of_others_has_its_pair_bends(visit: Visit, tmp_path: Path) -> None:
    """Its own file is shown, with what was made of its targets in it."""
    file = write_foreign_glb(tmp_path / "theirs.glb", straight("jawOpen", "mouthClose"))
    rig = em.read_rig(file)
    assert [*rig.pair_bends()] == [PAIR]
    page = visit(read_scene([str(file)]), size=SMALL)
    pose = {"jawOpen": 0.6, "mouthClose": 0.5}
    update(page, weights=pose, t=1)
    assert off(page, rig.pose(pose)) < WITHIN
    update(page, correctivesOff=[PAIR])
    assert off(page, without(rig, PAIR).pose(pose)) < WITHIN
    assert off(page, rig.pose(pose)) > 10 * WITHIN


@pytest.mark.slow
def test_solved_by_laws_as_python_does(visit: Visit) -> None:
    rig = lawful()
    page = visit(scene(glb(rig)), size=SMALL)
    goals = telling(rig, {"jawOpen": 0.7, "mouthClose": 0.5, "mouthSmile_L": 0.4}, 8)
    assert_solved(page, rig, goals, exact=False)
    left_out = [name for name in rig.sliders.correctives if name not in rig.names]
    update(page, correctivesOff=left_out)
    plain = without(rig, *left_out)
    assert_solved(page, plain, telling(plain, {"jawOpen": 0.7, "mouthClose": 0.5}, 8), exact=False)


def rows(page: Page) -> dict[str, str]:
    """Weights of the correctives as they stand in the list, in its order."""
    settled(page)
    found = page.locator(".corrective:visible")
    return {
        row.get_attribute("data-corrective") or "": row.locator(".weight").inner_text()
        for row in found.all()
    }


def test_weights_are_listed_while_a_slider_moves(visit: Visit) -> None:
    rig = lawful()
    page = visit(scene(glb(rig)), **COARSE)
    heading = page.get_by_role("button", name="Correctives")
    assert heading.get_attribute("aria-expanded") == "false"
    assert rows(page) == {}
    heading.focus()
    page.keyboard.press("Enter")
    driven = [name for name in rig.sliders.correctives if name not in rig.names]
    assert rows(page) == dict.fromkeys(driven, "0.00")
    page.get_by_role("slider", name="jawOpen", exact=True).focus()
    update(page, weights={"mouthClose": 0.4, "jawOpen": 0.89, "mouthSmile_L": 0.3}, t=0.5)
    settled(page)
    page.keyboard.press("ArrowRight")
    found = rows(page)  # 0.9 · 0.15 + 0.8 · 0.45 is below 1, and the others have one at 0
    assert found == dict.fromkeys([PAIR, *driven], "0.00") | {PAIR: "0.20"}
    assert next(iter(found)) == PAIR, "those that do something stand first"
    assert heading.inner_text().split() == ["Correctives", "1", "of", str(len(driven))]
    update(page, weights={"mouthSmile_L": 1, "jawOpen": 0.5}, t=1)
    page.locator(".picture").focus()
    assert next(iter(rows(page).items())) == ("by hinge", "0.30")


def test_a_corrective_is_switched_off_and_on(visit: Visit) -> None:
    """By the keyboard alone; the picture is then that of a rig without it."""
    rig = lawful()
    page = visit(scene(glb(rig)), **COARSE)
    pose = dict(zip(rig.names, POSES["all"], strict=True))
    update(page, weights=pose, t=1)
    page.get_by_role("button", name="Correctives").press("Enter")
    settled(page)
    page.keyboard.press("Tab")
    first = page.evaluate("document.activeElement.closest('.corrective').dataset.corrective")
    switch = page.get_by_role("switch", name=PAIR)
    described = switch.get_attribute("aria-describedby")
    assert page.locator(f"#{described}").inner_text() == rows(page)[PAIR]
    page.keyboard.press("Space")
    assert state(page)["correctivesOff"] == [first]
    assert off(page, without(rig, first).pose(pose)) < WITHIN
    if first != PAIR:
        switch.press("Space")
    page.get_by_role("switch", name="by min").press("Space")
    gone = {first, PAIR, "by min"}
    assert set(state(page)["correctivesOff"]) == gone
    assert off(page, without(rig, *gone).pose(pose)) < WITHIN
    assert off(page, rig.pose(pose)) > 5 * WITHIN
    page.keyboard.press("Space")
    assert off(page, without(rig, *(gone - {"by min"})).pose(pose)) < WITHIN
    page.keyboard.press("Control+z")
    assert set(state(page)["correctivesOff"]) == gone
    update(page, weights={})
    settled(page)
    page.get_by_role("button", name="Reset all").click()
    assert state(page)["correctivesOff"] == []
    update(page, weights=pose)
    assert off(page, rig.pose(pose)) < WITHIN


def test_correctives_are_found_by_name(visit: Visit) -> None:
    page = visit(scene(glb(lawful())), **COARSE)
    page.get_by_role("searchbox", name="Search sliders").fill("by mulavg")
    assert [*rows(page)] == ["by mulAvgExt", "by mulAvgAll"]


def test_a_rig_without_correctives_has_no_list_of_them(visit: Visit) -> None:
    rig = without(lawful(), *(n for n in lawful().sliders.correctives if n != "eyeSquint_L"))
    page = visit(scene(glb(rig)), **COARSE)
    settled(page)
    assert not page.get_by_text("Correctives").is_visible()
