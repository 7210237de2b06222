"""Deformations: rigid motion costs nothing, data is met, and the energy is the one written down."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from test_capture_surface import ball

from elastomorph.capturing.geometry import Deformation

SURFACE = ball(14)
REST = SURFACE.vertices
TURN = Rotation.from_rotvec([0.4, -0.9, 0.5]).as_matrix()


def held(indices: np.ndarray, places: np.ndarray, weight: float) -> tuple[np.ndarray, np.ndarray]:
    quadratic, linear = np.zeros((len(REST), 3, 3)), np.zeros((len(REST), 3))
    quadratic[indices] = weight * np.eye(3)
    linear[indices] = weight * places
    return quadratic, linear


@pytest.mark.parametrize(("arap", "bending"), [(1.0, 0.0), (0.1, 1.0), (0.01, 5.0)])
def test_a_few_points_moved_rigidly_take_the_rest_along(arap, bending):
    deformation = Deformation(REST, SURFACE.triangles)
    moved = REST @ TURN.T + [3, 2, 1]
    few = np.arange(0, len(REST), 17)
    found = deformation.solve(
        REST, *held(few, moved[few], 10.0), arap=arap, bending=bending, rounds=200
    )
    np.testing.assert_allclose(found, moved, atol=2e-3)
    np.testing.assert_allclose(
        deformation.rotations(moved), np.broadcast_to(TURN, (len(REST), 3, 3)), atol=1e-9
    )


def test_what_is_found_has_least_energy_for_its_rotations():
    """One round is a least squares problem: solved here once more, densely, from its formula."""
    deformation = Deformation(REST, SURFACE.triangles)
    random = np.random.default_rng(2)
    few = np.arange(0, len(REST), 9)
    goal = REST[few] + random.normal(size=(len(few), 3)) * 0.2
    quadratic, linear = held(few, goal, 0.7)
    normals = random.normal(size=(len(few), 3))
    quadratic[few] = np.einsum("ni,nj->nij", normals, normals) + 0.1 * np.eye(3)
    linear[few] = np.einsum("nij,nj->ni", quadratic[few], goal)
    start = REST + random.normal(size=REST.shape) * 0.05
    found = deformation.solve(start, quadratic, linear, arap=0.3, bending=0.8, rounds=1)

    turned, count = deformation.rotations(start), len(REST)
    mean = np.eye(count)
    for i in range(count):
        near = [j for edge in deformation.edges for j in edge if i in edge and j != i]
        mean[i, near] = -1 / len(near)

    def energy(v: np.ndarray) -> float:
        total = np.einsum("ni,nij,nj->", v, quadratic, v) - 2 * (linear * v).sum()
        for i, j in deformation.edges:
            wanted = (turned[i] + turned[j]) / 2 @ (REST[i] - REST[j])
            total += 0.3 * ((v[i] - v[j] - wanted) ** 2).sum()
        bent = mean @ v - np.einsum("nij,nj->ni", turned, mean @ REST)
        return float(total + 0.8 * (bent**2).sum())

    least = energy(found)
    for seed in range(8):
        step = np.random.default_rng(seed).normal(size=REST.shape) * 1e-3
        assert energy(found + step) > least
        assert energy(found - step) > least


def test_parts_that_nothing_holds_go_along():
    small = 0.2 * REST + [0, 0, 1.5]
    rest = np.concatenate([REST, small, [[9.0, 9, 9]]])
    triangles = np.concatenate([SURFACE.triangles, len(REST) + SURFACE.triangles])
    moved = rest @ TURN.T + [1, 2, 3]
    quadratic, linear = np.zeros((len(rest), 3, 3)), np.zeros((len(rest), 3))
    few = np.arange(0, len(REST), 5)
    quadratic[few], linear[few] = np.eye(3), moved[few]
    found = Deformation(rest, triangles).solve(
        rest, quadratic, linear, arap=1.0, bending=0.5, rounds=300
    )
    np.testing.assert_allclose(found[:-1], moved[:-1], atol=5e-3)
    np.testing.assert_allclose(found[-1], rest[-1])
