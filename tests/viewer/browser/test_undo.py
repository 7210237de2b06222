"""Whatever was done is undone, gesture by gesture, and done again."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest
from faces import Faces
from test_sliders import assert_posed, slider
from visiting import COARSE, Visit, settled, state, update, wait

if TYPE_CHECKING:
    from playwright.sync_api import Locator, Page

CLOCK = {"playing", "t", "clipTime"}


def undo(page: Page) -> Locator:
    return page.get_by_role("button", name="Undo")


def redo(page: Page) -> Locator:
    return page.get_by_role("button", name="Redo")


def drag(page: Page, name: str, *shares: float) -> None:
    """With the mouse, in one go over places of the slider."""
    box = slider(page, name).bounding_box()
    assert box is not None
    middle = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + 6, middle)
    page.mouse.down()
    for share in shares:
        page.mouse.move(box["x"] + share * box["width"], middle, steps=4)
    page.mouse.up()


def test_a_drag_is_one_step(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **COARSE)
    assert undo(page).is_disabled()
    assert redo(page).is_disabled()
    drag(page, "jawOpen", 0.3, 0.9, 0.5)
    first = state(page)["weights"]
    drag(page, "mouthFunnel", 0.8)
    second = state(page)["weights"]
    assert set(second) == {"jawOpen", "mouthFunnel"}
    undo(page).click()
    assert state(page)["weights"] == first
    undo(page).click()
    assert state(page)["weights"] == {}
    settled(page)
    assert undo(page).is_disabled()
    redo(page).click()
    redo(page).click()
    assert state(page)["weights"] == second
    assert_posed(page, faces)
    settled(page)
    assert redo(page).is_disabled()


def test_by_keys(visit: Visit, faces: Faces) -> None:
    """Keys of a control that follow soon are one step; a pause begins another."""
    page = visit(faces.alone, **COARSE)
    jaw = slider(page, "jawOpen")
    jaw.focus()
    # In the page, as a hand presses them: from outside, a busy machine takes longer than a pause.
    jaw.evaluate(
        """range => {
            const options = {key: 'ArrowRight', bubbles: true};
            for (let i = 0; i < 5; i += 1) {
                range.dispatchEvent(new KeyboardEvent('keydown', options));
                range.stepUp();
                range.dispatchEvent(new Event('input', {bubbles: true}));
            }
        }"""
    )
    page.wait_for_timeout(600)
    page.keyboard.press("End")
    page.keyboard.press("Control+z")
    assert state(page)["weights"] == {"jawOpen": pytest.approx(0.05)}
    page.keyboard.press("Control+z")
    assert state(page)["weights"] == {}
    page.keyboard.press("Control+Shift+z")
    page.keyboard.press("Control+y")
    assert state(page)["weights"] == {"jawOpen": 1}


def test_what_comes_after_an_undo_replaces_what_was_undone(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **COARSE)
    drag(page, "jawOpen", 0.5)
    page.keyboard.press("Control+z")
    drag(page, "mouthFunnel", 0.5)
    settled(page)
    assert redo(page).is_disabled()
    page.keyboard.press("Control+y")
    assert set(state(page)["weights"]) == {"mouthFunnel"}


def test_everything_is_undone(visit: Visit, faces: Faces) -> None:
    """Switches, choices, keys, picked vertices and the comparison, in the order they were made."""
    page = visit(faces.together, **COARSE)
    before = [state(page)]

    def done() -> None:
        before.append(state(page))
        assert _settings(before[-1]) != _settings(before[-2])

    page.keyboard.press("w")
    done()
    page.get_by_role("switch", name="Mirror").check()
    done()
    page.get_by_role("tab", name="Display").click()
    page.get_by_role("radio", name="Flat").check(force=True)
    done()
    page.get_by_role("tab", name="Compare").click()
    page.get_by_role("radio", name="Swipe").check(force=True)
    done()
    page.get_by_role("combobox", name="Timing").select_option("blink")
    done()
    page.get_by_role("combobox", name="What plays").select_option("a take")
    done()
    page.get_by_role("combobox", name="What plays").focus()  # as the mouse leaves it
    for expected in reversed(before[:-1]):
        page.keyboard.press("Control+z")
        assert _settings(state(page)) == _settings(expected)
    for expected in before[1:]:
        page.keyboard.press("Control+y")
        assert _settings(state(page)) == _settings(expected)


def test_the_clock_is_not_undone(visit: Visit, faces: Faces) -> None:
    page = visit(faces.performed, **COARSE, reduced_motion="no-preference")
    update(page, clip=None)
    page.wait_for_timeout(600)
    page.get_by_role("combobox", name="What plays").select_option("a take")
    page.get_by_role("button", name="Play").click()
    wait(page, "elastomorph.state().clipTime > 0.2")
    page.get_by_role("button", name="Pause").click()
    page.keyboard.press("g")
    page.keyboard.press("Control+z")
    assert not state(page)["ghost"]
    assert state(page)["clip"] == "a take"
    page.keyboard.press("Control+z")
    assert state(page)["clip"] is None


def test_a_slider_that_stops_a_performance_gives_it_back(visit: Visit, faces: Faces) -> None:
    page = visit(faces.performed, **COARSE)
    update(page, clip="a take", clipTime=0.5)
    playing = state(page)
    drag(page, "mouthFunnel", 0.5)
    assert state(page)["clip"] is None
    undo(page).click()
    assert state(page) == playing


def test_by_touch(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, size=(390, 844), has_touch=True, **COARSE)
    slider(page, "jawOpen").tap()
    assert set(state(page)["weights"]) == {"jawOpen"}
    undo(page).tap()
    assert state(page)["weights"] == {}


def test_memory_is_bounded(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **COARSE)
    page.evaluate(
        """() => {
            for (let i = 1; i <= 220; i += 1) {
                dispatchEvent(new PointerEvent('pointerdown'));
                elastomorph.update({weights: {jawOpen: i / 220}});
                dispatchEvent(new PointerEvent('pointerup'));
            }
            for (let i = 0; i < 300; i += 1)
                dispatchEvent(new KeyboardEvent('keydown', {key: 'z', ctrlKey: true}));
        }"""
    )
    assert state(page)["weights"] == {"jawOpen": pytest.approx(20 / 220)}, "200 steps"
    settled(page)
    assert undo(page).is_disabled()


def _settings(found: dict[str, Any]) -> dict[str, Any]:
    return {field: value for field, value in found.items() if field not in CLOCK}


LONG = """([frames, steps, part]) => {
    const tracks = new Map(['a', 'b'].map(name => [name, new Float32Array(frames)]));
    const times = Float64Array.from({length: frames}, (_, i) => i / 60);
    elastomorph.update({takes: [{name: 'long', times, tracks}]});
    for (let i = 1; i <= steps; i += 1) {
        dispatchEvent(new PointerEvent('pointerdown'));
        const [take] = elastomorph.state().takes;
        const next = new Map([...take.tracks].map(
            ([name, track]) => [name, track.slice().fill(i / 100, 0, part)]));
        elastomorph.update({takes: [{...take, tracks: next}]});
        dispatchEvent(new PointerEvent('pointerup'));
    }
}"""
UNDONE = """() => {
    for (let i = 0; i < 300; i += 1)
        dispatchEvent(new KeyboardEvent('keydown', {key: 'z', ctrlKey: true}));
    const [take] = elastomorph.state().takes;
    return take ? [take.tracks.get('a')[0], take.tracks.get('b').at(-1)] : null;
}"""


@pytest.mark.parametrize(
    ("part", "left"), [(600, None), (2_000_000, [0.05, 0.05])], ids=["frames", "takes"]
)
def test_long_takes_are_remembered_by_what_changed(
    visit: Visit, faces: Faces, part: int, left: list[float] | None
) -> None:
    """Of edits of ten seconds all; of whole takes of 16 MB each as many as 256 MB hold, and one."""
    page = visit(faces.alone, **COARSE)
    page.evaluate(LONG, [2_000_000, 22, part])
    assert page.evaluate(UNDONE) == pytest.approx(left)
    page.evaluate(UNDONE.replace("'z'", "'y'"))
    first = page.evaluate("elastomorph.state().takes[0].tracks.get('a')[0]")
    last = page.evaluate("elastomorph.state().takes[0].tracks.get('b').at(-1)")
    assert first == pytest.approx(0.22)
    assert last == pytest.approx(0.22 if part > 600 else 0)
    page.evaluate("elastomorph.update({takes: []})")
