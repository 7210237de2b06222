"""Which edge goes straight on: compared with a walk around each vertex."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from slow_loops import slow_straight
from topologies import anything, cube, fan, grid, patiently

from elastomorph.curves.extraction import edge_ends, straight_successors
from elastomorph.model.mesh import Mesh


def straight_of(mesh: Mesh) -> dict[tuple[int, tuple[int, int]], tuple[int, int]]:
    ends = edge_ends(mesh.faces, len(mesh.vertices))
    straight = straight_successors(ends)
    edges = [tuple(edge) for edge in ends.edges.tolist()]
    return {
        (edges[end >> 1][end & 1], edges[end >> 1]): edges[onward >> 1]
        for end, onward in enumerate(straight.tolist())
        if onward >= 0
    }


@patiently
@given(anything)
def test_straight_on_is_what_a_walk_around_the_vertex_finds(mesh):
    assert straight_of(mesh) == slow_straight(mesh)


@patiently
@given(anything)
def test_edges_are_those_of_the_mesh(mesh):
    assert np.array_equal(edge_ends(mesh.faces, len(mesh.vertices)).edges, mesh.edges)


@patiently
@given(anything)
def test_going_straight_on_and_back_returns(mesh):
    ends = edge_ends(mesh.faces, len(mesh.vertices))
    straight = straight_successors(ends)
    going = np.flatnonzero(straight >= 0)
    assert np.array_equal(straight[straight[going]], going)
    vertex = ends.edges.reshape(-1)
    assert np.array_equal(vertex[straight[going]], vertex[going])


def test_an_edge_arriving_at_a_border_ends_and_the_border_goes_on():
    straight = straight_of(grid(3, 3))
    assert (1, (1, 4)) not in straight
    assert straight[1, (0, 1)] == (1, 2)
    assert straight[2, (1, 2)] == (2, 5)
    assert straight[4, (3, 4)] == (4, 5)


def test_loops_end_where_three_or_five_edges_meet():
    assert straight_of(cube()) == {}
    assert not any(vertex == 0 for vertex, _ in straight_of(fan(5)))
    assert straight_of(fan(6))[0, (0, 1)] == (0, 4)


def test_loops_end_at_an_edge_of_three_polygons():
    book = Mesh(np.random.default_rng(0).random((8, 3)), [[0, 1, 2, 3], [0, 1, 4, 5], [0, 1, 6, 7]])
    straight = straight_of(book)
    assert not any(vertex in (0, 1) for vertex, _ in straight)
    assert straight[2, (1, 2)] == (2, 3)


def test_two_surfaces_touching_in_a_vertex_keep_their_own_borders():
    bow_tie = Mesh(np.random.default_rng(0).random((5, 3)), [[0, 1, 2], [0, 3, 4]])
    straight = straight_of(bow_tie)
    assert straight[0, (0, 1)] == (0, 2)
    assert straight[0, (0, 3)] == (0, 4)
