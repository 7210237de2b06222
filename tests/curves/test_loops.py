"""Edge loops: hand-counted on regular meshes, and properties on random ones."""

from __future__ import annotations

from collections import Counter
from math import gcd

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from slow_loops import slow_loops
from topologies import (
    anything,
    cube,
    fan,
    figure_eight,
    grid,
    patiently,
    relabelled,
    surfaces,
    triangulated,
)

from elastomorph.curves import Curve, edge_loops
from elastomorph.curves.extraction import edge_ends, trace_loops
from elastomorph.model.mesh import Mesh


def kinds(loops: tuple[Curve, ...]) -> Counter[tuple[int, bool]]:
    """How many loops there are of each number of vertices, open or closed."""
    return Counter((len(loop), loop.closed) for loop in loops)


def edge_set(curve: Curve) -> frozenset[tuple[int, int]]:
    return frozenset((min(a, b), max(a, b)) for a, b in curve.edges.tolist())


def test_a_grid_has_its_border_its_inner_rows_and_its_inner_columns():
    assert kinds(edge_loops(grid(4, 6))) == {(16, True): 1, (6, False): 2, (4, False): 4}


def test_the_loops_of_a_grid_are_its_lines():
    loops = {tuple(loop.vertices.tolist()) for loop in edge_loops(grid(3, 4)) if not loop.closed}
    assert loops == {(4, 5, 6, 7), (1, 5, 9), (2, 6, 10)}


def test_every_edge_of_a_cube_is_a_loop_of_its_own():
    assert kinds(edge_loops(cube())) == {(2, False): 12}


def test_a_tube_has_closed_rings_and_open_lines():
    assert kinds(edge_loops(grid(5, 8, around=True))) == {(8, True): 5, (5, False): 8}


def test_all_loops_of_a_torus_are_closed():
    torus = grid(5, 8, around=True, through=True)
    assert kinds(edge_loops(torus)) == {(8, True): 5, (5, True): 8}


def test_a_fan_of_six_has_three_diameters_and_a_rim():
    assert kinds(edge_loops(fan(6))) == {(3, False): 3, (6, True): 1}


def test_a_fan_of_five_has_five_spokes_and_a_rim():
    assert kinds(edge_loops(fan(5))) == {(2, False): 5, (5, True): 1}


def test_a_regular_triangle_lattice_is_passed_straight_in_three_directions():
    rows, columns = 4, 6
    lattice = triangulated(grid(rows, columns, around=True, through=True))
    diagonals = gcd(rows, columns)
    assert kinds(edge_loops(lattice)) == Counter(
        {(columns, True): rows, (rows, True): columns}
    ) + Counter({(rows * columns // diagonals, True): diagonals})
    for loop in edge_loops(lattice):
        row, column = np.divmod(loop.edges, columns)
        steps = np.stack([np.diff(row)[:, 0] % rows, np.diff(column)[:, 0] % columns], axis=1)
        assert len(np.unique(steps, axis=0)) == 1


def test_a_loop_through_a_vertex_twice_is_cut_into_its_lobes():
    mesh, one, other = figure_eight()
    lobes = {edge_set(Curve(lobe, closed=True)) for lobe in (one, other)}
    found = [loop for loop in edge_loops(mesh) if edge_set(loop) in lobes]
    assert kinds(tuple(found)) == {(4, True): 2}
    whole = trace_loops(edge_ends(mesh.faces, len(mesh.vertices)))
    assert any(
        closed and len(items) == 8 and len(set(items.tolist())) == 7
        for items, closed in zip(whole.arrays(), whole.closed, strict=True)
    )


def test_a_mesh_without_polygons_has_no_loops():
    assert edge_loops(Mesh([[0.0, 0.0, 0.0]])) == ()


def test_a_vertex_repeated_in_a_row_counts_once():
    degenerate = Mesh(np.eye(3), [[0, 0, 1, 2], [1, 1, 1], [2, 2, 0]])
    plain = Mesh(np.eye(3), [[0, 1, 2]])
    assert set(map(edge_set, edge_loops(degenerate))) == set(map(edge_set, edge_loops(plain)))


@patiently
@given(anything)
def test_every_edge_lies_on_exactly_one_loop(mesh):
    edges = Counter(edge for loop in edge_loops(mesh) for edge in edge_set(loop))
    assert edges == Counter(tuple(edge) for edge in mesh.edges.tolist())


@patiently
@given(anything)
def test_loops_are_those_found_one_edge_at_a_time(mesh):
    whole = trace_loops(edge_ends(mesh.faces, len(mesh.vertices)))
    found = set()
    for items, closed in zip(whole.arrays(), whole.closed.tolist(), strict=True):
        following = np.roll(items, -1) if closed else items[1:]
        pairs = zip(items.tolist(), following.tolist(), strict=False)
        found.add((frozenset((min(pair), max(pair)) for pair in pairs), closed))
    assert found == slow_loops(mesh)


@patiently
@given(surfaces(), st.randoms(use_true_random=False))
def test_loops_do_not_depend_on_numbering(mesh, random):
    count = len(mesh.vertices)
    new_index = np.array(random.sample(range(count), count))
    order = random.sample(range(len(mesh.faces)), len(mesh.faces))
    other = relabelled(mesh, new_index, order)
    moved = {
        (edge_set(Curve(new_index[loop.vertices], loop.closed)), loop.closed)
        for loop in edge_loops(mesh)
    }
    assert moved == {(edge_set(loop), loop.closed) for loop in edge_loops(other)}


@patiently
@given(surfaces(), st.randoms(use_true_random=False))
def test_loops_do_not_depend_on_winding(mesh, random):
    faces = [face[:: random.choice([1, -1])].tolist() for face in mesh.faces]
    flipped = edge_loops(Mesh(mesh.vertices, faces))
    assert {edge_set(loop) for loop in flipped} == {edge_set(loop) for loop in edge_loops(mesh)}
