"""auto: the straight line where the path of `rotation` stays close to it, else that path."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, Delaunay
from scipy.spatial.transform import Rotation

import elastomorph as em
from elastomorph.curves import Curve, CurveNetwork
from elastomorph.evaluation.movements import evaluate_movements
from elastomorph.evaluation.shape import ShapeProbe
from elastomorph.io.sequences import read_recording
from elastomorph.model.geometry import connected_parts
from elastomorph.model.morph import Choice
from elastomorph.model.sequence import MeshSequence
from elastomorph.paths import rotation
from small_head import head, shapes
from small_meshes import grid


def off_straight(mesh: em.Mesh, target: em.Mesh) -> float:
    """Largest distance of the whole path of `rotation` from the straight line halfway, over D."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", em.ElastomorphWarning)
        path = rotation.rotation_path(mesh, target)
    middle = (mesh.vertices + target.vertices) / 2
    return float(np.linalg.norm(path(0.5) - middle, axis=1).max()) / mesh.diameter


def turned(points: NDArray[np.float64], degrees: float) -> NDArray[np.float64]:
    return np.asarray(Rotation.from_rotvec([0, 0, np.radians(degrees)]).apply(points.copy()))


def test_the_shapes_of_the_head_are_judged_by_their_whole_path() -> None:
    """The stated distance is that of the path of `rotation`, and it alone decides."""
    face = head()
    to = em.prepare(face, "auto", straight_within=2e-3)
    bent = 0
    for name, target in shapes().items():
        morph, distance = to(target), off_straight(face, target)
        assert morph.choice is not None
        assert morph.choice.allowed == 2e-3
        assert morph.choice.straight == (distance <= 2e-3), name
        assert morph.method == ("linear" if morph.choice.straight else "rotation")
        if morph.choice.exact:
            assert morph.choice.distance == pytest.approx(distance, rel=1e-6, abs=1e-12)
        else:
            assert distance <= morph.choice.distance <= 2e-3
        expected = em.interpolate(face, target, morph.method)
        np.testing.assert_array_equal(morph.bends, expected.bends)
        bent += not morph.choice.straight
    assert 0 < bent < len(shapes())


@pytest.mark.filterwarnings("ignore::elastomorph.ElastomorphWarning")
@given(st.integers(0, 10**6), st.floats(-6.0, 0.5))
@settings(max_examples=30, deadline=None)
def test_no_target_that_bends_is_called_straight(seed: int, exponent: float) -> None:
    """Random polygons and motions of any size, from where the bound decides to where it cannot."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(12, 3))
    faces = rng.permuted(np.tile(np.arange(12), (9, 1)), axis=1)[:, :3]
    mesh = em.Mesh(points, faces)
    target = mesh.with_vertices(points + 10.0**exponent * rng.normal(size=points.shape))
    morph = em.interpolate(mesh, target, "auto")
    whole = em.interpolate(mesh, target, "rotation")
    stored = float(np.linalg.norm(whole.at(0.5) - (points + target.vertices) / 2, axis=1).max())
    stored /= mesh.diameter
    assert morph.choice is not None
    # What is stored decides: it is closer to the line where bends were eased because they fold.
    assert morph.choice.straight or off_straight(mesh, target) > 5e-4
    assert morph.choice.straight or np.array_equal(morph.bends, whole.bends)
    assert morph.choice.straight or abs(morph.choice.distance - stored) <= whole.bake_error
    assert not morph.choice.straight or stored <= 5e-4 + whole.bake_error


def test_small_motions_are_decided_without_a_solve() -> None:
    """The bound falls with the square of the motion."""
    face, target = head(), shapes()["mouthSmile_L"]
    small = face.with_vertices(face.vertices + 1e-4 * (target.vertices - face.vertices))
    morph = em.interpolate(face, small, "auto")
    assert morph.choice is not None
    assert not morph.choice.exact
    assert morph.choice.straight
    assert len(morph.bends) == 0


def test_the_extent_of_a_rig_tightens_the_decision() -> None:
    """A face on a body: what matters is what targets move."""
    face, target = head(), shapes()["mouthSmile_L"]
    distance = off_straight(face, target)
    allowed = 2 * distance
    assert em.interpolate(face, target, "auto", straight_within=allowed).method == "linear"
    small = face.diameter / 4
    morph = em.interpolate(face, target, "auto", straight_within=allowed, extent=small)
    assert morph.method == "rotation"
    assert morph.choice is not None
    assert morph.choice.distance == pytest.approx(4 * distance, rel=1e-6)


def test_half_a_turn_bends() -> None:
    """Straight lines would pass through the axis."""
    face = head()
    morph = em.interpolate(face, face.with_vertices(turned(face.vertices, 180)), "auto")
    assert morph.method == "rotation"
    assert morph.choice is not None
    lengths = [np.linalg.norm(p[:, :2], axis=1) for p in (face.vertices, morph.at(0.5))]
    np.testing.assert_allclose(lengths[1], lengths[0], atol=2e-3 * face.diameter)


@pytest.mark.parametrize("method", ["auto"])
def test_nothing_moves(method: str) -> None:
    face = head()
    morph = em.interpolate(face, face, method)
    assert morph.choice == Choice(0.0, 5e-4, exact=True)
    assert morph.method == "linear"
    np.testing.assert_array_equal(morph.at(0.3), face.vertices)


@pytest.mark.parametrize(
    "mesh",
    [
        em.Mesh(np.zeros((4, 3)), [[0, 1, 2, 3]]),
        em.Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]]),
        em.Mesh(np.eye(3)),
    ],
    ids=["one point", "one line", "no polygons"],
)
def test_meshes_without_a_surface_have_a_path(mesh: em.Mesh) -> None:
    """No area, no diameter, no polygons: finite numbers and exact ends."""
    rng = np.random.default_rng(0)
    for end in (mesh.vertices, mesh.vertices + 1.0, mesh.vertices + rng.normal(size=(3,))):
        for extent in (None, 0.0):
            morph = em.interpolate(mesh, mesh.with_vertices(end), "auto", extent=extent)
            assert morph.choice is not None
            assert np.isfinite(morph.choice.distance)
            assert np.isfinite(morph.at([0, 0.3, 1])).all()
            np.testing.assert_array_equal(morph.at(1.0), end)


def test_loose_vertices_go_straight_without_a_word_and_parts_turn_for_themselves() -> None:
    """Beside a sheet that turns, one that is stretched, and a vertex on no polygon."""
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    points = np.concatenate([square, square + [3, 0, 0], [[9.0, 9.0, 9.0]]])
    mesh = em.Mesh(points, [[0, 1, 2, 3], [4, 5, 6, 7]])
    end = points.copy()
    end[:4] = turned(square, 90)
    end[4:8, 1] *= 2.0
    end[8] += 1.0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        morph = em.interpolate(mesh, mesh.with_vertices(end), "auto")
    assert morph.method == "rotation"
    np.testing.assert_allclose(morph.at(0.5)[:4], turned(square, 45), atol=1e-3)
    np.testing.assert_allclose(morph.at(0.5)[4:], ((points + end) / 2)[4:], atol=1e-12)


def test_markers_follow_arcs_only_where_a_turn_explains_their_curve() -> None:
    """A chin that swings, beside lids of which one marker moves alone."""
    angle = np.radians([-40, -20, 0, 20, 40])
    chin = np.stack([np.sin(angle), -np.cos(angle), 0 * angle + 1], axis=1)
    lids = np.array([[5, 0, 0], [6, 0.5, 0], [7, 0, 0], [6, -0.5, 0]], float)
    mesh = em.Mesh(np.concatenate([chin, lids]))
    end = mesh.vertices.copy()
    end[:5] = Rotation.from_rotvec([0.6, 0, 0]).apply(chin)
    end[6] = [6, -0.4, 0.3]
    curves = CurveNetwork([Curve([0, 1, 2, 3, 4], False), Curve([5, 6, 7, 8], True)], 9)
    target = mesh.with_vertices(end)
    morph = em.interpolate(mesh, target, "auto", curves=curves)
    assert morph.method == "arc"
    true = Rotation.from_rotvec([0.3, 0, 0]).apply(chin)
    np.testing.assert_allclose(morph.at(0.5)[:5], true, atol=2e-3)
    np.testing.assert_array_equal(morph.bends[:, 5:], 0.0)
    arcs = em.interpolate(mesh, target, "arc", curves=curves)
    assert np.abs(arcs.bends[:, 6]).max() > 0.01
    only_lids = mesh.vertices.copy()
    only_lids[6] = end[6]
    still = em.interpolate(mesh, mesh.with_vertices(only_lids), "auto", curves=curves)
    assert still.method == "linear"
    assert still.choice == Choice(0.0, 5e-4, exact=True)


@pytest.mark.parametrize("rest", ["linear", "neutral"])
def test_the_choice_survives_a_region(rest: str) -> None:
    face, target = head(), shapes()["jawOpen"]
    region = np.flatnonzero(face.vertices[:, 1] < np.median(face.vertices[:, 1]))
    morph = em.interpolate(face, target, "auto", region=region, rest=rest)
    whole = em.interpolate(face, target, "auto")
    assert whole.choice is not None
    assert morph.choice == whole.choice
    assert morph.method == whole.method == "rotation"


@pytest.mark.realdata
@pytest.mark.slow
def test_a_production_rig(data_dir: Path) -> None:
    """Of 57 targets 18 bend, those the whole path says; no polygon turns over on any."""
    folder = data_dir / "ict-facekit"
    neutral = em.read(folder / "generic_neutral_mesh.obj")
    to, full = em.prepare(neutral, "auto"), em.prepare(neutral, "rotation")
    bent = 0
    for file in sorted(folder.glob("*.obj")):
        if file.stem == "generic_neutral_mesh":
            continue
        target = neutral.with_vertices(em.read(file).vertices)
        morph, whole = to(target), full(target)
        assert morph.choice is not None
        middle = (neutral.vertices + target.vertices) / 2
        stored = np.linalg.norm(whole.at(0.5) - middle, axis=1).max() / neutral.diameter
        assert abs(stored - morph.choice.distance) <= whole.bake_error + 1e-9, file.stem
        assert morph.method == ("linear" if morph.choice.distance <= 5e-4 else "rotation")
        probe = ShapeProbe.of(neutral, target, np.zeros(len(neutral.vertices), int))
        assert [probe.flips(morph.at(t)) for t in (0.25, 0.5, 0.75)] == [0, 0, 0], file.stem
        bent += morph.method == "rotation"
    assert bent == 18


def eye_and_skin(face: em.Mesh) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """One eyeball, a part of its own, and 300 vertices of the skin around one of them."""
    parts = sorted(connected_parts(len(face.vertices), face.edges), key=len)
    skin, centre = parts[-1], face.vertices[parts[-1][500]]
    away = np.linalg.norm(face.vertices[skin] - centre, axis=1)
    return parts[-2], skin[np.argsort(away)[:300]]


@pytest.mark.parametrize("method", ["auto", "rotation", "arc"])
@pytest.mark.parametrize("noise", [0.0, 1e-16, 1e-9, 1e-7])
@pytest.mark.parametrize("shape", ["part", "part grows", "region"])
def test_what_shrinks_to_a_point_goes_straight(method: str, noise: float, shape: str) -> None:
    """What is left of it, rounding or noise, says nothing about a turn."""
    face, rng = head(), np.random.default_rng(5)
    part, region = eye_and_skin(face)
    gone = region if shape == "region" else part
    point = face.vertices.copy()
    point[gone] = point[gone].mean(axis=0) + noise * face.diameter * rng.normal(size=(len(gone), 3))
    if shape != "region":
        point[gone] += [0.0, 0.3 * face.diameter, 0.0]
    ends = (point, face.vertices) if shape == "part grows" else (face.vertices, point)
    start, end = face.with_vertices(ends[0]), face.with_vertices(ends[1])
    morph = em.interpolate(start, end, method)
    middle = (start.vertices + end.vertices) / 2
    np.testing.assert_allclose(morph.at(0.5), middle, atol=1e-12 * face.diameter)
    if method == "auto":
        assert morph.choice is not None
        assert morph.choice.shrunk == len(gone)
        assert f"{len(gone)} vertices that shrink to a point" in morph.choice.text


def test_beside_what_shrinks_the_others_turn_as_before() -> None:
    """A jaw that opens while an eye vanishes, through a file of single precision."""
    face, jaw = head(), shapes()["jawOpen"]
    eye, _ = eye_and_skin(face)
    both = jaw.vertices.copy()
    both[eye] = both[eye].mean(axis=0)
    morph = em.interpolate(face, face.with_vertices(both.astype(np.float32)))
    others = np.setdiff1d(np.arange(len(both)), eye)
    whole = em.interpolate(face, jaw)
    assert not morph.bends[:, eye].any()
    assert morph.choice is not None
    assert morph.choice.shrunk == len(eye)
    gap = np.abs(morph.at(0.5)[others] - whole.at(0.5)[others]).max()
    assert gap < 1e-3 * np.abs(whole.bends).max() * face.diameter


def test_a_part_that_ends_inside_the_others_goes_straight() -> None:
    """A plate before the face, turned as it goes into the head: a bend that nobody sees."""
    face = head()
    size, middle = face.diameter, face.vertices.mean(axis=0)
    plate = 0.05 * size * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)
    before = middle + [0, 0, 0.6 * size]
    first = len(face.vertices)
    mesh = em.Mesh(
        np.concatenate([face.vertices, plate + before]),
        [*(own.tolist() for own in face.faces), list(range(first, first + 4))],
    )
    tilted = Rotation.from_rotvec([1.0, 0, 0]).apply(plate)
    for end, hidden in ((middle + [0, 0, -0.2 * size], 4), (before + [0, size / 2, 0], 0)):
        vertices = np.concatenate([shapes()["jawOpen"].vertices, tilted + end])
        morph = em.interpolate(mesh, mesh.with_vertices(vertices))
        assert morph.choice is not None
        assert morph.choice.hidden == hidden
        assert ("end inside other parts" in morph.choice.text) == bool(hidden)
        assert morph.bends[:, first:].any() != bool(hidden)
        assert morph.bends[:, :first].any()  # the jaw turns
    # What is inside at both ends, as teeth are, turns.
    inside = middle + [0, 0, -0.2 * size]
    start = mesh.with_vertices(np.concatenate([face.vertices, plate + inside]))
    end_mesh = mesh.with_vertices(np.concatenate([face.vertices, tilted + inside]))
    morph = em.interpolate(start, end_mesh)
    assert morph.choice is not None
    assert morph.choice.hidden == 0
    assert morph.bends[:, first:].any()


def test_teeth_that_shrink_far_behind_a_mask_are_hidden() -> None:
    """Faces of avatars have no back: a mask winds less than once around what was inside before."""
    flat, plate = (own.vertices - own.vertices.mean(axis=0) for own in (grid(12, 12), grid(3, 3)))
    mask = np.column_stack([flat[:, :2] / 5.5, -((flat[:, :2] / 5.5) ** 2).sum(axis=1)])
    first, count = len(mask), len(plate)
    faces = [*grid(12, 12).faces, *(own + first for own in grid(3, 3).faces)]
    start = em.Mesh(np.concatenate([mask, 0.15 * plate + [0, 0, -0.5]]), faces)
    turned_plate = 0.15 * Rotation.from_rotvec([1.2, 0, 0]).apply(plate)
    for size, depth, hidden in ((0.15, -1.3, count), (1.0, -1.3, 0), (0.15, 1.0, 0)):
        end = np.concatenate([mask, size * turned_plate + [0, 0, depth]])
        choice = em.interpolate(start, start.with_vertices(end)).choice
        assert choice is not None
        assert choice.hidden == hidden


def test_markers_are_compared_halfway() -> None:
    """Where an arc is farthest from its chord: r(1 - cos θ/2) at the longest radius."""
    angle = np.radians([-40, -20, 0, 20, 40])
    chin = em.Mesh(np.stack([np.sin(angle), -np.cos(angle), 0 * angle + 1], axis=1))
    turned_chin = chin.with_vertices(Rotation.from_rotvec([0.6, 0, 0]).apply(chin.vertices.copy()))
    curves = CurveNetwork([Curve([0, 1, 2, 3, 4], False)], 5)
    morph = em.interpolate(chin, turned_chin, "auto", curves=curves)
    assert morph.choice is not None
    farthest = np.sqrt(2.0) * (1 - np.cos(0.3)) / chin.diameter
    assert morph.choice.distance == pytest.approx(farthest, rel=1e-9)


def test_triangles_between_markers_are_no_skin() -> None:
    """Markers that move alone turn long edges around them, and no cheek; all as one do turn."""
    points = np.random.default_rng(4).uniform(-1, 1, (41, 2))
    bowl = np.column_stack([points, 0.5 - 0.5 * (points**2).sum(axis=1)])
    mesh = em.Mesh(bowl, Delaunay(points).simplices)
    moved = bowl.copy()
    moved[np.argsort(np.abs(points).sum(axis=1))[:6]] += [0.0, 0.15, 0.1]
    target = mesh.with_vertices(moved)
    assert em.interpolate(mesh, target).method == "linear"
    assert len(em.interpolate(mesh, target, "rotation").bends)  # by name, as on any surface
    whole = em.interpolate(mesh, mesh.with_vertices(turned(bowl, 60)))
    assert whole.method == "arc"
    np.testing.assert_allclose(whole.at(0.5), turned(bowl, 30), atol=2e-3)
    finer = grid(10, 10, lambda x, y: 0.1 * x * y)
    skin = em.Mesh(finer.vertices, finer.faces.triangles())
    end = skin.vertices.copy()
    end[44:46, 2] += 2.0
    assert em.interpolate(skin, skin.with_vertices(end)).method == "rotation"
    ball = np.random.default_rng(6).normal(size=(60, 3))
    ball /= np.linalg.norm(ball, axis=1)[:, None]
    closed = em.Mesh(ball, ConvexHull(ball).simplices)
    end = ball.copy()
    end[:3] *= 2.0
    assert em.interpolate(closed, closed.with_vertices(end)).method == "rotation"


@pytest.mark.realdata
def test_markers_with_triangles_are_no_worse_than_straight(data_dir: Path) -> None:
    """On all movements of two takes, with the best time for each frame."""
    for name in ("jaw", "eyebrows"):
        motion = read_recording(data_dir / "animface" / f"{name}.npz").motion
        rest = motion.mesh.vertices - motion.mesh.vertices.mean(axis=0)
        flat = rest @ np.linalg.svd(rest, full_matrices=False)[2][:2].T
        mesh = em.Mesh(motion.mesh.vertices, Delaunay(flat).simplices)
        frames = MeshSequence(mesh, motion.frames, motion.times)
        curves = CurveNetwork([Curve(range(len(rest)), False)], len(rest))
        for one in evaluate_movements(frames, curves, lambda _: ("linear", "auto")):
            errors = {each: one.evaluation[each].path_lme for each in ("linear", "auto")}
            assert errors["auto"] <= errors["linear"] + 1e-9
