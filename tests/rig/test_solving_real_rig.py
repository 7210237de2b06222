"""Dragging the production rig: what a few vertices say of 57 sliders."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from dragging import poses, telling_vertices
from elastomorph.io import read_rig
from elastomorph.rig import Rig

pytestmark = [pytest.mark.realdata, pytest.mark.slow]


@pytest.fixture(scope="module")
def rig(data_dir: Path) -> Rig:
    return read_rig(data_dir / "ict-facekit")


def test_weights_are_found_again_from_twenty_vertices(rig: Rig) -> None:
    vertices = telling_vertices(rig, 20)
    assert len(vertices) == 20
    for weights in poses(rig):
        face = rig.pose(weights)
        solved = rig.solve({vertex: face[vertex] for vertex in vertices})
        expected = rig.sliders.row(weights)
        np.testing.assert_allclose(list(solved.weights.values()), expected, atol=1e-3)
        assert solved.reached


def test_the_bent_rig_is_nearer_than_the_straight_one(rig: Rig) -> None:
    vertices = telling_vertices(rig, 20)
    straight = Rig(rig.neutral, {n: m.target for n, m in rig.morphs.items()}, method="linear")
    face = rig.pose({"jawOpen": 0.5, "eyeBlink_L": 0.5, "eyeBlink_R": 0.5})
    handles = {vertex: face[vertex] for vertex in vertices}
    off = [np.abs(one.pose(one.solve(handles).weights) - face).max() for one in (rig, straight)]
    assert off[0] < 1e-3 * off[1]
