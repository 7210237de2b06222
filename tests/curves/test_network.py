"""Curves and networks: what they accept, what they refuse and why, parts and renumbering."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from topologies import patiently

from elastomorph.curves import Curve, CurveNetwork
from elastomorph.errors import CurveError


@st.composite
def networks(draw):
    """Disjoint open and closed curves, and vertices on none of them."""
    lengths = draw(st.lists(st.integers(1, 8), max_size=6))
    count = sum(lengths) + draw(st.integers(0, 4))
    labels = draw(st.permutations(range(max(count, 1))))
    curves, start = [], 0
    for number, length in enumerate(lengths):
        closed = length >= 3 and draw(st.booleans())
        name = draw(st.sampled_from(["", f"curve {number}"]))
        curves.append(Curve(labels[start : start + length], closed, name))
        start += length
    return CurveNetwork(curves, max(count, 1))


def test_vertices_of_a_curve_cannot_be_written_and_do_not_follow_the_callers_array():
    mine = np.array([3, 1, 2])
    curve = Curve(mine)
    mine[0] = 7
    assert curve.vertices.tolist() == [3, 1, 2]
    assert curve.vertices.dtype == np.int32
    with pytest.raises(ValueError, match="read-only"):
        curve.vertices[0] = 5


def test_edges_of_a_closed_curve_return_to_its_first_vertex():
    assert Curve([4, 2, 9]).edges.tolist() == [[4, 2], [2, 9]]
    assert Curve([4, 2, 9], closed=True).edges.tolist() == [[4, 2], [2, 9], [9, 4]]
    assert Curve([4]).edges.shape == (0, 2)


def test_curves_are_equal_when_vertices_closure_and_name_are():
    assert Curve([1, 2, 3]) == Curve(np.array([1, 2, 3]))
    assert hash(Curve([1, 2, 3])) == hash(Curve([1, 2, 3]))
    different = [Curve([1, 3, 2]), Curve([1, 2, 3], True), Curve([1, 2, 3], name="lip"), 5]
    assert all(Curve([1, 2, 3]) != other for other in different)


@pytest.mark.parametrize(
    ("vertices", "closed", "message"),
    [
        ([], False, "no vertices"),
        ([1, 2, 1], False, "through vertex 1 twice.*closed=True"),
        ([1, 2, 2, 3], False, "through vertex 2 twice$"),
        ([0, -4], False, "-4.*negative"),
        ([0, 1], True, "closed but has 2"),
        ([0.0, 1.0], False, "whole numbers"),
        ([True, False], False, "whole numbers"),
        ([[0, 1]], False, "whole numbers"),
        ([[0], [1, 2]], False, "whole numbers"),
        (["a"], False, "whole numbers"),
        (None, False, "whole numbers"),
        ([2**40], False, "more than any mesh"),
    ],
)
def test_a_curve_refuses(vertices, closed, message):
    with pytest.raises(CurveError, match=message):
        Curve(vertices, closed)


def test_a_named_curve_is_named_in_complaints():
    with pytest.raises(CurveError, match="curve 'upper lip' passes through vertex 3 twice"):
        Curve([3, 3], name="upper lip")


def test_a_network_reads_like_a_tuple():
    curves = [Curve([0, 1, 2]), Curve([5]), Curve([3, 4])]
    network = CurveNetwork(curves, 7)
    assert network[1] == curves[1]
    assert list(network) == curves
    assert len(network) == 3
    assert network.curves == tuple(curves)
    assert network[1:] == tuple(curves[1:])
    assert network.curve_of.tolist() == [0, 0, 0, 2, 2, 1, -1]
    assert network == CurveNetwork(curves, 7)
    assert network != CurveNetwork(curves, 8)
    assert "3 curves" in repr(network)


def test_two_curves_through_one_vertex_are_refused_with_both_named():
    with pytest.raises(
        CurveError, match=r"vertex 2 lies on curve 0 \('lip'\) and on curve 1; a vertex can"
    ):
        CurveNetwork([Curve([0, 1, 2], name="lip"), Curve([2, 3])], 9)


def test_a_vertex_that_the_mesh_does_not_have_is_named():
    with pytest.raises(CurveError, match=r"curve 1 names vertex 12, but the mesh has 12 vertices"):
        CurveNetwork([Curve([0, 1, 2]), Curve([11, 12])], 12)


def test_a_closed_curve_cut_by_a_region_becomes_open_runs_across_its_first_vertex():
    ring = CurveNetwork([Curve(range(8), closed=True, name="eye")], 8)
    runs = ring.restricted([7, 0, 1, 3, 5])
    assert [run.vertices.tolist() for run in runs] == [[3], [5], [7, 0, 1]]
    assert not any(run.closed for run in runs)
    assert {run.name for run in runs} == {"eye"}


def test_an_open_curve_is_not_joined_across_its_ends():
    line = CurveNetwork([Curve(range(5))], 5)
    assert [run.vertices.tolist() for run in line.restricted([0, 1, 3, 4])] == [[0, 1], [3, 4]]


@patiently
@given(networks(), st.randoms(use_true_random=False))
def test_a_restriction_keeps_exactly_the_edges_inside(network, random):
    inside = np.array([random.random() < 0.6 for _ in range(network.vertex_count)])
    part = network.restricted(inside)
    expected = {
        tuple(edge)
        for curve in network
        for edge in curve.edges.tolist()
        if inside[edge[0]] and inside[edge[1]]
    }
    assert {tuple(edge) for curve in part for edge in curve.edges.tolist()} == expected
    assert np.array_equal(part.curve_of >= 0, (network.curve_of >= 0) & inside)
    assert part == network.restricted(np.flatnonzero(inside))


@given(networks())
def test_the_restriction_to_everything_is_the_network(network):
    assert network.restricted(np.ones(network.vertex_count, bool)) == network
    assert len(network.restricted([])) == 0


@patiently
@given(networks(), st.randoms(use_true_random=False))
def test_renumbering_and_back_is_the_network(network, random):
    new_index = np.array(random.sample(range(network.vertex_count), network.vertex_count))
    moved = network.relabelled(new_index)
    assert moved.relabelled(np.argsort(new_index)) == network
    assert np.array_equal(moved.curve_of[new_index], network.curve_of)


def test_a_part_can_be_renumbered_into_a_smaller_mesh():
    network = CurveNetwork([Curve([2, 4, 6], closed=True)], 8)
    part = network.relabelled([-1, -1, 0, -1, 1, -1, 2, -1], vertex_count=3)
    assert part == CurveNetwork([Curve([0, 1, 2], closed=True)], 3)


@pytest.mark.parametrize(
    ("new_index", "message"),
    [
        ([0, 1], "2 entries.*3 vertices"),
        ([0, 1, 1], "through vertex 1 twice"),
        ([0, 1, -1], "negative"),
        ([0, 1, 3], "names vertex 3, but the mesh has 3"),
        ([0.5, 1, 2], "whole numbers"),
    ],
)
def test_a_renumbering_that_does_not_fit_is_refused(new_index, message):
    with pytest.raises(CurveError, match=message):
        CurveNetwork([Curve([0, 1, 2])], 3).relabelled(new_index)
