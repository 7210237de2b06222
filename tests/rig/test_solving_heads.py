"""Dragging whole heads: what a few vertices say of all sliders."""

from __future__ import annotations

import numpy as np
import pytest

from dragging import poses, telling_vertices
from elastomorph.io import read_rig
from elastomorph.rig import Rig
from elastomorph.rig.build import extent_of, with_paths
from small_head import bare_head

COUNT = 20
PRODUCTION = pytest.param("ict-facekit", marks=[pytest.mark.realdata, pytest.mark.slow])


@pytest.fixture(scope="module", params=["small head", PRODUCTION])
def rig(request: pytest.FixtureRequest) -> Rig:
    if request.param == "small head":
        return with_paths(bare_head())
    return read_rig(request.getfixturevalue("data_dir") / request.param)


@pytest.fixture(scope="module")
def vertices(rig: Rig) -> list[int]:
    return telling_vertices(rig, COUNT)


def worst(rig: Rig, vertices: list[int], weights: dict[str, float]) -> float:
    """The largest error of a weight found again from where a pose has the vertices."""
    face = rig.pose(weights)
    solved = rig.solve({vertex: face[vertex] for vertex in vertices})
    assert solved.reached
    return max(abs(found - weights.get(name, 0.0)) for name, found in solved.weights.items())


def test_weights_are_found_again_from_twenty_vertices(rig: Rig, vertices: list[int]) -> None:
    assert len(vertices) == COUNT
    assert max(worst(rig, vertices, weights) for weights in poses(rig)) < 1e-3


def test_weights_are_found_again_where_a_product_drives_a_slider(
    rig: Rig, vertices: list[int]
) -> None:
    """At rest its slider moves nothing: the jaw must open first."""
    other = "mouthPucker"
    driven = Rig(rig.neutral, rig.morphs, correctives={other: ("jawOpen", other)})
    assert worst(driven, vertices, {"jawOpen": 0.6, other: 0.5, "mouthSmile_L": 0.4}) < 1e-3


def test_a_face_is_off_by_no_more_than_the_noise_of_its_handles(
    rig: Rig, vertices: list[int]
) -> None:
    """Noise of σ an axis is √3 σ a point, and least squares lets through a part of it.

    Of 60 numbers 45 to 57 are unknown, so at the handles next to all could come through.
    """
    random, noise = np.random.default_rng(1), 0.01 * extent_of(rig)
    for weights in poses(rig)[:8]:
        face = rig.pose(weights)
        handles = {v: face[v] + noise * random.normal(size=3) for v in vertices}
        off = rig.pose(rig.solve(handles, prior=3e-3).weights) - face
        assert np.sqrt(np.square(off).sum(axis=1).mean()) < np.sqrt(3) * noise
        assert np.sqrt(np.square(off[vertices]).sum(axis=1).mean()) < np.sqrt(3) * noise


def test_the_bent_rig_is_nearer_than_the_straight_one(rig: Rig, vertices: list[int]) -> None:
    straight = Rig(rig.neutral, {n: m.target for n, m in rig.morphs.items()}, method="linear")
    face = rig.pose({"jawOpen": 0.5, "eyeBlink_L": 0.5, "eyeBlink_R": 0.5})
    handles = {vertex: face[vertex] for vertex in vertices}
    off = [np.abs(one.pose(one.solve(handles).weights) - face).max() for one in (rig, straight)]
    assert off[0] < 1e-3 * off[1]


def test_a_chin_out_of_reach_is_left_where_no_other_pose_is_nearer(rig: Rig) -> None:
    """Three times as far as the jaw opens: among many poses none has it nearer than is said."""
    opened = rig["jawOpen"].delta
    chin = int(np.linalg.norm(opened, axis=1).argmax())
    goal = rig.neutral.vertices[chin] + 3.0 * opened[chin]
    solved = rig.solve({chin: goal})
    left = solved.distances[chin]
    assert not solved.reached
    assert left == pytest.approx(np.linalg.norm(rig.pose(solved.weights)[chin] - goal))
    random = np.random.default_rng(0)
    near = np.array(list(solved.weights.values()))
    for step in np.repeat([1e-3, 1e-2, 0.1, 1.0], 25):
        row = np.clip(near + step * random.normal(size=len(near)), 0, 1)
        assert np.linalg.norm(rig.pose(row)[chin] - goal) > left - 1e-3 * left


def test_handles_that_pull_apart_leave_the_face_in_their_middle(rig: Rig) -> None:
    """|p - g|² + |p - h|² is least nearest to (g + h) / 2: from anywhere the face goes to rest."""
    rest, opened = rig.neutral.vertices, rig["jawOpen"].delta
    chin = int(np.linalg.norm(opened, axis=1).argmax())
    apart = {chin: rest[chin] + opened[chin], ((chin,), (1.0,)): rest[chin] - opened[chin]}
    torn = rig.solve(apart, {"jawOpen": 0.4})
    size = np.linalg.norm(opened[chin])
    assert list(torn.distances.values()) == pytest.approx([size, size], rel=1e-3)
    assert np.linalg.norm(rig.pose(torn.weights)[chin] - rest[chin]) < 1e-2 * size
    assert set(rig.solve(apart).weights.values()) == {0.0}
