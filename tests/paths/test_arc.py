"""Arcs: true turns, exact ends, and a path for whatever mesh there is."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from turned_meshes import random_triangles, rigid

import elastomorph as em
from elastomorph.curves import Curve, CurveNetwork
from elastomorph.model.geometry import fit_rigid
from elastomorph.paths.arc import Arc, Arcs, bent_path, neighbourhoods
from small_head import head, shapes

TIMES = (0.0, 0.2, 0.5, 0.7, 1.0)
METHOD = Arc()


def arc_path(neutral: em.Mesh, target: em.Mesh) -> Callable[[float], NDArray[np.float64]]:
    """The arcs themselves, before they are stored."""
    return bent_path(neutral, target, Arcs.of(neutral, target, neighbourhoods(neutral)).at)


@pytest.fixture(scope="module")
def face() -> em.Mesh:
    return head()


@given(st.integers(0, 10**6), st.floats(0.0, 170.0))
@settings(max_examples=15, deadline=None)
def test_a_rigid_copy_follows_the_true_arc(seed: int, degrees: float) -> None:
    """Of any triangles, crossing ones too, at every t to 1e-6 of D."""
    rng = np.random.default_rng(seed)
    mesh = em.Mesh(rng.normal(size=(12, 3)), random_triangles(rng, 9))
    axis = rng.normal(size=3)
    vector = np.radians(degrees) * axis / np.linalg.norm(axis)
    loose = np.setdiff1d(np.arange(12), mesh.faces.indices)
    end = rigid(mesh.vertices, vector)
    end[loose] = mesh.vertices[loose]
    path = arc_path(mesh, mesh.with_vertices(end))
    on = np.setdiff1d(np.arange(12), loose)
    for t in TIMES:
        true = rigid(mesh.vertices, t * vector)
        assert np.abs(path(t) - true)[on].max() < 1e-6 * mesh.diameter


@pytest.mark.parametrize("degrees", [30.0, 170.0, 180.0])
def test_a_rigid_head_is_stored_within_the_tolerance(face: em.Mesh, degrees: float) -> None:
    vector = np.radians(degrees) * np.array([0.36, 0.48, 0.8])
    morph = METHOD.prepare(face)(face.with_vertices(rigid(face.vertices, vector)))
    assert morph.bake_error <= 1e-4
    for t in TIMES:
        turned = fit_rigid(face.vertices, morph.at(t))[1]
        assert turned.max() < 2e-4 * face.diameter


def test_the_pair_may_be_moved_and_scaled(face: em.Mesh) -> None:
    """Moving neutral and target moves the path: equivariance under similarities."""
    target = shapes()["jawOpen"]
    turn, scale = Rotation.from_rotvec([0.3, -1.0, 0.4]), 0.01

    def moved(points: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(scale * turn.apply(points.copy()) + [1.0, 2.0, 3.0])

    path = arc_path(face, target)
    other = arc_path(
        face.with_vertices(moved(face.vertices)), target.with_vertices(moved(target.vertices))
    )
    for t in TIMES:
        gap = np.abs(other(t) - moved(path(t))).max()
        assert gap < 1e-6 * scale * face.diameter


def test_the_way_back_is_the_same_path(face: em.Mesh) -> None:
    target = shapes()["jawOpen"]
    there, back = arc_path(face, target), arc_path(target, face)
    for t in TIMES:
        assert np.abs(there(t) - back(1 - t)).max() < 1e-6 * face.diameter


def test_without_turn_the_path_is_straight(face: em.Mesh) -> None:
    """Shifts, scalings and symmetric stretches, to 1e-9 of D."""
    stretch = np.array([[1.2, 0.1, 0.0], [0.1, 0.8, 0.2], [0.0, 0.2, 1.1]])
    for end in (face.vertices + 3.0, 2.0 * face.vertices, face.vertices @ stretch):
        path = arc_path(face, face.with_vertices(end))
        for t in TIMES:
            straight = (1 - t) * face.vertices + t * end
            assert np.abs(path(t) - straight).max() < 1e-9 * face.diameter


def test_both_ends_are_exact_to_the_last_bit(face: em.Mesh) -> None:
    target = shapes()["jawOpen"]
    path, morph = arc_path(face, target), METHOD.prepare(face)(target)
    for at in (path, morph.at):
        assert at(0.0).tobytes() == face.vertices.tobytes()
        assert at(1.0).tobytes() == target.vertices.tobytes()


def test_vertices_that_do_not_move_stay(face: em.Mesh) -> None:
    target = shapes()["jawOpen"]
    still = (target.vertices == face.vertices).all(axis=1)
    assert still.any()
    np.testing.assert_array_equal(arc_path(face, target)(0.4)[still], face.vertices[still])
    morph = METHOD.prepare(face)(target)
    assert not morph.bends[:, still].any()


@given(st.integers(0, 10**6))
@settings(max_examples=25, deadline=None)
def test_any_polygons_have_a_path(seed: int) -> None:
    """Crossing, duplicated, flipped, flat and vanishing polygons, edges with many of them."""
    rng = np.random.default_rng(seed)
    points = rng.integers(-2, 3, size=(14, 3)).astype(float)
    faces = random_triangles(rng, 8).tolist()
    faces += [faces[0], faces[1][::-1]]
    end = rng.integers(-2, 3, size=points.shape).astype(float)
    end[faces[2]] = end[faces[2][0]]
    mesh = em.Mesh(points, faces)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", em.ElastomorphWarning)
        morph = METHOD.prepare(mesh)(mesh.with_vertices(end))
    assert np.isfinite(morph.at(TIMES)).all()
    assert morph.at(1.0).tobytes() == end.tobytes()


def test_markers_without_edges_go_straight_and_say_so() -> None:
    markers = em.Mesh(np.random.default_rng(0).normal(size=(6, 3)))
    target = markers.with_vertices(rigid(markers.vertices, np.array([0.0, 0.0, 1.0])))
    with pytest.warns(em.ElastomorphWarning, match="6 moving vertices .* first is 0"):
        morph = METHOD.prepare(markers)(target)
    assert len(morph.bends) == 0


def test_markers_on_curves_turn_with_them() -> None:
    """Curves stand in for edges: a rigidly turned ring of markers stays rigid."""
    angle = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    markers = em.Mesh(np.stack([np.cos(angle), np.sin(angle), 0.1 * np.cos(3 * angle)], axis=1))
    curves = CurveNetwork((Curve(np.arange(12), True),), 12)
    vector = np.array([1.0, 0.5, 0.0])
    target = markers.with_vertices(rigid(markers.vertices, vector))
    morph = METHOD.prepare(markers, curves)(target)
    true = rigid(markers.vertices, 0.5 * vector)
    assert np.abs(morph.at(0.5) - true).max() < 1e-4 * markers.diameter


def test_bad_arguments_are_named(face: em.Mesh) -> None:
    with pytest.raises(em.TopologyError):
        arc_path(face, em.Mesh(face.vertices))


@pytest.mark.realdata
def test_the_jaw_swings_about_its_hinge(data_dir: Path) -> None:
    """Teeth within 0.08 % and gums within 0.25 % of D of the true arc; linear is 0.67 % off."""
    neutral = em.read(data_dir / "ict-facekit" / "generic_neutral_mesh.obj")
    target = em.read(data_dir / "ict-facekit" / "jawOpen.obj")
    morph = METHOD.prepare(neutral)(target)
    start, end = neutral.vertices, target.vertices
    teeth = 17039 + np.flatnonzero((start != end)[17039:21451].any(axis=1))
    screw, residual = fit_rigid(start[teeth], end[teeth])
    gums = np.arange(14062, 17039)
    gums = gums[np.linalg.norm(screw.at(1, start[gums]) - end[gums], axis=1) <= residual.max()]
    assert len(teeth) == 2204
    assert len(gums) > 1600
    for t in (0.25, 0.5, 0.75):
        for part, allowed in ((teeth, 0.0008), (gums, 0.0025)):
            off = np.linalg.norm(morph.at(t)[part] - screw.at(t, start[part]), axis=1)
            assert off.max() < allowed * neutral.diameter
