"""Cameras: projection, its derivative, distortion and moving the world."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.spatial.transform import Rotation

from elastomorph.capturing.geometry import Camera, Similarity, open_view
from elastomorph.errors import FormatError

RANDOM = np.random.default_rng(8)


def a_camera(radial: float = -0.05) -> Camera:
    turned = Rotation.from_rotvec([0.2, -0.3, 0.1]).as_matrix()
    return Camera(
        "a.jpg", (300, 200), 400.0, np.array([152.0, 97.0]), radial, turned, np.array([1.0, 2, 50])
    )


def points() -> np.ndarray:
    return RANDOM.normal(size=(40, 3)) * 4


def test_projection_by_hand():
    camera = Camera("a", (100, 80), 50.0, np.array([49.5, 39.5]), 0.0, np.eye(3), np.zeros(3))
    pixels, depths = camera.project(np.array([[1.0, 2.0, 10.0]]))
    np.testing.assert_allclose(pixels, [[54.5, 49.5]])
    np.testing.assert_allclose(depths, [10.0])


def test_rays_through_pixels_meet_the_points():
    camera = a_camera()
    places = points()
    pixels, depths = camera.project(places)
    again = camera.position + depths[:, None] * camera.through(pixels)
    np.testing.assert_allclose(again, places, atol=1e-10)
    grid = camera.directions()
    assert grid.shape == (200, 300, 3)
    np.testing.assert_allclose(grid[7, 11], camera.through(np.array([11.0, 7.0])))


def test_jacobian_is_the_derivative():
    camera, places, step = a_camera(), points(), 1e-5
    for axis in range(3):
        there, _ = camera.project(places + step * np.eye(3)[axis])
        here, _ = camera.project(places - step * np.eye(3)[axis])
        np.testing.assert_allclose(
            camera.jacobian(places)[:, :, axis], (there - here) / (2 * step), atol=1e-6
        )


@pytest.mark.parametrize("radial", [-0.05, 0.0, 0.08])
def test_distortion_is_undone(radial):
    camera = a_camera(radial)
    pixels = RANDOM.uniform(0, 200, (50, 2))
    np.testing.assert_allclose(camera.undistorted(camera.distorted(pixels)), pixels, atol=1e-9)


def test_a_moved_world_looks_the_same():
    camera, places = a_camera(), points()
    moving = Similarity(2.5, Rotation.from_rotvec([1, 2, 3]).as_matrix(), np.array([4.0, -5, 6]))
    moved = camera.moved(moving)
    np.testing.assert_allclose(moved.project(moving(places))[0], camera.project(places)[0])
    np.testing.assert_allclose(moved.position, moving(camera.position))


def test_a_photograph_is_undistorted_and_scaled_where_the_camera_says(tmp_path: Path):
    """Bright spots of a distorted photograph come to lie where the camera projects their points."""
    camera = a_camera(-0.08)
    spots = np.array([[60.0, 40], [240, 40], [150, 100], [70, 160], [235, 150]])
    rows, columns = np.mgrid[:200, :300]
    picture = np.zeros((200, 300))
    for x, y in camera.distorted(spots):
        picture += 250 * np.exp(-((columns - x) ** 2 + (rows - y) ** 2) / 8)
    path = tmp_path / "a.png"
    Image.fromarray(picture.clip(0, 255).astype(np.uint8)).save(path)
    for scale in (1.0, 0.5):
        view = open_view(camera, path, scale=scale)
        wanted = (spots + 0.5) * scale - 0.5
        rows, columns = np.mgrid[: view.grey.shape[0], : view.grey.shape[1]]
        for x, y in wanted:
            near = view.grey * (np.hypot(columns - x, rows - y) < 9 * scale)
            found = np.array([(near * columns).sum(), (near * rows).sum()]) / near.sum()
            np.testing.assert_allclose(found, [x, y], atol=0.1)
        assert view.camera.radial == 0


def test_a_photograph_of_another_size_is_refused(tmp_path: Path):
    path = tmp_path / "a.png"
    Image.new("L", (30, 20)).save(path)
    with pytest.raises(FormatError, match="30 × 20 pixels, expected 300 × 200"):
        open_view(a_camera(), path)
    path.write_bytes(b"nothing")
    with pytest.raises(FormatError, match="no picture"):
        open_view(a_camera(), path)
