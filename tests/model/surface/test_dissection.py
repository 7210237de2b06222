"""The order of elimination: every vertex once, cuts above what they cut, borders complete."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from elastomorph.model.surface import dissection
from elastomorph.model.surface.dissection import EliminationTree


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
    monkeypatch.setattr(dissection, "_LEAF", 16)
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
