"""Seams, flips and stretch on shapes drawn by hand."""

from __future__ import annotations

import numpy as np
import pytest

import elastomorph as em
from elastomorph.curves import CurveNetwork
from elastomorph.evaluation import Shape, ShapeProbe
from elastomorph.evaluation.shape import closure_seams
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.model.polygons import Polygons, polygon_normals
from elastomorph.physics import mean_response

SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])


def probe_of(neutral: Mesh, target: Mesh) -> ShapeProbe:
    return ShapeProbe.of(neutral, target, np.full(len(neutral.vertices), -1))


def test_normals_are_as_long_as_the_area() -> None:
    """A unit square, a triangle of area 2 and an L of area 3, wherever they lie."""
    triangle = [[0, 0, 5], [0, 2, 5], [0, 0, 7]]
    hook = [[0, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0], [1, 2, 0], [0, 2, 0]]
    vertices = np.array([*SQUARE, *triangle, *hook], dtype=float)
    faces = Polygons.of([[0, 1, 2, 3], [4, 5, 6], [12, 11, 10, 9, 8, 7]])
    expected = [[0, 0, 1], [2, 0, 0], [0, 0, -3]]
    np.testing.assert_allclose(polygon_normals(vertices, faces), expected)
    far = polygon_normals(vertices + 1e5 / 3, faces)  # (1e5/3)² loses seven digits more than 1e5/3
    np.testing.assert_allclose(far, expected, atol=1e-9)


def test_a_polygon_turned_over_against_both_ends_is_a_flip() -> None:
    """A square mirrored on the way is one; turned against one end only, it is none."""
    mesh = Mesh(SQUARE, [[0, 1, 2, 3]])
    mirrored = SQUARE * [-1, 1, 1]
    probe = probe_of(mesh, mesh)
    assert probe.flips(SQUARE) == 0
    assert probe.flips(mirrored) == 1
    assert probe.flips(SQUARE * [0, 1, 1]) == 0  # no area, no normal
    assert probe_of(mesh, mesh.with_vertices(mirrored)).flips(mirrored) == 0


def test_stretch_is_measured_against_the_nearer_end() -> None:
    """An edge of length 1 at one end and 2 at the other may have any length between."""
    neutral = Mesh([[0.0, 0, 0], [1, 0, 0], [0.5, 0, 1]], [[0, 1, 2]])
    target = neutral.with_vertices(2 * neutral.vertices)
    probe = probe_of(neutral, target)
    for scale, expected in ((1.0, 1.0), (1.5, 1.0), (2.0, 1.0), (3.0, 1.5), (0.25, 4.0)):
        assert probe.stretch(scale * neutral.vertices) == pytest.approx(expected)


def test_an_edge_that_collapses_is_infinitely_shrunk() -> None:
    """Unless it is a point at one of the ends, as eyelids that close."""
    line = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    shut = line.copy()
    shut[1] = 0
    mesh = Mesh(line, [[0, 1, 2]])
    assert probe_of(mesh, mesh).stretch(shut) == np.inf
    assert probe_of(mesh, mesh.with_vertices(shut)).stretch(shut) == pytest.approx(1.0)


def test_edges_without_length_are_skipped() -> None:
    """Two vertices at one place in both ends are no measure of anything."""
    welded = SQUARE.copy()
    welded[1] = welded[0]
    mesh = Mesh(welded, [[0, 1, 2, 3]])
    apart = welded.copy()
    apart[1] += [0, 0, 0.1]
    stretch = probe_of(mesh, mesh).stretch(apart)
    assert stretch == pytest.approx(np.sqrt(2.01 / 2))  # only the diagonal 1-2 grew


def test_a_seam_computed_by_hand() -> None:
    """Two curves of a ladder, D = 5; the bend lifts one of them by 0.5 at t = 0.5."""
    vertices = np.array([[0.0, 0, 0], [4, 0, 0], [4, 3, 0], [0, 3, 0]])
    neutral = Mesh(vertices, [[0, 1, 2, 3]])
    bend = np.zeros((1, 4, 3))
    bend[0, 2:, 2] = -2.0  # times t² - t = -1/4
    morph = Morph(neutral, neutral, bend, (BendCurve.power(2),))
    across = ShapeProbe.of(neutral, neutral, np.array([0, 0, 1, 1]))
    assert across.seam(morph, 0.5) == pytest.approx(0.5 / 5)
    assert across.seam(morph, 0.25) == pytest.approx(0.375 / 5)
    assert across.seam(morph, 0.0) == 0
    along = ShapeProbe.of(neutral, neutral, np.array([0, 1, 1, 0]))
    assert along.seam(morph, 0.5) == 0  # its edges between curves, 0-1 and 2-3, do not part
    one = ShapeProbe.of(neutral, neutral, np.zeros(4, dtype=int))
    assert one.seam(morph, 0.5) == 0
    no_curve = ShapeProbe.of(neutral, neutral, np.array([0, 0, -1, -1]))
    assert no_curve.seam(morph, 0.5) == pytest.approx(0.1)


@pytest.mark.parametrize("law", [BendCurve.power(2), BendCurve.polynomial([0, 0.5, -1.5, 1])])
def test_the_limit_law_has_no_seam(
    neutral: Mesh, target: Mesh, rows: CurveNetwork, law: BendCurve
) -> None:
    """Linear, and the straight line at any law that is the limit law, part nowhere."""
    probe = ShapeProbe.of(neutral, target, rows.curve_of)
    delta = (target.vertices - neutral.vertices)[None]
    eased = Morph(neutral, target, delta, (law,), limit_law=law)
    linear = Morph(neutral, target, delta[:0], ())
    for time in np.linspace(0, 1, 7):
        assert probe.seam(eased, time) == 0
        assert probe.seam(linear, time) == 0
    behind = Morph(neutral, target, delta, (law,), limit_law=BendCurve.power(5))
    assert probe.seam(behind, 0.5) > 0


def test_markers_have_no_shape() -> None:
    """Without polygons there are no edges, so nothing parts, flips or stretches."""
    markers = Mesh(SQUARE)
    still = Morph(markers, markers, np.zeros((0, 4, 3)), ())
    probe = ShapeProbe.of(markers, markers, np.arange(4))
    assert probe.at(still, 0.5, 3 * SQUARE) == Shape(0.0, 0, 1.0)


def test_the_worst_of_two_is_taken_number_by_number() -> None:
    """The largest seam and the largest stretch may come from different frames."""
    worst = Shape(0.1, 3, 1.2).worst(Shape(0.2, 1, 1.1))
    assert worst == Shape(0.2, 3, 1.2)


def test_seam_is_the_difference_of_the_means() -> None:
    """One row of a strip rises, the other stays: the seam is |φ₀(½) - ¼|·height / D."""
    count = 6
    x = np.arange(count, dtype=float)
    points = np.concatenate([np.stack([x, 0 * x + row, 0 * x], axis=1) for row in (0, 1)])
    faces = [[i, i + 1, count + i + 1, count + i] for i in range(count - 1)]
    neutral = em.Mesh(points, faces)
    target = neutral.with_vertices(points + np.repeat([[0, 0, 0], [0, 0, 2.0]], count, axis=0))
    rows = em.CurveNetwork(
        [em.Curve(np.arange(count), False), em.Curve(np.arange(count, 2 * count), False)],
        2 * count,
    )
    for found in closure_seams(neutral, target, rows):
        law = mean_response(found.closure, em.Load.power(2), em.Material())
        value = sum(c * 0.5 ** (r + 1) for r, c in enumerate(law))
        assert found.shape.seam == pytest.approx(abs(value - 0.25) * 2 / neutral.diameter)
