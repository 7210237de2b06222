"""A jaw on its hinge: what turns is found, and distances from its arc are those of geometry."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import elastomorph as em
from elastomorph.evaluation import evaluate
from elastomorph.evaluation.hinge import Hinge, find_hinge, hinge_errors
from elastomorph.evaluation.rigid_parts import RigidParts, find_rigid_parts

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
QUADS = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
ANGLE = np.radians(30)


@pytest.fixture(scope="module")
def ends() -> tuple[em.Mesh, em.Mesh]:
    """Four cubes: a tooth, a gum that turns with it almost rigidly, one that bends, one at rest.

    The axis is that of x, through the origin.
    """
    neutral = em.Mesh(
        np.concatenate([CUBE + [3 * i, 0, 4] for i in range(4)]),
        [[v + 8 * i for v in quad] for i in range(4) for quad in QUADS],
    )
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
