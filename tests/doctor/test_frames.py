"""Units and axes are recognised on a face that also has an expression, and undone exactly."""

from __future__ import annotations

from itertools import permutations, product

import numpy as np
import pytest

from elastomorph.doctor.frames import UNITS, Frame, frame_between
from elastomorph.model.mesh import Mesh

ORIENTATIONS = [
    (axes, signs) for axes in permutations((0, 1, 2)) for signs in product((1, -1), repeat=3)
]


@pytest.mark.parametrize(("axes", "signs"), ORIENTATIONS)
def test_every_orientation_is_recognised(
    face: Mesh, rig: dict[str, Mesh], axes: tuple[int, int, int], signs: tuple[int, int, int]
) -> None:
    """All 48, on a symmetric face with a grin, 100 times larger."""
    target = rig["mouthSmile_L.obj"].vertices
    there = 100.0 * target[:, axes] * np.array(signs)
    frame = frame_between(face.vertices, there, 1.2)
    assert (frame.factor, frame.axes, frame.signs) == (100.0, axes, signs)
    determinant = np.linalg.det(np.eye(3)[list(axes)] * np.array(signs)[:, None])
    assert frame.mirrored == (determinant < 0)
    assert frame.same_axes == (axes == (0, 1, 2) and signs == (1, 1, 1))
    np.testing.assert_allclose(frame.back(there), target, rtol=1e-14, atol=1e-12)


@pytest.mark.parametrize("unit", UNITS)
def test_every_unit_is_recognised_both_ways(face: Mesh, unit: float) -> None:
    larger = frame_between(face.vertices, unit * face.vertices, 1.2)
    smaller = frame_between(face.vertices, face.vertices / unit, 1.2)
    assert (larger.factor, smaller.factor) == (unit, 1 / unit)
    assert larger.known
    assert smaller.known
    assert larger.unit.split()[2] == smaller.unit.split()[-1]


def test_a_factor_of_no_unit_is_not_undone(face: Mesh) -> None:
    frame = frame_between(face.vertices, 1.7 * face.vertices, 1.2)
    assert frame.factor == pytest.approx(1.7)
    assert not frame.known


def test_expressions_change_no_frame(face: Mesh, rig: dict[str, Mesh]) -> None:
    for mesh in rig.values():
        frame = frame_between(face.vertices, mesh.vertices, 1.2)
        assert (frame.factor, frame.same_axes) == (1.0, True)


def test_a_face_that_an_expression_enlarges_has_its_unit(face: Mesh) -> None:
    """The lower half drops by half a head: sizes change by a third, most distances do not."""
    below = face.vertices[:, 1] < np.median(face.vertices[:, 1])
    dropped = face.vertices - np.where(below, 0.5 * face.diameter, 0.0)[:, None] * [0, 1, 0]
    spread = [
        np.median(np.linalg.norm(p - np.median(p, axis=0), axis=1))
        for p in (face.vertices, dropped)
    ]
    assert spread[1] / spread[0] > 1.3
    assert frame_between(face.vertices, dropped, 1.2).is_same
    assert frame_between(face.vertices, 2.54 * dropped, 1.2).factor == 2.54


def test_the_inverse_goes_back(face: Mesh) -> None:
    for axes, signs in ORIENTATIONS:
        frame = Frame(25.4, "such as millimetres instead of inches", axes, signs)
        there = frame.forth(face.vertices)
        np.testing.assert_allclose(frame.back(there), face.vertices, rtol=1e-14, atol=1e-13)
        np.testing.assert_allclose(frame.inverse().forth(there), face.vertices, rtol=1e-12)
        assert frame.inverse().unit == "such as inches instead of millimetres"
        assert frame.inverse().inverse().is_like(frame)


def test_points_at_one_place_have_no_frame() -> None:
    here = np.zeros((5, 3))
    frame = frame_between(here, here + 1.0, 1.2)
    assert (frame.factor, frame.same_axes) == (1.0, True)


def test_axes_are_said_in_words() -> None:
    assert Frame(1.0, "", (0, 2, 1), (1, -1, 1)).describe_axes() == "x, -z, y in place of x, y, z"
