"""The face is taken by any point and dragged: sliders follow, pins hold, the other side mirrors."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from faces import Faces, glb
from visiting import COARSE, PHONE, Visit, settled, state, update, wait

import elastomorph as em
from elastomorph.io import read_rig
from elastomorph.model.mesh import Mesh
from elastomorph.rig import Rig
from elastomorph.viewer import Scene, SceneModel
from small_head import head, shapes

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from playwright.sync_api import Page

    Pixels = tuple[float, float]


def grabbing(visit: Visit, scene: Scene, **options: object) -> Page:
    page = visit(scene, **{**COARSE, **options})
    page.get_by_role("button", name="Grab the face").click()
    assert state(page)["grab"]
    return page


def seen(page: Page, vertex: int, model: int = 0) -> np.ndarray:
    """The pixel of a vertex, from the upper left corner of the page."""
    place, corner = page.evaluate(
        """([model, vertex]) => {
            const at = elastomorph.positions(model).slice(3 * vertex, 3 * vertex + 3);
            const box = document.querySelector('.picture').getBoundingClientRect();
            return [elastomorph.spot(Array.from(at), model), [box.x, box.y]];
        }""",
        [model, vertex],
    )
    return np.array([place["x"], place["y"]]) + corner


def nearest(faces: Faces, place: np.ndarray) -> int:
    return int(np.linalg.norm(faces.neutral.vertices - place, axis=1).argmin())


def drag(page: Page, start: np.ndarray, by: Pixels, steps: int = 5, *, drop: bool = True) -> None:
    page.mouse.move(*start)
    page.mouse.down()
    for step in range(1, steps + 1):
        page.mouse.move(*(start + np.array(by) * step / steps))
        settled(page)
    if drop:
        page.mouse.up()
        settled(page)


def moved(page: Page) -> list[str]:
    rows = page.locator(".slider[data-moved]")
    return sorted(row.get_attribute("data-slider") or "" for row in rows.all())


def test_the_point_goes_where_the_pointer_does(visit: Visit, faces: Faces) -> None:
    page = grabbing(visit, faces.alone)
    start = seen(page, faces.chin)
    drag(page, start, (0, 24))
    weights = state(page)["weights"]
    assert weights["jawOpen"] > 0.1
    assert not [name for name in weights if name.startswith(("eye", "brow"))]
    np.testing.assert_allclose(seen(page, faces.chin), start + [0, 24], atol=1.5)
    assert moved(page) == sorted(name for name, weight in weights.items() if weight > 0.005)
    page.keyboard.press("Control+z")
    assert state(page)["weights"] == {}, "a gesture is one step"


def test_a_point_out_of_reach(visit: Visit, faces: Faces) -> None:
    """It comes as near as it can; a line shows where it is wanted, and the status how far."""
    page = grabbing(visit, faces.alone)
    start = seen(page, faces.chin)
    drag(page, start, (0, 260), drop=False)
    wait(page, "document.querySelector('.status').textContent.includes('cm out of reach')")
    wait(page, f"document.querySelector('.want-line').y2.baseVal.value > {start[1] + 200}")
    line = page.locator(".want-line")
    length = abs(float(line.get_attribute("y2") or 0) - float(line.get_attribute("y1") or 0))
    assert length == pytest.approx(start[1] + 260 - seen(page, faces.chin)[1], abs=2)
    weights = state(page)["weights"]
    assert weights["jawOpen"] > 0.9
    assert all(0 <= weight <= 1 for weight in weights.values())
    page.keyboard.press("Escape")
    page.mouse.up()
    assert state(page)["weights"] == {}, "Escape takes a drag back"


def test_pins_hold_still(visit: Visit, faces: Faces) -> None:
    page = grabbing(visit, faces.alone)
    lip = nearest(faces, faces.neutral.vertices[faces.chin] + [0, 2.5, 1])
    rest = seen(page, lip)
    drag(page, seen(page, faces.chin), (0, 30))
    free = np.abs(seen(page, lip) - rest).max()
    page.keyboard.press("0")
    page.keyboard.down("Shift")
    page.mouse.click(*rest)
    page.keyboard.up("Shift")
    (pin,) = state(page)["pins"]
    assert np.abs(seen(page, pin) - rest).max() < 12
    page.get_by_role("button", name=f"Pin at vertex {pin}").wait_for()
    rest = seen(page, pin)
    drag(page, seen(page, faces.chin), (0, 30))
    assert np.abs(seen(page, pin) - rest).max() < 0.7 * free
    page.keyboard.press("0")
    page.keyboard.down("Shift")
    page.mouse.click(*rest)
    page.keyboard.up("Shift")
    assert state(page)["pins"] == [], "the same click takes it away"


def test_pins_by_keys(visit: Visit, faces: Faces) -> None:
    page = grabbing(visit, faces.alone)
    for vertex in (faces.chin, 300):
        field = page.get_by_role("group", name="Grab").get_by_role("spinbutton", name="Vertex")
        field.fill(str(vertex))
        field.press("Enter")
        page.get_by_role("button", name="Pin the vertex").click()
    assert state(page)["pins"] == [faces.chin, 300]
    settled(page)
    pin = page.get_by_role("button", name="Pin at vertex 300")
    pin.focus()
    page.keyboard.press("Delete")
    assert state(page)["pins"] == [faces.chin]
    settled(page)
    page.get_by_role("button", name="Clear 1 pin").press("Enter")
    assert state(page)["pins"] == []


def test_arrow_keys_move_the_vertex(visit: Visit, faces: Faces) -> None:
    page = grabbing(visit, faces.alone)
    field = page.get_by_role("group", name="Grab").get_by_role("spinbutton", name="Vertex")
    field.fill(str(faces.chin))
    field.press("Enter")
    start = seen(page, faces.chin)
    for _ in range(3):
        page.keyboard.press("ArrowDown")
    page.keyboard.press("Shift+ArrowDown")
    np.testing.assert_allclose(seen(page, faces.chin), start + [0, 32], atol=2)
    jaw = state(page)["weights"]["jawOpen"]
    page.keyboard.press("ArrowUp")
    assert state(page)["weights"]["jawOpen"] < jaw
    page.keyboard.press("Escape")
    page.keyboard.press("Escape")
    assert not state(page)["grab"]


def test_mirrored(visit: Visit, faces: Faces) -> None:
    page = grabbing(visit, faces.alone)
    smile = faces.rigs["linear"].morphs["mouthSmile_L"].delta
    corner = int(np.linalg.norm(smile, axis=1).argmax())
    update(page, mirror=True)
    drag(page, seen(page, corner), (8, -10))
    weights = state(page)["weights"]
    assert weights["mouthSmile_L"] > 0.1
    assert weights["mouthSmile_L"] == weights["mouthSmile_R"]
    update(page, mirror=False, weights={})
    drag(page, seen(page, corner), (8, -10))
    assert "mouthSmile_R" not in state(page)["weights"]


def test_a_face_beside_which_something_hangs(visit: Visit) -> None:
    """The middle of the face stays in the middle of the face, wherever hair or a body ends."""
    face, count = head(), len(head().vertices)
    plait = np.array([[12.0, 0, 0], [13, 0, 0], [13, 1, 0]])

    def beside(mesh: Mesh) -> NDArray[np.float64]:
        return np.vstack([mesh.vertices, plait])

    neutral = Mesh(beside(face), [*face.faces, [count, count + 1, count + 2]])
    moved = {name: beside(shapes()[name]) for name in ("mouthLeft", "mouthRight")}
    leaning = Rig(
        neutral,
        {n: em.interpolate(neutral, neutral.with_vertices(v), "linear") for n, v in moved.items()},
    )
    aside = np.where(np.abs(face.vertices[:, 0]) < 0.1, moved["mouthLeft"][:count, 0], 0)
    page = grabbing(visit, Scene((SceneModel("a", "rig", glb(leaning)),), "Leaning", "cm"))
    update(page, mirror=True)
    settled(page)
    drag(page, seen(page, int(aside.argmax())), (8, 0))
    assert state(page)["weights"] == {}


def test_a_point_that_nothing_moves(visit: Visit, faces: Faces) -> None:
    page = grabbing(visit, faces.alone)
    crown = int(faces.neutral.vertices[:, 1].argmax())
    drag(page, seen(page, crown) + [0, 6], (0, 30))
    assert page.get_by_role("alert").get_by_text("No slider moves vertex").is_visible()
    assert state(page)["weights"] == {}


def test_a_performance_gives_the_sliders_away(visit: Visit, faces: Faces) -> None:
    page = grabbing(visit, faces.performed)
    update(page, clip="a take", clipTime=0.3)
    start = seen(page, faces.chin)
    update(page, playing=True)
    drag(page, start, (0, 12))
    now = state(page)
    assert (now["clip"], now["playing"], now["t"]) == (None, False, 1)
    settled(page)
    assert state(page)["weights"] == now["weights"] != {}


def test_before_the_end_of_the_path(visit: Visit, faces: Faces) -> None:
    """The point is brought to the pointer at the t that is shown; at t = 0 it would not move."""
    page = grabbing(visit, faces.alone)
    for t, after in ((0.5, 0.5), (0.0, 1.0)):
        update(page, weights={}, t=t)
        start = seen(page, faces.chin)
        drag(page, start, (0, 6))
        np.testing.assert_allclose(seen(page, faces.chin), start + [0, 6], atol=1.5)
        assert state(page)["t"] == after


def test_two_models_side_by_side(visit: Visit, faces: Faces) -> None:
    """Each is pulled along its own paths."""
    page = grabbing(visit, faces.together)
    update(page, arrangement="side", shown=[0, 2])
    settled(page)
    found = []
    for model in (0, 2):
        update(page, weights={})
        start = seen(page, faces.chin, model)
        drag(page, start, (0, 14))
        np.testing.assert_allclose(seen(page, faces.chin, model), start + [0, 14], atol=1.5)
        found.append(state(page)["weights"]["jawOpen"])
    assert abs(found[0] - found[1]) > 1e-3, "the paths differ"


def test_alt_is_the_tool_for_a_moment(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **COARSE)
    start = seen(page, faces.chin)
    page.keyboard.down("Alt")
    drag(page, start, (0, 20))
    assert state(page)["weights"]["jawOpen"] > 0.1
    assert not state(page)["grab"]
    page.keyboard.up("Alt")
    update(page, weights={}, grab=True)
    page.keyboard.down("Alt")
    drag(page, start, (40, 0))
    page.keyboard.up("Alt")
    assert state(page)["weights"] == {}
    assert np.abs(seen(page, faces.chin) - start).max() > 10, "the camera has turned"


def test_by_touch(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, size=PHONE, has_touch=True, **COARSE)
    page.get_by_role("button", name="Grab the face").tap()
    x, y = seen(page, faces.chin)
    touches = page.context.new_cdp_session(page)

    def touch(kind: str, *points: Pixels) -> None:
        given = [{"x": px, "y": py, "id": i} for i, (px, py) in enumerate(points)]
        touches.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": given})
        settled(page)

    touch("touchStart", (x, y))
    touch("touchMove", (x, y + 8))
    touch("touchMove", (x, y + 16))
    touch("touchStart", (x, y + 16), (x + 60, y - 60))  # a second finger changes nothing
    touch("touchEnd", (x, y + 16))
    touch("touchEnd")
    np.testing.assert_allclose(seen(page, faces.chin), [x, y + 16], atol=1.5)
    page.get_by_role("button", name="Pin the vertex").tap()
    assert len(state(page)["pins"]) == 1


def test_a_rig_of_one_slider(visit: Visit, faces: Faces) -> None:
    rig = faces.rigs["rotation"]
    alone = Rig(rig.neutral, {"jawOpen": rig.morphs["jawOpen"]})
    page = grabbing(visit, Scene((SceneModel("jaw", "rig", glb(alone)),), "One", "cm"))
    drag(page, seen(page, faces.chin), (10, 24))
    assert 0.1 < state(page)["weights"]["jawOpen"] < 1


@pytest.mark.parametrize("name", ["linear", "rotation", "beam:2"])
def test_solved_as_python_does(visit: Visit, faces: Faces, name: str) -> None:
    rig = faces.rigs[name]
    page = visit(Scene((SceneModel(name, "rig", glb(rig)),), name, "cm"), size=(420, 320))
    goals = telling(rig, {"jawOpen": 0.6, "mouthSmile_L": 0.4, "browInnerUp": 0.8}, 6)
    assert_solved(page, rig, goals, exact=name != "beam:2")


@pytest.mark.slow
def test_the_production_rig_as_python_does(visit: Visit, data_dir: Path) -> None:
    rig = read_rig(data_dir / "ict-facekit", method="arc")
    page = visit(Scene((SceneModel("ICT", "rig", glb(rig)),), "ICT", "cm"), size=(420, 320))
    goals = telling(rig, {"jawOpen": 0.5, "mouthSmile_L": 0.7, "cheekPuff_R": 0.4}, 10)
    assert_solved(page, rig, goals, exact=True)


def telling(rig: Rig, weights: dict[str, float], count: int) -> dict[int, np.ndarray]:
    """Where a pose brings vertices that it moves far, one for each slider and some more."""
    face = rig.pose(weights)
    one_each = [int(np.linalg.norm(rig.morphs[n].delta, axis=1).argmax()) for n in weights]
    far = np.linalg.norm(face - rig.neutral.vertices, axis=1).argsort()[:: -(len(face) // 40)]
    return {int(v): face[v] for v in [*one_each, *far[:count].tolist()]}


def assert_solved(page: Page, rig: Rig, goals: dict[int, np.ndarray], *, exact: bool) -> None:
    """The page finds the weights and positions that `Rig.solve` does, or nearer ones."""
    asked = {str(v): goal.tolist() for v, goal in goals.items()}
    for prior in (1e-3, 1e-8):
        expected = rig.solve(goals, prior=prior)
        found = page.evaluate("([goals, by]) => elastomorph.solve(goals, by)", [asked, prior])
        apart = [expected.distances[v] for v in sorted(goals)]
        if exact:
            weights = {name: found["weights"].get(name, 0) for name in rig.names}
            assert weights == pytest.approx(dict(expected.weights), abs=1e-3)
            assert found["distances"] == pytest.approx(apart, abs=1e-4 * rig.neutral.diameter)
        else:
            assert np.hypot.reduce(found["distances"]) <= 1.01 * np.hypot.reduce(apart) + 1e-3
        reached = rig.pose(found["weights"])
        for v, distance in zip(sorted(goals), found["distances"], strict=True):
            left = np.linalg.norm(reached[v] - goals[v])
            assert left == pytest.approx(distance, abs=1e-4 * rig.neutral.diameter)
