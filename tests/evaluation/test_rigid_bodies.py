"""Rigid components as ground truth."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import elastomorph as em
from elastomorph.evaluation import evaluate
from elastomorph.evaluation.rigid_bodies import (
    Hinge,
    RigidParts,
    find_eyelid,
    find_hinge,
    find_rigid_parts,
    hinge_errors,
    rigidity,
)
from elastomorph.model.mesh import FaceLabels


def boxes(count: int) -> em.Mesh:
    """Cubes side by side, each a component of its own."""
    cube = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    points = np.concatenate([cube + [3 * i, 0, 0] for i in range(count)])
    return em.Mesh(points, [[v + 8 * i for v in quad] for i in range(count) for quad in quads])


def test_two_of_four_boxes_turn_together() -> None:
    """One more stretches, one stays: the truth holds two, on a true arc."""
    neutral = boxes(4)
    turn = Rotation.from_rotvec([0.4, 0, 0])
    moved = neutral.vertices.copy()
    moved[:16] = turn.apply(moved[:16] - [0, -2, 0]) + [0, -2, 0]
    moved[16:24] *= [1, 1.5, 1]
    parts = find_rigid_parts(neutral, neutral.with_vertices(moved))
    assert parts is not None
    assert parts.components == 2
    np.testing.assert_array_equal(parts.vertices, np.arange(16))
    assert parts.screw.angle == pytest.approx(0.4)
    radius = np.linalg.norm(parts.truth.frames[:, :, 1:] - [-2, 0], axis=2)
    np.testing.assert_allclose(radius, radius[:1].repeat(11, axis=0), atol=1e-9)
    np.testing.assert_array_equal(parts.truth.frames[-1], moved[:16])
    assert len(parts.truth.mesh.faces) == 12
    network = parts.curves(em.extract_curves(neutral))
    assert sum(len(curve) for curve in network) == 16


def test_the_parts_keep_the_names_of_their_polygons() -> None:
    """So that teeth look like teeth wherever the truth is drawn."""
    plain = boxes(2)
    names = FaceLabels(("lips", "teeth"), np.repeat([0, 1], 6).astype(np.int32))
    neutral = em.Mesh(plain.vertices, plain.faces, materials=names, groups=names)
    moved = neutral.vertices.copy()
    moved[8:] = Rotation.from_rotvec([0.4, 0, 0]).apply(moved[8:])
    moved[:8] *= [1, 1.5, 1]
    parts = find_rigid_parts(neutral, neutral.with_vertices(moved))
    assert parts is not None
    for labels in (parts.truth.mesh.materials, parts.truth.mesh.groups):
        assert labels is not None
        assert [labels.names[number] for number in labels.of_face] == ["teeth"] * 6


def test_nothing_rigid_is_nothing_found() -> None:
    neutral = boxes(1)
    stretched = neutral.with_vertices(neutral.vertices * [1, 2, 1])
    assert find_rigid_parts(neutral, stretched) is None
    assert find_rigid_parts(neutral, neutral) is None


def test_what_hardly_moves_turns_about_nothing() -> None:
    """An empty target of an avatar, and hair in a point, to which every turn is as good."""
    neutral = boxes(3)
    points = neutral.vertices.copy()
    points[:8] = points[0]
    neutral = neutral.with_vertices(points)
    assert find_rigid_parts(neutral, neutral) is None
    points[8:16] = 1e-4 * Rotation.from_rotvec([1, 0, 0]).apply(points[8:16] - points[8]) + 3
    tiny = points.copy()
    tiny[8:16] = 1e-4 * Rotation.from_rotvec([2, 0, 0]).apply(neutral.vertices[8:16] - 3) + 3
    assert find_rigid_parts(neutral.with_vertices(points), neutral.with_vertices(tiny)) is None


ANGLE = np.radians(30)


@pytest.fixture(scope="module")
def ends() -> tuple[em.Mesh, em.Mesh]:
    """Four cubes: a tooth, a gum that turns with it almost rigidly, one that bends, one at rest.

    The axis is that of x, through the origin.
    """
    row = boxes(4)
    neutral = row.with_vertices(row.vertices + [0, 0, 4])
    moved = neutral.vertices.copy()
    moved[:24] = Rotation.from_rotvec([ANGLE, 0, 0]).apply(moved[:24])
    moved[8] += [0.2, 0, 0]  # one corner of the gum is soft: the piece is not rigid
    moved[16:23] += [0, 0.5, 0]  # of the third, one corner alone happens to run along
    return neutral, neutral.with_vertices(moved)


@pytest.fixture(scope="module")
def parts(ends: tuple[em.Mesh, em.Mesh]) -> RigidParts:
    found = find_rigid_parts(*ends)
    assert found is not None
    return found


@pytest.fixture(scope="module")
def hinge(ends: tuple[em.Mesh, em.Mesh], parts: RigidParts) -> Hinge:
    return find_hinge(*ends, parts)


def test_what_is_carried_for_the_most_part_is_found(hinge: Hinge) -> None:
    np.testing.assert_array_equal(hinge.parts, np.arange(8))
    np.testing.assert_array_equal(hinge.along, np.arange(9, 16))
    assert hinge.screw.angle == pytest.approx(ANGLE)
    assert hinge.residual < 1e-9


def test_the_straight_line_is_off_by_the_sagitta(
    ends: tuple[em.Mesh, em.Mesh], hinge: Hinge
) -> None:
    """r (1 - cos 15°) for the farthest corner; the rigid turn is met but for its storage."""
    neutral, target = ends
    morphs = {name: em.interpolate(neutral, target, name) for name in ("linear", "rotation")}
    straight, turned = hinge_errors(hinge, morphs)
    radius = np.linalg.norm(neutral.vertices[hinge.vertices][:, 1:], axis=1).max()
    sagitta = radius * (1 - np.cos(ANGLE / 2)) / neutral.diameter
    assert straight.label == "linear"
    assert straight.parts == pytest.approx(sagitta, rel=0.02)
    assert turned.parts < 3e-4
    assert turned.parts < straight.parts / 20


def test_the_parts_of_a_path_are_judged_in_the_size_of_the_whole(
    ends: tuple[em.Mesh, em.Mesh], parts: RigidParts
) -> None:
    """The same distances over a larger D: the ratio of the errors is that of the sizes."""
    neutral, target = ends
    whole = em.interpolate(neutral, target, "linear")
    part = parts.restricted(whole)
    np.testing.assert_array_equal(part.at(0.3), whole.at(0.3)[parts.vertices])
    curves = parts.curves(em.extract_curves(neutral))
    own = evaluate(parts.truth, {"linear": part}, curves)
    of_face = evaluate(parts.truth, {"linear": part}, curves, extent=neutral.diameter)
    assert own.diameter == pytest.approx(np.sqrt(3))
    assert of_face.diameter == neutral.diameter
    ratio = neutral.diameter / np.sqrt(3)
    assert own["linear"].lme == pytest.approx(ratio * of_face["linear"].lme)


POINTS = np.random.default_rng(0).normal(size=(12, 3))
NEUTRAL = em.Mesh(POINTS)
TURN = 0.5
TURNED = NEUTRAL.with_vertices(Rotation.from_rotvec([0, 0, TURN]).apply(POINTS))
TIMES = (0.25, 0.5, 0.75)


def test_a_true_turn_stays_rigid() -> None:
    path = em.bake(
        lambda t: Rotation.from_rotvec([0, 0, t * TURN]).apply(POINTS),
        NEUTRAL,
        TURNED,
        tolerance=1e-10,
    )
    found = rigidity(path, np.arange(12), TIMES)
    assert found.change < 1e-9
    assert found.off_screw < 1e-7


def test_the_straight_path_shrinks_the_body_by_the_cosine() -> None:
    """Halfway every radius is cos(θ/2) of its own, and so is every distance across the axis."""
    flat = em.Mesh(POINTS * [1, 1, 0])
    turned = flat.with_vertices(Rotation.from_rotvec([0, 0, TURN]).apply(POINTS * [1, 1, 0]))
    found = rigidity(em.interpolate(flat, turned, "linear"), np.arange(12), [0.5])
    assert found.change == pytest.approx(1 - np.cos(TURN / 2), rel=1e-9)
    radius = np.linalg.norm(flat.vertices, axis=1).max()
    assert found.off_screw == pytest.approx(
        radius * (1 - np.cos(TURN / 2)) / flat.diameter, rel=1e-3
    )


def test_what_is_no_rigid_body_is_told_by_its_ends() -> None:
    stretched = NEUTRAL.with_vertices(POINTS * [1, 2, 1])
    path = em.interpolate(NEUTRAL, stretched, "linear")
    assert rigidity(path, np.arange(12), TIMES).ends > 0.05
    turned = em.interpolate(NEUTRAL, TURNED, "linear")
    assert rigidity(turned, np.arange(12), TIMES).ends < 1e-12


def test_bodies_must_exist() -> None:
    path = em.interpolate(NEUTRAL, TURNED, "linear")
    with pytest.raises(em.ParameterError, match="at least 4"):
        rigidity(path, [1, 2, 3], TIMES)
    with pytest.raises(em.CurveError, match="99"):
        rigidity(path, [1, 2, 3, 99], TIMES)


def eye(turn: float, lashes: float = 0.0) -> tuple[em.Mesh, em.Mesh]:
    """An eyeball of radius 2 about (1, 2, 3), and a lid at 2.1 that turns about its x axis.

    Above the lid stands a fringe, a part of its own, that moves farther by some factor.
    """
    around, down = np.meshgrid(
        np.linspace(0, 2 * np.pi, 24, endpoint=False), np.linspace(0.2, 2.9, 9)
    )
    ball = 2 * np.stack(
        [np.sin(down) * np.sin(around), np.cos(down), np.sin(down) * np.cos(around)], axis=-1
    )
    side, up = np.meshgrid(np.linspace(-0.5, 0.5, 5), np.linspace(0.3, 0.8, 4))
    lid = 2.1 * np.stack(
        [np.sin(side), np.cos(side) * np.sin(up), np.cos(side) * np.cos(up)], axis=-1
    )

    def quads(rows: int, columns: int, first: int) -> list[list[int]]:
        at = first + np.arange(rows * columns).reshape(rows, columns)
        return (
            np.stack([at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]], -1)
            .reshape(-1, 4)
            .tolist()
        )

    fringe = lid[:2, :2].reshape(-1, 3) * 1.2
    parts = [ball.reshape(-1, 3), lid.reshape(-1, 3), fringe]
    faces = quads(9, 24, 0) + quads(4, 5, 216) + quads(2, 2, 236)
    rest = np.concatenate(parts)
    moved = rest.copy()
    rotation = Rotation.from_rotvec([turn, 0, 0])
    moved[216:] = rotation.apply(moved[216:])
    moved[236:] += lashes * (moved[236:] - rest[236:])
    return em.Mesh(rest + [1, 2, 3], faces), em.Mesh(moved + [1, 2, 3], faces)


@pytest.mark.parametrize("lashes", [0.0, 1.0])
def test_a_lid_is_found_on_its_eyeball_whatever_lashes_do(lashes: float) -> None:
    neutral, target = eye(0.9, lashes)
    lid = find_eyelid(neutral, target)
    assert lid is not None
    assert 216 <= lid.vertex < 236
    np.testing.assert_allclose(lid.centre, [1, 2, 3], atol=1e-9)
    assert lid.radius == pytest.approx(2)
    np.testing.assert_allclose(np.abs(lid.axis), [1, 0, 0], atol=0.3)


def test_a_straight_line_sinks_by_the_sagitta_of_its_chord_at_any_pace() -> None:
    """The vertex in the middle of the lid is farthest from the axis: its chord spans 0.9 rad."""
    neutral, target = eye(0.9)
    lid = find_eyelid(neutral, target)
    assert lid is not None
    sagitta = 2.1 * (1 - np.cos(0.45)) / neutral.diameter
    for method in ("linear", "ease:2", "cosine"):
        morph = em.interpolate(neutral, target, method)
        assert lid.dip(morph) == pytest.approx(sagitta, rel=2e-3)
        heights = lid.heights(morph, [0.0, 1.0])
        np.testing.assert_allclose(heights, 0.1 / neutral.diameter, atol=1e-9)
    turned = em.interpolate(neutral, target, "rotation")
    assert lid.dip(turned) < 0.02 * sagitta


def test_there_is_no_lid_without_a_ball_that_stays() -> None:
    neutral, _ = eye(0.9)
    everything = neutral.with_vertices(neutral.vertices + [0, 0.3, 0])
    assert find_eyelid(neutral, everything) is None
    assert find_eyelid(boxes(2), boxes(2)) is None
    assert find_eyelid(neutral, neutral) is None
