"""Units and axes between two positions of the same vertices: which factor, which axis is which."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
from numpy.typing import NDArray

UNITS: dict[float, tuple[str, str]] = {
    10.0: ("millimetres", "centimetres"),
    100.0: ("centimetres", "metres"),
    1000.0: ("millimetres", "metres"),
    2.54: ("centimetres", "inches"),
    25.4: ("millimetres", "inches"),
    39.3701: ("inches", "metres"),
    12.0: ("inches", "feet"),
    30.48: ("centimetres", "feet"),
    304.8: ("millimetres", "feet"),
    3.28084: ("feet", "metres"),
}
"""How many times the numbers in one unit are larger than in another."""

_NEAR = 1.04
# Distances are measured from so many vertices, to so many near ones each.
_SAMPLE, _NEAREST = 3000, 6
# A third of them agree on a factor within this: within 0.0005 in a jaw that drops, 0.33 under noise
# of 0.2 % of D on a fine mesh, 0.8 where vertices are scrambled.
_AGREED = 0.5
# Axes are changed if that explains all but this part of what the other axes leave unexplained.
_BETTER = 0.25
_POORLY = 0.02

Axes = tuple[int, int, int]
_SAME: tuple[Axes, Axes] = ((0, 1, 2), (1, 1, 1))


@dataclass(frozen=True, eq=False)
class Frame:
    """How positions differ in unit and axes: there = factor · here[:, axes] · signs, nearly."""

    factor: float  # sizes there over sizes here; exactly 1 where they are about the same
    unit: str  # what the factor may mean; empty for a factor of no two units
    axes: Axes  # which of our axes is each of theirs
    signs: Axes  # 1 or -1 for each of their axes

    @property
    def same_axes(self) -> bool:
        """Whether every axis is itself."""
        return (self.axes, self.signs) == _SAME

    @property
    def mirrored(self) -> bool:
        """Whether left and right change places."""
        return _handedness(self.axes, self.signs) < 0

    @property
    def is_same(self) -> bool:
        """Whether neither unit nor axes differ."""
        return self.factor == 1.0 and self.same_axes

    @property
    def known(self) -> bool:
        """Whether the positions can be brought back: the factor is 1 or one of two units."""
        return self.factor == 1.0 or bool(self.unit)

    def is_like(self, other: Frame) -> bool:
        """Whether another frame has the same axes, and nearly the same factor."""
        near = 1 / _NEAR < self.factor / other.factor < _NEAR
        return near and (self.axes, self.signs) == (other.axes, other.signs)

    def forth(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) our positions in their unit and axes."""
        return np.asarray(self.factor * points[:, self.axes] * np.array(self.signs, dtype=float))

    def back(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) their positions in our unit and axes."""
        ours = np.empty_like(points)
        ours[:, self.axes] = points * np.array(self.signs, dtype=float)
        return ours / self.factor

    def inverse(self) -> Frame:
        """How positions here differ from those there."""
        x, y, z = (self.axes.index(axis) for axis in range(3))
        factor, unit = (1.0, "") if self.factor == 1.0 else _named(1.0 / self.factor)
        signs = (self.signs[x], self.signs[y], self.signs[z])
        return Frame(factor, unit, (x, y, z), signs)

    def describe_axes(self) -> str:
        """Which axis holds what, such as ``x, -z, y in place of x, y, z``."""
        pairs = zip(self.axes, self.signs, strict=True)
        names = (("-" if sign < 0 else "") + "xyz"[axis] for axis, sign in pairs)
        return f"{', '.join(names)} in place of x, y, z"


def frame_between(here: NDArray[np.float64], there: NDArray[np.float64], scale: float) -> Frame:
    """The unit and the axes of positions, compared with others of the same vertices.

    Sizes are compared between near vertices: an expression leaves most of them as far apart as they
    were, however far it opens the jaw, while another unit changes all by one factor. Axes are
    compared by which of the 48 signed permutations fits best in least squares, if the axes as they
    are fit badly. Factors up to ``scale`` are no change of unit.
    """
    factor, unit = 1.0, ""
    ratio = _common_ratio(here, there)
    if max(ratio, 1 / ratio) > scale:
        factor, unit = _named(ratio)
    axes, signs = _axes(here - here.mean(axis=0), there - there.mean(axis=0))
    return Frame(factor, unit, axes, signs)


def _common_ratio(here: NDArray[np.float64], there: NDArray[np.float64]) -> float:
    """The factor that most distances between near vertices share; 1 where there are none.

    The middle of the shortest interval of logarithms that holds a third of them: what a third of
    the distances agree on is not changed by what the others do.
    """
    from scipy.spatial import cKDTree

    some = np.arange(0, len(here), -(-len(here) // _SAMPLE))
    around = min(_NEAREST + 1, len(here))
    near = np.asarray(cKDTree(here).query(here[some], around)[1]).reshape(len(some), around)
    starts, ends = np.repeat(some, around), near.ravel()
    before, after = (np.linalg.norm(p[starts] - p[ends], axis=1) for p in (here, there))
    measured = (before > 0) & (after > 0)
    ratios = np.sort(np.log(after[measured] / before[measured]))
    if not ratios.size:
        return 1.0
    third = -(-len(ratios) // 3)
    widths = ratios[third - 1 :] - ratios[: len(ratios) - third + 1]
    first = int(np.argmin(widths))
    if widths[first] > _AGREED:  # near vertices are torn apart: only the whole has a size
        mine, their = (np.linalg.norm(p - np.median(p, axis=0), axis=1) for p in (here, there))
        sizes = float(np.median(mine)), float(np.median(their))
        return sizes[1] / sizes[0] if min(sizes) > 0 else 1.0
    return float(np.exp(np.median(ratios[first : first + third])))


def _named(ratio: float) -> tuple[float, str]:
    """The factor between two units that a ratio nearly is, and their names; itself if of none."""
    for known, (larger, smaller) in UNITS.items():
        if 1 / _NEAR < ratio / known < _NEAR:
            return known, f"such as {larger} instead of {smaller}"
        if 1 / _NEAR < ratio * known < _NEAR:
            return 1 / known, f"such as {smaller} instead of {larger}"
    return ratio, ""


def _axes(mine: NDArray[np.float64], their: NDArray[np.float64]) -> tuple[Axes, Axes]:
    lengths = float((mine**2).sum() * (their**2).sum())
    if lengths == 0:
        return _SAME
    products = their.T @ mine
    # What least squares with the best factor leaves, as a part of all.
    left: dict[tuple[Axes, Axes], float] = {}
    for axes in permutations((0, 1, 2)):
        for signs in product((1, -1), repeat=3):
            fit = sum(signs[i] * products[i, axes[i]] for i in range(3))
            left[axes, signs] = 1.0 - max(fit, 0.0) ** 2 / lengths  # type: ignore[index]
    best = min(left, key=lambda key: (round(left[key], 9), key != _SAME, -_handedness(*key)))
    return best if left[_SAME] > _POORLY and left[best] < _BETTER * left[_SAME] else _SAME


def _handedness(axes: Axes, signs: Axes) -> int:
    """1, or -1 where left and right change places."""
    matrix = np.zeros((3, 3))
    matrix[[0, 1, 2], axes] = signs
    return round(float(np.linalg.det(matrix)))
