"""The Poisson equation of turning edges against its energy and against true turns."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
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
    each = VertexRotations(np.tile(quaternion, (len(end), 1)), ())
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
