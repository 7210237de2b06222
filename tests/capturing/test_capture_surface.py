"""Rays and closest points against plain formulas on every triangle."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from elastomorph.capturing.geometry import Camera, Surface, closest_weights


def soup(seed: int, count: int = 60) -> Surface:
    """Triangles of very different sizes, some of them thin."""
    random = np.random.default_rng(seed)
    middles = random.normal(size=(count, 1, 3)) * 2
    corners = middles + random.normal(size=(count, 3, 3)) * random.uniform(0.01, 2, (count, 1, 1))
    return Surface(corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3))


def ball(rings: int = 24) -> Surface:
    """A sphere of radius 1."""
    around, down = np.meshgrid(
        np.linspace(0, 2 * np.pi, 2 * rings, endpoint=False), np.linspace(0.01, np.pi - 0.01, rings)
    )
    vertices = np.stack(
        [np.sin(down) * np.cos(around), np.cos(down), np.sin(down) * np.sin(around)], axis=-1
    ).reshape(-1, 3)
    index = np.arange(2 * rings * rings).reshape(rings, 2 * rings)
    a, b = index[:-1], index[1:]
    c, d = np.roll(a, -1, axis=1), np.roll(b, -1, axis=1)
    triangles = np.concatenate([np.stack(t, -1).reshape(-1, 3) for t in ((a, c, b), (c, d, b))])
    return Surface(vertices, triangles)


@given(seed=st.integers(0, 1000))
def test_closest_points_are_the_closest_of_all_triangles(seed):
    surface = soup(seed)
    points = np.random.default_rng(seed + 1).normal(size=(15, 3)) * 3
    found = surface.closest(points)
    count = len(surface.triangles)
    corners = np.tile(surface.vertices[surface.triangles], (len(points), 1, 1))
    weights = closest_weights(np.repeat(points, count, axis=0), corners)
    places = np.einsum("ni,nij->nj", weights, corners)
    distances = np.linalg.norm(places - np.repeat(points, count, axis=0), axis=1)
    np.testing.assert_allclose(
        found.distances, distances.reshape(-1, count).min(axis=1), rtol=1e-9, atol=1e-12
    )
    np.testing.assert_allclose(surface.at(found, surface.vertices), found.points, atol=1e-12)


@given(seed=st.integers(0, 1000))
def test_no_point_of_the_triangle_is_closer(seed):
    """Against a fine grid of weights, which can only be farther."""
    random = np.random.default_rng(seed)
    corners, point = random.normal(size=(1, 3, 3)), random.normal(size=(1, 3)) * 2
    u, v = np.meshgrid(np.linspace(0, 1, 60), np.linspace(0, 1, 60))
    grid = np.stack([1 - u - v, u, v], axis=-1)[u + v <= 1]
    far = np.linalg.norm(grid @ corners[0] - point, axis=1).min()
    weights = closest_weights(point, corners)
    assert weights.sum() == pytest.approx(1)
    assert weights.min() >= 0
    mine = np.linalg.norm(weights[0] @ corners[0] - point[0])
    assert mine <= far + 1e-12
    assert mine >= far - 0.1


def test_rays_meet_the_ball_where_a_formula_says():
    surface = ball(80)
    camera = Camera(
        "a", (40, 40), 60.0, np.array([19.5, 19.5]), 0.0, np.eye(3), np.array([0, 0, 4.0])
    )
    hits = surface.seen(camera)
    directions = camera.directions()
    length = np.linalg.norm(directions, axis=-1)
    unit = directions / length[..., None]
    along = unit @ -camera.position
    inside = along**2 - (camera.position @ camera.position - 1)
    sure = np.abs(inside) > 0.01
    np.testing.assert_array_equal(hits.met[sure], (inside > 0)[sure])
    wanted = (along - np.sqrt(np.maximum(inside, 0))) / length
    np.testing.assert_allclose(hits.depths[inside > 0.05], wanted[inside > 0.05], atol=0.01)
    places = camera.position + hits.depths[hits.met][:, None] * directions[hits.met]
    np.testing.assert_allclose(surface.at(hits, surface.vertices)[hits.met], places, atol=1e-4)


def test_a_camera_sees_the_half_that_faces_it():
    surface = ball()
    camera = Camera(
        "a", (400, 400), 600.0, np.array([199.5, 199.5]), 0.0, np.eye(3), np.array([0, 0, 4.0])
    )
    seen, cosines = surface.visible(
        camera, surface.vertices, surface.normals, least_cosine=0.1, tolerance=0.02
    )
    np.testing.assert_array_equal(seen, cosines > 0.1)
    assert seen.any()
    assert (surface.vertices[seen, 2] < -0.25).all()
    hidden, _ = Surface(
        np.concatenate([surface.vertices, [[-9, -9, -2], [9, -9, -2], [0, 9, -2.0]]]),
        np.concatenate([surface.triangles, len(surface.vertices) + np.arange(3)[None]]),
    ).visible(camera, surface.vertices, surface.normals, least_cosine=0.1, tolerance=0.02)
    assert not hidden.any()


def test_normals_of_a_ball_point_outwards():
    surface = ball()
    np.testing.assert_allclose(surface.normals, surface.vertices, atol=0.1)


@given(seed=st.integers(0, 1000))
def test_rays_are_free_where_they_meet_nothing(seed):
    surface = soup(seed)
    random = np.random.default_rng(seed)
    starts, ways = random.normal(size=(2, 5, 8, 3))
    free = surface.free(starts, ways)
    np.testing.assert_array_equal(free, ~surface.cast(starts, ways).met)
