"""Drivers that follow laws and bend curves, in what Blender evaluates without running scripts.

Blender works out arithmetic, comparisons, conditions and some functions in a driver by itself and
keeps up to 255 characters of it. A law is such an expression, and so is a curve whose pieces fit.
Any other is the animation curve that Blender maps the value of a driver through: a cubic polynomial
is one Bézier segment, whose handles are a third of the way along, so cubic pieces are exact here
too.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from itertools import pairwise
from math import ceil, factorial

import bpy
import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from elastomorph import BendCurve, Corrective
from elastomorph.errors import ElastomorphWarning

from .record import VARIABLE

LONGEST = 255
"""Characters that Blender keeps of an expression."""

# What rounding of numbers in an expression, or cubics in place of higher powers, may change of a
# weight; what Blender computes in single precision is no closer.
_CLOSE = 2e-7
_MOST_SEGMENTS = 1000

# Blender takes keyframes of an animation curve that are less than 0.01 apart for one.
_APART = 0.05


def drive(
    keys: bpy.types.Key, block: bpy.types.ShapeKey, law: Corrective, curve: BendCurve | None = None
) -> None:
    """Let a key follow a law of the weights of others.

    A bend follows a curve of it, and is muted where one of them is.
    """
    names = [f"w{number}" for number in range(len(law.drivers))]
    if curve is not None:
        names[0] = VARIABLE
    weight = law_expression(law, names)
    if weight is None:
        warnings.warn(
            f"{block.name} is not driven: Blender keeps no law of {len(law.drivers)} drivers",
            ElastomorphWarning,
            stacklevel=2,
        )
        return
    followed = keys.driver_add(block.path_from_id("value"))
    driver = followed.driver
    driver.type = "SCRIPTED"
    _read(driver, keys, law, names, "value")
    if curve is None:
        driver.expression = weight
        return
    text = expression(curve, weight)
    if text is not None:
        driver.expression = text
    if text is None or not driver.is_simple_expression:
        driver.expression = _of_weight(_set_segments(followed, curve), weight)
    muted = keys.driver_add(block.path_from_id("mute")).driver
    muted.type = "MAX"
    _read(muted, keys, law, names, "mute")


def law_expression(law: Corrective, names: Sequence[str]) -> str | None:
    """The weight that a law gives of these variables, or None where it is too long."""
    for digits in (17, 12, 9, 7):
        text = _law(law, names, [_number(float(f"{number:.{digits}g}")) for number in law.numbers])
        if len(text) <= LONGEST:
            return text
    return None


def _law(law: Corrective, names: Sequence[str], numbers: Sequence[str]) -> str:
    every, count = ",".join(names), len(names)
    low, high = (f"min({every})", f"max({every})") if count > 1 else (every, every)
    clamped = [f"clamp({name})" for name in names]
    least, most, product = f"clamp({low})", f"clamp({high})", "*".join(clamped)
    sharpness = numbers[0] if numbers else ""
    # Relative to the least, so that no power overflows.
    powers = "+".join(f"pow({low}/{name},{sharpness})" for name in names)
    sum_of_gains = "+".join(f"{gain}*{name}" for gain, name in zip(numbers, names, strict=False))
    return {
        "product": "*".join(names),
        "min": f"max(0,{low})",
        "softmin": f"{low}*pow(({powers})/{count},-1/{sharpness}) if {low}>0 else 0",
        "hinge": f"max(0,{sum_of_gains.replace('+-', '-')}-1)",
        "allMul": product,
        "extMul": f"{least}*{most}",
        "mulAvgExt": f"2*{least}*{most}/({least}+{most}) if {low}>0 else 0",
        "mulAvgAll": f"{count}*{product}/({'+'.join(clamped)}) if {low}>0 else 0",
    }[law.law]


def _of_weight(text: str, weight: str) -> str:
    return text if weight == VARIABLE else text.replace(VARIABLE, f"({weight})")


def expression(curve: BendCurve, weight: str = VARIABLE) -> str | None:
    """A curve as an expression that Blender evaluates by itself, or None where none fits."""
    pieces = [
        Polynomial(row)(Polynomial([-start, 1.0])).coef
        for start, row in zip(curve.breaks, curve.coefficients, strict=False)
    ]
    for digits in (17, 12, 10, 9):
        rounded = [np.array([float(f"{c:.{digits}g}") for c in row]) for row in pieces]
        text = _of_weight(_text(curve, rounded), weight)
        if len(text) <= LONGEST and _close(curve, rounded):
            return text
    return None


def _text(curve: BendCurve, pieces: Sequence[NDArray[np.float64]]) -> str:
    """Straight on before 0 and after 1, and polynomials between."""
    first, last = curve.end_slopes
    parts = [f"{_straight(first, VARIABLE)} if {VARIABLE}<0 else "]
    for stop, row in zip(curve.breaks[1:], pieces, strict=True):
        parts.append(f"{_horner(row)} if {VARIABLE}<{_number(stop)} else ")
    return "".join(parts) + _straight(last, f"({VARIABLE}-1)")


def _straight(slope: float, variable: str) -> str:
    if abs(slope) == 1:
        return variable if slope > 0 else f"-{variable}"
    return f"{_number(slope)}*{variable}" if slope else "0"


def _horner(row: NDArray[np.float64]) -> str:
    """A polynomial with one product for each of its coefficients that is not 0."""
    powers = np.flatnonzero(row).tolist()
    if not powers:
        return "0"
    text = _number(row[powers[-1]])
    for low, high in reversed([*pairwise(powers)]):
        text = f"({_number(row[low])}+{_product(high - low, text)})"
    return _product(powers[0], text)


def _product(power: int, text: str) -> str:
    if power == 0:
        return text
    factor = VARIABLE if power == 1 else f"pow({VARIABLE},{power})"
    return factor if text == "1" else f"{factor}*{text}"


def _number(value: float) -> str:
    return repr(float(value)).removesuffix(".0")


def _close(curve: BendCurve, pieces: Sequence[NDArray[np.float64]]) -> bool:
    """Whether polynomials in t with rounded coefficients are the curve, piece by piece."""
    for (start, stop), row in zip(pairwise(curve.breaks), pieces, strict=True):
        times = np.linspace(start, stop, 65)[:-1]
        if np.abs(Polynomial(row)(times) - curve(times)).max() > _CLOSE:
            return False
    return True


def knots(curve: BendCurve) -> NDArray[np.float64]:
    """(N,) times between which cubics with the values and slopes of the curve are close to it."""
    times = [0.0]
    for (start, stop), row in zip(pairwise(curve.breaks), curve.coefficients, strict=True):
        width = stop - start
        # A cubic that meets values and slopes at both ends is off by at most h⁴/384 max |b⁗|.
        fourth = sum(
            abs(c) * factorial(n) / factorial(n - 4) * width ** (n - 4)
            for n, c in enumerate(row)
            if n >= 4
        )
        needed = ceil(width * (fourth / (384 * _CLOSE)) ** 0.25)
        times += np.linspace(start, stop, min(max(needed, 1), _MOST_SEGMENTS) + 1)[1:].tolist()
    return np.array(times)


def _set_segments(followed: bpy.types.FCurve, curve: BendCurve) -> str:
    """The curve as Bézier segments, which go on straight along the handles of its ends.

    Returns the expression of the driver: what the segments are a curve of.
    """
    times = knots(curve)
    values = curve(times)
    after, before = _slopes(curve, times)
    stretch = 2.0 ** max(0, ceil(np.log2(_APART / np.diff(times).min())))
    times, after, before = times * stretch, after / stretch, before / stretch
    thirds = np.diff(times) / 3
    while followed.modifiers:  # up to Blender 4.5 a driver has one that maps its value to itself
        followed.modifiers.remove(followed.modifiers[0])
    points = followed.keyframe_points
    while len(points):
        points.remove(points[0])
    points.add(len(times))
    # The outermost handles reach far, so that single precision holds the slopes along them.
    lefts = np.stack([np.r_[stretch, thirds], np.r_[after[0], before]])
    rights = np.stack([np.r_[thirds, stretch], np.r_[after, before[-1]]])
    for i, point in enumerate(points):
        point.interpolation = "BEZIER"
        point.handle_left_type = point.handle_right_type = "FREE"
        (left, rise), (right, fall) = lefts[:, i], rights[:, i]
        point.co = (times[i], values[i])
        point.handle_left = (times[i] - left, values[i] - left * rise)
        point.handle_right = (times[i] + right, values[i] + right * fall)
    followed.extrapolation = "LINEAR"
    followed.update()
    return _product(1, _number(stretch))


def _slopes(
    curve: BendCurve, times: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(N - 1,) slopes just after the start and just before the end of each segment."""
    pieces = np.searchsorted(curve.breaks, (times[1:] + times[:-1]) / 2, side="right") - 1
    rates = [Polynomial(row).deriv() for row in curve.coefficients]
    ends = zip(pieces, times, times[1:], strict=False)
    both = [[rates[i](t - curve.breaks[i]) for t in (start, stop)] for i, start, stop in ends]
    after, before = np.array(both).T
    return after, before


def _read(
    driver: bpy.types.Driver, keys: bpy.types.Key, law: Corrective, names: Sequence[str], what: str
) -> None:
    for name, host in zip(names, law.drivers, strict=True):
        variable = driver.variables.new()
        variable.name = name
        goal = variable.targets[0]
        goal.id_type = "KEY"
        goal.id = keys
        goal.data_path = keys.key_blocks[host].path_from_id(what)
