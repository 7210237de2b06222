"""Clips of bent characters: keys by the formulas of glTF's specification, written out here."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from elastomorph.bending.keys import Columns, Driven, Keys, bent_keys
from elastomorph.errors import ParameterError
from elastomorph.io.blend_shapes import hats
from elastomorph.model.bend_curve import BendCurve
from elastomorph.paths.through import cardinal_curves
from elastomorph.rig.laws import LAWS, Corrective

ARCH = BendCurve.polynomial([0, 1, -1])
HAT = hats(np.array([0.3]))[0]
CURVES = [
    None,
    ARCH,
    BendCurve.power(5),
    HAT,
    *cardinal_curves([0.2, 0.65], "spline"),
    cardinal_curves([0.4], "smooth")[0],
]


def played(
    times: NDArray[np.float64],
    values: NDArray[np.float64],
    interpolation: str,
    when: NDArray[np.float64],
) -> NDArray[np.float64]:
    """(N, targets) weights at moments within the clip, as glTF 2.0 says (appendix C)."""
    found = []
    for moment in when:
        k = max(int(np.sum(times <= moment)) - 1, 0)
        if k == len(times) - 1 or interpolation == "STEP":
            found.append(values[k] if interpolation != "CUBICSPLINE" else values[k, 1])
            continue
        span = times[k + 1] - times[k]
        t = (moment - times[k]) / span
        if interpolation == "LINEAR":
            found.append((1 - t) * values[k] + t * values[k + 1])
            continue
        (_, here, leaves), (arrives, there, _) = values[k], values[k + 1]
        found.append(
            (2 * t**3 - 3 * t**2 + 1) * here
            + span * (t**3 - 2 * t**2 + t) * leaves
            + (-2 * t**3 + 3 * t**2) * there
            + span * (t**3 - t**2) * arrives
        )
    return np.array(found)


def off(columns: Columns, source: tuple[NDArray, NDArray, str], keys: Keys) -> float:
    """Largest Σ_k |error|·|D_k| of what follows, at many moments and at those beside keys."""
    times, values, interpolation = source
    parts = np.linspace(0, 1, 41)[:, None]
    when = np.append((keys.times[:-1] + parts * np.diff(keys.times)).ravel(), keys.times[-1])
    sliders = played(times, values, interpolation, when)
    weights = played(keys.times, keys.values, interpolation, when)
    sizes = np.zeros(weights.shape[1])
    sizes[columns.count :] = [size for _, _, size in columns.bends]
    for column, (_, size) in columns.folds.items():
        sizes[column] = size
    return float((np.abs(weights - columns.weights(sliders)) @ sizes).max())


def single(*shape: int, low: float, high: float) -> st.SearchStrategy[NDArray[np.float64]]:
    count = int(np.prod(shape))
    numbers = st.floats(low, high, width=32)
    listed = st.lists(numbers, min_size=count, max_size=count)
    return listed.map(lambda values: np.array(values, dtype=np.float64).reshape(shape))


@st.composite
def driven(draw: st.DrawFn, count: int) -> Driven:
    """One to three sliders, and a law of them."""
    columns = draw(st.lists(st.integers(0, count - 1), min_size=1, max_size=3))
    law = draw(st.sampled_from(list(LAWS)))
    gains = [draw(st.floats(-2, 2, width=16)) for _ in columns]
    numbers = {"hinge": tuple(gains), "softmin": (draw(st.sampled_from([1.0, 3.0])),)}
    names = tuple(map(str, columns))
    return Driven(tuple(columns), Corrective(names, law, numbers.get(law, ())))


@st.composite
def clips(draw: st.DrawFn) -> tuple[Columns, tuple[NDArray, NDArray, str]]:
    """A mesh of one to three sliders, and a clip of them that leaves [0, 1] too."""
    count, length = draw(st.integers(1, 3)), draw(st.integers(1, 4))
    steps = draw(single(length, low=2**-10, high=4.0))
    start = draw(st.floats(0, 8, width=32))
    times = (start + np.cumsum(steps)).astype(np.float32).astype(np.float64)
    values = draw(single(length, count, low=-0.25, high=1.25))
    interpolation = draw(st.sampled_from(["STEP", "LINEAR", "CUBICSPLINE"]))
    if interpolation == "CUBICSPLINE":
        tangents = draw(single(2, length, count, low=-4, high=4))
        values = np.stack([tangents[0], values, tangents[1]], axis=1)
    sizes = st.floats(1e-4, 0.1)
    curves = st.sampled_from(CURVES)
    driver = st.one_of(st.integers(0, count - 1), driven(count))
    bends = draw(st.lists(st.tuples(driver, curves, sizes), max_size=3))
    folds = draw(st.dictionaries(st.integers(0, count - 1), st.tuples(curves, sizes), max_size=1))
    return Columns(count, tuple(bends), folds), (times, values, interpolation)


@settings(max_examples=150, deadline=None)
@given(clips())
def test_between_keys_all_that_follows_is_within_the_tolerance(clip):
    columns, source = clip
    times, values, interpolation = source
    keys = bent_keys(times, values, interpolation, columns, 1e-4)
    assert keys.error <= 1e-4 + 1e-6  # room is there for all keys, and weights are rounded
    if interpolation != "STEP":
        assert off(columns, source, keys) <= keys.error + 1e-7  # of a corner's rounded time


@settings(max_examples=100, deadline=None)
@given(clips())
def test_source_keys_stay_and_hold_the_exact_weights(clip):
    columns, (times, values, interpolation) = clip
    keys = bent_keys(times, values, interpolation, columns, 1e-4)
    assert keys.interpolation == interpolation
    assert np.isin(times, keys.times).all()
    assert (np.diff(keys.times.astype(np.float32)) > 0).all()
    assert np.array_equal(keys.times.astype(np.float32), keys.times)
    assert np.array_equal(keys.values.astype(np.float32), keys.values)
    own = keys.values[np.searchsorted(keys.times, times)]
    unfolded = [column for column in range(columns.count) if column not in columns.folds]
    assert np.array_equal(own[..., unfolded], values[..., unfolded])
    if interpolation == "CUBICSPLINE":
        own, values = own[:, 1], values[:, 1]
    assert np.array_equal(own, columns.weights(values).astype(np.float32))


@settings(max_examples=60, deadline=None)
@given(clips())
def test_sliders_play_the_same_curve_between_more_keys(clip):
    columns, (times, values, interpolation) = clip
    keys = bent_keys(times, values, interpolation, columns, 1e-5)
    when = np.linspace(times[0], times[-1], 301)
    before = played(times, values, interpolation, when)
    after = played(keys.times, keys.values, interpolation, when)
    for column in range(columns.count):
        if column not in columns.folds:
            assert after[:, column] == pytest.approx(before[:, column], abs=2e-6)


@settings(max_examples=40, deadline=None)
@given(clips())
def test_steps_get_no_keys(clip):
    columns, (times, values, interpolation) = clip
    if interpolation == "CUBICSPLINE":
        values = values[:, 1]
    keys = bent_keys(times, values, "STEP", columns, 1e-9)
    assert np.array_equal(keys.times, times)
    assert np.array_equal(keys.values, columns.weights(values).astype(np.float32))


def test_a_parabola_gets_as_few_straight_pieces_as_there_can_be():
    # A chord of length h of s - s² leaves h²/4 (a quarter of h² times half of b″ = -2). With a
    # bend of 0.1 D and 0.1/4/16 allowed, h = 1/4 just fits: four pieces, three keys between.
    columns = Columns(1, ((0, ARCH, 0.1),), {})
    keys = bent_keys([0, 1], [[0], [1]], "LINEAR", columns, 1.1 * 0.1 / 4 / 16)
    assert len(keys.times) == 5


def test_one_cubic_holds_a_parabola_of_a_straight_slider():
    # CUBICSPLINE keys with tangents 1 are s = t, and s - s² is a cubic in t already.
    values = [[[1], [0], [1]], [[1], [1], [1]]]
    keys = bent_keys([0, 1], values, "CUBICSPLINE", Columns(1, ((0, ARCH, 0.1),), {}), 1e-9)
    assert keys.times.tolist() == [0, 1]
    assert keys.values[:, :, 1].tolist() == [[1, 0, 1], [-1, 0, -1]]
    assert keys.error < 1e-9


def test_keys_of_an_in_between_turn_the_corner_at_a_source_key():
    # The slider stands at 0.3 at a source key, rounded: the hat comes up one side with slope
    # 1/0.3 and leaves with -1/0.7; no key more is needed.
    level = np.float64(np.float32(0.3))
    values = [[[1], [0], [1]], [[1], [level], [1]], [[1], [1], [1]]]
    columns = Columns(1, ((0, HAT, 0.1),), {})
    keys = bent_keys([0, level, 1], values, "CUBICSPLINE", columns, 1e-6)
    assert len(keys.times) == 3
    assert keys.values[1, :, 1] == pytest.approx([1 / 0.3, 1, -1 / 0.7], rel=1e-6)


def test_a_slider_that_turns_back_at_a_corner_leaves_as_it_came():
    values = [[[0], [0.3], [-1]], [[0], [0], [0]]]
    keys = bent_keys([0, 1], values, "CUBICSPLINE", Columns(1, ((0, HAT, 0.1),), {}), 1e-3)
    assert keys.values[0, 2, 1] == pytest.approx(-1 / 0.3, rel=1e-6)


def test_where_single_precision_has_no_room_the_error_left_is_told():
    times = np.float32(4096) + np.array([0, 2, 4]) * np.spacing(np.float32(4096))
    columns = Columns(1, ((0, ARCH, 0.1),), {})
    keys = bent_keys(times, [[0], [1], [0]], "LINEAR", columns, 1e-6)
    assert len(keys.times) == 5  # the one time between each two is taken
    assert 0.1 / 16 <= keys.error <= 0.1 / 16 * 1.01 + 0.1 * 1 / 16  # a chord of a half, bounded


def test_sliders_that_rest_need_no_keys():
    columns = Columns(2, ((0, ARCH, 0.1),), {})
    keys = bent_keys([0, 1, 2], [[0.5, 0], [0.5, 1], [0.5, 0]], "LINEAR", columns, 1e-9)
    assert keys.times.tolist() == [0, 1, 2]
    assert keys.values[:, 2].tolist() == [0.25] * 3


def test_a_fold_is_added_to_the_weight_of_its_own_slider():
    columns = Columns(2, (), {1: (ARCH, 0.3)})
    assert columns.weights([0.5, 0.5]).tolist() == [0.5, 0.75]
    assert columns.weights([[0, -1], [0, 2]]).tolist() == [[0, -2], [0, 1]]  # along end tangents


@pytest.mark.parametrize(
    ("times", "values", "interpolation", "words"),
    [
        ([0, 1], [[0], [1]], "SLERP", "an interpolation is STEP"),
        ([0, 1], [[0]], "LINEAR", "found \\(1, 1\\) at \\(2,\\)"),
        ([0, 1], [[0], [1]], "CUBICSPLINE", "shape \\('T', 3, 1\\)"),
        ([], np.zeros((0, 1)), "LINEAR", "keys of 1 weights"),
        ([1, 1], [[0], [1]], "LINEAR", "must rise"),
        ([1, 1 + 1e-12], [[0], [1]], "LINEAR", "must rise"),
        ([0, 1], [[0], [np.nan]], "LINEAR", "finite"),
        ([0, 1], [[0], [1e39]], "STEP", "finite"),
    ],
)
def test_keys_that_are_none_are_refused(times, values, interpolation, words):
    with pytest.raises(ParameterError, match=words):
        bent_keys(times, values, interpolation, Columns(1, ((0, ARCH, 0.1),), {}), 1e-5)


def test_columns_know_their_sliders():
    with pytest.raises(ParameterError, match="column 2 of a mesh of 2 weights"):
        Columns(2, ((2, ARCH, 0.1),), {})
    with pytest.raises(ParameterError, match=r"shape \(…, 2\)"):
        Columns(2, (), {}).weights([1.0, 2.0, 3.0])


def test_a_kink_at_a_moment_that_is_rounded_needs_one_key() -> None:
    """0.5 - 3u + 4.5u² - 2u³ passes 0 at u = 0.25, which no time in single precision is here."""
    law = Driven((0, 0), Corrective(("0", "0"), "min", ()))
    columns = Columns(1, ((law, None, 0.0625),), {})
    for start in (1.0633256, 37.1, 301.7):
        times = np.array([start, start + 3], dtype=np.float32).astype(np.float64)
        values = np.array([[[0.0], [0.5], [-1.0]], [[0.0], [0.0], [0.0]]])
        keys = bent_keys(times, values, "CUBICSPLINE", columns, 1e-4)
        assert len(keys.times) == 3
        assert keys.error < 1e-5
