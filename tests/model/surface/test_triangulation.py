"""Polygons are split where their diagonals are shortest, and ties never decide anything."""

from __future__ import annotations

import numpy as np
import pytest

import elastomorph as em
from elastomorph.model.surface import triangulate


def areas(mesh: em.Mesh) -> np.ndarray:
    split = triangulate(mesh)
    a, b, c = np.moveaxis(mesh.vertices[split.triangles], 1, 0)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1) * split.shares


def test_a_quad_is_split_along_its_shorter_diagonal():
    kite = em.Mesh(vertices=[[-1, 0, 0], [0, -3, 0], [1, 0, 0], [0, 3, 0]], faces=[[0, 1, 2, 3]])
    split = triangulate(kite)
    assert split.shares.tolist() == [1, 1]
    assert all({0, 2} <= set(triangle) for triangle in split.triangles.tolist())


def test_a_rectangle_has_both_splits_at_half_weight():
    rectangle = em.Mesh(vertices=[[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]], faces=[[0, 1, 2, 3]])
    split = triangulate(rectangle)
    assert split.shares.tolist() == [0.5] * 4
    assert areas(rectangle).sum() == pytest.approx(2)


@pytest.mark.parametrize("size", [3, 4, 5, 6, 9])
def test_convex_polygons_keep_their_area_and_winding(size):
    angle = np.sort(np.random.default_rng(size).uniform(0, 2 * np.pi, size))
    points = np.stack([2 * np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    mesh = em.Mesh(vertices=points, faces=[list(range(size))])
    x, y = points[:, 0], points[:, 1]
    shoelace = 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))
    assert areas(mesh).sum() == pytest.approx(shoelace)
    a, b, c = np.moveaxis(points[triangulate(mesh).triangles], 1, 0)
    assert (np.cross(b - a, c - a)[:, 2] >= 0).all()


def test_a_regular_polygon_is_split_alike_from_every_corner():
    angle = np.arange(7) * 2 * np.pi / 7
    points = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    split = triangulate(em.Mesh(vertices=points, faces=[list(range(7))]))
    weight = np.bincount(split.triangles.ravel(), np.repeat(split.shares, 3), minlength=7)
    assert weight == pytest.approx(np.full(7, 15 / 7))  # 5 triangles of 3 corners each


def test_polygons_of_the_same_vertices_count_once():
    points = [[0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 1, 0]]
    once = em.Mesh(vertices=points, faces=[[0, 1, 2, 3]])
    twice = em.Mesh(vertices=points, faces=[[0, 1, 2, 3], [2, 3, 0, 1], [3, 2, 1, 0]])
    assert areas(twice).sum() == areas(once).sum()


def test_triangles_that_name_a_vertex_twice_are_left_out():
    mesh = em.Mesh(vertices=[[0, 0, 0], [1, 0, 0], [0, 1, 0]], faces=[[0, 1, 1], [0, 1, 2, 2]])
    split = triangulate(mesh)
    assert {tuple(sorted(triangle)) for triangle in split.triangles.tolist()} == {(0, 1, 2)}
