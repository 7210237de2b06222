"""A file with a performance is dropped on a face of as many vertices: it plays there."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from faces import Faces, glb
from takes import alone, latest, open_files, told
from visiting import SMALL, Visit, positions, settled, state, update

from elastomorph.rig import Rig
from elastomorph.rig.performance import Performance, slider_weights

if TYPE_CHECKING:
    from pathlib import Path

    from playwright.sync_api import Page


def dropped(page: Page, folder: Path, name: str, rig: Rig, take: Performance | None) -> None:
    path = folder / f"{name}.glb"
    path.write_bytes(glb(rig, take))
    open_files(page, path)


def assert_posed(page: Page, rig: Rig, take: Performance, frame: int, model: int) -> None:
    weights = slider_weights(rig, take)[frame]
    wanted = rig.pose(dict(zip(rig.names, weights, strict=True)))
    found = positions(page, model, len(wanted))
    np.testing.assert_allclose(found, wanted, atol=1e-4 * rig.neutral.diameter)


def test_the_same_rig_with_a_performance_plays_it(
    visit: Visit, faces: Faces, tmp_path: Path
) -> None:
    """On the face that is shown, which stays alone; one step, which is undone."""
    rig, take = faces.rigs["beam:2"], faces.take
    page = visit(alone(glb(rig), "head"), size=SMALL)
    update(page, weights={"mouthFunnel": 0.5})
    dropped(page, tmp_path, "walk", rig, take)
    assert told(page) == []
    found = state(page)
    assert (found["clip"], found["arrangement"], found["playing"]) == ("a take", "single", False)
    assert page.evaluate("elastomorph.models().length") == 1
    page.locator(".picture").focus()
    page.keyboard.press("Control+z")
    assert state(page)["clip"] is None
    assert state(page)["weights"] == {"mouthFunnel": 0.5}
    page.keyboard.press("Control+y")
    update(page, clipTime=float(take.times[7]))
    assert_posed(page, rig, take, 7, 0)


def test_another_face_stands_beside_and_both_play(
    visit: Visit, faces: Faces, tmp_path: Path
) -> None:
    rig, other, take = faces.rigs["linear"], faces.rigs["rotation"], faces.take
    page = visit(alone(glb(rig), "head"), size=SMALL)
    dropped(page, tmp_path, "other", other, take)
    assert told(page) == []
    found = state(page)
    assert (found["clip"], found["arrangement"], found["shown"]) == ("a take", "side", [0, 1])
    update(page, clipTime=float(take.times[11]))
    for model, one in enumerate((rig, other)):
        assert_posed(page, one, take, 11, model)


def test_a_face_without_a_performance_only_stands_beside(
    visit: Visit, faces: Faces, tmp_path: Path
) -> None:
    page = visit(alone(glb(faces.rigs["linear"]), "head"), size=SMALL)
    update(page, weights={"jawOpen": 0.5})
    dropped(page, tmp_path, "other", faces.rigs["linear"], None)
    found = state(page)
    assert (found["clip"], found["arrangement"]) == (None, "side")
    assert found["weights"] == {"jawOpen": 0.5}


def test_performances_of_one_name(visit: Visit, faces: Faces, tmp_path: Path) -> None:
    """The same one is there once; another one, however edited what is there, gets a number."""
    take = faces.take
    page = visit(faces.performed, size=SMALL)  # with the same performance in its file
    for _ in range(2):
        dropped(page, tmp_path, "again", faces.rigs["beam:2"], take)
        assert state(page)["clip"] == "a take"
        assert state(page)["takes"] == []
    half = Performance(take.names, take.times, take.weights / 2, take.rate)
    for _ in range(2):
        dropped(page, tmp_path, "half", faces.rigs["beam:2"], half)
        assert state(page)["clip"] == "a take 2"
        np.testing.assert_allclose(latest(page).tracks["jawOpen"], half.weights[:, 0], atol=1e-6)
    settled(page)
    names = page.get_by_role("combobox", name="What plays").locator("option").all_inner_texts()
    assert names == ["Pose (t)", "a take 2", "a take"]
    assert page.evaluate("elastomorph.models().length") == 1
