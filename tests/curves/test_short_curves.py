"""Short curves: each kind of join on the smallest case that calls for it."""

from __future__ import annotations

import numpy as np
from topologies import fan, grid

from elastomorph.curves.extraction import GrowingCurves, join_short_curves, ordered_chains
from elastomorph.model.mesh import Mesh


def mended(
    mesh: Mesh, curves: list[tuple[list[int], bool]], fixed: tuple[int, ...] = ()
) -> list[tuple[list[int], bool]]:
    """The curves after joining, short ones that stay among them."""
    count = len(mesh.vertices)
    growing = GrowingCurves(np.full((count, 2), -1, dtype=np.int32), np.zeros(count, dtype=bool))
    for vertices, closed in curves:
        for place, vertex in enumerate(vertices):
            growing.is_closed[vertex] = closed
            if place or closed:
                growing.links[vertex, 0] = vertices[place - 1]
            if closed or place + 1 < len(vertices):
                growing.links[vertex, 1] = vertices[(place + 1) % len(vertices)]
    fixed_mask = np.zeros(count, dtype=bool)
    fixed_mask[list(fixed)] = True
    join_short_curves(growing, fixed_mask, mesh.edges, mesh.vertices)
    chains = ordered_chains(growing.links)
    rings = np.repeat(chains.closed, chains.lengths)
    assert np.array_equal(growing.is_closed[chains.items], rings)
    return [
        (items.tolist(), closed)
        for items, closed in zip(chains.arrays(), chains.closed.tolist(), strict=True)
    ]


def test_a_short_curve_is_appended_to_the_end_that_it_continues_most_straight():
    # 0 1 2 3
    # 4 5 6 7   7 is left: 4 5 6 goes straight on to it, 1 2 3 would have to turn
    # 8 9 . .
    mesh = grid(3, 4)
    curves = [([1, 2, 3], False), ([4, 5, 6], False), ([0], False), ([8, 9, 10, 11], False)]
    after = mended(mesh, curves, fixed=(0,))
    assert ([4, 5, 6, 7], False) in after
    assert ([1, 2, 3], False) in after


def test_between_two_consecutive_vertices_it_is_inserted_and_the_ring_stays_closed():
    after = mended(fan(5), [([1, 2, 3, 4, 5], True)])
    assert len(after) == 1
    assert after[0][1]
    assert sorted(after[0][0]) == [0, 1, 2, 3, 4, 5]


def test_two_short_curves_side_by_side_are_inserted_between_two_vertices_of_a_ring():
    # a ring of ten around the two inner vertices 5 and 6 of a 3 × 4 grid
    ring = [0, 1, 2, 3, 7, 11, 10, 9, 8, 4]
    after = mended(grid(3, 4), [(ring, True)])
    assert len(after) == 1
    assert after[0][1]
    assert len(after[0][0]) == 12


def test_an_open_curve_is_cut_where_both_parts_keep_three_vertices():
    # the foot of a T: vertex 7 below the middle of a line of seven
    mesh = Mesh(
        [[i, 0, 0] for i in range(7)] + [[3, -1, 0]] + [[-1, -1, 0]],
        [[2, 3, 7], [3, 4, 7]],
    )
    wires = Mesh(mesh.vertices, [[i, i + 1, i] for i in range(6)] + [[3, 7, 3]])
    after = mended(wires, [(list(range(7)), False)])
    assert sorted(len(items) for items, _ in after) == [1, 3, 5]
    assert any(set(items) in ({0, 1, 2, 3, 7}, {3, 4, 5, 6, 7}) for items, _ in after)


def test_a_curve_too_short_to_cut_is_left_alone():
    wires = Mesh(
        np.random.default_rng(0).random((6, 3)), [[0, 1, 0], [1, 2, 1], [2, 3, 2], [1, 4, 1]]
    )
    assert ([0, 1, 2, 3], False) in mended(wires, [([0, 1, 2, 3], False)])


def test_a_ring_with_one_vertex_inside_is_opened_for_it():
    ring = [0, 1, 2, 5, 8, 7, 6, 3]
    after = mended(grid(3, 3), [(ring, True)])
    assert len(after) == 1
    items, closed = after[0]
    assert not closed
    assert 4 in (items[0], items[-1])
    assert sorted(items) == list(range(9))


def test_curves_that_are_fixed_are_left_as_they_are():
    ring = [0, 1, 2, 5, 8, 7, 6, 3]
    after = mended(grid(3, 3), [(ring, True)], fixed=tuple(ring))
    assert ([4], False) in after
    assert sum(closed for _, closed in after) == 1


def test_short_curves_are_joined_with_each_other():
    after = mended(grid(2, 2), [])
    assert [sorted(items) for items, _ in after] == [[0, 1, 2, 3]]


def test_two_vertices_by_themselves_become_one_curve_of_two():
    wire = Mesh(np.eye(3), [[0, 1, 0]])
    assert mended(wire, []) == [([0, 1], False), ([2], False)]
