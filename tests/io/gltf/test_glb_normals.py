"""Normals are those of the surface at both ends, and turn with it in between."""

from __future__ import annotations

import numpy as np
import pytest

from elastomorph.io.gltf.morph_targets import NormalField, normal_deltas
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.model.polygons import Polygons
from elastomorph.paths.bake import bake

QUADS = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


def cube() -> Mesh:
    corners = [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    return Mesh(corners, QUADS)


def angles(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(one, axis=1) * np.linalg.norm(other, axis=1)
    return np.degrees(np.arccos(np.clip(np.einsum("ij,ij->i", one, other) / length, -1, 1)))


def test_the_corner_of_a_cube_looks_along_its_diagonal_however_it_is_cut() -> None:
    """Weighting by angle makes the three sides count alike, though one has two triangles there."""
    mesh = cube()
    for faces in (mesh.faces, Polygons.of(mesh.faces.triangles())):
        found = NormalField.of(faces).normals(mesh.vertices)
        np.testing.assert_allclose(found, mesh.vertices / np.sqrt(3), atol=1e-12)


def test_orientation_follows_the_order_of_the_corners() -> None:
    flat = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    for face, side in (([0, 1, 2], 1), ([0, 2, 1], -1)):
        found = NormalField.of(Polygons.of([face])).normals(np.array(flat, dtype=float))
        np.testing.assert_allclose(found, [[0, 0, side]] * 3)


def test_vertices_without_area_look_along_z() -> None:
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [5, 5, 5]])
    found = NormalField.of(Polygons.of([[0, 1, 2]])).normals(vertices)
    np.testing.assert_array_equal(found, [[0, 0, 1]] * 4)
    both_sides = NormalField.of(Polygons.of([[0, 1, 2], [2, 1, 0]]))
    found = both_sides.normals(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]))
    np.testing.assert_array_equal(found, [[0, 0, 1]] * 3)


def turned(angle: float) -> np.ndarray:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, cos, -sin], [0, sin, cos]])


def test_both_ends_are_right() -> None:
    mesh = cube()
    target = mesh.with_vertices(mesh.vertices @ turned(0.6).T)
    field = NormalField.of(mesh.faces)
    at_rest = field.normals(mesh.vertices)
    morph = Morph(mesh, target, np.zeros((0, 8, 3)), ())
    delta = normal_deltas(field, morph, (), at_rest)
    assert delta.shape == (1, 8, 3)
    np.testing.assert_allclose(at_rest + delta[0], at_rest @ turned(0.6).T, atol=1e-12)


def test_a_bend_that_repeats_delta_turns_the_normals_as_delta_does() -> None:
    """Then V(t) is the straight path at t + b(t), and so are the normals, to first order."""
    mesh = cube()
    target = mesh.with_vertices(mesh.vertices @ turned(0.02).T)
    morph = Morph(mesh, target, (target.vertices - mesh.vertices)[None], (BendCurve.power(2),))
    field = NormalField.of(mesh.faces)
    delta, bend = normal_deltas(field, morph, (0,), field.normals(mesh.vertices))
    np.testing.assert_allclose(bend, delta, atol=0.02 * np.abs(delta).max())


def test_bends_of_a_turning_body_keep_its_normals_within_a_hundredth_of_a_degree() -> None:
    """Without them the chord of the normals is more than two degrees off."""
    mesh, whole = cube(), 0.9
    target = mesh.with_vertices(mesh.vertices @ turned(whole).T)
    morph = bake(lambda t: mesh.vertices @ turned(t * whole).T, mesh, target, tolerance=1e-6)
    field = NormalField.of(mesh.faces)
    at_rest = field.normals(mesh.vertices)
    kept = tuple(range(len(morph.bends)))
    deltas = normal_deltas(field, morph, kept, at_rest)
    for t in (0.25, 0.5, 0.75):
        true = at_rest @ turned(t * whole).T
        weights = np.array([t, *(float(curve(t)) for curve in morph.bend_curves)])
        assert angles(at_rest + np.tensordot(weights, deltas, axes=1), true).max() < 0.01
    straight = angles(at_rest + 0.25 * deltas[0], at_rest @ turned(0.25 * whole).T).max()
    assert straight == pytest.approx(chord_error(whole, 0.25), abs=1e-6)
    assert straight > 2


def chord_error(whole: float, t: float) -> float:
    """Degrees between (1, 1, 1) turned about x by t of an angle, and the chord of its turn at t.

    Across the axis the chord is a complex number; along the axis 1/3 of the square stays.
    """
    chord = (1 - t) + t * np.exp(1j * whole)
    lag = np.angle(chord) - t * whole
    cosine = (1 / 3 + 2 / 3 * abs(chord) * np.cos(lag)) / np.sqrt(1 / 3 + 2 / 3 * abs(chord) ** 2)
    return float(np.degrees(np.arccos(cosine)))
