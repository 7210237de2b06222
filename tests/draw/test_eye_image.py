"""Eyes without an iris of their own are given one."""

from __future__ import annotations

import numpy as np

from elastomorph.draw.eyes import SPAN, eye_image, iris_coordinates
from elastomorph.model.mesh import Mesh
from scenes import ball, joined

NONE = np.zeros(0, dtype=np.int64)


def _all(mesh: Mesh) -> np.ndarray:
    return np.arange(len(mesh.faces))


def test_the_pole_of_each_eyeball_shows_the_middle_of_the_image() -> None:
    mesh = joined(left=ball(1.5, (3, 2, 9)), right=ball(1.5, (-3, 2, 9)))
    place = iris_coordinates(mesh, _all(mesh), NONE)
    corners = mesh.vertices[mesh.faces.indices]
    poles = corners[:, 2] == 10.5
    assert poles.sum() == 48
    np.testing.assert_allclose(place[poles], 0.5, atol=1e-12)
    np.testing.assert_array_equal(place[corners[:, 2] <= 9], 0)


def test_image_coordinates_are_the_front_view_in_eyeball_radii() -> None:
    mesh = ball(2.0, (5, 6, 7))
    place = iris_coordinates(mesh, _all(mesh), NONE)
    corners = (mesh.vertices[mesh.faces.indices] - [5, 6, 7]) / 2
    near = (corners[:, 2] > 0) & (np.abs(corners[:, :2]).max(axis=1) < SPAN)
    np.testing.assert_allclose(place[near], 0.5 + corners[near, :2] / (2 * SPAN), atol=1e-12)


def test_flat_shells_and_eyes_with_an_iris_in_front_stay_white() -> None:
    flat = ball()
    flat = flat.with_vertices(flat.vertices * [1, 0.3, 1])
    np.testing.assert_array_equal(iris_coordinates(flat, _all(flat), NONE), 0)
    mesh = joined(eye=ball(), iris=ball(0.3, (0, 0, 0.8)))
    count = len(ball().faces)
    numbers = np.arange(count)
    np.testing.assert_array_equal(iris_coordinates(mesh, numbers, numbers + count), 0)


def test_an_iris_behind_the_white_is_not_seen_and_so_painted() -> None:
    mesh = joined(eye=ball(), iris=ball(0.9))
    count = len(ball().faces)
    numbers = np.arange(count)
    assert iris_coordinates(mesh, numbers, numbers + count).any()


def test_the_image_is_dark_in_the_middle_and_white_at_its_edges() -> None:
    image = eye_image(64).astype(int)
    assert image[31:33, 31:33].max() < 20
    edge = np.concatenate([image[0], image[-1], image[:, 0], image[:, -1]])
    assert edge.min() > 220
    np.testing.assert_array_equal(edge, edge[:1].repeat(len(edge), axis=0))
