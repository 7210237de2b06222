"""Smoothed local rotations of a sheet."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import elastomorph as em
from elastomorph.paths.rotations import Neighbourhoods, VertexRotations, vertex_rotations
from elastomorph.paths.rotations.vertex_rotations import nearest_quaternions, rotation_vectors


def rotations(mesh: em.Mesh, end: np.ndarray, rings: int = 2) -> np.ndarray:
    around = Neighbourhoods.of(len(mesh.vertices), mesh.edges)
    return vertex_rotations(mesh.vertices, end, around, diameter=mesh.diameter, rings=rings).vectors


def rolled(mesh: em.Mesh) -> np.ndarray:
    """The sheet rolled about x: its far half turned by 90°, a part that bends between."""
    angle = np.clip(mesh.vertices[:, 1] - 3.0, 0.0, 3.0) * np.pi / 6
    turned = Rotation.from_rotvec(angle[:, None] * [1.0, 0.0, 0.0]).apply(
        mesh.vertices - [0.0, 4.5, 0.0]
    )
    return np.asarray(turned + [0.0, 4.5, 0.0])


def test_covariances_are_averaged_over_rings_with_binomial_weights(
    sheet: Callable[[int, int], em.Mesh],
) -> None:
    """The same by loops over vertices, edges and rings."""
    mesh = sheet(3, 3)
    end = rolled(sheet(9, 3))[-len(mesh.vertices) :] * 1.1
    vectors = rotations(mesh, end)
    own = np.zeros((len(end), 3, 3))
    for i, j in mesh.edges:
        before, after = mesh.vertices[j] - mesh.vertices[i], end[j] - end[i]
        stretch = abs(np.log(np.linalg.norm(after) / np.linalg.norm(before)))
        for vertex in (i, j):
            own[vertex] += np.exp(-stretch) * np.outer(before, after) / (1 + (stretch / 0.3) ** 2)
    for _ in range(2):
        summed = own.copy()
        for i, j in mesh.edges:
            summed[i] += own[j]
            summed[j] += own[i]
        own = summed
    expected = rotation_vectors(nearest_quaternions(own))
    np.testing.assert_allclose(vectors, expected, atol=1e-8)


def test_a_part_that_stays_and_one_that_turns_keep_their_rotations(
    sheet: Callable[[int, int], em.Mesh],
) -> None:
    mesh = sheet(16, 3)
    vectors = rotations(mesh, rolled(mesh), rings=1)
    y = mesh.vertices[:, 1]
    np.testing.assert_allclose(vectors[y <= 1], 0.0, atol=1e-12)
    np.testing.assert_allclose(vectors[y >= 9] - [np.pi / 2, 0, 0], 0.0, atol=1e-7)


def test_stretched_edges_hardly_count(sheet: Callable[[int, int], em.Mesh]) -> None:
    """Between a still part and one torn far away, both keep their own rotation."""
    mesh = sheet(9, 3)
    end = mesh.vertices.copy()
    far = mesh.vertices[:, 1] >= 5
    end[far] = Rotation.from_rotvec([0.5, 0, 0]).apply(end[far]) + [0, 0, 400.0]
    vectors = rotations(mesh, end, rings=1)
    expected = np.where(far[:, None], [0.5, 0.0, 0.0], 0.0)
    assert np.abs(vectors - expected).max() < 0.12


def test_rotations_turn_with_the_pair_and_ignore_its_size(
    sheet: Callable[[int, int], em.Mesh],
) -> None:
    mesh = sheet(9, 3)
    end = rolled(mesh)
    turn = Rotation.from_rotvec([1.0, 2.0, -0.5])
    vectors = rotations(mesh, end)
    moved = rotations(
        mesh.with_vertices(1e-3 * turn.apply(mesh.vertices.copy()) + 4.0),
        1e-3 * turn.apply(end) - 1.0,
    )
    np.testing.assert_allclose(moved, turn.apply(vectors), atol=1e-7)


def test_the_way_back_is_the_opposite_turn(sheet: Callable[[int, int], em.Mesh]) -> None:
    mesh = sheet(9, 3)
    there = rotations(mesh, rolled(mesh))
    back = rotations(mesh.with_vertices(rolled(mesh)), mesh.vertices)
    np.testing.assert_allclose(back, -there, atol=1e-7)


def test_loose_and_still_vertices_do_not_turn(sheet: Callable[[int, int], em.Mesh]) -> None:
    mesh = sheet(4, 3)
    loose = em.Mesh(np.concatenate([mesh.vertices, [[9.0, 9, 9]]]), mesh.faces)
    assert not rotations(loose, loose.vertices + np.eye(21)[-1][:, None]).any()


@pytest.mark.parametrize(("part", "turns"), [(0.24, True), (0.26, False)])
def test_a_turn_that_leaves_a_quarter_unexplained_is_none(part: float, turns: bool) -> None:
    """Of an edge that turns by θ and grows s-fold: (s - 1)² = part · (1 + s² - 2 s cos θ)."""
    angle = 0.6
    linear = 1.0 - part * np.cos(angle)
    longer = (linear + np.sqrt(linear**2 - (1.0 - part) ** 2)) / (1.0 - part)
    around = Neighbourhoods.of(2, np.array([[0, 1]]))
    half = np.array([np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)])
    own = VertexRotations(np.tile(half, (2, 1)), (), np.zeros(2, bool))
    start = np.array([[0.0, 0, 0], [1.0, 0, 0]])
    end = longer * Rotation.from_rotvec([0, 0, angle]).apply(start)
    found = own.where_edges_turn(start, end, around).vectors
    np.testing.assert_allclose(found[:, 2], angle if turns else 0.0, atol=1e-12)
