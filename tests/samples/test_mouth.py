"""Lips and teeth keep apart in every shape, and the red of the lips does not turn over."""

from __future__ import annotations

import numpy as np
import pytest

from elastomorph.samples import expressions, shapes

SHAPES = shapes()
FACES = {**expressions(), **SHAPES}
ROLLED = {"mouthRollLower", "mouthRollUpper"}


def crossings(points, edges, triangles):
    """How many pairs of an edge and a triangle near it cut each other."""
    from scipy.spatial import cKDTree

    start, end = points[edges].swapaxes(0, 1)
    corners = points[triangles]
    reach = np.linalg.norm(end - start, axis=1).max() / 2.0
    reach += np.linalg.norm(corners - corners.mean(axis=1, keepdims=True), axis=2).max()
    near = cKDTree((start + end) / 2.0).query_ball_tree(cKDTree(corners.mean(axis=1)), reach)
    e = np.repeat(np.arange(len(near)), [len(found) for found in near])
    t = np.array([number for found in near for number in found], dtype=int)
    way, (a, b, c) = end[e] - start[e], corners[t].swapaxes(0, 1)
    across = np.cross(way, c - a)
    scale = np.einsum("ij,ij->i", b - a, across)
    scale = np.where(scale == 0.0, np.nan, scale)
    turned = np.cross(start[e] - a, b - a)
    u = np.einsum("ij,ij->i", start[e] - a, across) / scale
    v = np.einsum("ij,ij->i", way, turned) / scale
    along = np.einsum("ij,ij->i", c - a, turned) / scale
    return int(((u > 0) & (v > 0) & (u + v < 1) & (along > 0) & (along < 1)).sum())


def test_an_edge_through_a_triangle_is_found():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0.2, 0.2, -1], [0.2, 0.2, 1], [2, 2, 1]])
    triangle = np.array([[0, 1, 2]])
    assert crossings(points, np.array([[3, 4]]), triangle) == 1
    assert crossings(points, np.array([[3, 5]]), triangle) == 0


@pytest.fixture(scope="module")
def triangles_of(neutral):
    """The triangles of a group of polygons."""
    label = np.repeat(neutral.groups.of_face, neutral.faces.sizes - 2)

    def of(*names):
        numbers = [neutral.groups.names.index(name) for name in names]
        return neutral.faces.triangles()[np.isin(label, numbers)]

    return of


def edges_of(triangles):
    return np.unique(np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)), axis=0)


@pytest.mark.parametrize("face", FACES)
def test_lips_and_teeth_do_not_meet(face, triangles_of, neutral):
    """The lips that close an open jaw are looked at where the jaw is open."""
    opened = SHAPES["jawOpen"].vertices - neutral.vertices if face == "mouthClose" else 0.0
    points, lips, teeth = (
        FACES[face].vertices + opened,
        triangles_of("lips"),
        triangles_of("teeth", "gums"),
    )
    assert crossings(points, edges_of(lips), teeth) == 0
    assert crossings(points, edges_of(teeth), lips) == 0


@pytest.mark.parametrize("name", sorted(set(SHAPES) - ROLLED - {"mouthClose"}))
def test_the_red_of_the_lips_does_not_turn_over(name, triangles_of, neutral):
    """Less than half a per cent of it, at the corners, turns by more than a right angle."""
    triangles = triangles_of("lips")

    def normals(points):
        a, b, c = points[triangles].swapaxes(0, 1)
        return np.cross(b - a, c - a)

    cosine = np.einsum("ij,ij->i", normals(neutral.vertices), normals(SHAPES[name].vertices))
    areas = np.linalg.norm(normals(neutral.vertices), axis=1)
    assert areas[cosine < 0.0].sum() < 0.005 * areas.sum()
