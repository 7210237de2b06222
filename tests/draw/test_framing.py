"""Heads are framed without their shoulders, and close-ups come close."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from elastomorph.draw.camera import Camera, Turntable, camera_for, drawn_vertices, turn_angles
from elastomorph.draw.stage import BACKGROUND, Stage
from elastomorph.errors import ParameterError
from elastomorph.model.mesh import Mesh
from scenes import ball, joined, seen_at
from small_head import head

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


TURNED = (120, 150)
PAPER = np.rint(np.array(BACKGROUND) * 255)


def _covered(image: NDArray[np.uint8]) -> NDArray[np.bool_]:
    return (np.abs(image.astype(float) - PAPER) > 8).any(axis=2)


def test_whole_turns_leave_out_the_angle_that_is_the_first_again() -> None:
    np.testing.assert_allclose(turn_angles(4), [0, 90, 180, 270])
    np.testing.assert_allclose(turn_angles(4, -720), [0, -180, -360, -540])
    np.testing.assert_allclose(turn_angles(4, 90), [0, 30, 60, 90])
    np.testing.assert_allclose(turn_angles(1, 90), [0])


@pytest.mark.parametrize(("count", "degrees"), [(0, 360), (3, 0), (3, np.nan), (3, np.inf)])
def test_turns_that_are_none(count: int, degrees: float) -> None:
    with pytest.raises(ParameterError):
        turn_angles(count, degrees)


@given(st.floats(-400, 400), st.floats(-1, 1), st.floats(-1, 1))
def test_turning_keeps_heights_and_distances_from_the_axis_and_adds_up(
    degrees: float, x: float, z: float
) -> None:
    table = Turntable(Camera((0, 0, 9), (0, 0, 0), (0, 1, 0)), (x, z))
    points = np.random.default_rng(0).normal(size=(20, 3))
    turned = table.turned(points, degrees)
    np.testing.assert_allclose(turned[:, 1], points[:, 1])
    radii = [np.hypot(each[:, 0] - x, each[:, 2] - z) for each in (points, turned)]
    np.testing.assert_allclose(radii[1], radii[0], atol=1e-12)
    np.testing.assert_allclose(table.turned(turned, -degrees), points, atol=1e-12)
    np.testing.assert_allclose(
        table.turned(turned, 90), table.turned(points, degrees + 90), atol=1e-12
    )


def test_a_turn_to_the_left_shows_what_the_camera_to_the_left_sees() -> None:
    """The three-quarter view by angle, up to where the picture is centred: the same directions."""
    ball_mesh = ball()
    table = Turntable.around(ball_mesh, [0.0, 35.0], size=TURNED)
    aside = Camera.framing(ball_mesh.vertices, (35.0, 0.0), size=TURNED)
    turned = table.turned(ball_mesh.vertices, 35.0)
    np.testing.assert_allclose(
        seen_at(table.camera, turned, TURNED),
        seen_at(aside, ball_mesh.vertices, TURNED),
        atol=0.6,
    )


def test_everything_is_seen_at_every_angle_and_something_reaches_the_margin() -> None:
    mesh = joined(skin=ball(1.0), lips=ball(0.3, (0.2, -0.4, 1.5)))
    angles = turn_angles(36)
    table = Turntable.around(mesh, angles, size=TURNED, margin=0.05)
    seen = np.concatenate(
        [seen_at(table.camera, table.turned(mesh.vertices, a), TURNED) for a in angles.tolist()]
    )
    share = seen / np.array(TURNED)
    assert share.min() >= 0.05 - 1e-6
    assert share.max() <= 0.95 + 1e-6
    assert min(share.min(), 1 - share.max()) == pytest.approx(0.05, abs=1e-6)


def test_of_a_ball_the_first_frame_is_the_still_from_the_front(sphere: Mesh) -> None:
    """Nothing else of a ball is seen from elsewhere, so no room is needed for it either."""
    table = Turntable.around(sphere, turn_angles(24), size=TURNED)
    still = camera_for(sphere, size=TURNED)
    np.testing.assert_allclose(table.camera.position, still.position, atol=0.01)
    with (
        Stage(sphere, table.camera, size=TURNED) as one,
        Stage(sphere, still, size=TURNED) as other,
    ):
        first = one.picture(table.turned(sphere.vertices, 0.0)).astype(int)
        assert np.abs(first - other.picture()).mean() < 0.5


def test_the_head_turns_from_its_face_over_its_left_to_its_back() -> None:
    """Frame 0 is the front, frame N/2 has no lips, and k and N - k are mirror images."""
    mesh, angles = head(), turn_angles(8)
    table = Turntable.around(mesh, angles, size=TURNED)
    with Stage(mesh, table.camera, size=TURNED) as stage:
        frames = [stage.picture(table.turned(mesh.vertices, a)) for a in angles.tolist()]
        front = stage.picture()
    np.testing.assert_array_equal(frames[0], front)
    outlines = [_covered(frame) for frame in frames]
    for number in (1, 2, 3):
        same = outlines[number] == outlines[8 - number][:, ::-1]
        assert same.mean() > 0.99
        assert (outlines[number] == outlines[8 - number]).mean() < 0.97

    def reds(image: NDArray[np.uint8]) -> int:
        """Pixels of lips: their red is farther from their green than that of skin."""
        red, green = image[..., 0].astype(float), image[..., 1].astype(float)
        return int((red > 1.35 * green).sum())

    assert reds(frames[0]) > 20
    assert reds(frames[4]) == 0
    # at 90 degrees the camera is on the face's left, so the nose points to the left of the picture
    rows = slice(TURNED[1] // 3, TURNED[1] // 2)
    nose = [np.flatnonzero(outlines[n][rows].any(axis=0)) for n in (2, 6)]
    assert nose[0].min() + nose[1].max() == pytest.approx(TURNED[0] - 1, abs=2)
    z = mesh.vertices[:, 2]
    tip = mesh.vertices[[z.argmax()]]
    assert seen_at(table.camera, table.turned(tip, 90.0), TURNED)[0, 0] < TURNED[0] / 4


def test_a_close_up_cannot_be_turned(sphere: Mesh) -> None:
    with pytest.raises(ParameterError, match="mouth"):
        Turntable.around(sphere, turn_angles(4), "mouth")


def test_a_flat_mesh_turns_too() -> None:
    square = Mesh([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1, 2, 3]])
    table = Turntable.around(square, turn_angles(12), size=TURNED)
    np.testing.assert_allclose(table.turned(square.vertices, 90)[:, 0], 0, atol=1e-12)
