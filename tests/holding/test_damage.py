"""Damage where sliders meet, on sheets whose folds are known and on heads."""

from __future__ import annotations

import numpy as np
import pytest
from folded_sheets import SIDE, moved, sheet
from numpy.typing import NDArray

import elastomorph as em
from elastomorph.holding.damage import Surface, folds_by_sliders, rank_meetings
from elastomorph.model.mesh import Mesh
from elastomorph.rig import Rig
from elastomorph.rig.performance import Performance

MIDDLE = SIDE * (SIDE // 2) + SIDE // 2


def sheet_rig(*, lid: bool = False) -> Rig:
    """Two sliders that move the middle by 0.7 squares each, and one far away."""
    points, faces = sheet()
    if lid:
        over, more = sheet(1.0)
        faces += [[corner + len(points) for corner in face] for face in more]
        points = np.concatenate([points, over])
    neutral = Mesh(points, faces)
    targets = {
        "a": moved(points, MIDDLE, (0.7, 0, 0)),
        "b": moved(points, MIDDLE, (0.7, 0.1, 0)),
        "c": moved(points, SIDE + 1, (0.3, 0, 0)),
    }
    named = {name: neutral.with_vertices(there) for name, there in targets.items()}
    return Rig(neutral, named, method="linear")


def folded_by_hand(points: NDArray[np.float64], triangles: NDArray[np.int64]) -> set[int]:
    """Triangles against the sum of all that share a vertex within three steps, one by one."""
    normals = [np.cross(b - a, c - a) for a, b, c in points[triangles]]
    corners = [set(map(int, triangle)) for triangle in triangles]
    folded = set()
    for number, own in enumerate(corners):
        reached = set(own)
        for _ in range(2):
            reached = set().union(*(each for each in corners if each & reached))
        mean = sum(normals[k] for k, each in enumerate(corners) if each & reached)
        if float(np.dot(normals[number], mean)) < 0:
            folded.add(number)
    return folded


def test_folds_are_those_found_one_by_one() -> None:
    rng = np.random.default_rng(3)
    points, faces = sheet(side=9)
    neutral = Mesh(points, faces)
    surface = Surface.of(Rig(neutral, {"a": neutral.with_vertices(points + 1)}, method="linear"))
    crumpled = points + rng.normal(0, 0.4, points.shape)
    found = set(np.flatnonzero(surface.folded(crumpled)).tolist())
    assert found == folded_by_hand(crumpled, surface.triangles)
    some = np.arange(0, len(surface.triangles), 3)
    assert (surface.folded(crumpled, some) == surface.folded(crumpled)[some]).all()


def test_only_the_pair_that_folds_is_ranked() -> None:
    (worst,) = rank_meetings(sheet_rig())
    assert worst.sliders == ("a", "b")
    assert worst.folds > 0
    assert worst.depth == 0
    assert not worst.opposite
    assert worst.frames is None
    assert worst.per_frame is None


def test_what_is_hidden_is_no_damage() -> None:
    """A sheet in front hides the fold; one behind does not."""
    assert rank_meetings(sheet_rig(lid=True)) == []
    rig = sheet_rig()
    surface = Surface.of(rig)
    pose = rig.pose({"a": 1, "b": 1})
    assert len(surface.visible_folds(pose)) == surface.folded(pose).sum() > 0
    assert not len(surface.visible_folds(pose * [-1, 1, -1]))  # turned away


def test_takes_say_how_often() -> None:
    """Of four frames one folds by both, and a frame in which one is at rest does not count."""
    rig = sheet_rig()
    frames = np.array([[1, 1, 0], [0.5, 0.5, 0], [1, 0, 1], [0, 0, 0]])
    take = Performance(["a", "b", "c"], np.arange(4) / 30, frames, 30)
    (worst,) = rank_meetings(rig, take)
    folds = len(Surface.of(rig).visible_folds(rig.pose({"a": 1, "b": 1})))
    assert worst.frames == 2
    assert list(worst.weights) == [1, 1]
    assert worst.per_frame == pytest.approx(folds / 4)
    by = list(folds_by_sliders(rig, Surface.of(rig), frames))
    assert {(place, sliders) for place, _, sliders in by} == {(0, (0, 1))}


def test_opposites_come_last() -> None:
    points, faces = sheet()
    neutral = Mesh(points, faces)
    other = MIDDLE + 5
    to = {
        "left": moved(points, MIDDLE, (0.7, 0, 0)),
        "more": moved(points, MIDDLE, (0.7, 0, 0)),
        "up": moved(points, other, (0, 1.5, 0)),
        "down": moved(points, other, (0, -0.2, 0)),
    }
    to["down"][other + 1] += (0, 1.5, 0)
    named = {name: neutral.with_vertices(there) for name, there in to.items()}
    ranked = rank_meetings(Rig(neutral, named, method="linear"), triples=False)
    assert ranked[0].sliders == ("left", "more")
    assert sorted(ranked, key=lambda one: one.opposite) == ranked


def test_errors_say_what_is_missing() -> None:
    points, faces = sheet()
    neutral, end = Mesh(points, faces), points + [0, 0, 1]
    with pytest.raises(em.ParameterError, match="two sliders or more, the rig has 1"):
        rank_meetings(Rig(neutral, {"a": neutral.with_vertices(end)}, method="linear"))
    markers = Mesh(points)
    bare = {name: markers.with_vertices(end) for name in "ab"}
    with pytest.raises(em.MeshError, match="no polygons"):
        rank_meetings(Rig(markers, bare, method="linear"))
    take = Performance(["JawOpen"], [0.0], [[1.0]], 30, source="take.csv")
    with pytest.raises(em.ParameterError, match=r"no weight of take\.csv drives"):
        rank_meetings(sheet_rig(), take)
