"""The choice of runs: the fast rounds take what the definition, read slowly, takes."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from slow_selection import slow_choice
from topologies import anything, figure_eight, grid, patiently, together

from elastomorph.curves.extraction import choose_runs, edge_ends, ordered_chains, trace_loops
from elastomorph.model.mesh import Mesh


def chosen_edges(mesh: Mesh, taken: np.ndarray) -> set[frozenset[int]]:
    links = choose_runs(trace_loops(edge_ends(mesh.faces, len(mesh.vertices))), taken).links
    return {
        frozenset((vertex, other))
        for vertex, others in enumerate(links.tolist())
        for other in others
        if other >= 0
    }


def edges_of(runs: list[tuple[list[int], bool]]) -> set[frozenset[int]]:
    edges = set()
    for vertices, closed in runs:
        for one, other in zip(vertices, vertices[1:] + vertices[: int(closed)], strict=False):
            edges.add(frozenset((one, other)))
    return edges


@patiently
@given(anything, st.sampled_from([0.0, 0.1, 0.4]), st.randoms(use_true_random=False))
def test_rounds_over_arrays_take_the_runs_of_the_definition(mesh, share, random):
    taken = np.array([random.random() < share for _ in mesh.vertices])
    loops = trace_loops(edge_ends(mesh.faces, len(mesh.vertices)))
    expected_taken = set(np.flatnonzero(taken).tolist())
    expected = edges_of(slow_choice(loops, expected_taken))
    assert chosen_edges(mesh, taken) == expected
    assert set(np.flatnonzero(taken).tolist()) == expected_taken


@patiently
@given(anything)
def test_runs_are_disjoint_have_three_vertices_and_leave_no_loop_with_three_free_in_a_row(mesh):
    taken = np.zeros(len(mesh.vertices), dtype=bool)
    loops = trace_loops(edge_ends(mesh.faces, len(mesh.vertices)))
    growing = choose_runs(loops, taken)
    runs = ordered_chains(growing.links)
    size = np.repeat(runs.lengths, runs.lengths)
    assert set(runs.items[size >= 3].tolist()) == set(np.flatnonzero(taken).tolist())
    assert (size[~taken[runs.items]] == 1).all()
    assert np.array_equal(growing.is_closed[runs.items], np.repeat(runs.closed, runs.lengths))
    for items, closed in zip(loops.arrays(), loops.closed.tolist(), strict=True):
        items = np.concatenate([items, items[: 2 * closed]])
        free = ~taken[items]
        three = free[:-2] & free[1:-1] & free[2:] & (items[:-2] != items[2:])
        assert not three.any()


def test_of_two_crossing_families_the_one_with_more_vertices_is_taken_whole():
    torus = grid(4, 9, around=True, through=True)
    taken = np.zeros(36, dtype=bool)
    runs = ordered_chains(choose_runs(trace_loops(edge_ends(torus.faces, 36)), taken).links)
    assert runs.lengths.tolist() == [9] * 4
    assert runs.closed.all()


def test_a_loop_that_crosses_itself_gives_its_longest_part_without_a_repeat():
    mesh, one, other = figure_eight()
    middle = {*one, *other}
    taken = np.array([vertex not in middle for vertex in range(len(mesh.vertices))])
    runs = ordered_chains(
        choose_runs(trace_loops(edge_ends(mesh.faces, len(mesh.vertices))), taken).links
    )
    assert runs.lengths.max() == 7
    assert not runs.closed.any()


def test_components_do_not_influence_each_other():
    one, other = grid(6, 5), grid(4, 9, around=True)
    both = together([one, other])
    expected = chosen_edges(one, np.zeros(30, dtype=bool)) | {
        frozenset(vertex + 30 for vertex in edge)
        for edge in chosen_edges(other, np.zeros(36, dtype=bool))
    }
    assert chosen_edges(both, np.zeros(66, dtype=bool)) == expected
