"""Timings: from 0 to 1 over a clip, smooth where they say so, and called by their names."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from elastomorph import timing
from elastomorph.errors import ParameterError
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph

GRID = np.linspace(0.0, 1.0, 1001)
RISING = [
    timing.linear,
    timing.smoothstep,
    timing.minimum_jerk,
    timing.cosine,
    timing.gompertz(1e-4),
    timing.gompertz(3),
    timing.gompertz(50),
    timing.from_keys([(0, 0), (0.2, 0.7), (0.5, 0.75), (1, 1)]),
]
EVERY = [*RISING, timing.blink(), timing.blink(0.2, 0.1), timing.from_keys([(0, 1), (0.4, -1)])]

names = pytest.mark.parametrize("law", EVERY, ids=lambda law: law.name)
rising = pytest.mark.parametrize("law", RISING, ids=lambda law: law.name)


def slopes(law: timing.Timing, where: np.ndarray, step: float = 1e-5) -> np.ndarray:
    return (law(where + step) - law(where - step)) / (2 * step)


@rising
def test_from_exactly_0_to_exactly_1_without_turning_back(law: timing.Timing) -> None:
    values = law.at(GRID)
    assert values[0] == 0
    assert values[-1] == 1
    assert np.diff(values).min() >= -1e-15
    assert values.min() >= 0
    assert values.max() <= 1 + 1e-15


@names
def test_a_timing_holds_outside_its_clip(law: timing.Timing) -> None:
    assert law.at(-3) == law.at(0)
    assert law.at(7.5) == law.at(1)


@names
def test_the_shape_of_the_times_is_kept(law: timing.Timing) -> None:
    assert law.at(0.3).shape == ()
    assert law.at([0.3]).shape == (1,)
    # A power of one number and of many are different functions of the processor.
    np.testing.assert_allclose(law([0.3, 0.9]), [law.at(0.3), law.at(0.9)], rtol=1e-14)


@names
def test_a_name_makes_the_same_timing(law: timing.Timing) -> None:
    again = timing.by_name(law.name)
    assert again.name == law.name
    np.testing.assert_array_equal(again.at(GRID), law.at(GRID))


@given(st.floats(0.01, 50))
@settings(max_examples=30, deadline=None)
def test_every_shape_survives_its_name(shape: float) -> None:
    law = timing.gompertz(shape)
    np.testing.assert_array_equal(timing.by_name(law.name).at(GRID), law.at(GRID))


@pytest.mark.parametrize("text", ["minimum-jerk", "minimum_jerk", " Minimum-Jerk "])
def test_names_are_forgiving(text: str) -> None:
    assert timing.by_name(text) is timing.minimum_jerk


def test_names_without_numbers_take_the_usual_ones() -> None:
    assert timing.by_name("gompertz").name == timing.gompertz().name
    assert timing.by_name("blink:0.25").name == timing.blink(0.25).name


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("bounce", "unknown; expected one of linear, smoothstep"),
        ("linear:2", "so many numbers"),
        ("gompertz:1:2", "so many numbers"),
        ("gompertz:fast", "expected a number, found 'fast'"),
        ("gompertz:-1", "above 0"),
        ("blink:0.7:0.3", "together below 1"),
        ("keys:0=0,1", "expected a number, found ''"),
        ("keys:0=0", "two keys or more"),
        ("", "unknown"),
    ],
)
def test_names_that_mean_nothing(text: str, words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        timing.by_name(text)


def test_derivatives_at_the_ends() -> None:
    """smoothstep and cosine start and stop at rest, minimum jerk without acceleration too."""
    t = sympy.symbols("t")
    for law, polynomial, order in (
        (timing.smoothstep, 3 * t**2 - 2 * t**3, 1),
        (timing.minimum_jerk, 10 * t**3 - 15 * t**4 + 6 * t**5, 2),
        (timing.cosine, (1 - sympy.cos(sympy.pi * t)) / 2, 1),
    ):
        expected = sympy.lambdify(t, polynomial, "numpy")(GRID)
        np.testing.assert_allclose(law.at(GRID), expected, atol=1e-15)
        for derivative in range(1, order + 1):
            for end in (0, 1):
                assert sympy.diff(polynomial, t, derivative).subs(t, end) == 0
        assert sympy.diff(polynomial, t, order + 1).subs(t, 0) != 0


@pytest.mark.parametrize(
    "law",
    [timing.linear, timing.smoothstep, timing.minimum_jerk, timing.cosine],
    ids=lambda law: law.name,
)
def test_the_way_back_is_the_way_in_mirrored(law: timing.Timing) -> None:
    np.testing.assert_allclose(law.at(1 - GRID), 1 - law.at(GRID), atol=1e-15)


class TestGompertz:
    @pytest.mark.parametrize("shape", [0.5, 2.0, 5.0])
    def test_it_is_the_double_exponential_from_0_to_1(self, shape: float) -> None:
        plain = np.exp(-np.exp(shape * (1 - 2 * GRID)))
        expected = (plain - plain[0]) / (plain[-1] - plain[0])
        np.testing.assert_allclose(timing.gompertz(shape).at(GRID), expected, atol=1e-14)

    def test_towards_zero_it_is_linear(self) -> None:
        np.testing.assert_allclose(timing.gompertz(1e-9).at(GRID), GRID, atol=2e-9)

    @pytest.mark.parametrize("shape", [1.0, 3.0, 8.0])
    def test_steepest_in_the_middle_below_half(self, shape: float) -> None:
        law = timing.gompertz(shape)
        inner = GRID[1:-1]
        assert inner[np.argmax(slopes(law, inner))] == pytest.approx(0.5, abs=2e-3)
        assert law.at(0.5) < 0.5

    @pytest.mark.parametrize("shape", [0, -1, np.nan, np.inf, 51])
    def test_shapes_have_a_range(self, shape: float) -> None:
        with pytest.raises(ParameterError, match="shape of gompertz"):
            timing.gompertz(shape)


class TestBlink:
    @pytest.mark.parametrize(("closing", "closed"), [(0.3, 0.0), (0.2, 0.25), (0.6, 0.1)])
    def test_open_closed_open(self, closing: float, closed: float) -> None:
        law = timing.blink(closing, closed)
        assert law.at(0) == 0
        assert law.at(closing) == 1
        assert law.at(closing + closed) == pytest.approx(1, abs=1e-14)
        assert law.at(1) == 0
        values = law.at(GRID)
        opening = closing + closed
        before, after = np.less(GRID, closing), np.greater(GRID, opening)
        assert (np.diff(values[before]) >= 0).all()
        assert (np.diff(values[after]) <= 0).all()
        np.testing.assert_allclose(values[~before & ~after], 1, atol=1e-15)

    def test_it_closes_faster_than_it_opens(self) -> None:
        """Each phase is minimum jerk, whose top speed is 15/8 over its length."""
        inner = np.linspace(0.001, 0.999, 2001)
        speed = slopes(timing.blink(0.3), inner)
        assert speed.max() == pytest.approx(15 / 8 / 0.3, rel=1e-4)
        assert speed.min() == pytest.approx(-15 / 8 / 0.7, rel=1e-4)

    def test_no_jolt_where_it_turns(self) -> None:
        law = timing.blink(0.3, 0.1)
        for time in (0.3, 0.4):
            assert abs(slopes(law, np.array([time]))[0]) < 1e-6

    @pytest.mark.parametrize("shares", [(0, 0), (1, 0), (0.5, 0.5), (0.3, -0.1), (np.nan, 0)])
    def test_shares_leave_time_to_open(self, shares: tuple[float, float]) -> None:
        with pytest.raises(ParameterError, match="together below 1"):
            timing.blink(*shares)


class TestKeys:
    @given(
        st.lists(st.tuples(st.integers(0, 100), st.floats(-2, 2)), min_size=2, max_size=8,
                 unique_by=lambda key: key[0])
    )  # fmt: skip
    @settings(max_examples=50, deadline=None)
    def test_through_every_key_and_never_out_of_range_between_two(
        self, keys: list[tuple[int, float]]
    ) -> None:
        placed = sorted((time / 100, value) for time, value in keys)
        law = timing.from_keys(reversed(placed))
        for (early, start), (late, end) in pairwise(placed):
            between = law.at(np.linspace(early, late, 21))
            assert between[0] == pytest.approx(start, abs=1e-12)
            assert between[-1] == pytest.approx(end, abs=1e-12)
            assert between.min() >= min(start, end) - 1e-12
            assert between.max() <= max(start, end) + 1e-12
        assert law.at(0) == pytest.approx(placed[0][1], abs=1e-12)
        assert law.at(1) == pytest.approx(placed[-1][1], abs=1e-12)

    def test_slopes_next_to_nothing(self) -> None:
        """Numbers too small to have a reciprocal are no reason to warn or to leave the range."""
        law = timing.from_keys([(0, 0), (0.5, 1e-310), (1, 1)])
        assert law.at(0.25) <= 1e-310

    def test_two_keys_are_a_straight_line(self) -> None:
        law = timing.from_keys([(0.0, 0.0), (1.0, 1.0)])
        np.testing.assert_allclose(law.at(GRID), GRID, atol=1e-15)

    @pytest.mark.parametrize(
        ("keys", "words"),
        [
            ([(0, 0)], "two keys"),
            ([(0, 0), (0, 1)], "different t"),
            ([(-0.1, 0), (1, 1)], "from 0 to 1"),
            ([(0, 0), (1.1, 1)], "from 0 to 1"),
            ([(0, 0), (np.nan, 1)], "from 0 to 1"),
            ([(0, 0), (1, np.inf)], "finite"),
            ([0, 1], "pairs of numbers"),
            ([("start", 0), (1, 1)], "pairs of numbers"),
        ],
    )
    def test_keys_that_make_no_timing(self, keys: list, words: str) -> None:
        with pytest.raises(ParameterError, match=words):
            timing.from_keys(keys)


class TestOwnLaws:
    def test_any_function_is_a_timing(self) -> None:
        own = timing.Timing("square", lambda t: t**2)
        np.testing.assert_allclose(own.at([0.5, 2.0]), [0.25, 1.0])

    @pytest.mark.parametrize(
        ("law", "words"),
        [(lambda t: t[:1], "2 values for 2 times"), (lambda t: t / 0 * 0, "no finite value")],
    )
    @pytest.mark.filterwarnings("ignore::RuntimeWarning")
    def test_answers_that_are_none(self, law: timing.Law, words: str) -> None:
        with pytest.raises(ParameterError, match=words):
            timing.Timing("own", law).at([0.2, 0.4])

    def test_times_are_finite_numbers(self) -> None:
        with pytest.raises(ParameterError, match="finite"):
            timing.linear.at(np.nan)


class TestTimed:
    def morph(self) -> Morph:
        neutral = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
        bend = np.arange(9.0).reshape(1, 3, 3)
        target = neutral.with_vertices(neutral.vertices + 1)
        return Morph(neutral, target, bend, (BendCurve.power(2),))

    def test_the_path_at_the_times_of_the_timing(self) -> None:
        times = np.linspace(0, 1, 7)
        for law in (timing.minimum_jerk, "minimum-jerk", lambda t: t**3 * (10 + t * (6 * t - 15))):
            frames = timing.timed(self.morph(), law, times)
            assert frames.shape == (7, 3, 3)
            np.testing.assert_allclose(
                frames, self.morph().at(timing.minimum_jerk.at(times)), atol=1e-13
            )

    def test_one_time_is_a_clip_of_one_frame(self) -> None:
        assert timing.timed(self.morph(), timing.blink(), 0.3).shape == (1, 3, 3)

    def test_it_begins_and_ends_exactly(self) -> None:
        frames = timing.timed(self.morph(), "gompertz:4", [0, 1])
        np.testing.assert_array_equal(frames[0], self.morph().neutral.vertices)
        np.testing.assert_array_equal(frames[1], self.morph().target.vertices)

    def test_a_timing_may_overshoot(self) -> None:
        """A value beyond 1 goes straight on along the end of the path."""
        frames = timing.timed(self.morph(), lambda t: 1.2 * t, [1.0])
        np.testing.assert_array_equal(frames[0], self.morph().at(1.2))

    def test_what_is_no_timing(self) -> None:
        with pytest.raises(ParameterError, match="its name or a function"):
            timing.timed(self.morph(), 3, [0, 1])  # type: ignore[arg-type]
