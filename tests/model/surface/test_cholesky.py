"""The factorisation against dense algebra."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from elastomorph.errors import MeshError
from elastomorph.model.surface import dissection
from elastomorph.model.surface.cholesky import Cholesky
from elastomorph.model.surface.dissection import EliminationTree


@given(st.integers(0, 10**6), st.integers(1, 120), st.integers(2, 40), st.floats(0.2, 1.0))
@settings(max_examples=40, deadline=None)
def test_solutions_are_those_of_the_dense_matrix(
    seed: int, count: int, leaf: int, share: float
) -> None:
    """For any graph, some of whose vertices have no row, and any number of right-hand sides."""
    rng = np.random.default_rng(seed)
    ends = np.unique(np.sort(rng.integers(0, count, size=(3 * count, 2)), axis=1), axis=0)
    ends = ends[ends[:, 0] < ends[:, 1]]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(dissection, "_LEAF", leaf)
        tree = EliminationTree.of(rng.normal(size=(count, 3)), ends)
    kept = rng.random(count) < share
    ends = ends[kept[ends].all(axis=1)]
    weights = rng.random(len(ends)) * (rng.random(len(ends)) < 0.8)
    row = np.cumsum(kept) - 1
    dense = np.zeros((kept.sum(), kept.sum()))
    first, second = row[ends].T
    dense[first, second] = dense[second, first] = -weights
    diagonal = 0.01 + np.abs(dense).sum(axis=1)
    np.fill_diagonal(dense, diagonal)
    wanted = rng.normal(size=(len(dense), 4))
    found = Cholesky.of(tree, kept, ends, weights, diagonal).solve(wanted)
    np.testing.assert_allclose(dense @ found, wanted, atol=1e-10)


def test_one_factor_serves_many_right_hand_sides_and_changes_none() -> None:
    tree = EliminationTree.of(np.eye(3), np.array([[0, 1], [1, 2]]))
    factor = Cholesky.of(
        tree, np.ones(3, bool), np.array([[0, 1], [1, 2]]), np.ones(2), np.array([2.0, 3.0, 2.0])
    )
    wanted = np.array([[1.0], [1.0], [1.0]])
    np.testing.assert_allclose(factor.solve(wanted), 1.0)
    np.testing.assert_array_equal(wanted, 1.0)


def test_a_matrix_without_inverse_up_to_rounding_still_gives_numbers() -> None:
    """A ring that nothing holds: its shift is left open, all else is solved for."""
    count = 50
    ends = np.stack([np.arange(count), np.roll(np.arange(count), -1)], axis=1)
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    points = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    tree = EliminationTree.of(points, ends)
    factor = Cholesky.of(
        tree, np.ones(count, bool), ends, np.full(count, 1e3), np.full(count, 2e3 * (1 - 1e-16))
    )
    wanted = np.sin(angle)[:, None]
    found = factor.solve(wanted)
    assert np.isfinite(found).all()
    exact = wanted / (1e3 * (2 - 2 * np.cos(2 * np.pi / count)))
    np.testing.assert_allclose(found - found.mean(), exact, atol=1e-5)


@pytest.mark.timeout(10)
def test_a_matrix_of_zeros_is_refused_and_not_tried_for_ever() -> None:
    ends = np.array([[0, 1]])
    tree = EliminationTree.of(np.eye(3)[:2], ends)
    with pytest.raises(MeshError, match="nothing holds a part of it"):
        Cholesky.of(tree, np.ones(2, bool), ends, np.zeros(1), np.zeros(2))
