"""Films and strips of heads that turn are pictures of vertices that were turned."""

from __future__ import annotations

import numpy as np
import pytest

import elastomorph as em
from elastomorph.draw.film import film_camera, film_frames
from elastomorph.draw.head import neck_of
from elastomorph.draw.stage import Stage
from elastomorph.draw.strips import take_strip
from elastomorph.rig.performance import HeadTurn
from scenes import ball

SIZE = (64, 80)
ANGLES = np.array([[0, 0, 0], [0.9, 0, 0], [0.9, 0, 0], [-0.4, 0.5, 0.3]])
WEIGHTS = np.array([[0.0], [1.0], [1.0], [1.0]])


@pytest.fixture(scope="module")
def rig() -> em.Rig:
    """A ball with a nose that grows."""
    neutral = ball()
    ahead = neutral.vertices[:, 2:] > 0.8 * neutral.vertices[:, 2].max()
    longer = neutral.with_vertices(neutral.vertices + ahead * [0, 0, 0.5])
    return em.Rig(neutral, {"nose": longer}, method="linear")


def test_the_neck_is_a_quarter_up_the_middle(rig: em.Rig) -> None:
    box = np.array([rig.neutral.vertices.min(axis=0), rig.neutral.vertices.max(axis=0)])
    expected = box.mean(axis=0)
    expected[1] = 0.75 * box[0, 1] + 0.25 * box[1, 1]
    np.testing.assert_allclose(neck_of(rig.neutral, rig.morphs.values()), expected, atol=1e-12)


def test_a_frame_is_the_picture_of_its_vertices_turned(rig: em.Rig) -> None:
    neck = neck_of(rig.neutral, rig.morphs.values())
    turn = HeadTurn(neck, ANGLES)
    frames = list(film_frames(rig, WEIGHTS, size=SIZE, turn=turn))
    camera = film_camera(rig, WEIGHTS, "front", SIZE, turn)
    with Stage(rig.neutral, camera, size=SIZE, occlusion=16) as stage:
        for frame, (weight,), (yaw, pitch, roll) in zip(frames, WEIGHTS, ANGLES, strict=True):
            x, y, z = (rig.pose({"nose": weight}) - neck).T
            x, y = x * np.cos(roll) + y * np.sin(roll), y * np.cos(roll) - x * np.sin(roll)
            y, z = y * np.cos(pitch) - z * np.sin(pitch), z * np.cos(pitch) + y * np.sin(pitch)
            x, z = x * np.cos(yaw) - z * np.sin(yaw), z * np.cos(yaw) + x * np.sin(yaw)
            drawn = stage.picture(np.column_stack([x, y, z]) + neck)
            assert np.abs(frame.astype(int) - drawn).max() <= 2
    assert (frames[1] == frames[2]).all()
    apart = np.abs(frames[1].astype(int) - frames[3]).mean()
    assert apart > 2, "a frame that turns otherwise is drawn again"


def test_the_whole_head_is_seen_wherever_it_turns(rig: em.Rig) -> None:
    """The nose of a head in profile reaches farther aside than anything of a still one."""
    turn = HeadTurn(neck_of(rig.neutral, rig.morphs.values()), ANGLES)
    camera = film_camera(rig, WEIGHTS, "front", SIZE, turn)
    for number, (weight,) in enumerate(WEIGHTS):
        seen = camera.seen(turn.of(rig.pose({"nose": weight}), number), SIZE)
        assert (seen >= 0).all()
        assert (seen <= SIZE).all()


def test_an_upright_head_is_drawn_as_one_without_angles(rig: em.Rig) -> None:
    turn = HeadTurn(neck_of(rig.neutral, rig.morphs.values()), 0 * ANGLES)
    plain, upright = (list(film_frames(rig, WEIGHTS, size=SIZE, turn=t)) for t in (None, turn))
    for one, other in zip(plain, upright, strict=True):
        assert np.abs(one.astype(int) - other).max() <= 2


def test_a_strip_turns_too(rig: em.Rig) -> None:
    take = em.Performance(["nose"], np.arange(4.0), WEIGHTS, 1)
    turn = HeadTurn(neck_of(rig.neutral, rig.morphs.values()), ANGLES)
    still = take_strip(rig, take, WEIGHTS, face=SIZE)
    turned = take_strip(rig, take, WEIGHTS, face=SIZE, turn=turn)
    assert still.shape == turned.shape
    assert np.abs(still.astype(int) - turned).mean() > 2
