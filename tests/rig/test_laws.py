"""Laws of correctives: by their definitions, number for number, and by what must hold of each."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import elastomorph as em
from elastomorph.rig.laws import LAWS

UNIT = st.floats(0, 1)
ANY = st.floats(-2, 3)


def of_two(law, **numbers):
    return em.Corrective(("a", "b"), law, **numbers)


TWO = {
    "product": of_two("product"),
    "min": of_two("min"),
    "softmin": of_two("softmin", numbers=(6.0,)),
    "hinge": of_two("hinge", numbers=(0.75, 1.5)),
    "allMul": of_two("allMul"),
    "extMul": of_two("extMul"),
    "mulAvgExt": of_two("mulAvgExt"),
    "mulAvgAll": of_two("mulAvgAll"),
}


def weight(own, *drivers):
    return float(own.weight(np.array(drivers, float)))


def by_hand(own, drivers):
    """The same in plain Python, from the table of the docstring."""
    clamped = [min(max(w, 0.0), 1.0) for w in drivers]
    low, high, total = min(clamped), max(clamped), sum(clamped)
    match own.law:
        case "product":
            return math.prod(drivers)
        case "min":
            return max(0.0, min(drivers))
        case "softmin":
            if min(drivers) <= 0:
                return 0.0
            # By logarithms, for powers of small numbers overflow.
            p = own.numbers[0]
            logs = [-p * math.log(w) for w in drivers]
            top = max(logs)
            mean = sum(math.exp(own - top) for own in logs) / len(logs)
            return math.exp(-(top + math.log(mean)) / p)
        case "hinge":
            return max(0.0, sum(k * w for k, w in zip(own.numbers, drivers, strict=True)) - 1)
        case "allMul":
            return math.prod(clamped)
        case "extMul":
            return low * high
        case "mulAvgExt":
            return 2 * low * high / (low + high) if low + high else 0.0
        case "mulAvgAll":
            return len(drivers) * math.prod(clamped) / total if total else 0.0


def test_every_law_is_tried_here():
    assert TWO.keys() == LAWS.keys()


@pytest.mark.parametrize("law", TWO)
@given(st.lists(ANY, min_size=1, max_size=5))
def test_it_is_what_the_table_says(law, drivers):
    numbers = TWO[law].numbers[: 1 if law == "softmin" else None]
    if law == "hinge":
        numbers = tuple(np.linspace(-1, 2, len(drivers)))
    own = em.Corrective(tuple(map(str, range(len(drivers)))), law, numbers)
    assert weight(own, *drivers) == pytest.approx(by_hand(own, drivers), rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("law", [law for law in TWO if law != "hinge"])
@given(w=UNIT)
def test_one_slider_alone_moves_nothing(law, w):
    assert weight(TWO[law], w, 0.0) == weight(TWO[law], 0.0, w) == 0.0


@pytest.mark.parametrize("law", ["min", "softmin", "mulAvgExt", "mulAvgAll"])
@given(w=st.floats(1e-100, 1))
def test_both_alike_are_as_one(law, w):
    assert weight(TWO[law], w, w) == pytest.approx(w, rel=1e-12, abs=1e-300)


@pytest.mark.parametrize("law", [law for law in TWO if law != "hinge"])
def test_both_at_one_are_one(law):
    assert weight(TWO[law], 1.0, 1.0) == pytest.approx(1.0, rel=1e-15)


@given(a=UNIT, b=UNIT)
def test_a_sharper_minimum_is_closer_to_the_minimum(a, b):
    values = [weight(of_two("softmin", numbers=(p,)), a, b) for p in (1.0, 4.0, 64.0, 4096.0)]
    least = min(a, b)
    assert all(x >= y - 1e-12 for x, y in pairwise(values))
    assert least - 1e-12 <= values[-1] <= least * 2 ** (1 / 4096) + 1e-12


@given(a=UNIT, b=UNIT)
def test_the_harmonic_mean_has_three_names(a, b):
    means = [of_two("softmin", numbers=(1.0,)), TWO["mulAvgExt"], TWO["mulAvgAll"]]
    first, *others = (weight(own, a, b) for own in means)
    assert others == pytest.approx([first, first], rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("law", TWO)
@given(a=st.floats(0.05, 0.95), b=st.floats(0.05, 0.95))
def test_a_complex_step_is_the_derivative(law, a, b):
    if abs(a - b) < 1e-3 or (law == "hinge" and abs(0.75 * a + 1.5 * b - 1) < 1e-3):
        return  # a kink
    point, step = np.array([a, b]), 1e-6
    for axis in np.eye(2):
        exact = TWO[law].weight(point + 1e-30j * axis).imag / 1e-30
        ends = [TWO[law].weight(point + side * step * axis) for side in (-1, 1)]
        assert exact == pytest.approx((ends[1] - ends[0]) / (2 * step), rel=1e-4, abs=1e-4)


@pytest.mark.parametrize("law", TWO)
@given(st.lists(st.tuples(ANY, ANY), min_size=2, max_size=2), UNIT, UNIT)
def test_no_weight_is_out_of_reach(law, ends, s, t):
    ranges = [(min(own), max(own)) for own in ends]
    low, high = TWO[law].reach(ranges)
    drivers = [a + part * (b - a) for (a, b), part in zip(ranges, (s, t), strict=True)]
    assert low - 1e-9 <= weight(TWO[law], *drivers) <= high + 1e-9


@pytest.mark.parametrize("law", TWO)
@given(other=st.floats(0.1, 1), own=st.floats(0.1, 1))
def test_the_driver_that_gives_a_weight_gives_it(law, other, own):
    wanted = TWO[law].weight(np.array([[other, own]]))
    found = TWO[law].driven_by("b", {"a": np.array([other])}, wanted)
    again = TWO[law].weight(np.stack([[other], found], axis=-1))
    assert again == pytest.approx(wanted, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("own", TWO.values(), ids=TWO)
def test_what_is_written_is_read(own):
    assert em.Corrective.of(own.entry()) == own


def test_drivers_alone_are_a_product():
    assert em.Corrective.of(["a", "b"]) == em.Corrective(("a", "b"))
    assert em.Corrective(("a", "b")).entry() == {"drivers": ["a", "b"]}


@pytest.mark.parametrize(
    "given",
    [
        {"drivers": []},
        {"drivers": "ab"},
        {"drivers": [1]},
        {"drivers": None},
        {"drivers": ["a"], "law": "max"},
        {"drivers": ["a"], "law": ["min"]},
        {"drivers": ["a"], "law": "hinge"},
        {"drivers": ["a"], "law": "hinge", "gains": [1, 2]},
        {"drivers": ["a"], "law": "hinge", "gains": [math.nan]},
        {"drivers": ["a"], "law": "hinge", "gains": ["1"]},
        {"drivers": ["a"], "law": "min", "gains": [1]},
        {"drivers": ["a"], "law": "softmin"},
        {"drivers": ["a"], "law": "softmin", "sharpness": 0},
        {"drivers": ["a"], "law": "softmin", "sharpness": [1, 2]},
        {"drivers": ["a"], "law": "hinge", "gains": [1], "sharpness": 1},
    ],
)
def test_what_fits_no_law_is_refused(given):
    with pytest.raises(em.ParameterError):
        em.Corrective.of(given)


@pytest.mark.parametrize("own", TWO.values(), ids=TWO)
@given(a=ANY, b=ANY)
def test_a_rig_follows_its_law(own, a, b):
    neutral = em.Mesh(np.eye(3), [[0, 1, 2]])
    target = neutral.with_vertices(np.eye(3) + 1)
    still = em.interpolate(neutral, neutral, "linear")
    morphs = {"a": still, "b": still, "c": em.interpolate(neutral, target, "linear")}
    rig = em.Rig(neutral, morphs, correctives={"c": own})
    assert rig.names == ("a", "b")
    moved = rig.pose({"a": a, "b": b}) - neutral.vertices
    assert moved == pytest.approx(np.full((3, 3), weight(own, a, b)), rel=1e-9, abs=1e-9)
    batch = rig.batch([[a, b]], dtype=np.float64)[0] - neutral.vertices
    assert batch == pytest.approx(moved, abs=1e-9)
