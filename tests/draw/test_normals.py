"""Normals are smooth on smooth surfaces and sharp at edges."""

from __future__ import annotations

import numpy as np
import pytest

from elastomorph.draw.materials import CornerNormals, corner_pairs
from elastomorph.model.mesh import Mesh
from elastomorph.model.polygons import Polygons


def _cube() -> Mesh:
    vertices = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return Mesh(vertices, faces)


def test_corners_of_a_cube_keep_the_normals_of_their_faces() -> None:
    cube = _cube()
    normals = CornerNormals(cube.faces, corner_pairs(cube.faces)).of(cube.vertices)
    expected = np.repeat(
        [[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1]], 4, 0
    )
    np.testing.assert_allclose(normals, expected, atol=1e-12)


def test_a_large_crease_angle_rounds_a_cube() -> None:
    cube = _cube()
    normals = CornerNormals(cube.faces, corner_pairs(cube.faces), crease=120).of(cube.vertices)
    outward = (cube.vertices - 0.5) * 2 / np.sqrt(3)
    np.testing.assert_allclose(normals, outward[cube.faces.indices], atol=1e-12)


def test_normals_of_a_sphere_point_outwards(sphere: Mesh) -> None:
    normals = CornerNormals(sphere.faces, corner_pairs(sphere.faces)).of(sphere.vertices)
    along = np.einsum("ij,ij->i", normals, sphere.vertices[sphere.faces.indices])
    assert along.min() > 0.99


def test_corner_pairs_are_all_pairs_at_a_vertex() -> None:
    """Against the obvious double loop, on polygons of mixed sizes."""
    rng = np.random.default_rng(3)
    faces = Polygons.of([rng.choice(12, size, replace=False).tolist() for size in (3, 5, 4, 3, 6)])
    pairs = corner_pairs(faces)
    found = sorted(zip(*(corners.tolist() for corners in pairs), strict=True))
    corners = faces.indices
    expected = [
        (a, b) for a in range(len(corners)) for b in range(len(corners)) if corners[a] == corners[b]
    ]
    assert found == expected


def test_polygons_without_area_get_a_normal_of_length_one() -> None:
    mesh = Mesh(np.zeros((3, 3)), [[0, 1, 2]])
    normals = CornerNormals(mesh.faces, corner_pairs(mesh.faces)).of(mesh.vertices)
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1)
