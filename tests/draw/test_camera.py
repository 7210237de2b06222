"""A camera sees what it is given, and nothing wasted."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from elastomorph.draw.camera import VIEWS, Camera
from elastomorph.errors import ParameterError
from scenes import seen_at


@settings(max_examples=60, deadline=None)
@given(
    st.integers(0, 10_000),
    st.sampled_from([*VIEWS, (17.0, -23.0)]),
    st.sampled_from([(720, 900), (900, 500), (64, 64)]),
    st.sampled_from([0.0, 0.04, 0.2]),
)
def test_points_fill_the_picture_in_one_direction_and_fit_in_the_other(
    seed: int, view: object, size: tuple[int, int], margin: float
) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(50, 3)) * rng.uniform(0.1, 10, 3) + rng.normal(size=3) * 100
    camera = Camera.framing(points, view, size=size, margin=margin)  # type: ignore[arg-type]
    seen = seen_at(camera, points, size) / size
    low, high = seen.min(axis=0), seen.max(axis=0)
    assert (low >= margin - 1e-9).all()
    assert (high <= 1 - margin + 1e-9).all()
    np.testing.assert_allclose(low + high, 1, atol=1e-6)  # centred both ways
    assert (high - low).max() == pytest.approx(1 - 2 * margin)


def test_front_looks_along_z_with_y_up() -> None:
    camera = Camera.framing([[-1, -1, 0], [1, 1, 0]], "front", size=(100, 100))
    (left,) = seen_at(camera, np.array([-1.0, 0, 0]), (100, 100))
    (top,) = seen_at(camera, np.array([0.0, 1, 0]), (100, 100))
    assert left[0] < 50
    assert top[1] < 50
    np.testing.assert_allclose(np.array(camera.position)[:2], 0, atol=1e-12)
    assert camera.position[2] > 0


def test_side_sees_the_nose_on_the_left() -> None:
    camera = Camera.framing([[0, 0, -1], [0, 1, 1]], "side", size=(100, 100))
    (nose,) = seen_at(camera, np.array([0.0, 0.5, 1.0]), (100, 100))
    assert nose[0] < 50
    assert camera.position[0] > 0


def test_one_point_can_be_framed() -> None:
    camera = Camera.framing([[3.0, 4.0, 5.0]], size=(10, 10))
    np.testing.assert_allclose(seen_at(camera, np.array([3.0, 4.0, 5.0]), (10, 10)), [[5, 5]])


def test_points_move_towards_the_camera_along_their_ray() -> None:
    points = np.random.default_rng(1).normal(size=(20, 3))
    camera = Camera.framing(points, "three-quarter", size=(50, 60))
    moved = camera.towards(points, 0.01)
    np.testing.assert_allclose(
        seen_at(camera, moved, (50, 60)), seen_at(camera, points, (50, 60)), atol=1e-9
    )
    distance = np.linalg.norm(np.subtract(camera.position, camera.focus))
    np.testing.assert_allclose(np.linalg.norm(moved - points, axis=1), 0.01 * distance)


@pytest.mark.parametrize(
    ("points", "options"),
    [
        (np.zeros((0, 3)), {}),
        ([[0, 0, np.nan]], {}),
        ([[0, 0, 0]], {"view": "behind"}),
        ([[0, 0, 0]], {"size": (0, 10)}),
        ([[0, 0, 0]], {"margin": 0.5}),
    ],
)
def test_what_cannot_be_framed_is_refused(points: object, options: dict[str, object]) -> None:
    with pytest.raises(ParameterError):
        Camera.framing(points, **options)  # type: ignore[arg-type]
