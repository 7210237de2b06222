"""Left and right exchanged: by where targets move the face, or which way, and what left is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.checks.inside_out import inside_out
from elastomorph.doctor.findings import Finding, finding
from elastomorph.doctor.mirror import Mirror
from elastomorph.mesh import Mesh

__all__ = ["examine_swapped"]

# How clearly a target must be on one side to be called left or right: the mean distance from the
# plane of what moves, signed over unsigned;
_CLEARLY = 0.8
# and how clearly one that moves the middle must go to one side: its mean motion, across the plane
# over all. Jaws and mouths of three rigs have 0.76 and more.
_ASIDE = 0.5
# From so many pairs on, what most of them do tells what is left.
_ENOUGH = 3
# A face looks along an axis if what moves has this cosine with it.
_FACES = 0.75


@dataclass(frozen=True, eq=False)
class _Pair:
    """Two targets, and how clearly the left one is on one side of the plane, from -1 to 1."""

    left: str
    right: str
    side: float


def examine_swapped(
    neutral: Mesh,
    targets: Mapping[str, Mesh],
    files: Mapping[str, str],
    mirror: Mirror,
    pairs: Sequence[tuple[str, str]],
) -> list[Finding]:
    """Pairs whose left is where the right of most others is, or of the face itself.

    Args:
        neutral: The neutral.
        targets: Targets by name.
        files: File by name.
        mirror: The plane of symmetry.
        pairs: Names of left and right targets.
    """
    clear = []
    for left, right in pairs:
        moved = [targets[name].vertices - neutral.vertices for name in (left, right)]
        side = _side_of(*moved, neutral.vertices, mirror)
        if side:
            clear.append(_Pair(left, right, side))
    sides = np.sign([pair.side for pair in clear])
    usual = float(np.sign(sides.sum()))
    others = [pair for pair, side in zip(clear, sides, strict=True) if side == -usual]
    if len(clear) >= _ENOUGH and usual:
        if 3 * len(others) > len(clear):
            return []
        what = "other right targets move"
    else:
        usual = _left_of(neutral, [targets[name] for pair in pairs for name in pair], mirror)
        others = [pair for pair, side in zip(clear, sides, strict=True) if side == -usual]
        what = "is the right one of the face"
    if not usual:
        return []
    return [
        finding(
            "swapped-sides",
            files[pair.left],
            f"moves the side, or to the side, that {what}, and "
            f"{Path(files[pair.right]).name} the left",
        )
        for pair in others
    ]


def _side_of(
    left: NDArray[np.float64],
    right: NDArray[np.float64],
    points: NDArray[np.float64],
    mirror: Mirror,
) -> float:
    """On which side of the plane the left one is, or to which it moves the middle; 0 if neither."""
    heights = mirror.heights(points)
    for measure, least in (
        (lambda moved: _ratio(moved, heights), _CLEARLY),
        (lambda moved: _aside(moved, mirror.normal), _ASIDE),
    ):
        mine, their = measure(left), measure(right)
        if min(abs(mine), abs(their)) > least and mine * their < 0:
            return mine
    return 0.0


def _ratio(moved: NDArray[np.float64], heights: NDArray[np.float64]) -> float:
    """From -1, all that moves is on one side of the plane, to 1, all is on the other."""
    weights = np.linalg.norm(moved, axis=1)
    total = float(weights @ np.abs(heights))
    return float(weights @ heights) / total if total > 0 else 0.0


def _aside(moved: NDArray[np.float64], normal: NDArray[np.float64]) -> float:
    """From -1, all moves one way across the plane, to 1, all moves the other way."""
    total = float(np.linalg.norm(moved, axis=1).sum())
    return float((moved @ normal).sum()) / total if total > 0 else 0.0


def _left_of(neutral: Mesh, targets: Sequence[Mesh], mirror: Mirror) -> float:
    """Which way along the normal of the plane the left of the character is: 1, -1, or 0 unknown.

    A face is on the side of the head that expressions move, and looks where that surface does. Up
    is y, or z where it looks along y; left is up × front.
    """
    points, triangles = neutral.vertices, neutral.faces.triangles()
    lengths = [np.linalg.norm(mesh.vertices - points, axis=1) for mesh in targets]
    moved = np.asarray(sum(lengths))
    a, b, c = (points[triangles[:, i]] for i in range(3))
    outwards = np.cross(b - a, c - a)
    outwards[np.repeat(inside_out(neutral), neutral.faces.sizes - 2)] *= -1.0
    middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
    front = np.zeros(3)
    for way in (moved @ (points - middle), moved[triangles].mean(axis=1) @ outwards):
        across = way - (way @ mirror.normal) * mirror.normal
        front += across / max(float(np.linalg.norm(across)), 1e-300)
    length = float(np.linalg.norm(front))
    if length == 0 or np.abs(front).max() < _FACES * length:
        return 0.0
    axis = int(np.abs(front).argmax())
    up = np.eye(3)[2 if axis == 1 else 1]
    return float(np.sign(np.cross(up, front) @ mirror.normal))
