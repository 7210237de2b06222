"""Rigid components as ground truth."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import elastomorph as em
from elastomorph.evaluation.rigid_parts import find_rigid_parts
from elastomorph.model.mesh import FaceLabels


def boxes(count: int) -> em.Mesh:
    """Cubes side by side, each a component of its own."""
    cube = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    points = np.concatenate([cube + [3 * i, 0, 0] for i in range(count)])
    return em.Mesh(points, [[v + 8 * i for v in quad] for i in range(count) for quad in quads])


def test_two_of_four_boxes_turn_together() -> None:
    """One more stretches, one stays: the truth holds two, on a true arc."""
    neutral = boxes(4)
    turn = Rotation.from_rotvec([0.4, 0, 0])
    moved = neutral.vertices.copy()
    moved[:16] = turn.apply(moved[:16] - [0, -2, 0]) + [0, -2, 0]
    moved[16:24] *= [1, 1.5, 1]
    parts = find_rigid_parts(neutral, neutral.with_vertices(moved))
    assert parts is not None
    assert parts.components == 2
    np.testing.assert_array_equal(parts.vertices, np.arange(16))
    assert parts.screw.angle == pytest.approx(0.4)
    radius = np.linalg.norm(parts.truth.frames[:, :, 1:] - [-2, 0], axis=2)
    np.testing.assert_allclose(radius, radius[:1].repeat(11, axis=0), atol=1e-9)
    np.testing.assert_array_equal(parts.truth.frames[-1], moved[:16])
    assert len(parts.truth.mesh.faces) == 12
    network = parts.curves(em.extract_curves(neutral))
    assert sum(len(curve) for curve in network) == 16


def test_the_parts_keep_the_names_of_their_polygons() -> None:
    """So that teeth look like teeth wherever the truth is drawn."""
    plain = boxes(2)
    names = FaceLabels(("lips", "teeth"), np.repeat([0, 1], 6).astype(np.int32))
    neutral = em.Mesh(plain.vertices, plain.faces, materials=names, groups=names)
    moved = neutral.vertices.copy()
    moved[8:] = Rotation.from_rotvec([0.4, 0, 0]).apply(moved[8:])
    moved[:8] *= [1, 1.5, 1]
    parts = find_rigid_parts(neutral, neutral.with_vertices(moved))
    assert parts is not None
    for labels in (parts.truth.mesh.materials, parts.truth.mesh.groups):
        assert labels is not None
        assert [labels.names[number] for number in labels.of_face] == ["teeth"] * 6


def test_nothing_rigid_is_nothing_found() -> None:
    neutral = boxes(1)
    stretched = neutral.with_vertices(neutral.vertices * [1, 2, 1])
    assert find_rigid_parts(neutral, stretched) is None
    assert find_rigid_parts(neutral, neutral) is None
