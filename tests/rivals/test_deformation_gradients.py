from __future__ import annotations

import numpy as np
from sheets import between, turn

import elastomorph as em
from elastomorph.rivals import DeformationGradients
from elastomorph.rivals.elastic_solid import polar

AXIS = np.array([1.0, 2.0, -0.5])
TIMES = [0.0, 0.3, 0.5, 1.0]


def test_a_body_that_turns_and_grows_does_so_evenly(sheet: em.Mesh) -> None:
    """Its rotation is interpolated, its size grows in proportion, its centre goes straight."""
    centre = sheet.vertices.mean(axis=0)
    arms, shift = sheet.vertices - centre, np.array([0.5, 0.0, 2.0])
    end = 1.5 * arms @ turn(AXIS, 2.0).T + centre + shift
    found = DeformationGradients().poses(between(sheet, end), TIMES)
    for time, face in zip(TIMES, found, strict=True):
        expected = (1 + 0.5 * time) * arms @ turn(AXIS, 2.0 * time).T + centre + time * shift
        np.testing.assert_allclose(face, expected, atol=1e-10)


def test_ends_are_met_whatever_moves(sheet: em.Mesh) -> None:
    """Held vertices stay to the last bit."""
    end = sheet.vertices.copy()
    end[10:] += np.random.default_rng(0).normal(scale=0.1, size=end[10:].shape)
    found = DeformationGradients().poses(between(sheet, end), TIMES)
    np.testing.assert_allclose(found[[0, -1]], [sheet.vertices, end], atol=1e-10)
    assert (found[:, :10] == sheet.vertices[:10]).all()


def test_each_part_by_itself(sheet: em.Mesh) -> None:
    """A part that hangs on nothing is not moved by the others."""
    count = len(sheet.vertices)
    faces = [*sheet.faces, *(np.asarray(face) + count for face in sheet.faces)]
    both = em.Mesh(np.concatenate([sheet.vertices, sheet.vertices + 9.0]), faces)
    end = sheet.vertices @ turn(AXIS, 1.0).T
    one = DeformationGradients().poses(between(sheet, end), [0.5])[0]
    two = DeformationGradients().poses(
        between(both, np.concatenate([end, sheet.vertices + 9.0])), [0.5]
    )[0]
    np.testing.assert_allclose(two[:count], one, atol=1e-10)
    np.testing.assert_allclose(two[count:], sheet.vertices + 9.0, atol=1e-10)


def test_a_triangle_that_is_flat_does_no_harm(sheet: em.Mesh) -> None:
    start = sheet.vertices.copy()
    start[1] = start[0]
    end = start + [0.0, 0.0, 1.0] * np.abs(start)
    found = DeformationGradients().poses(between(sheet.with_vertices(start), end), TIMES)
    assert np.isfinite(found).all()


def test_polar_parts_multiply_to_the_whole_without_mirroring() -> None:
    matrices = np.random.default_rng(3).normal(size=(50, 3, 3))
    turns, stretches = polar(matrices)
    np.testing.assert_allclose(turns @ stretches, matrices, atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(turns), 1.0, atol=1e-12)
    np.testing.assert_allclose(stretches, np.swapaxes(stretches, 1, 2), atol=1e-12)
