"""Edges drawn over photographs lie where the camera sees them, and hidden ones are not drawn."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import elastomorph as em
from elastomorph.capturing.geometry import Camera
from elastomorph.draw.over_photographs import box_of, over_photograph
from needs import extra

extra("cv2", "capture")
extra("embreex", "capture")

SIZE = (160, 120)
GREY = 90


def camera(turn: float = 0.0, size: tuple[int, int] = SIZE) -> Camera:
    """Ten before the origin, with y upwards in the world."""
    c, s = np.cos(turn), np.sin(turn)
    rotation = np.diag([1.0, -1.0, -1.0]) @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
    centre = (np.array(size) - 1) / 2
    return Camera("a.jpg", size, 200.0, centre, 0.0, rotation, np.array([0.0, 0, 10]))


def photograph(own: Camera) -> np.ndarray:
    return np.full((own.size[1], own.size[0], 3), GREY, np.uint8)


def cube(side: float = 2.0) -> em.Mesh:
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * side / 2
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return em.Mesh(corners, faces)


def drawn(picture: NDArray[np.uint8]) -> NDArray[np.bool_]:
    return np.abs(picture.astype(int) - GREY).max(axis=-1) > 40


def distance_to_edge(mesh: em.Mesh, own: Camera, edge: int, pixels: NDArray[np.float64]):
    """(N,) from pixels to the line of an edge in the picture."""
    one, other = own.project(mesh.vertices[mesh.edges[edge]])[0]
    way = other - one
    along = np.clip((pixels - one) @ way / (way @ way), 0, 1)
    return np.linalg.norm(pixels - one - along[:, None] * way, axis=1)


def test_a_cube_shows_nine_of_its_edges() -> None:
    """From where three sides are seen; the three edges of the hidden corner are not drawn."""
    mesh = cube()
    turned = camera(0.5)
    tilt = np.array([[1, 0, 0], [0, np.cos(0.4), -np.sin(0.4)], [0, np.sin(0.4), np.cos(0.4)]])
    own = Camera("a", SIZE, 200.0, turned.centre, 0.0, tilt @ turned.rotation, turned.translation)
    found = drawn(over_photograph(photograph(own), own, mesh))
    rows, columns = np.nonzero(found)
    pixels = np.stack([columns, rows], axis=1).astype(float)
    near = np.array([distance_to_edge(mesh, own, edge, pixels) for edge in range(12)])
    depths = own.project(mesh.vertices)[1]
    hidden = (mesh.edges == depths.argmax()).any(axis=1)
    assert near[~hidden].min(axis=0).max() < 1.6, "nothing is drawn elsewhere"
    for edge in np.flatnonzero(~hidden):
        ends = own.project(mesh.vertices[mesh.edges[edge]])[0]
        middle = ends.mean(axis=0).round().astype(int)
        assert found[middle[1] - 1 : middle[1] + 2, middle[0] - 1 : middle[0] + 2].any()
    for edge in np.flatnonzero(hidden):
        middle = own.project(mesh.vertices[mesh.edges[edge]])[0].mean(axis=0).round().astype(int)
        away = [distance_to_edge(mesh, own, other, middle[None])[0] for other in range(12)]
        if min(away[other] for other in np.flatnonzero(~hidden)) > 4:
            assert not found[middle[1] - 1 : middle[1] + 2, middle[0] - 1 : middle[0] + 2].any()


def test_a_line_is_where_it_is_to_a_fraction_of_a_pixel() -> None:
    """The upper edge of a square, whose height in the picture is known."""
    mesh = em.Mesh([[-2, -1, 0], [2, -1, 0], [2, 1.2345, 0], [-2, 1.2345, 0]], [[0, 1, 2, 3]])
    own = camera()
    picture = over_photograph(photograph(own), own, mesh, strength=1.0, line=(1.0, 1.0, 1.0))
    column = picture[: SIZE[1] // 2, SIZE[0] // 2, 0].astype(float) - GREY
    found = (column * np.arange(len(column))).sum() / column.sum()
    assert found == pytest.approx(own.centre[1] - 200 * 1.2345 / 10, abs=0.1)
    assert 0.9 < column.sum() / (255 - GREY) < 1.5, "about a pixel wide"


def test_a_box_is_the_same_part_of_the_picture() -> None:
    own = camera(0.3)
    box = box_of(own, cube(1.0).vertices)
    left, top, right, bottom = box
    whole = over_photograph(photograph(own), own, cube(), strength=0.7)
    part = over_photograph(photograph(own), own, cube(), strength=0.7, box=box)
    np.testing.assert_array_equal(part, whole[top:bottom, left:right])
    pixels = own.project(cube(1.0).vertices)[0]
    assert (pixels >= [left, top]).all()
    assert (pixels <= [right - 1, bottom - 1]).all()


def test_colours_are_those_of_the_vertices() -> None:
    mesh = cube()
    colours = np.where(mesh.vertices[:, :1] > 0, [[1.0, 0, 0]], [[0, 0, 1.0]])
    picture = over_photograph(photograph(camera()), camera(), mesh, colours=colours, strength=1.0)
    upright = picture[50:70].astype(int)  # between the edges that run across
    left, right = upright[:, : SIZE[0] // 2], upright[:, SIZE[0] // 2 :]
    assert left[..., 2].max() > 220
    assert left[..., 0].max() <= GREY
    assert right[..., 0].max() > 220
    assert right[..., 2].max() <= GREY


def test_dense_edges_cover_less_and_the_photograph_is_left_alone() -> None:
    own = camera()
    picture = photograph(own)
    few, many = (over_photograph(picture, own, fan(count)) for count in (2, 80))
    assert np.abs(few.astype(int) - GREY).max() > 1.5 * np.abs(many.astype(int) - GREY).max()
    assert (picture == GREY).all()


def fan(count: int) -> em.Mesh:
    """A square of (count, count) polygons."""
    x, y = np.meshgrid(np.linspace(-1, 1, count + 1), np.linspace(-1, 1, count + 1))
    number = np.arange((count + 1) ** 2).reshape(count + 1, count + 1)
    corners = [number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]]
    vertices = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
    return em.Mesh(vertices, np.stack(corners, axis=-1).reshape(-1, 4))


def test_a_mesh_behind_the_camera_or_beside_the_picture_is_not_drawn() -> None:
    own = camera()
    picture = photograph(own)
    for shift in ([0, 0, 30], [40, 0, 0]):
        moved = cube().with_vertices(cube().vertices + shift)
        np.testing.assert_array_equal(over_photograph(picture, own, moved), picture)
    assert box_of(own, cube().vertices + [0, 0, 30]) == (0, 0, *SIZE)
