"""Heads are framed without their shoulders, and close-ups come close."""

from __future__ import annotations

import numpy as np
import pytest

from elastomorph.draw.framing import camera_for, drawn_vertices
from elastomorph.errors import ParameterError
from elastomorph.model.mesh import Mesh
from scenes import ball, joined, seen_at

SIZE = (200, 250)


@pytest.fixture(scope="module")
def bust() -> Mesh:
    """A ball on a thin neck on broad shoulders."""
    skull, shoulders = ball(1.0, (0, 3.0, 0)), ball(1.0)
    neck = ball(0.5, (0, 1.5, 0))
    wide = shoulders.with_vertices(shoulders.vertices * [3.0, 0.8, 0.8])
    return joined(skin=skull, neck=neck.with_vertices(neck.vertices), chest=wide)


def test_the_head_fills_the_picture_and_the_shoulders_do_not_shrink_it(bust: Mesh) -> None:
    seen = seen_at(camera_for(bust, size=SIZE), bust.vertices, SIZE) / SIZE
    skull = seen[:266]
    assert (skull >= 0).all()
    assert (skull <= 1).all()
    assert np.ptp(skull[:, 1]) > 0.45
    assert np.ptp(seen[:, 0]) > 1.3  # the shoulders reach beyond the picture


def test_a_long_neck_is_cut_below_the_chin() -> None:
    skull = ball(1.0, (0, 3.0, 0.3))
    square = np.array([[1, 0, 1], [1, 0, -1], [-1, 0, -1], [-1, 0, 1]]) * 0.5
    column = Mesh(
        np.concatenate([square + [0, -2, 0], square + [0, 2.5, 0]]),
        [[i, (i + 1) % 4, (i + 1) % 4 + 4, i + 4] for i in range(4)],
    )
    mesh = joined(skin=skull, neck=column)
    seen = seen_at(camera_for(mesh, size=SIZE), mesh.vertices, SIZE) / SIZE
    assert np.ptp(seen[:266, 0]) > 0.8  # the skull fills the width
    assert seen[266:, 1].max() > 1.2  # the neck reaches beyond the picture


def test_what_moves_is_in_the_picture_even_below_the_neck(bust: Mesh) -> None:
    moved = bust.vertices.copy()
    lowest = int(moved[:, 1].argmin())
    moved[lowest, 1] -= 1.0
    camera = camera_for(bust, poses=np.stack([bust.vertices, moved]), size=SIZE)
    (place,) = seen_at(camera, moved[lowest], SIZE) / SIZE
    assert 0 <= place[1] <= 1


def test_every_pose_fits(bust: Mesh) -> None:
    poses = np.stack([bust.vertices, bust.vertices + [0, 2.0, 0]])
    seen = seen_at(camera_for(bust, poses=poses, size=SIZE), poses[1], SIZE) / SIZE
    assert (seen >= 0).all(axis=0)[1]


def test_a_ball_without_shoulders_is_framed_whole(sphere: Mesh) -> None:
    seen = seen_at(camera_for(sphere, size=(100, 100), margin=0.0), sphere.vertices, (100, 100))
    np.testing.assert_allclose(seen.min(axis=0), 0, atol=1e-6)
    np.testing.assert_allclose(seen.max(axis=0), 100, atol=1e-6)


@pytest.mark.parametrize(("view", "name"), [("mouth", "lips"), ("mouth", "teeth"), ("eyes", "eye")])
def test_a_close_up_shows_the_part_it_is_named_for(view: str, name: str) -> None:
    part = ball(0.2, (0.1, 0.3, 0.9))
    mesh = joined(skin=ball(), **{name: part})
    seen = seen_at(camera_for(mesh, view, size=SIZE), part.vertices, SIZE) / SIZE
    assert (seen >= 0).all()
    assert (seen <= 1).all()
    assert np.ptp(seen, axis=0).max() > 0.5


def test_a_close_up_of_a_face_without_names_still_comes_closer(sphere: Mesh) -> None:
    whole = camera_for(sphere, size=SIZE)
    for view in ("mouth", "eyes"):
        near = camera_for(sphere, view, size=SIZE)
        assert near.position[2] < whole.position[2]
    assert camera_for(sphere, "mouth").focus[1] < camera_for(sphere, "eyes").focus[1]


def test_hidden_pieces_do_not_count_as_drawn() -> None:
    mesh = joined(skin=ball(), EyeOcclusion=ball(9.0))
    np.testing.assert_array_equal(drawn_vertices(mesh), np.arange(266))


def test_an_unknown_view_is_refused(sphere: Mesh) -> None:
    with pytest.raises(ParameterError, match="front"):
        camera_for(sphere, "behind")
