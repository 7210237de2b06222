"""Facts of a mesh, counted by hand."""

from __future__ import annotations

import numpy as np
import pytest

from elastomorph.errors import TopologyError
from elastomorph.model.inspection import displacement, mesh_facts
from elastomorph.model.mesh import Mesh


def test_a_cube_and_a_loose_triangle_and_a_lone_vertex() -> None:
    cube = [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    loose = [[3, 0, 0], [4, 0, 0], [3, 1, 0], [9, 9, 9]]
    facts = mesh_facts(Mesh(np.array(cube + loose, float), [*quads, [8, 9, 10]]))
    assert facts.polygons == {3: 1, 4: 6}
    assert (facts.vertices, facts.edges) == (12, 15)
    assert (facts.border_edges, facts.non_manifold_edges) == (3, 0)
    assert (facts.components, facts.isolated_vertices) == (2, 1)
    assert facts.poles == 8  # every corner of the cube has three edges
    assert facts.diameter == pytest.approx(np.sqrt(243))
    assert facts.highest == (9, 9, 9)


def test_three_triangles_on_one_edge() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, -1, 0]], float)
    facts = mesh_facts(Mesh(points, [[0, 1, 2], [0, 1, 3], [0, 1, 4]]))
    assert (facts.edges, facts.border_edges, facts.non_manifold_edges) == (7, 6, 1)


def test_markers_without_polygons() -> None:
    facts = mesh_facts(Mesh(np.eye(3)))
    assert (facts.edges, facts.components, facts.isolated_vertices) == (0, 0, 3)


def test_displacement_of_one_vertex() -> None:
    neutral = Mesh([[0, 0, 0], [2, 0, 0], [0, 1, 0]])
    target = neutral.with_vertices([[0, 0, 0], [2, 0, 0.5], [0, 1, 0]])
    moved = displacement(neutral, target)
    assert (moved.moved, moved.farthest_vertex) == (1, 1)
    assert moved.largest == pytest.approx(0.5 / np.sqrt(5))
    assert moved.mean_of_moved == moved.largest
    with pytest.raises(TopologyError):
        displacement(neutral, Mesh(np.zeros((4, 3))))
