"""Bend curves and morphs: exact at the ends, straight beyond them."""

from __future__ import annotations

from math import comb

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from elastomorph.errors import BakeError, MeshError, ParameterError, TopologyError
from elastomorph.model.bend_curve import BendCurve, unit_roots
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.paths.bake import bake

RANDOM = np.random.default_rng(7)
NEUTRAL = Mesh(RANDOM.normal(size=(30, 3)))
TARGET = NEUTRAL.with_vertices(NEUTRAL.vertices + RANDOM.normal(size=(30, 3)))


@given(st.integers(2, 12), st.floats(0, 1))
def test_power_curve(exponent: int, t: float) -> None:
    assert BendCurve.power(exponent)(t) == pytest.approx(t**exponent - t, abs=1e-14)


def test_continues_along_the_end_tangents() -> None:
    """t³ - t has slope -1 at 0 and 2 at 1."""
    curve = BendCurve.power(3)
    assert curve.end_slopes == (-1.0, 2.0)
    np.testing.assert_allclose(curve([-2.0, -0.5, 1.25, 3.0]), [2.0, 0.5, 0.5, 4.0])


def test_piecewise_curve_takes_the_right_piece() -> None:
    """A tent: up with slope 1 to t = 1/4, then down with slope -1/3."""
    curve = BendCurve(np.array([0, 0.25, 1]), np.array([[0, 1.0], [0.25, -1 / 3]]))
    np.testing.assert_allclose(curve([0, 0.1, 0.25, 0.625, 1]), [0, 0.1, 0.25, 0.125, 0])
    np.testing.assert_allclose(curve.slope([0.1, 0.5]), [1.0, -1 / 3])


def bernstein(row: np.ndarray) -> np.ndarray:
    """The coefficients whose hull a polynomial on [0, 1] does not leave."""
    n = len(row) - 1
    return np.array(
        [sum(comb(i, k) / comb(n, k) * row[k] for k in range(i + 1)) for i in range(n + 1)]
    )


@given(st.floats(-320, -3), st.booleans())
def test_the_peak_of_a_parabola_with_a_last_coefficient_of_dust(exponent, negative):
    """t - t² + e(t³ - t²), its peak at 1/2 but for O(e): rounding noise in e is no turn lost."""
    e = (-1) ** negative * 10**exponent
    time, value = BendCurve.polynomial([0, 1, -1 - e, e]).peak
    assert value == pytest.approx(0.25, abs=abs(e))
    assert time == pytest.approx(0.5, abs=max(abs(e), 1e-7))


coefficient = st.one_of(st.floats(-2, 2), st.sampled_from([1e-14, -3e-16, 1e-17, 1e-200, 0]))


@given(st.lists(coefficient, min_size=2, max_size=7), st.floats(0.05, 0.95), st.floats(-9, 9))
def test_no_value_is_above_the_peak_and_none_of_the_hull_below(inner, middle, knot):
    """Two pieces t(1 - t)q(t), the second scaled to any height: samples below, hulls above."""
    row = np.convolve([0, 1, -1], inner)
    shifted = np.polynomial.Polynomial(row)(np.polynomial.Polynomial([middle, 1])).coef
    rows = np.zeros((2, len(row)))
    rows[0] = row
    rows[1, : len(shifted)] = shifted
    rows *= 10**knot
    curve = BendCurve(np.array([0, middle, 1]), rows)
    times = curve.times_within(257)
    size = np.abs(rows).sum()
    assert np.abs(curve(times)).max() <= curve.height + 1e-13 * size
    fine = np.linspace(0, 1, 129)
    hulls = []
    for start, step in zip(fine, np.diff(fine), strict=False):
        local = np.polynomial.Polynomial(rows[0])(np.polynomial.Polynomial([start, step])).coef
        hulls.append(np.abs(bernstein(local)).max())
    assert curve.height <= max(hulls) + 1e-13 * size
    assert abs(float(curve(curve.peak[0]))) == pytest.approx(curve.height, abs=1e-13 * size)


@given(
    st.lists(st.integers(1, 19), min_size=1, max_size=4, unique=True),
    st.lists(st.floats(-320, -6), max_size=3),
)
def test_roots_are_found_whatever_dust_the_last_coefficients_are(places, dusts):
    """Π (u - r) Π (1 - 10^-d u): the other roots are beyond a million, or at infinity."""
    expected = np.sort(np.array(places) / 20)
    row = np.polynomial.polynomial.polyfromroots(expected)
    for dust in dusts:
        row = np.convolve(row, [1, -(10**dust)])
    assert np.sort(unit_roots(row)) == pytest.approx(expected, abs=1e-7)


def test_what_is_zero_nowhere_or_everywhere_has_no_roots() -> None:
    for row in ([], [0], [1], [0, 0, 0], [1, 0, 0], [1.25, -1, 1], [-1, 0.5]):
        assert unit_roots(np.array(row, dtype=float)).size == 0


@given(st.floats(-2, 3))
def test_one_time_is_the_same_as_many(t: float) -> None:
    tent = BendCurve(np.array([0, 0.25, 1]), np.array([[0, 1.0], [0.25, -1 / 3]]))
    for curve in (BendCurve.power(3), tent):
        assert curve.at(t) == curve(t)
        assert curve.at(t) == curve([0.5, t])[1]


@pytest.mark.parametrize(
    ("breaks", "coefficients"),
    [
        ([0, 1], [[0.1, 0.0]]),
        ([0, 1], [[0.0, 1.0]]),
        ([0, 0.5, 0.5, 1], [[0.0]] * 3),
        ([0, 0.9], [[0.0]]),
        ([0, 1], [[0.0], [0.0]]),
        ([0, 1], [[0.0, np.nan]]),
    ],
)
def test_curves_that_move_the_end_shapes_are_refused(breaks: object, coefficients: object) -> None:
    with pytest.raises(ParameterError):
        BendCurve(np.array(breaks, dtype=float), np.array(coefficients, dtype=float))


def morph(bends: int = 2) -> Morph:
    fields = np.random.default_rng(bends).normal(size=(bends, 30, 3))
    return Morph(NEUTRAL, TARGET, fields, tuple(BendCurve.power(k + 2) for k in range(bends)))


def test_ends_are_exact_to_the_last_bit() -> None:
    ends = morph().at([0, 1])
    assert ends[0].tobytes() == NEUTRAL.vertices.tobytes()
    assert ends[1].tobytes() == TARGET.vertices.tobytes()


def test_one_time_and_many_agree() -> None:
    path, times = morph(), np.array([-0.3, 0.2, 0.5, 0.9, 1.4])
    many = path.at(times)
    assert many.shape == (5, 30, 3)
    for t, positions in zip(times, many, strict=True):
        np.testing.assert_array_equal(path.at(t), positions)


def test_formula_inside() -> None:
    path, t = morph(), 0.3
    d = path.bends
    expected = NEUTRAL.vertices + t * path.delta + (t**2 - t) * d[0] + (t**3 - t) * d[1]
    np.testing.assert_allclose(path.at(t), expected, atol=1e-14)


def test_straight_beyond_both_ends() -> None:
    path, h = morph(), 1e-6
    for end, sign in ((0.0, -1), (1.0, 1)):
        tangent = (path.at(end) - path.at(end - sign * h)) / (sign * h)
        beyond = (path.at(end + sign * 2) - path.at(end)) / (sign * 2)
        np.testing.assert_allclose(beyond, tangent, atol=1e-4)


@pytest.mark.parametrize("times", [np.nan, [0, np.inf], "soon", [[0.1]], None])
def test_times_that_are_not_numbers_are_refused(times: object) -> None:
    with pytest.raises(ParameterError, match="times must be"):
        morph().at(times)  # type: ignore[arg-type]


def test_bends_must_fit() -> None:
    with pytest.raises(MeshError, match="shape"):
        Morph(NEUTRAL, TARGET, np.zeros((1, 29, 3)), (BendCurve.power(2),))
    with pytest.raises(MeshError, match="finite"):
        Morph(NEUTRAL, TARGET, np.full((1, 30, 3), np.nan), (BendCurve.power(2),))
    with pytest.raises(TopologyError):
        Morph(NEUTRAL, Mesh(np.zeros((29, 3))), np.zeros((0, 30, 3)), ())


def rotation(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def test_baked_jaw_rotation_takes_two_bends() -> None:
    """A turn of 25° is a cubic in t to within 0.007 % of D."""
    angle = np.radians(25)
    target = NEUTRAL.with_vertices(NEUTRAL.vertices @ rotation(angle).T)
    path = bake(lambda t: NEUTRAL.vertices @ rotation(t * angle).T, NEUTRAL, target)
    assert len(path.bends) == 2
    assert path.bake_error < 7e-5
    dense = np.linspace(0, 1, 57)
    exact = np.stack([NEUTRAL.vertices @ rotation(t * angle).T for t in dense])
    measured = np.linalg.norm(path.at(dense) - exact, axis=2).max() / NEUTRAL.diameter
    assert measured <= path.bake_error * 1.02


def test_baking_a_polynomial_gives_its_own_bends() -> None:
    exact = morph(3)
    again = bake(exact.at, NEUTRAL, TARGET, tolerance=1e-12)
    assert len(again.bends) == 3
    np.testing.assert_allclose(again.bends, exact.bends, atol=1e-10)


def test_a_straight_path_needs_no_bends() -> None:
    straight = morph(0)
    path = bake(straight.at, NEUTRAL, TARGET)
    assert len(path.bends) == 0
    assert path.bake_error < 1e-14


def test_paths_that_cannot_be_baked_say_so() -> None:
    with pytest.raises(BakeError, match="more than 1e-06"):
        bake(
            lambda t: NEUTRAL.vertices + (t + abs(t - 0.4) - 0.4 - 0.2 * t) * morph().delta,
            NEUTRAL,
            TARGET,
            tolerance=1e-6,
        )
    with pytest.raises(MeshError, match="away from its end at t = 1"):
        bake(lambda t: NEUTRAL.vertices, NEUTRAL, TARGET)
