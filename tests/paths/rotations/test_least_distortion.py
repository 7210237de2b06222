"""The Poisson equation of turning edges against its energy and against true turns."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import elastomorph as em
from elastomorph.paths.rotations import (
    ArcBend,
    EdgeBend,
    LeastDistortion,
    Neighbourhoods,
    SurfaceEdges,
    VertexRotations,
    vertex_rotations,
)

Rigid = Callable[..., NDArray[np.float64]]
Sheet = Callable[[int, int], em.Mesh]


@pytest.mark.parametrize("degrees", [10, 90, 170])
def test_the_equation_itself_keeps_a_rigid_copy_rigid(
    sheet: Sheet, rigid: Rigid, degrees: float
) -> None:
    """Nothing pinned as a whole: every vertex is solved for, and follows the true arc."""
    mesh = sheet(5, 4)
    vector = np.radians(degrees) * np.array([0.6, 0.0, 0.8])
    where = np.array([3.0, -8.0, 1.0]), np.array([0.0, 0.0, 0.0])
    end = rigid(mesh.vertices, vector, *where)
    half = np.radians(degrees) / 2
    quaternion = np.append(np.cos(half), np.sin(half) * vector / np.linalg.norm(vector))
    each = VertexRotations(np.tile(quaternion, (len(end), 1)), (), np.zeros(len(end), bool))
    surface = SurfaceEdges.of(mesh)
    bend = LeastDistortion.of(mesh.vertices, end, each, surface).bend()
    for t in (0.2, 0.5, 0.9):
        found = (1 - t) * mesh.vertices + t * end + bend.at(t)
        true = rigid(mesh.vertices, t * vector, *where)
        assert np.abs(found - true).max() < 1e-7 * mesh.diameter


def test_it_minimises_the_stated_energy(sheet: Sheet) -> None:
    """The same by dense least squares over all rows, edges and arcs, written one by one."""
    mesh = sheet(4, 3)
    rng = np.random.default_rng(5)
    end = Rotation.from_rotvec([0.0, 0.0, 0.9]).apply(mesh.vertices.copy())
    end += 0.15 * rng.normal(size=end.shape)
    still = mesh.vertices[:, 1] == 0
    end[still] = mesh.vertices[still]
    around = Neighbourhoods.of(len(end), mesh.edges)
    turns = vertex_rotations(mesh.vertices, end, around, diameter=mesh.diameter, rings=1)
    assert turns.whole == ()
    surface = SurfaceEdges.of(mesh)
    t = 0.4
    rows, wanted = [], []
    for (i, j), weight in zip(surface.ends, surface.weights, strict=True):
        before, after = mesh.vertices[j] - mesh.vertices[i], end[j] - end[i]
        here = Rotation.from_rotvec(turns.vectors[[i, j]])
        vector = here.mean().as_rotvec()
        off = Rotation.from_rotvec(vector).apply(before) - after
        shorter = min(np.linalg.norm(before), np.linalg.norm(after))
        weight = weight / (1 + (np.linalg.norm(off) / (0.3 * shorter)) ** 2)
        edge = (1 - t) * before + t * after + EdgeBend.of(before[None], after[None], vector).at(t)
        row = np.zeros(len(end))
        row[[i, j]] = -1.0, 1.0
        rows.append(np.sqrt(weight) * row)
        wanted.append(np.sqrt(weight) * edge[0])
    chords = end - mesh.vertices
    arcs = mesh.vertices + t * chords + ArcBend.of(chords, turns.vectors).at(t)
    share = np.sqrt(0.01 * surface.mass)
    rows += list(np.diag(share))
    wanted += list(share[:, None] * arcs)
    matrix, right = np.array(rows), np.array(wanted)
    right -= matrix[:, still] @ mesh.vertices[still]
    expected = np.linalg.lstsq(matrix[:, ~still], right, rcond=None)[0]
    turning = LeastDistortion.of(mesh.vertices, end, turns, surface)
    for bend in (turning.at(t), turning.bend().at(t)):
        found = mesh.vertices + t * chords + bend
        np.testing.assert_allclose(found[~still], expected, atol=1e-7)
        assert not bend[still].any()


def test_negative_weights_count_as_none(sheet: Sheet) -> None:
    """Obtuse triangles leave an energy that is bounded below."""
    mesh = em.Mesh([[0, 0, 0], [1, 0, 0], [0.5, 0.1, 0], [0.5, -0.1, 0]], [[0, 1, 2], [1, 0, 3]])
    surface = SurfaceEdges.of(mesh)
    assert (surface.weights > 0).all()
    assert [0, 1] not in surface.ends.tolist()


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
