"""The factorisation is that of dense algebra; its order cuts a surface in halves."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.sparse import coo_array, diags_array

from elastomorph.errors import MeshError
from elastomorph.model import cholesky
from elastomorph.model.cholesky import Cholesky, EliminationTree, symmetric_factor


def grid(side: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """A square grid of side² vertices and its edges."""
    number = np.arange(side * side).reshape(side, side)
    ends = [np.stack([number[:-1], number[1:]], -1), np.stack([number[:, :-1], number[:, 1:]], -1)]
    x, y = np.divmod(np.arange(side * side), side)
    points = np.stack([x, y, np.zeros(side * side)], axis=1).astype(float)
    return points, np.concatenate([e.reshape(-1, 2) for e in ends])


def require_valid(tree: EliminationTree, count: int, ends: NDArray[np.int64]) -> None:
    """Eliminating nodes in order joins nothing that a border does not name (done on sets)."""
    np.testing.assert_array_equal(np.sort(tree.order), np.arange(count))
    assert tree.starts[0] == 0
    assert tree.starts[-1] == count
    place = np.argsort(tree.order)
    joined: list[set[int]] = [set() for _ in range(count)]
    for i, j in place[ends]:
        if i != j:
            joined[min(i, j)].add(int(max(i, j)))
    for node, parent in enumerate(tree.parents):
        own = range(tree.starts[node], tree.starts[node + 1])
        border = set(tree.borders[node].tolist())
        assert parent == -1 or parent > node
        assert parent != -1 or not border
        for vertex in own:
            later = joined[vertex]
            assert later <= border | set(own)
            for other in later:
                joined[other] |= {k for k in later if k > other}
        above = []
        while parent >= 0:
            above += range(tree.starts[parent], tree.starts[parent + 1])
            parent = tree.parents[parent]
        assert border <= set(above)


@given(st.integers(0, 10**6), st.integers(1, 300), st.floats(0.0, 3.0))
@settings(max_examples=30, deadline=None)
def test_borders_name_all_that_elimination_joins(seed: int, count: int, density: float) -> None:
    """Any graph: in pieces, without edges, with all points in one place."""
    rng = np.random.default_rng(seed)
    ends = rng.integers(0, count, size=(int(density * count), 2))
    ends = np.unique(np.sort(ends[ends[:, 0] != ends[:, 1]], axis=1), axis=0)
    points = rng.integers(0, 3, size=(count, 3)).astype(float)
    require_valid(EliminationTree.of(points, ends), count, ends)


def test_a_grid_is_cut_in_halves(monkeypatch: pytest.MonkeyPatch) -> None:
    """The last cut is one row of vertices, the two before it half a row."""
    monkeypatch.setattr(cholesky, "_LEAF", 16)
    points, ends = grid(32)
    tree = EliminationTree.of(points, ends)
    require_valid(tree, len(points), ends)
    sizes = np.diff(tree.starts)
    assert sizes[-1] == 32
    assert set(sizes[-3:-1]) <= {15, 16}
    assert sizes[tree.parents == -1].tolist() == [32]


def test_the_factor_of_a_grid_is_nearly_linear_in_its_vertices() -> None:
    """N log N entries: four times the vertices, less than six times the entries."""
    entries = []
    for side in (40, 80, 160):
        points, ends = grid(side)
        tree = EliminationTree.of(points, ends)
        sizes, reach = np.diff(tree.starts), np.array([len(b) for b in tree.borders])
        entries.append(int((sizes * (sizes + 1) // 2 + sizes * reach).sum()))
    assert entries[1] < 6 * entries[0]
    assert entries[2] < 6 * entries[1]


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
        patch.setattr(cholesky, "_LEAF", leaf)
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


def test_a_matrix_of_zeros_is_refused_and_not_tried_for_ever() -> None:
    ends = np.array([[0, 1]])
    tree = EliminationTree.of(np.eye(3)[:2], ends)
    with pytest.raises(MeshError, match="nothing holds a part of it"):
        Cholesky.of(tree, np.ones(2, bool), ends, np.zeros(1), np.zeros(2))


def test_a_symmetric_matrix_keeps_its_diagonal_as_pivots_definite_or_not() -> None:
    """So the signs of the pivots are those of the eigenvalues (Sylvester's law of inertia)."""
    _, ends = grid(6)
    one, other = ends.T
    laplacian = coo_array((np.full(len(ends), -1.0), (one, other)), shape=(36, 36))
    laplacian = laplacian + laplacian.T
    whole = laplacian - diags_array(laplacian.sum(axis=1)) - diags_array(np.full(36, 1.7))
    factor = symmetric_factor(whole.tocsc())
    np.testing.assert_array_equal(factor.perm_r, factor.perm_c)
    below = np.linalg.eigvalsh(whole.toarray()) < 0
    assert 0 < below.sum() < 36
    assert (factor.U.diagonal() < 0).sum() == below.sum()
    wanted = np.random.default_rng(0).normal(size=36)
    np.testing.assert_allclose(whole @ factor.solve(wanted), wanted, atol=1e-10)
    with pytest.raises(RuntimeError, match="singular"):
        symmetric_factor(coo_array((36, 36)).tocsc())
