"""Playing: t by its timing, and recorded performances to the frame."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest
from faces import RATE, Faces, distances
from visiting import COARSE, SMALL, Visit, positions, settled, state, update, wait

from elastomorph import timing
from elastomorph.viewer import Scene

if TYPE_CHECKING:
    from playwright.sync_api import Page

WITHIN = 1e-4  # of D


def assert_frame(page: Page, faces: Faces, seconds: float) -> None:
    """The face is that of the take at this moment, straight between its frames."""
    rig, take = faces.rigs["beam:2"], faces.take
    weights = {
        name: float(np.interp(seconds, take.times, column))
        for name, column in zip(take.names, take.weights.T, strict=True)
    }
    found = positions(page, 0, len(rig.neutral.vertices))
    assert distances(found, rig.pose(weights)).max() < WITHIN * faces.diameter


def test_a_take_is_scrubbed_to_the_frame(visit: Visit, faces: Faces) -> None:
    page = visit(faces.performed, size=SMALL)
    page.get_by_role("combobox", name="What plays").select_option("a take")
    assert state(page)["clip"] == "a take"
    page.locator(".picture").focus()
    for frame in range(1, 8):
        page.keyboard.press("]")
        assert state(page)["clipTime"] == pytest.approx(frame / RATE, abs=1e-6)
    assert_frame(page, faces, 7 / RATE)
    page.keyboard.press("[")
    assert_frame(page, faces, 6 / RATE)
    settled(page)
    timeline = page.get_by_role("slider", name="Seconds of a take")
    timeline.press("End")
    assert_frame(page, faces, 1.0)
    for _ in range(4):
        timeline.press("PageDown")
    moment = state(page)["clipTime"]
    assert 0.2 < moment < 0.9
    assert_frame(page, faces, moment)
    settled(page)
    assert timeline.get_attribute("aria-valuetext") == (
        f"{moment:.2f} seconds, frame {int(moment * RATE + 0.02)}"
    )


def test_paths_are_no_takes(visit: Visit, faces: Faces) -> None:
    """Every file has an animation a morph, which only plays its path: nothing to choose."""
    page = visit(faces.alone, size=SMALL)
    assert not page.get_by_role("combobox", name="What plays").is_visible()


def test_a_take_plays_and_pauses(visit: Visit, faces: Faces) -> None:
    page = visit(faces.performed, size=SMALL)
    update(page, clip="a take", repeat="loop")
    settled(page)
    page.get_by_role("button", name="Play").click()
    wait(page, "elastomorph.state().clipTime > 0.1")
    settled(page)
    page.get_by_role("button", name="Pause").click()
    stopped = state(page)["clipTime"]
    page.wait_for_timeout(150)
    assert state(page)["clipTime"] == stopped
    assert_frame(page, faces, stopped)


def test_moving_a_slider_takes_over(visit: Visit, faces: Faces) -> None:
    """The pose of that moment stays, and the hand goes on from there."""
    page = visit(faces.performed, **COARSE)
    update(page, clip="a take", clipTime=0.4, playing=False)
    settled(page)
    page.get_by_role("slider", name="browInnerUp", exact=True).press("End")
    now = state(page)
    assert now["clip"] is None
    jaw = float(np.interp(0.4, faces.take.times, faces.take.weights[:, 0]))
    assert now["weights"]["jawOpen"] == pytest.approx(jaw, abs=1e-5)
    assert now["weights"]["browInnerUp"] == 1


def test_it_plays_through_and_stops(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, size=SMALL)
    update(page, weights={"jawOpen": 1}, t=0, repeat="once", seconds=0.3, playing=True)
    wait(page, "!elastomorph.state().playing")
    assert state(page)["t"] == 1


def test_back_and_forth_and_loop(visit: Visit, faces: Faces) -> None:
    """Back and forth t falls after it has risen; a loop begins again at 0."""
    page = visit(faces.alone, size=SMALL)
    for repeat in ("back and forth", "loop"):
        # A step of the clock is half a second at most, however long frames take.
        update(page, t=0.9, repeat=repeat, seconds=3, playing=True)
        seen = page.evaluate(
            """new Promise(done => {
                const seen = [];
                const look = () => {
                    seen.push(elastomorph.state().t);
                    const steps = seen.slice(1).map((t, i) => t - seen[i]);
                    const both = steps.some(step => step > 0) && steps.some(step => step < 0);
                    if (both && steps.length > 9) done(seen); else requestAnimationFrame(look);
                };
                look();
            })"""
        )
        update(page, playing=False)
        steps = np.diff(seen)
        assert (steps > 0).any(), repeat
        assert (steps < 0).any(), repeat
        if repeat == "loop":
            # Only the jump to the beginning goes down.
            assert (steps[steps < 0] < -0.5).all()


def test_the_drawn_timing_is_the_law(visit: Visit, faces: Faces) -> None:
    """The small picture of a timing runs through the values of `elastomorph.rig.timing`."""
    laws = {
        "linear": timing.linear,
        "smoothstep": timing.smoothstep,
        "minimum-jerk": timing.minimum_jerk,
        "cosine": timing.cosine,
        "blink": timing.blink(),
    }
    page = visit(faces.alone, **COARSE)
    choice = page.get_by_role("combobox", name="Timing")
    for name, law in laws.items():
        choice.select_option(name)
        settled(page)
        drawn = page.locator(".timing-picture .curve").get_attribute("d") or ""
        points = np.array([pair.split() for pair in drawn.lstrip("M").split("L")], float)
        wanted = np.array([law(share) for share in np.linspace(0, 1, len(points))])
        heights = (points[0, 1] - points[:, 1]) / 18  # of the drawing, from t = 0 to 1
        np.testing.assert_allclose(heights, wanted, atol=0.01)
    assert choice.locator("option").count() == len(laws)


@pytest.mark.parametrize("motion", ["reduce", "no-preference"])
def test_nothing_starts_by_itself_for_those_who_ask_for_less(
    visit: Visit, faces: Faces, motion: str
) -> None:
    scene = faces.alone
    playing = replace_start(scene, {"weights": {"jawOpen": 1}, "t": 0.3, "playing": True})
    page = visit(playing, size=SMALL, reduced_motion=motion)
    page.wait_for_timeout(200)
    moves = motion == "no-preference"
    assert state(page)["playing"] is moves
    assert (state(page)["t"] != 0.3) is moves
    # Whoever presses play wants to see it play, whatever they asked for.
    page.keyboard.press("Space")
    assert state(page)["playing"] is not moves


def replace_start(scene: Scene, start: dict[str, object]) -> Scene:
    return Scene(scene.models, scene.title, scene.unit, scene.diameter, scene.curves, start)
