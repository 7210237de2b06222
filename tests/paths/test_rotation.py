"""Least distortion: true turns, exact ends, and a path or one clear error for any mesh."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from turned_meshes import random_triangles, rigid

import elastomorph as em
from elastomorph.evaluation.shape import ShapeProbe
from elastomorph.model.geometry import fit_rigid
from elastomorph.paths import rotation
from small_head import head, shapes

TIMES = (0.0, 0.2, 0.5, 0.7, 1.0)
METHOD = rotation.Rotation()


def bar() -> em.Mesh:
    """A square bar of 1 × 1 × 12 along y, its ends open."""
    ring = np.array([[0, 0], [0.5, 0], [1, 0], [1, 0.5], [1, 1], [0.5, 1], [0, 1], [0, 0.5]])
    points = [[x, y, z] for y in np.arange(0, 12.5, 0.5) for x, z in ring]
    quads = [
        [8 * r + c, 8 * r + (c + 1) % 8, 8 * r + 8 + (c + 1) % 8, 8 * r + 8 + c]
        for r in range(24)
        for c in range(8)
    ]
    return em.Mesh(points, quads)


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
    path = rotation.rotation_path(mesh, mesh.with_vertices(end))
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


def test_a_bar_that_turns_and_doubles_its_length_does_both_steadily() -> None:
    """exp(t log R)((1 - t)I + tS) of one affine map, wherever it is."""
    mesh = bar()
    vector, stretch = np.array([0.0, 0.0, 1.2]), np.diag([1.0, 2.0, 1.0])
    middle = mesh.vertices.mean(axis=0)
    end = Rotation.from_rotvec(vector).apply((mesh.vertices - middle) @ stretch) + [4.0, 0, 0]
    path = rotation.rotation_path(mesh, mesh.with_vertices(end))
    for t in TIMES:
        partly = (1 - t) * np.eye(3) + t * stretch
        shape = Rotation.from_rotvec(t * vector).apply((mesh.vertices - middle) @ partly)
        found = path(t)
        np.testing.assert_allclose(found - found.mean(axis=0), shape, atol=1e-8)


def test_a_bending_bar_keeps_its_lengths_better_than_straight_lines() -> None:
    """Rolled up to a half circle: edges keep their length where linear shortens them."""
    mesh = bar()
    x, y, z = mesh.vertices.T
    angle = np.pi * y / 12
    radius = 12 / np.pi + x
    end = np.stack([radius * np.cos(angle) - 12 / np.pi, radius * np.sin(angle), z], axis=1)
    target = mesh.with_vertices(end)
    path, straight = rotation.rotation_path(mesh, target), em.interpolate(mesh, target, "linear")

    def distortion(points: NDArray[np.float64]) -> float:
        def lengths(at: NDArray[np.float64]) -> NDArray[np.float64]:
            return np.linalg.norm(np.diff(at[mesh.edges], axis=1)[:, 0], axis=1)

        kept = (lengths(mesh.vertices) + lengths(end)) / 2
        return float(np.abs(lengths(points) / kept - 1).max())

    assert distortion(straight.at(0.5)) > 0.25
    assert distortion(path(0.5)) < 0.01


def test_the_pair_may_be_moved_and_scaled(face: em.Mesh) -> None:
    """Moving neutral and target moves the path: equivariance under similarities."""
    target = shapes()["jawOpen"]
    turn, scale = Rotation.from_rotvec([0.3, -1.0, 0.4]), 0.01

    def moved(points: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(scale * turn.apply(points.copy()) + [1.0, 2.0, 3.0])

    path = rotation.rotation_path(face, target)
    other = rotation.rotation_path(
        face.with_vertices(moved(face.vertices)), target.with_vertices(moved(target.vertices))
    )
    still = (target.vertices == face.vertices).all(axis=1)
    assert still.any()
    for t in TIMES:
        gap = np.abs(other(t) - moved(path(t))).max()
        assert gap < 1e-6 * scale * face.diameter


def test_without_turn_the_path_is_straight(face: em.Mesh) -> None:
    """Shifts, scalings and symmetric stretches, to 1e-9 of D."""
    stretch = np.array([[1.2, 0.1, 0.0], [0.1, 0.8, 0.2], [0.0, 0.2, 1.1]])
    for end in (face.vertices + 3.0, 2.0 * face.vertices, face.vertices @ stretch):
        path = rotation.rotation_path(face, face.with_vertices(end))
        for t in TIMES:
            straight = (1 - t) * face.vertices + t * end
            assert np.abs(path(t) - straight).max() < 1e-9 * face.diameter


def test_both_ends_are_exact_to_the_last_bit(face: em.Mesh) -> None:
    target = shapes()["jawOpen"]
    path, morph = rotation.rotation_path(face, target), METHOD.prepare(face)(target)
    for at in (path, morph.at):
        assert at(0.0).tobytes() == face.vertices.tobytes()
        assert at(1.0).tobytes() == target.vertices.tobytes()


def test_vertices_that_do_not_move_stay(face: em.Mesh) -> None:
    target = shapes()["jawOpen"]
    still = (target.vertices == face.vertices).all(axis=1)
    assert still.any()
    path = rotation.rotation_path(face, target)
    np.testing.assert_array_equal(path(0.4)[still], face.vertices[still])
    assert not METHOD.prepare(face)(target).bends[:, still].any()


@given(st.integers(0, 10**6))
@settings(max_examples=25, deadline=None)
def test_any_polygons_with_an_area_have_a_path(seed: int) -> None:
    """Crossing, duplicated, flipped, flat and vanishing polygons, edges with many of them."""
    rng = np.random.default_rng(seed)
    points = rng.integers(-2, 3, size=(14, 3)).astype(float)
    faces = random_triangles(rng, 8).tolist()
    faces += [faces[0], faces[1][::-1], [12, 13, 0, 1]]
    end = rng.integers(-2, 3, size=points.shape).astype(float)
    end[faces[2]] = end[faces[2][0]]
    mesh = em.Mesh(points, faces)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", em.ElastomorphWarning)
        morph = METHOD.prepare(mesh)(mesh.with_vertices(end))
    assert np.isfinite(morph.at(TIMES)).all()
    assert morph.at(1.0).tobytes() == end.tobytes()
    assert np.linalg.norm(morph.at(0.5) - (points + end) / 2, axis=1).max() < 3 * mesh.diameter


def test_a_part_that_vanishes_or_appears_goes_straight() -> None:
    """To a point and out of one, beside a part that turns."""
    mesh = bar()
    count = len(mesh.vertices)
    twice = em.Mesh(
        np.concatenate([mesh.vertices, mesh.vertices + [5.0, 0, 0]]),
        np.concatenate([np.array(list(mesh.faces)), np.array(list(mesh.faces)) + count]),
    )
    end = rigid(twice.vertices, np.array([0.0, 1.0, 0.0]))
    end[count:] = [1.0, 2.0, 3.0]
    for first, last in ((twice.vertices, end), (end, twice.vertices)):
        path = rotation.rotation_path(twice.with_vertices(first), twice.with_vertices(last))
        half = path(0.5)
        assert np.abs(half - (first + last) / 2)[count:].max() < 1e-9 * twice.diameter
        true = rigid(twice.vertices, np.array([0.0, 0.5, 0.0]))
        assert np.abs(half - true)[:count].max() < 1e-6 * twice.diameter


def test_loose_vertices_go_straight_and_are_named() -> None:
    mesh = bar()
    loose = em.Mesh(np.concatenate([mesh.vertices, [[9.0, 9.0, 9.0]]]), mesh.faces)
    end = rigid(loose.vertices, np.array([0.0, 1.0, 0.0]))
    with pytest.warns(em.ElastomorphWarning, match="1 moving vertices .* first is 200"):
        path = rotation.rotation_path(loose, loose.with_vertices(end))
    np.testing.assert_allclose(path(0.5)[-1], (loose.vertices + end)[-1] / 2, atol=1e-12)


def test_meshes_without_surface_are_refused_and_so_are_bad_arguments(face: em.Mesh) -> None:
    with pytest.raises(em.MeshError, match="has no surface"):
        METHOD.prepare(em.Mesh(np.eye(3)))
    with pytest.raises(em.TopologyError):
        rotation.rotation_path(face, em.Mesh(face.vertices))


@pytest.fixture(scope="module")
def rig(data_dir: Path) -> Path:
    return data_dir / "ict-facekit"


@pytest.fixture(scope="module")
def neutral(rig: Path) -> em.Mesh:
    return em.read(rig / "generic_neutral_mesh.obj")


@pytest.mark.realdata
def test_the_jaw_swings_about_its_hinge(rig: Path, neutral: em.Mesh) -> None:
    """Teeth and gums within 0.08 % of D of the true arc; linear is 0.67 % off."""
    target = em.read(rig / "jawOpen.obj")
    morph = METHOD.prepare(neutral)(target)
    start, end = neutral.vertices, target.vertices
    teeth = 17039 + np.flatnonzero((start != end)[17039:21451].any(axis=1))
    screw, residual = fit_rigid(start[teeth], end[teeth])
    gums = np.arange(14062, 17039)
    gums = gums[np.linalg.norm(screw.at(1, start[gums]) - end[gums], axis=1) <= residual.max()]
    assert len(teeth) == 2204
    assert len(gums) > 1600
    for t in (0.25, 0.5, 0.75):
        for part in (teeth, gums):
            off = np.linalg.norm(morph.at(t)[part] - screw.at(t, start[part]), axis=1)
            assert off.max() < 0.0008 * neutral.diameter


@pytest.mark.realdata
@pytest.mark.slow
def test_hard_shapes_do_not_fold(rig: Path, neutral: em.Mesh) -> None:
    to = METHOD.prepare(neutral)
    for name in ("mouthClose", "mouthFunnel", "mouthPucker", "mouthLeft", "jawOpen"):
        target = em.read(rig / f"{name}.obj")
        morph = to(target)
        probe = ShapeProbe.of(neutral, target, np.zeros(len(neutral.vertices), int))
        assert [probe.flips(morph.at(t)) for t in (0.25, 0.5, 0.75)] == [0, 0, 0], name


@pytest.mark.realdata
def test_lids_slide_around_the_eyeball(rig: Path, neutral: em.Mesh) -> None:
    """Lids sink towards the centre of the eye a quarter as far as on the straight line."""
    target = em.read(rig / "eyeBlink_L.obj")
    sclera = neutral.vertices[21451:22221]
    sphere = np.c_[2 * sclera, np.ones(len(sclera))]
    *centre, _ = np.linalg.lstsq(sphere, (sclera**2).sum(axis=1), rcond=None)[0]

    def away(points: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.linalg.norm(points[:9409] - centre, axis=1)

    ends = np.minimum(away(neutral.vertices), away(target.vertices))
    moved = np.linalg.norm(target.vertices - neutral.vertices, axis=1)[:9409] > 0.05
    lids = moved & (ends < 1.25 * 1.577)
    assert lids.sum() > 300

    def sunk(morph: em.Morph) -> float:
        return max(float((ends - away(morph.at(t)))[lids].max()) for t in (0.25, 0.5, 0.75))

    straight = sunk(em.interpolate(neutral, target, "linear"))
    turned = sunk(METHOD.prepare(neutral)(target))
    assert straight > 0.05
    assert turned < straight / 3


@pytest.mark.parametrize("method", ["arc", "rotation"])
def test_a_tighter_tolerance_keeps_a_stored_path_rigid(method: str, face: em.Mesh) -> None:
    """Rigid at every t to 1e-6 of D with the bends that it takes."""
    vector = np.array([0.3, -0.1, 0.2])
    target = face.with_vertices(rigid(face.vertices, vector))
    path = em.interpolate(face, target, method, tolerance=2e-7)
    for t in TIMES:
        away = path.at(t) - rigid(face.vertices, t * vector)
        assert np.linalg.norm(away, axis=1).max() < 1e-6 * face.diameter
