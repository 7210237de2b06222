"""Pictures of dragged faces: rings where handles should be, lines to there, distances left."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from elastomorph.draw import Camera, drag_picture
from elastomorph.draw.posed import LINE, RING
from elastomorph.errors import MeshError, ParameterError
from scenes import ball, seen_at

FACE = (64, 80)


def near(picture: np.ndarray, colour: tuple[int, int, int]) -> np.ndarray:
    """(H, W) pixels of about this colour."""
    return np.asarray(np.abs(picture.astype(int) - colour).max(axis=-1) < 40)


def test_a_point_is_seen_where_the_projection_has_it() -> None:
    points = np.random.default_rng(0).normal(size=(9, 3))
    camera = Camera.framing(points, (40.0, 10.0), size=FACE)
    np.testing.assert_allclose(camera.seen(points, FACE), seen_at(camera, points, FACE))


def test_rings_and_lines_show_what_is_left(tmp_path: Path) -> None:
    """A line from where the handle is to its ring; none, and no distance, where it has arrived."""
    mesh = ball()
    goal = mesh.vertices[3] + [0.0, 0.6, 0.0]
    arrived = mesh.vertices.copy()
    arrived[3] = goal
    path = tmp_path / "drag.png"
    picture = drag_picture(
        mesh, {"top": goal}, {"rest": mesh.vertices, "there": arrived}, path,
        landmarks={"top": 3}, face=FACE,
    )  # fmt: skip
    np.testing.assert_array_equal(np.asarray(Image.open(path)), picture)
    half = picture.shape[1] // 2
    rest, there = picture[: FACE[1] + 20, :half], picture[: FACE[1] + 20, half:]
    assert near(rest, LINE).any()
    assert not near(there, LINE).any()
    assert near(rest, RING).any()
    assert near(there, RING).any()


def test_a_goal_far_away_and_points_between_vertices_are_in_the_picture() -> None:
    mesh = ball()
    between = ((3, 4), (0.5, 0.5))
    far = mesh.vertices[[3, 4]].mean(axis=0) + [4.0, 0.0, 0.0]
    picture = drag_picture(
        mesh, {between: far}, {"rest": mesh.vertices}, face=FACE, views=["front", "side"]
    )
    assert near(picture[: FACE[1] + 20], RING).any()


def test_what_cannot_be_drawn_is_refused() -> None:
    mesh = ball()
    handles = {0: mesh.vertices[0]}
    with pytest.raises(ParameterError, match="at least one face and one view"):
        drag_picture(mesh, handles, {})
    with pytest.raises(ParameterError, match="at least one face and one view"):
        drag_picture(mesh, handles, {"rest": mesh.vertices}, views=[])
    with pytest.raises(MeshError, match="'cut' needs 266 vertices, found 265"):
        drag_picture(mesh, handles, {"rest": mesh.vertices, "cut": mesh.vertices[1:]})
