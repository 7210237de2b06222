"""The bound that needs no solve, against the solve."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

import elastomorph as em
from elastomorph.paths.rotations import (
    LeastDistortion,
    Neighbourhoods,
    SurfaceEdges,
    vertex_rotations,
)


@given(st.integers(0, 10**6), st.floats(1e-3, 3.0), st.booleans())
@settings(max_examples=40, deadline=None)
def test_no_bend_exceeds_the_bound(seed: int, size: float, pinned: bool) -> None:
    """Of any polygons and any motion, with and without vertices that stay."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(14, 3))
    faces = rng.permuted(np.tile(np.arange(14), (12, 1)), axis=1)[:, :3]
    mesh = em.Mesh(points, faces)
    end = points + size * rng.normal(size=points.shape)
    if pinned:
        end[:4] = points[:4]
    around = Neighbourhoods.of(14, mesh.edges)
    turns = vertex_rotations(points, end, around, diameter=mesh.diameter, rings=2)
    equation = LeastDistortion.of(points, end, turns, SurfaceEdges.of(mesh))
    for t in (0.2, 0.5, 0.8):
        longest = np.linalg.norm(equation.at(t), axis=1).max()
        assert longest <= equation.at_most(t) * (1 + 1e-9)


def test_the_bound_is_nothing_where_nothing_turns(sheet: Callable[[int, int], em.Mesh]) -> None:
    mesh = sheet(4, 4)
    around = Neighbourhoods.of(len(mesh.vertices), mesh.edges)
    end = mesh.vertices + [0.0, 0.0, 2.0]
    turns = vertex_rotations(mesh.vertices, end, around, diameter=mesh.diameter, rings=2)
    equation = LeastDistortion.of(mesh.vertices, end, turns, SurfaceEdges.of(mesh))
    assert equation.at_most(0.5) < 1e-12
