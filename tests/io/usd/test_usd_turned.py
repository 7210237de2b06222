"""The turn of a head in USD: the joint in its neck turns, and the rig is the same."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.errors import ParameterError
from elastomorph.io.usd import write_usd
from elastomorph.rig import Rig
from elastomorph.rig.performance import HeadTurn
from needs import extra

extra("pxr", "usd")

ANGLES = np.array([[0, 0, 0], [0.9, 0.2, -0.1], [-0.4, 0.5, 0.3]])
TIMES, WEIGHTS = np.arange(3) / 24, np.array([[0.0], [0.5], [1.0]])
NECK = np.array([0.3, -0.2, 0.7])


def rig() -> Rig:
    neutral = em.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    return Rig(neutral, {"up": neutral.with_vertices(neutral.vertices + [0, 0, 1.0])})


def written(path: Path) -> Path:
    turn = HeadTurn(NECK, ANGLES)
    write_usd(path, rig(), animation=(TIMES, WEIGHTS, "talk"), fps=24, turn=turn)
    return path


def test_joints_place_points_as_the_turn_does(tmp_path: Path) -> None:
    from pxr import Usd, UsdSkel

    stage = Usd.Stage.Open(str(written(tmp_path / "a.usda")))
    root = UsdSkel.Root(stage.GetPrimAtPath("/Face"))
    cache = UsdSkel.Cache()
    cache.Populate(root, Usd.PrimDefaultPredicate)
    query = cache.GetSkelQuery(UsdSkel.Skeleton(stage.GetPrimAtPath("/Face/Skeleton")))
    points = rig().neutral.vertices
    turn = HeadTurn(NECK, ANGLES)
    low, high = np.array(root.GetExtentAttr().Get())
    for frame in range(3):
        (joint,) = query.ComputeSkinningTransforms(frame)
        matrix = np.array(joint)
        placed = points @ matrix[:3, :3] + matrix[3, :3]
        expected = turn.of(points, frame)
        np.testing.assert_allclose(placed, expected, atol=1e-6)
        assert ((expected >= low - 1e-6) & (expected <= high + 1e-6)).all()


def test_the_rig_comes_back(tmp_path: Path) -> None:
    found = em.read_rig(written(tmp_path / "a.usdc"))
    np.testing.assert_array_equal(found.neutral.vertices, rig().neutral.vertices)
    assert found.names == ("up",)


def test_a_turn_needs_an_animation(tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="a head is turned with an animation"):
        write_usd(tmp_path / "a.usda", rig(), turn=HeadTurn(NECK, ANGLES))
    assert not list(tmp_path.iterdir())
