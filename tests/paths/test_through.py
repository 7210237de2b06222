"""Paths through scanned in-betweens: what each law promises, and that every shape is reached."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import trapezoid
from scipy.interpolate import CubicSpline

from elastomorph.errors import ElastomorphWarning, MeshError, ParameterError, TopologyError
from elastomorph.model.mesh import Mesh
from elastomorph.paths.through import LAWS, cardinal_curves, inner_curvatures, law_for, through

FACES = [[0, 1, 2, 3], [3, 2, 4]]
TIMES = (0.2, 0.45, 0.8)
GRID = np.linspace(0.0, 1.0, 401)

some_times = st.lists(
    st.integers(1, 999).map(lambda n: n / 1000), min_size=1, max_size=7, unique=True
)


def shape(seed: int) -> Mesh:
    return Mesh(np.random.default_rng(seed).normal(size=(5, 3)), FACES)


def shapes(times: tuple[float, ...]) -> dict[float, Mesh]:
    return {time: shape(2 + i) for i, time in enumerate(times)}


def second_derivative(times: tuple[float, ...], piece: int, local: float) -> np.ndarray:
    return np.array(
        [
            2 * curve.coefficients[piece, 2] + 6 * curve.coefficients[piece, 3] * local
            for curve in cardinal_curves(times)
        ]
    )


def hats(times: list[float]) -> np.ndarray:
    """(n, T) on the grid: straight from 0 at the neighbour to 1 at the own time and back."""
    knots = [0.0, *times, 1.0]
    return np.array([np.interp(GRID, knots, unit) for unit in np.eye(len(knots))[1:-1]])


class TestCardinalCurves:
    @pytest.mark.parametrize("law", LAWS)
    @given(times=some_times)
    @settings(max_examples=60, deadline=None)
    def test_one_at_its_own_time_and_zero_at_all_others(self, law: str, times: list[float]) -> None:
        """b_i(t_j) is exactly 1 or 0, and both ends are exactly 0."""
        rising = sorted(times)
        values = np.array([curve(rising) for curve in cardinal_curves(rising, law)])
        np.testing.assert_array_equal(values, np.eye(len(rising)))
        for curve in cardinal_curves(rising, law):
            assert curve(0.0) == 0
            assert curve(1.0) == 0

    @given(times=some_times)
    @settings(max_examples=60, deadline=None)
    def test_they_are_the_natural_splines_of_scipy(self, times: list[float]) -> None:
        rising = sorted(times)
        knots = [0.0, *rising, 1.0]
        for i, curve in enumerate(cardinal_curves(rising)):
            unit = np.zeros(len(knots))
            unit[i + 1] = 1.0
            expected = CubicSpline(knots, unit, bc_type="natural")(GRID)
            scale = np.abs(expected).max()
            np.testing.assert_allclose(curve(GRID), expected, atol=1e-12 * scale)

    @given(times=some_times)
    @settings(max_examples=60, deadline=None)
    def test_piecewise_and_smooth_are_the_hat_and_its_smoothstep(self, times: list[float]) -> None:
        """h and h²(3 - 2h), written out; no weight leaves [0, 1]."""
        rising = sorted(times)
        for h, straight, smooth in zip(
            hats(rising),
            cardinal_curves(rising, "piecewise"),
            cardinal_curves(rising, "smooth"),
            strict=True,
        ):
            np.testing.assert_allclose(straight(GRID), h, atol=1e-12)
            np.testing.assert_allclose(smooth(GRID), h * h * (3 - 2 * h), atol=1e-12)
            for curve in (straight, smooth):
                assert curve(GRID).min() >= -1e-15
                assert curve(GRID).max() <= 1 + 1e-15
                assert curve.peak[1] == pytest.approx(1, abs=1e-12)

    @given(times=some_times)
    @settings(max_examples=60, deadline=None)
    def test_smooth_has_no_slope_at_any_shape(self, times: list[float]) -> None:
        """d/dt h²(3 - 2h) = 6h(1 - h)h′ is 0 at h = 0 and h = 1, from the left and the right."""
        rising = sorted(times)
        breaks = np.array([0.0, *rising, 1.0])
        for curve in cardinal_curves(rising, "smooth"):
            gaps = np.diff(breaks)
            _, first, second, third = curve.coefficients.T
            np.testing.assert_array_equal(first, 0)
            scale = 1e-12 / gaps.min()
            np.testing.assert_allclose(2 * second * gaps + 3 * third * gaps**2, 0, atol=scale)

    def test_a_single_one_by_hand(self) -> None:
        """At τ = 0.1, t = 0.05 and t = 0.55 are half way up and down: weights 0.5 of a bump.

        The spline is x + 4.5(x - x³) at x = (1 - t)/0.9 before the end: 2.34 where 13.5x² = 5.5.
        """
        (smooth,), (spline,) = cardinal_curves([0.1], "smooth"), cardinal_curves([0.1])
        np.testing.assert_allclose(smooth([0.05, 0.1, 0.55]), [0.5, 1, 0.5], atol=1e-15)
        assert smooth(0.025) == pytest.approx(0.0625 * 2.5)  # h = 1/4: h²(3 - 2h)
        assert smooth.peak == pytest.approx((0.1, 1.0))
        assert spline.peak[1] == pytest.approx(2.34, abs=0.005)
        assert spline.peak[1] == pytest.approx(spline(GRID).max(), abs=1e-3)

    def test_natural_ends(self) -> None:
        """The second derivative is zero at 0 and at 1."""
        np.testing.assert_allclose(second_derivative(TIMES, 0, 0.0), 0, atol=1e-12)
        np.testing.assert_allclose(second_derivative(TIMES, 3, 1 - TIMES[-1]), 0, atol=1e-12)

    def test_velocity_and_acceleration_are_continuous(self) -> None:
        breaks = [0.0, *TIMES, 1.0]
        for piece, time in enumerate(TIMES):
            gap = time - breaks[piece]
            before = second_derivative(TIMES, piece, gap)
            np.testing.assert_allclose(before, second_derivative(TIMES, piece + 1, 0.0), atol=1e-10)
            for curve in cardinal_curves(TIMES):
                _, slope, second, third = curve.coefficients[piece]
                end = slope + 2 * second * gap + 3 * third * gap**2
                assert end == pytest.approx(curve.coefficients[piece + 1, 1], abs=1e-12)

    def test_one_in_the_middle_by_hand(self) -> None:
        """Through (0,0), (½,1), (1,0): M = -12, so b(s) = 3s - 4s³ on the first half."""
        (curve,) = cardinal_curves([0.5])
        np.testing.assert_allclose(curve.coefficients[0], [0, 3, 0, -4], atol=1e-14)
        np.testing.assert_allclose(inner_curvatures([0, 0.5, 1]), [[-12]])
        assert curve(0.25) == pytest.approx(0.75 - 4 / 64)

    @pytest.mark.parametrize("law", LAWS)
    def test_time_reversed_times_give_reversed_curves(self, law: str) -> None:
        forward = [curve(GRID) for curve in cardinal_curves(TIMES, law)]
        backward = cardinal_curves([1 - time for time in reversed(TIMES)], law)
        for ours, theirs in zip(forward, reversed(backward), strict=True):
            np.testing.assert_allclose(ours, theirs(1 - GRID), atol=1e-13)

    @pytest.mark.parametrize("times", [[0.5, 0.5], [0.6, 0.4], [0.0], [0.5, 1.0], [np.nan]])
    def test_times_must_rise_within_the_ends(self, times: list[float]) -> None:
        with pytest.raises(ParameterError, match="must rise"):
            cardinal_curves(times)


class TestThrough:
    @pytest.mark.parametrize("method", LAWS)
    def test_every_in_between_is_reached(self, method: str) -> None:
        given_shapes = shapes(TIMES)
        morph = through(shape(0), shape(1), given_shapes, method=method)
        for time, mesh in given_shapes.items():
            np.testing.assert_allclose(morph.at(time), mesh.vertices, rtol=0, atol=2e-15)
        np.testing.assert_array_equal(morph.at(0), shape(0).vertices)
        np.testing.assert_array_equal(morph.at(1), shape(1).vertices)
        assert len(morph.bends) == len(TIMES)

    def test_the_path_is_the_natural_spline_of_every_vertex(self) -> None:
        morph = through(shape(0), shape(1), shapes(TIMES))
        keys = [shape(0), *shapes(TIMES).values(), shape(1)]
        expected = CubicSpline(
            [0, *TIMES, 1], np.stack([mesh.vertices for mesh in keys]), bc_type="natural"
        )(GRID)
        np.testing.assert_allclose(morph.at(GRID), expected, atol=1e-13)

    def test_the_linear_path_is_straight_from_shape_to_shape(self) -> None:
        morph = through(shape(0), shape(1), shapes(TIMES), method="piecewise")
        keys = np.stack(
            [m.vertices for m in (shape(0), *shapes(TIMES).values(), shape(1))]
        ).reshape(5, -1)
        for time in GRID[::40]:
            expected = [np.interp(time, [0, *TIMES, 1], column) for column in keys.T]
            np.testing.assert_allclose(morph.at(time).ravel(), expected, atol=1e-13)

    @pytest.mark.parametrize("time", [0.02, 0.3, 0.5, 0.97])
    def test_through_one_shape_the_default_is_the_bump(self, time: float) -> None:
        """V = V₀ + tΔ + h²(3 - 2h)·D, D = Y - V₀ - τΔ, h = min(t/τ, (1 - t)/(1 - τ))."""
        first, last, between = (shape(seed).vertices for seed in range(3))
        morph = through(shape(0), shape(1), {time: shape(2)})
        h = np.minimum(GRID / time, (1 - GRID) / (1 - time))[:, None, None]
        t = GRID[:, None, None]
        bend = between - first - time * (last - first)
        expected = first + t * (last - first) + h * h * (3 - 2 * h) * bend
        np.testing.assert_allclose(morph.at(GRID), expected, atol=1e-13)
        assert len(morph.bends) == 1
        assert morph.method == f"through {time:g}"

    def test_through_two_shapes_the_default_is_the_spline(self) -> None:
        two = shapes(TIMES[:2])
        default, spline = (through(shape(0), shape(1), two, method=m) for m in (None, "spline"))
        np.testing.assert_array_equal(default.at(GRID), spline.at(GRID))
        assert default.method == spline.method == "through 0.2,0.45"
        smooth = through(shape(0), shape(1), two, method="smooth")
        assert smooth.method == "through 0.2,0.45 smooth"

    @pytest.mark.parametrize("method", LAWS)
    def test_a_face_moved_turned_and_scaled_takes_its_path_along(self, method: str) -> None:
        """Every law is linear in the shapes and keeps what is constant."""
        turn, _ = np.linalg.qr(np.random.default_rng(9).normal(size=(3, 3)))

        def placed(mesh: Mesh) -> Mesh:
            return mesh.with_vertices(2.5 * mesh.vertices @ turn + [1, -2, 3])

        path = through(shape(0), shape(1), shapes(TIMES), method=method)
        between = {time: placed(mesh) for time, mesh in shapes(TIMES).items()}
        moved = through(placed(shape(0)), placed(shape(1)), between, method=method)
        expected = 2.5 * path.at(GRID) @ turn + [1, -2, 3]
        np.testing.assert_allclose(moved.at(GRID), expected, atol=1e-12)

    def test_a_path_that_overshoots_says_so(self) -> None:
        early = {0.1: shape(2)}
        with pytest.warns(ElastomorphWarning, match=r"t = 0\.1 has the weight 2\.34"):
            through(shape(0), shape(1), early, method="spline")
        for method in ("smooth", "piecewise"):
            through(shape(0), shape(1), early, method=method)  # a warning would be an error here
        straight = shape(0).with_vertices(0.9 * shape(0).vertices + 0.1 * shape(1).vertices)
        through(shape(0), shape(1), {0.1: straight}, method="spline")

    def test_laws_by_name(self) -> None:
        """By default by the number of shapes; ``linear`` is what `piecewise` once was called."""
        assert [law_for(None, count) for count in range(4)] == ["spline", "smooth", *["spline"] * 2]
        assert [law_for(law, 1) for law in LAWS] == list(LAWS)
        assert law_for("linear", 1) == "piecewise"
        old, new = (
            through(shape(0), shape(1), shapes(TIMES), method=m) for m in ("linear", "piecewise")
        )
        assert old.method == new.method == "through 0.2,0.45,0.8 piecewise"
        np.testing.assert_array_equal(old.at(GRID), new.at(GRID))

    def test_no_curve_through_the_shapes_bends_less(self) -> None:
        """Any other path through the same shapes has a larger ∫ ‖V″‖² dt."""
        knots = np.array([0, *TIMES, 1])
        spline = CubicSpline(knots, np.sin(7 * knots), bc_type="natural")
        fine = np.linspace(0, 1, 20001)
        own = trapezoid(spline(fine, 2) ** 2, fine)
        bends = dict(
            zip(TIMES, (Mesh([[np.sin(7 * t), 0, 0], [0, 1, 0]]) for t in TIMES), strict=True)
        )
        morph = through(Mesh([[0, 0, 0], [0, 1, 0]]), Mesh([[np.sin(7), 0, 0], [0, 1, 0]]), bends)
        path = morph.at(fine)[:, 0, 0]
        measured = np.diff(path, 2) / np.diff(fine)[0] ** 2
        assert np.mean(measured**2) == pytest.approx(own, rel=1e-3)
        bump = np.prod([fine - knot for knot in knots], axis=0) ** 2 * 1e3
        other = np.gradient(np.gradient(path + bump, fine), fine)
        assert trapezoid(other**2, fine) > own

    def test_the_order_of_the_mapping_does_not_matter(self) -> None:
        forward = through(shape(0), shape(1), shapes(TIMES))
        backward = through(shape(0), shape(1), dict(reversed(shapes(TIMES).items())))
        np.testing.assert_array_equal(forward.bends, backward.bends)
        np.testing.assert_array_equal(forward.at(GRID), backward.at(GRID))
        assert forward.method == backward.method

    @pytest.mark.parametrize("time", [0.1, 1 / 3, 0.7])
    def test_a_shape_on_the_straight_line_needs_no_bend(self, time: float) -> None:
        halfway = (1 - time) * shape(0).vertices + time * shape(1).vertices
        morph = through(shape(0), shape(1), {time: shape(0).with_vertices(halfway)})
        assert not morph.bends.any()

    def test_vertices_that_rest_have_no_bend(self) -> None:
        moved = np.array(shape(0).vertices)
        moved[0] += 1
        middle = np.array(shape(0).vertices)
        middle[0] += [0.2, 0.9, 0.1]
        morph = through(
            shape(0), shape(0).with_vertices(moved), {0.3: shape(0).with_vertices(middle)}
        )
        assert morph.bends[0, 0].all()
        assert not morph.bends[0, 1:].any()

    def test_without_in_betweens_the_path_is_straight(self) -> None:
        morph = through(shape(0), shape(1), {})
        assert morph.method == "linear"
        assert morph.bends.shape == (0, 5, 3)
        np.testing.assert_allclose(
            morph.at(0.25), 0.75 * shape(0).vertices + 0.25 * shape(1).vertices, atol=1e-15
        )

    def test_outside_the_path_goes_straight_on(self) -> None:
        morph = through(shape(0), shape(1), shapes(TIMES))
        step = morph.at(1.1) - morph.at(1.0)
        np.testing.assert_allclose(morph.at(1.4) - morph.at(1.0), 4 * step, atol=1e-12)
        inside = (morph.at(1.0) - morph.at(1 - 1e-6)) / 1e-6
        np.testing.assert_allclose(step / 0.1, inside, atol=1e-4)

    @pytest.mark.parametrize("time", [0, 1, -0.1, 1.5, 1e-12, np.nan, np.inf])
    def test_times_are_within_the_ends(self, time: float) -> None:
        with pytest.raises(ParameterError, match="between 0"):
            through(shape(0), shape(1), {time: shape(2)})

    def test_one_time_cannot_come_twice(self) -> None:
        with pytest.raises(ParameterError, match=r"two in-betweens are at t = 0\.5"):
            through(shape(0), shape(1), {0.5: shape(2), 0.5 + 1e-10: shape(3)})

    def test_a_time_is_a_number(self) -> None:
        with pytest.raises(ParameterError, match="must be a number"):
            through(shape(0), shape(1), {"half": shape(2)})  # type: ignore[dict-item]

    def test_shapes_come_as_a_mapping(self) -> None:
        with pytest.raises(ParameterError, match="mapping from times"):
            through(shape(0), shape(1), [shape(2)])  # type: ignore[arg-type]

    def test_an_unknown_method(self) -> None:
        with pytest.raises(ParameterError, match="smooth, spline, piecewise"):
            through(shape(0), shape(1), {}, method="quintic")

    def test_another_topology(self) -> None:
        other = Mesh(shape(2).vertices, [[0, 1, 2, 4]])
        for arguments in (
            (shape(0), shape(1), {0.5: other}),
            (shape(0), other, {}),
            (shape(0), shape(1), {0.5: Mesh(np.ones((4, 3)))}),
        ):
            with pytest.raises(TopologyError):
                through(*arguments)

    def test_an_in_between_is_a_mesh(self) -> None:
        with pytest.raises(MeshError, match=r"t = 0\.5 must be a Mesh"):
            through(shape(0), shape(1), {0.5: shape(2).vertices})  # type: ignore[dict-item]

    def test_coordinates_that_are_not_numbers_never_become_a_mesh(self) -> None:
        broken = np.array(shape(2).vertices)
        broken[3, 1] = np.nan
        with pytest.raises(MeshError, match="vertex 3"):
            through(shape(0), shape(1), {0.5: shape(0).with_vertices(broken)})
