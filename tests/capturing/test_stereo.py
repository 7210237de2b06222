"""The pieces of the neutral's surface: pairs, offsets, curved triangles, parts, robust points."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from elastomorph.capturing.geometry import (
    Camera,
    Parts,
    Surface,
    View,
    along_normals,
    robust,
    to_points,
)
from elastomorph.capturing.neutral import curved, offsets_from, pairs_of
from elastomorph.errors import CaptureError
from needs import extra

extra("cv2", "capture")
extra("embreex", "capture")


def plane(count: int = 13, size: float = 3.0) -> Surface:
    """A square in z = 0, seen from above."""
    x, y = np.meshgrid(np.linspace(-size, size, count), np.linspace(-size, size, count))
    rows = np.arange(count * (count - 1)).reshape(count - 1, count)[:, :-1].ravel()
    a, b, c, d = rows, rows + 1, rows + count + 1, rows + count
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return Surface(np.stack([x, y, 0 * x], -1).reshape(-1, 3), triangles)


def camera(x: float) -> Camera:
    """Ten above the plane, looking at its middle."""
    position = np.array([x, 0.0, 10.0])
    forward = -position / np.linalg.norm(position)
    down = np.array([0.0, -1.0, 0.0])
    across = np.cross(down, forward)
    rotation = np.stack([across, np.cross(forward, across), forward])
    centre = np.array([149.5, 149.5])
    return Camera(str(x), (300, 300), 400.0, centre, 0.0, rotation, -rotation @ position)


def photograph(camera: Camera, height: float) -> View:
    """Of a plane with a pattern at a height."""
    rays = camera.directions()
    far = (height - camera.position[2]) / rays[..., 2]
    x, y, _ = np.moveaxis(camera.position + far[..., None] * rays, -1, 0)
    random = np.random.default_rng(0)
    grey = np.full(x.shape, 128.0)
    for _ in range(40):
        a, b, c = random.uniform(-9, 9, 3)
        grey += 8 * np.sin(a * x + b * y + c)
    return View(camera, np.clip(grey, 0, 255).astype(np.uint8), None)


@pytest.mark.parametrize("height", [0.0, 0.04, -0.06])
def test_a_plane_is_found_where_it_was_photographed(height):
    """A pixel shows 0.025; the height is found to a tenth of what one pixel of flow means."""
    surface = plane()
    crops = [photograph(camera(x), height) for x in (-2.0, 0.0, 2.0)]
    pairs = pairs_of([crop.camera for crop in crops], np.zeros(3), 1)
    found = offsets_from(crops, surface, np.ones(len(surface.vertices), bool), pairs, 0.01)
    inner = np.abs(surface.vertices[found.vertices, :2]).max(axis=1) < 2.4
    assert len(np.unique(found.vertices[inner])) > 50
    assert found.offsets[inner] == pytest.approx(height, abs=0.02)
    assert np.median(found.offsets[inner]) == pytest.approx(height, abs=0.004)
    assert (found.weights > 0).all()
    assert (found.weights <= 1).all()


def test_vertices_that_were_not_asked_about_are_not_answered():
    surface = plane()
    crops = [photograph(camera(x), 0.0) for x in (-2.0, 2.0)]
    chosen = surface.vertices[:, 0] > 0
    found = offsets_from(crops, surface, chosen, [(0, 1), (1, 0)], 0.01)
    assert len(found.vertices) > 0
    assert chosen[found.vertices].all()


def test_pairs_are_the_nearest_by_angle():
    cameras = [camera(x) for x in (-6.0, -2.0, 0.0, 0.1, 3.0, 40.0)]
    found = pairs_of(cameras, np.zeros(3), 1)
    # The third and fourth stand at half a degree, and the last at 45° or more from all others.
    assert found == [(0, 1), (1, 2), (2, 1), (3, 1), (4, 3)]


def test_curved_triangles_of_a_ball_are_nearly_on_it():
    count = 12
    around, down = np.meshgrid(
        np.linspace(0, 2 * np.pi, 2 * count, endpoint=False), np.linspace(0.4, 2.7, count)
    )
    points = np.stack(
        [np.sin(down) * np.cos(around), np.sin(down) * np.sin(around), np.cos(down)], -1
    ).reshape(-1, 3)
    index = np.arange(len(points)).reshape(count, 2 * count)
    a, b = index[:-1].ravel(), np.roll(index, -1, 1)[:-1].ravel()
    c, d = np.roll(index, -1, 1)[1:].ravel(), index[1:].ravel()
    triangles = np.concatenate([np.stack([a, d, c], 1), np.stack([a, c, b], 1)])
    ball = Surface(points, triangles)
    fine = curved(ball)
    assert len(fine.triangles) == 4 * len(triangles)
    np.testing.assert_array_equal(fine.vertices[: len(points)], points)
    middles = fine.vertices[len(points) :]
    inner = np.abs(middles[:, 2]) < 0.6  # at the two borders normals lean
    flat = 1 - np.cos(np.pi / 24)  # how far the middle of an edge of the ball lies below it
    below = 1 - np.linalg.norm(middles[inner], axis=1)
    assert np.abs(below).max() < 0.3 * flat
    level = curved(plane())
    np.testing.assert_allclose(level.vertices[:, 2], 0, atol=1e-15)
    assert np.linalg.norm(level.face_normals, axis=1).sum() == pytest.approx(72)


def test_parts_go_with_the_skin():
    """A tetrahedron above a plane keeps its shape; a loose triangle moves as what is below it."""
    skin = plane()
    count = len(skin.vertices)
    tooth = np.array([[0, 0, 0.3], [0.2, 0, 0.3], [0, 0.2, 0.3], [0, 0, 0.6]])
    lash = np.array([[2.5, 2.5, 0.0], [2.5, 2.0, 0.0], [2.0, 2.5, 0.1]])
    closed = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]) + count
    open_ = np.array([[0, 1, 2]]) + count + 4
    rest = np.concatenate([skin.vertices, tooth, lash])
    parts = Parts.of(rest, np.concatenate([skin.triangles, closed, open_]), [0, 5, 9])
    np.testing.assert_array_equal(parts.skin, np.arange(count))
    assert len(parts.solid) == 1
    bent = skin.vertices + [1.0, 0, 0]
    bent[:, 2] += 0.2 * bent[:, 1]
    moved = parts.carried(bent)
    np.testing.assert_array_equal(moved[:count], bent)
    before, after = (np.linalg.norm(x[:, None] - x, axis=2) for x in (tooth, moved[count:][:4]))
    np.testing.assert_allclose(after, before, atol=1e-12)
    assert moved[count : count + 4, 0].mean() == pytest.approx(tooth[:, 0].mean() + 1, abs=0.1)
    np.testing.assert_allclose(moved[count + 4], lash[0] + [1, 0, 0.5], atol=1e-6)
    with pytest.raises(CaptureError, match="spread over 3 parts"):
        Parts.of(rest, np.concatenate([skin.triangles, closed, open_]), [0, count, count + 4])


@given(st.floats(0.01, 10), st.floats(-5, 5))
def test_robust_weights_are_those_of_geman_and_mcclure(width, residual):
    """w r is the derivative of r² / (2 (1 + r²/width²))."""

    def cost(r: float) -> float:
        return r**2 / (1 + (r / width) ** 2) / 2

    step = 1e-6 * width
    slope = (cost(residual + step) - cost(residual - step)) / (2 * step)
    assert robust(np.array(residual), width) * residual == pytest.approx(slope, abs=1e-6, rel=1e-5)


def test_points_draw_the_triangles_below_them():
    surface = plane()
    random = np.random.default_rng(1)
    points = random.uniform(-2.9, 2.9, (4000, 3))
    points[:, 2] = 0.1
    points[::10, 2] = 2.0  # farther than the reach
    everywhere = np.ones(len(surface.vertices), dtype=bool)
    quadratic, linear = to_points(surface, points, everywhere, width=1.0, reach=0.5)
    pull = quadratic[:, 2, 2]
    assert (np.abs(surface.vertices[pull == 0][:, :2]).max(axis=1) > 2.5).all()
    np.testing.assert_allclose(linear[pull > 0, 2] / pull[pull > 0], 0.1)
    weights = robust(np.array(0.1), 1.0)
    assert pull.sum() < 3600 * weights
    right = surface.vertices[:, 0] > 1
    some = to_points(surface, points, right, width=1.0, reach=0.5)[0]
    assert (some[surface.vertices[:, 0] < 0] == 0).all()


def test_terms_along_normals_have_their_least_at_the_offset():
    surface = plane()
    offsets = np.linspace(-1, 1, len(surface.vertices))
    quadratic, linear = along_normals(surface, np.full(len(offsets), 2.0), offsets)
    goal = surface.vertices + offsets[:, None] * surface.normals
    np.testing.assert_allclose(np.einsum("nij,nj->ni", quadratic, goal), linear, atol=1e-12)
    np.testing.assert_allclose(np.trace(quadratic, axis1=1, axis2=2), 2)
