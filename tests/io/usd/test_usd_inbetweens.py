"""In-betweens stand where they help most, and the error stated is the error there is."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from usd_rigs import curved, grid, piecewise_linear

from elastomorph.io.blend_shapes import hats
from elastomorph.io.usd.inbetweens import deviation, place_inbetweens
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.paths import interpolate, through


def point_morph(bends: list[list[list[float]]], curves: list[BendCurve]) -> Morph:
    """Bends on two points at a distance of 1, so that D is 1."""
    mesh = Mesh([[0, 0, 0], [1, 0, 0]])
    return Morph(mesh, mesh, np.array(bends), tuple(curves))


@pytest.mark.parametrize("count", range(6))
def test_a_parabola_is_cut_into_equal_parts(count: int) -> None:
    """A chord of t² over a length h is off by h²/4, so n in-betweens leave 1/(4 (n + 1)²)."""
    morph = point_morph([[[0, 0, 0], [0, 3, 4]]], [BendCurve.power(2)])
    placed = place_inbetweens(morph, tolerance=0, most=count)
    # the grid is 1/64: parts of 22 or 21 cells instead of 21⅓ where 64 cannot be divided
    largest = -(-64 // (count + 1)) / 64
    assert len(placed.weights) == count
    assert placed.error == pytest.approx(5 * largest**2 / 4, rel=1e-4)
    assert placed.straight_error == pytest.approx(5 / 4)
    assert np.diff([0, *placed.weights, 1]).max() == largest


def test_a_straight_path_needs_no_inbetweens() -> None:
    mesh = grid()
    straight = interpolate(mesh, mesh.with_vertices(mesh.vertices * 2), method="linear")
    flat = Morph(mesh, straight.target, np.zeros((1, *mesh.vertices.shape)), (BendCurve.power(2),))
    for morph in (straight, flat):
        placed = place_inbetweens(morph, tolerance=0, most=3)
        assert placed.weights.size == 0
        assert placed.error == placed.straight_error == 0


@given(weights=st.lists(st.floats(1 / 64, 63 / 64, width=32), min_size=1, max_size=4, unique=True))
@settings(max_examples=50, deadline=None)
def test_a_piecewise_linear_path_gets_its_own_inbetweens_back(weights: list[float]) -> None:
    """Its corners are on the grid, so nothing is left of the error."""
    places = np.sort(weights)
    assume((np.diff(places) > 1e-3).all())
    rows = [[[0.0, 1.0 + i, 0.0], [0.0, 0.0, (-1.0) ** i * (2 + i)]] for i in range(len(places))]
    placed = place_inbetweens(point_morph(rows, [*hats(places)]), tolerance=0, most=len(places))
    np.testing.assert_array_equal(placed.weights, places)
    assert placed.error < 1e-12


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("count", [1, 2])
def test_no_other_place_on_the_grid_is_better(seed: int, count: int) -> None:
    """Every choice on the grid of 1/64 is tried."""
    morph = curved(grid(2, 4), seed, slice(0, 8), powers=2 + seed % 3)
    cells = np.linspace(0, 1, 65)
    step = 1 if count == 1 else 3
    placed = place_inbetweens(morph, tolerance=0, most=count)
    own = deviation(morph, placed.weights, cells)
    others = combinations(cells[1:-1:step], count)
    assert own <= min(deviation(morph, np.array(one), cells) for one in others) + 1e-12


@given(seed=st.integers(0, 10**6), powers=st.integers(1, 6), most=st.integers(0, 4))
@settings(max_examples=40, deadline=None)
def test_the_stated_error_is_what_a_finer_measurement_finds(
    seed: int, powers: int, most: int
) -> None:
    morph = curved(grid(2, 5), seed, slice(0, 10), powers)
    placed = place_inbetweens(morph, tolerance=0, most=most)
    fine = np.linspace(0, 1, 4001)
    found = deviation(morph, placed.weights, fine) / morph.neutral.diameter
    assert placed.error * (1 - 1e-9) <= found * (1 + 1e-3)
    assert found <= placed.error * (1 + 1e-3)
    for t in (0.1, 0.33, 0.8):
        straight = piecewise_linear(morph, tuple(placed.weights), t)
        apart = np.linalg.norm(morph.at(t) - straight, axis=1).max()
        assert apart == pytest.approx(deviation(morph, placed.weights, np.array([t])), abs=1e-9)
        assert apart <= found * morph.neutral.diameter * (1 + 1e-3) + 1e-9


@given(seed=st.integers(0, 10**6), tolerance=st.floats(1e-4, 1))
@settings(max_examples=40, deadline=None)
def test_no_more_inbetweens_than_the_tolerance_needs(seed: int, tolerance: float) -> None:
    morph = curved(grid(2, 3), seed, slice(0, 6))
    placed = place_inbetweens(morph, tolerance=tolerance, most=5)
    if placed.error > tolerance:
        assert len(placed.weights) == 5
    if len(placed.weights):
        fewer = place_inbetweens(morph, tolerance=0, most=len(placed.weights) - 1)
        assert fewer.error > tolerance


@pytest.mark.parametrize("time", [0.123, 0.5, 0.8])
def test_a_path_through_one_shape_has_it_for_its_inbetween(time: float) -> None:
    """|h²(3 - 2h) - h| = h(1 - h)|1 - 2h| is 1/(6√3) at most, on either side of it."""
    neutral, target = Mesh([[0, 0, 0], [1, 0, 0]]), Mesh([[0, 0, 1], [1, 0, 1]])
    shape = Mesh([[0, 0.3, time], [1, 0.3, time]])
    morph = through(neutral, target, {time: shape})
    placed = place_inbetweens(morph, tolerance=0, most=1)
    assert placed.weights.tolist() == pytest.approx([time], abs=1e-7)
    assert placed.error == pytest.approx(0.3 / (6 * 3**0.5), rel=1e-3)
    assert placed.straight_error == pytest.approx(0.3, rel=1e-6)


def test_more_inbetweens_never_hurt() -> None:
    morph = curved(grid(), 8, slice(0, 20), powers=5)
    errors = [place_inbetweens(morph, tolerance=0, most=n).error for n in range(7)]
    assert errors == sorted(errors, reverse=True)


def test_a_path_with_a_thousand_corners_is_placed_all_the_same() -> None:
    breaks = np.linspace(0, 1, 1001)
    heights = np.sin(np.pi * breaks)
    heights[-1] = 0
    slopes = np.diff(heights) * 1000
    curve = BendCurve(breaks, np.stack([heights[:-1], slopes], axis=1))
    placed = place_inbetweens(point_morph([[[0, 0, 0], [0, 0, 1]]], [curve]), tolerance=0, most=2)
    # a sine between thirds: the chord of the middle third, from √3/2 to √3/2, is off by 1 - √3/2
    assert placed.error < 1 - np.sqrt(3) / 2 + 1e-3
