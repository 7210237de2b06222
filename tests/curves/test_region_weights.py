"""Weights of a local region: 0 outside, 1 deep inside, smooth between."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra
from topologies import grid, patiently, surfaces, together

from elastomorph.curves import region_weights
from elastomorph.errors import CurveError, ParameterError


def test_weights_rise_ring_by_ring_from_the_boundary():
    line = np.array([[i, i + 1] for i in range(9)])
    weights = region_weights(line, 10, range(2, 10), falloff=3)
    third, two_thirds = 7 / 27, 20 / 27
    assert weights == pytest.approx([0, 0, third, two_thirds, 1, 1, 1, 1, 1, 1])


def test_a_falloff_of_one_edge_or_none_is_sharp():
    line = np.array([[0, 1], [1, 2]])
    for falloff in (0, 0.5, 1):
        assert region_weights(line, 3, [1, 2], falloff).tolist() == [0, 1, 1]


def test_a_whole_component_has_weight_one_at_once():
    mesh = together([grid(3, 3), grid(4, 4)])
    weights = region_weights(mesh.edges, 25, np.arange(9))
    assert weights.tolist() == [1.0] * 9 + [0.0] * 16


@patiently
@given(
    surfaces(),
    st.integers(0, 5) | st.floats(0, 5),
    st.randoms(use_true_random=False),
)
def test_weights_follow_the_distance_to_the_outside(mesh, falloff, random):
    count = len(mesh.vertices)
    outside = np.array([random.random() < 0.1 for _ in range(count)])
    distance = np.full(count, np.inf)
    if outside.any():
        graph = coo_matrix((np.ones(len(mesh.edges)), mesh.edges.T), shape=(count, count))
        from_outside = dijkstra(
            graph, directed=False, indices=np.flatnonzero(outside), unweighted=True
        )
        distance = from_outside.min(axis=0)
    s = np.minimum(distance / max(falloff, 1), 1)
    weights = region_weights(mesh.edges, count, ~outside, falloff)
    assert weights == pytest.approx(3 * s**2 - 2 * s**3)


def test_a_region_is_indices_or_flags():
    line = np.array([[0, 1], [1, 2], [2, 3]])
    flags = region_weights(line, 4, [False, True, True, False])
    for region in ([1, 2], [2, 1, 1], {1, 2}, range(1, 3), np.array([1, 2], np.uint8)):
        assert np.array_equal(region_weights(line, 4, region), flags)


@pytest.mark.parametrize("region", [[4], [-1], [0.5], [[0]], "face", [True, False]])
def test_a_region_that_is_not_of_this_mesh_is_refused(region):
    with pytest.raises(CurveError, match="region"):
        region_weights(np.array([[0, 1]]), 4, region)


@pytest.mark.parametrize("falloff", [-1, np.nan, np.inf])
def test_a_falloff_without_meaning_is_refused(falloff):
    with pytest.raises(ParameterError, match="falloff"):
        region_weights(np.array([[0, 1]]), 2, [0], falloff)
