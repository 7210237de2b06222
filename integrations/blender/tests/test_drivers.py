"""Drivers of bend curves and laws: as exact as single precision, whatever the curve or the law."""

import importlib

import bpy
import numpy as np
import pytest
from heads import settle


def drivers():
    """The module of the extension, which is there once it is installed."""
    return importlib.import_module("bl_ext.user_default.elastomorph.drivers")


def law(*names, **more):
    from elastomorph import Corrective

    return Corrective(names, **more)


def curve(breaks, coefficients):
    from elastomorph import BendCurve

    return BendCurve(np.array(breaks, float), np.array(coefficients, float))


def spline(count: int, seed: int):
    """A natural spline through random values at random times."""
    from scipy.interpolate import CubicSpline

    random = np.random.default_rng(seed)
    times = np.r_[0, np.sort(random.uniform(0.02, 0.98, count)), 1]
    values = np.r_[0, random.uniform(-1, 1, count), 0]
    found = CubicSpline(times, values, bc_type="natural")
    return curve(times, found.c[::-1].T)


def sextic():
    """Two pieces of the sixth degree that meet with a kink."""
    left = np.polynomial.Polynomial([0, 1, 0, 0, 0, 0, 8.0])
    height = left(0.5)
    right = np.polynomial.Polynomial([height, -2 * height + 3, 0, 0, 0, 0, 0])
    right -= np.polynomial.Polynomial([0] * 6 + [right(0.5) / 0.5**6])
    return curve([0, 0.5, 1], [left.coef, right.coef])


def power(exponent: int):
    from elastomorph import BendCurve

    return BendCurve.power(exponent)


CURVES = {
    "square": lambda: power(2),
    "16th power": lambda: power(16),
    "smooth bump": lambda: curve(
        [0, 0.3, 1], [[0, 0, 3 / 0.3**2, -2 / 0.3**3], [1, 0, -3 / 0.7**2, 2 / 0.7**3]]
    ),
    "spline of 2": lambda: spline(2, 1),
    "spline of 7": lambda: spline(7, 2),
    "spline of 40": lambda: spline(40, 3),
    "kink": sextic,
    "nothing": lambda: curve([0, 1], [[0.0]]),
}


@pytest.fixture
def keys():
    """Keys 'jaw"Open', "bend", "a" and "b" with the widest ranges."""
    mesh = bpy.data.meshes.new("mesh")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (1, 1, 0)], [], [(0, 1, 2)])
    thing = bpy.data.objects.new("thing", mesh)
    bpy.context.scene.collection.objects.link(thing)
    for name in ("Basis", 'jaw"Open', "bend", "a", "b"):
        block = thing.shape_key_add(name=name)
        block.slider_min, block.slider_max = -10, 10
        block.value = 0
    return mesh.shape_keys


@pytest.mark.parametrize("name", CURVES)
def test_a_driver_follows_its_curve(keys, name):
    followed = CURVES[name]()
    host, block = keys.key_blocks[1:3]
    drivers().drive(keys, block, law(host.name), followed)
    # What single precision leaves of a weight, and of the time at which it is taken.
    allowed = 2e-6 + 2e-7 * np.abs(followed.slope(np.linspace(0, 1, 1001))).max()
    for t in np.linspace(-0.4, 1.4, 361):
        host.value = t
        settle(keys)
        expected = float(followed(host.value))
        if abs(expected) < 9:
            assert abs(block.value - expected) < allowed * max(1.0, abs(expected))
    driver = keys.animation_data.drivers.find(block.path_from_id("value")).driver
    assert driver.is_simple_expression
    assert driver.is_valid


def test_what_fits_is_an_expression():
    for name in ("square", "16th power", "smooth bump", "nothing"):
        assert len(drivers().expression(CURVES[name]())) <= 255
    assert drivers().expression(CURVES["spline of 40"]()) is None


def test_an_expression_is_the_curve():
    """As Python computes it, which reads the same text."""
    for name in ("square", "16th power", "smooth bump", "nothing"):
        followed = CURVES[name]()
        text = compile(drivers().expression(followed), name, "eval")
        for t in np.linspace(-1, 2, 301):
            assert eval(text, {"pow": pow}, {"bent": t}) == pytest.approx(followed(t), abs=1e-6)


LAWS = {
    "product": {},
    "min": {"law": "min"},
    "softmin": {"law": "softmin", "numbers": (4.3,)},
    "sharp softmin": {"law": "softmin", "numbers": (100.0,)},
    "hinge": {"law": "hinge", "numbers": (1 / 3, -0.1, 1.2)},
    "allMul": {"law": "allMul"},
    "extMul": {"law": "extMul"},
    "mulAvgExt": {"law": "mulAvgExt"},
    "mulAvgAll": {"law": "mulAvgAll"},
}


def weights_of_three():
    """(N, 3) weights: random, below 0 and above 1 too; all that 0 and 1 make; ties; next to 0."""
    random = np.random.default_rng(11)
    corners = np.stack(np.meshgrid(*[[-1, 0, 0.5, 1, 2]] * 3), axis=-1).reshape(-1, 3)
    ties = np.repeat(random.uniform(-0.5, 1.5, (12, 2)), [2, 1], axis=1)[:, random.permutation(3)]
    small = 10.0 ** random.uniform(-6, 0, (12, 3))
    return np.concatenate([random.uniform(-0.5, 1.5, (60, 3)), corners, ties, small])


LEAST = 1.0001e-4
"""Blender takes what a driver gives for 0 where it is smaller, whoever made the driver."""


def as_blender_has_it(value: float, expected: float) -> bool:
    """Whether it is the same number in single precision."""
    same = value == pytest.approx(expected, rel=2e-7, abs=2e-7)
    return same or (value == 0 and abs(expected) < LEAST)


@pytest.mark.parametrize("name", LAWS)
def test_a_driver_follows_its_law(keys, name):
    followed = law('jaw"Open', "a", "b", **LAWS[name])
    hosts = [keys.key_blocks[driver] for driver in followed.drivers]
    block = keys.key_blocks["bend"]
    drivers().drive(keys, block, followed)
    (driver,) = keys.animation_data.drivers
    assert driver.driver.is_simple_expression
    for row in weights_of_three():
        for host, weight in zip(hosts, row, strict=True):
            host.value = weight
        settle(keys)
        expected = float(followed.weight(np.array([host.value for host in hosts])))
        assert as_blender_has_it(block.value, expected)
        assert driver.driver.is_valid


@pytest.mark.parametrize("name", CURVES)
def test_a_bend_follows_its_curve_of_a_law(keys, name):
    """That of a pair: nothing where one is below 0, and straight on beyond 1."""
    curve, pair = CURVES[name](), law('jaw"Open', "a", law="min")
    one, block, other = keys.key_blocks[1:4]
    drivers().drive(keys, block, pair, curve)
    driver = keys.animation_data.drivers.find(block.path_from_id("value")).driver
    assert driver.is_simple_expression
    allowed = 2e-6 + 2e-7 * np.abs(curve.slope(np.linspace(0, 1, 1001))).max()
    for a, b, _ in weights_of_three():
        one.value, other.value = a, b
        settle(keys)
        least = max(0.0, min(one.value, other.value))
        expected = float(curve(least))
        if abs(expected) < 9:
            found = abs(block.value - expected)
            assert found < allowed * max(1.0, abs(expected)) or 0 <= least < LEAST


@pytest.mark.parametrize("name", LAWS)
def test_one_driver_is_a_law_too(keys, name):
    """Of one slider the least, the most and the mean are that slider."""
    options = dict(LAWS[name])
    if name == "hinge":
        options["numbers"] = (1.5,)
    followed = law("a", **options)
    host, block = keys.key_blocks["a"], keys.key_blocks["bend"]
    drivers().drive(keys, block, followed)
    for host.value in (-0.5, 0.0, 0.3, 1.0, 1.7):
        settle(keys)
        expected = float(followed.weight(np.array([host.value])))
        assert as_blender_has_it(block.value, expected)


def test_a_law_of_many_takes_fewer_digits():
    gains = np.random.default_rng(5).uniform(-1, 1, 15)
    names = [f"w{number}" for number in range(len(gains))]
    text = drivers().law_expression(law(*names, law="hinge", numbers=tuple(gains)), names)
    assert len(text) <= 255
    weights = dict.fromkeys(names, 1.0)
    for sign in (1, -1):
        now = {name: sign * weight for name, weight in weights.items()}
        found = eval(text, {}, now)
        assert found == pytest.approx(max(0.0, sign * gains.sum() - 1), abs=15 * 1e-7)


def test_a_law_that_is_too_long_drives_nothing(keys):
    followed = law(*["a", "b"] * 20, law="softmin", numbers=(2.0,))
    with pytest.warns(UserWarning, match="bend is not driven: .* 40 drivers"):
        drivers().drive(keys, keys.key_blocks["bend"], followed)
    assert keys.animation_data is None
