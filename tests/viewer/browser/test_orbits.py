"""Orbits: a click picks the vertex under it, and its way is drawn where the path runs."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from faces import Faces
from pictures import differing, near, picture, rgb
from projecting import front_view
from visiting import HALVED, Visit, settled, state, update

# Of the first, second and third model, as on the labels of the page.
COLOURS = (rgb("#2f8fe0"), rgb("#f0862a"), rgb("#23a776"))
PLACES = tuple(itertools.product((0.42, 0.46, 0.5, 0.54, 0.58), (0.3, 0.47, 0.66)))


def test_a_click_picks_and_the_orbit_is_the_path(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone)
    neutral, chin = faces.neutral.vertices, faces.chin
    view = front_view(page, neutral, PLACES)
    page.mouse.click(*view.project(neutral[chin])[0].round())
    assert state(page)["picked"] == [chin]

    update(page, weights={"jawOpen": 1}, t=1, orbits=False)
    without = picture(page)
    update(page, orbits=True)
    drawn = picture(page)
    # At its end the chin has turned under itself, out of sight.
    path = faces.rigs["beam:2"].morphs["jawOpen"].at(np.linspace(0, 0.95, 25))[:, chin]
    box = page.locator(".picture").bounding_box()
    assert box is not None
    points = view.project(path) - [box["x"], box["y"]]
    assert np.ptp(points[:, 1]) > 40, "the chin hardly moves"
    changed = differing(without, drawn, 40)
    off = [not _around(changed & near(drawn, COLOURS[0], 90), x, y) for x, y in points]
    assert not any(off), f"the orbit is not drawn at {np.flatnonzero(off)} of 25 moments"
    # And nowhere else: all that has changed is near the path.
    rows, columns = np.nonzero(changed)
    away = np.hypot(rows[:, None] - points[:, 1], columns[:, None] - points[:, 0]).min(axis=1)
    assert away.max() < 14


def test_a_curved_path_is_drawn_curved(visit: Visit, faces: Faces) -> None:
    """From the side: each method's way of the chin is as bent on the picture as in space."""
    page = visit(faces.together)
    page.evaluate("elastomorph.look('side')")
    bends = {}
    for number, name in enumerate(faces.rigs):
        start = {"weights": {"jawOpen": 1}, "t": 1, "picked": [faces.chin], "shown": [number]}
        update(page, **start, arrangement="single", orbits=False)
        without = picture(page)
        update(page, orbits=True)
        drawn = picture(page)
        stroke = differing(without, drawn, 40) & near(drawn, COLOURS[number], 60)
        path = faces.rigs[name].morphs["jawOpen"].at(np.linspace(0, 1, 200))[:, faces.chin]
        bends[name] = _sagitta(path[:, [1, 2]])
        assert stroke.sum() > 100
        assert _sagitta(np.argwhere(stroke)) == pytest.approx(bends[name], abs=0.03)
    assert bends["linear"] < 1e-9
    assert bends["rotation"] > 0.06, "choose a path with a bend that can be seen"


def test_a_second_click_takes_it_away(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **HALVED)
    page.get_by_role("tab", name="Compare").click()
    page.get_by_role("switch", name="Draw orbits").check()
    box = page.locator(".picture").bounding_box()
    assert box is not None
    place = (box["x"] + 0.5 * box["width"], box["y"] + 0.3 * box["height"])
    page.mouse.click(*place)
    (vertex,) = state(page)["picked"]
    settled(page)
    assert page.get_by_role("button", name=f"Remove vertex {vertex}").is_visible()
    page.mouse.click(*place)
    assert state(page)["picked"] == []


def test_dragging_turns_and_picks_nothing(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone)
    update(page, orbits=True)
    before = picture(page)
    box = page.locator(".picture").bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.3 * box["height"])
    page.mouse.down()
    page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + 0.3 * box["height"], steps=4)
    page.mouse.up()
    assert state(page)["picked"] == []
    assert differing(before, picture(page)).mean() > 0.05


def test_without_orbits_a_click_picks_nothing(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **HALVED)
    box = page.locator(".picture").bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + 0.5 * box["width"], box["y"] + 0.3 * box["height"])
    assert state(page)["picked"] == []


def test_vertices_by_number(visit: Visit, faces: Faces) -> None:
    page = visit(faces.alone, **HALVED)
    page.get_by_role("tab", name="Compare").click()
    number = page.get_by_role("spinbutton", name="Vertex")
    for vertex in (faces.chin, 7):
        number.fill(str(vertex))
        number.press("Enter")
    assert state(page)["picked"] == [faces.chin, 7]
    assert state(page)["orbits"]
    settled(page)
    page.get_by_role("button", name=f"Remove vertex {faces.chin}").click()
    assert state(page)["picked"] == [7]
    page.get_by_role("button", name="Clear").click()
    assert state(page)["picked"] == []


def test_the_worst_vertex_is_a_click_away(visit: Visit, faces: Faces) -> None:
    page = visit(faces.together, **HALVED)
    update(page, weights={"jawOpen": 1}, t=0.5, shown=[0, 1], against=1, heat=True)
    worst = page.evaluate("elastomorph.readout()")["heat"]["worstVertex"]
    page.get_by_role("button", name=f"vertex {worst}").click()
    assert state(page)["picked"] == [worst]


def _around(mask: np.ndarray, x: float, y: float, reach: int = 2) -> bool:
    row, column = round(y), round(x)
    return bool(mask[row - reach : row + reach + 1, column - reach : column + reach + 1].any())


def _sagitta(points: np.ndarray) -> float:
    """How far a curve strays from its main direction, as a share of its length.

    Args:
        points: (n, 2) anywhere on the stroke, whose width does not count.
    """
    centred = points - points.mean(axis=0)
    _, _, axes = np.linalg.svd(centred, full_matrices=False)
    along, across = (centred @ axes.T).T
    places = np.round((along - along.min()) / np.ptp(along) * 20)
    middles = [across[places == place].mean() for place in range(21) if (places == place).any()]
    return float(np.ptp(middles) / np.ptp(along))
