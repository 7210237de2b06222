"""Drivers of bend curves: as exact as single precision, whatever the curve."""

import importlib

import bpy
import numpy as np
import pytest
from heads import settle


def drivers():
    """The module of the extension, which is there once it is installed."""
    return importlib.import_module("bl_ext.user_default.elastomorph.drivers")


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
    """A key 'jaw"Open' and a key that is to follow it, with the widest ranges."""
    mesh = bpy.data.meshes.new("mesh")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (1, 1, 0)], [], [(0, 1, 2)])
    thing = bpy.data.objects.new("thing", mesh)
    bpy.context.scene.collection.objects.link(thing)
    for name in ("Basis", 'jaw"Open', "bend"):
        block = thing.shape_key_add(name=name)
        block.slider_min, block.slider_max = -10, 10
        block.value = 0
    return mesh.shape_keys


@pytest.mark.parametrize("name", CURVES)
def test_a_driver_follows_its_curve(keys, name):
    followed = CURVES[name]()
    host, block = keys.key_blocks[1:]
    drivers().drive(keys, block, host, followed)
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
