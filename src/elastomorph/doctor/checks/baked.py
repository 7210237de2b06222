"""A target that contains another one whole: a smile sculpted while the jaw was open."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.findings import Finding, finding
from elastomorph.doctor.side_names import sided_pairs
from elastomorph.doctor.thresholds import Thresholds
from elastomorph.doctor.words import percent
from elastomorph.model.mesh import Mesh

__all__ = ["examine_baked"]

Motions = NDArray[np.float64]
# Vertices that a target moves by at least this part of its largest motion are compared, so many.
_MOVED = 0.1
_SAMPLE = 1500
# Equal means equal but for rounding: within this part of the motion, and of the face.
_EQUAL, _ROUNDING = 2e-3, 3e-6
# A target that others make up but for this part of its motion is a combination of them.
_COMBINED = 0.05
_WEIGHT = 0.1
# Weights this near to 1 are 1: all of the other target.
_ALL = 0.02


def examine_baked(
    neutral: Mesh,
    targets: Mapping[str, Mesh],
    limits: Thresholds,
    sides: Sequence[tuple[str, str]],
    name_of: Callable[[str], str],
) -> list[Finding]:
    """Targets in which another target is baked.

    Args:
        neutral: The neutral.
        targets: Targets as they should be, by file.
        limits: From where on to report.
        sides: How names of targets tell left and right.
        name_of: The name of a target, from its file.
    """
    files = list(targets)
    moved = {file: targets[file].vertices - neutral.vertices for file in files}
    scale = neutral.diameter or 1.0
    near, same = _ROUNDING * scale, limits.nothing * scale
    inside: dict[str, list[tuple[str, float]]] = {file: [] for file in files}
    # Of two that contain each other, the one that moves more vertices, then farther, is the whole.
    reach = {
        file: (int((np.abs(own) > near).any(axis=1).sum()), float((own**2).sum()))
        for file, own in moved.items()
    }
    for part in files:
        lengths = np.linalg.norm(moved[part], axis=1)
        some = np.flatnonzero(lengths > max(_MOVED * lengths.max(), near))
        some = some[:: max(1, -(-len(some) // _SAMPLE))]
        if not some.size:
            continue
        for whole in files:
            if whole == part:
                continue
            weight, share = _contained(moved[whole][some], moved[part][some], near)
            partly = _WEIGHT <= weight < 1.0 - _ALL
            wholly = abs(weight - 1.0) <= _ALL and reach[whole] > reach[part]
            if not (partly or wholly) or share < limits.baked:
                continue
            if float(np.abs(moved[whole] - moved[part]).max()) > same:
                inside[whole].append((part, weight))

    @cache
    def is_combination(file: str) -> bool:
        return _is_combination(file, moved, sides, name_of)

    found = []
    for whole, parts in inside.items():
        parts = [own for own in parts if not is_combination(own[0])]
        if parts and not is_combination(whole):
            found.append(_baked(whole, parts, name_of))
    return found


def _contained(whole: Motions, part: Motions, near: float) -> tuple[float, float]:
    """How much of a part a whole contains: its weight, and the share of it that is there."""
    squares = (part**2).sum(axis=1)
    weights = np.sort((whole * part).sum(axis=1) / squares)
    # The weight that a quarter agrees on: the rest of it also moves by what the whole does itself.
    quarter = -(-len(weights) // 4)
    first = int(np.argmin(weights[quarter - 1 :] - weights[: len(weights) - quarter + 1]))
    weight = float(np.median(weights[first : first + quarter]))
    lengths = np.sqrt(squares)
    off = np.linalg.norm(whole - weight * part, axis=1)
    same = off <= _EQUAL * abs(weight) * lengths + near
    return weight, float(lengths[same].sum() / lengths.sum())


def _is_combination(
    whole: str,
    moved: Mapping[str, Motions],
    sides: Sequence[tuple[str, str]],
    name_of: Callable[[str], str],
) -> bool:
    """Whether a target is made up of several others and nothing of its own, as combinations are.

    Two are only counted as such if they are the left and the right of one expression.
    """
    from scipy.optimize import nnls

    others = [file for file in moved if file != whole and moved[file].any()]
    basis = np.stack([moved[file].ravel() for file in others], axis=1)
    goal = moved[whole].ravel()
    weights, _ = nnls(basis.T @ basis, basis.T @ goal)
    if np.linalg.norm(basis @ weights - goal) > _COMBINED * np.linalg.norm(goal):
        return False
    used = [name_of(file) for file, own in zip(others, weights, strict=True) if own > _WEIGHT]
    return len(used) > 2 or bool(sided_pairs(used, sides)[0])


def _baked(
    whole: str, parts: Sequence[tuple[str, float]], name_of: Callable[[str], str]
) -> Finding:
    words = " and ".join(
        f"{name_of(part)}" + ("" if abs(weight - 1.0) <= _ALL else f" ({percent(weight)} of it)")
        for part, weight in parts
    )
    wholly = any(weight >= 1.0 - _ALL for _, weight in parts)
    return finding(
        "baked-in-target",
        whole,
        f"contains {words}: used together, it counts twice",
        severity=None if wholly else "note",
    )
