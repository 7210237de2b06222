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
from elastomorph.model.mesh import Mesh

__all__ = ["examine_swapped"]

# How clearly a target must be on one side to be called left or right: the mean distance from the
# plane of what moves, signed over unsigned;
_CLEARLY = 0.8
# and how clearly one that moves the middle must go to one side: its mean motion, across the plane
# over all. Jaws and mouths of three rigs have 0.76 and more.
_ASIDE = 0.5
# From so many pairs on, what most of them do tells what is left.
_ENOUGH = 3
# A face looks along an axis if where what moves is, and where its surface looks, both have this
# cosine with it. Lids alone tell nothing: they and their lashes look up as much as ahead.
_FACES = 0.75


@dataclass(frozen=True, eq=False)
class _Pair:
    """Two targets that tell sides.

    Attributes:
        left: Name of the one called left.
        right: Name of the other one.
        side: 1 or -1, the side of the plane that the left one moves, or to which it moves.
        aside: Whether it moves the middle of the face to that side.
    """

    left: str
    right: str
    side: float
    aside: bool


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
    heights = mirror.heights(neutral.vertices)
    clear = []
    for names in pairs:
        left, right = (targets[name].vertices - neutral.vertices for name in names)
        place = _clear(_ratio(left, heights), _ratio(right, heights), _CLEARLY)
        way = _clear(_aside(left, mirror.normal), _aside(right, mirror.normal), _ASIDE)
        if place or way:
            clear.append(_Pair(*names, place or way, not place))
    usual = float(np.sign(sum(pair.side for pair in clear))) if len(clear) >= _ENOUGH else 0.0
    which = "of the other right targets"
    if not usual:
        usual = _left_of(neutral, [targets[name] for pair in pairs for name in pair], mirror)
        which = "that is the right one of the face"
    others = [pair for pair in clear if pair.side == -usual]
    if len(clear) >= _ENOUGH and 3 * len(others) > len(clear):
        return []
    return [
        finding(
            "swapped-sides",
            files[pair.left],
            f"moves {'to ' if pair.aside else ''}the side {which}, and "
            f"{Path(files[pair.right]).name} {'to ' if pair.aside else ''}the left",
        )
        for pair in others
    ]


def _clear(left: float, right: float, least: float) -> float:
    """The sign of the left one, if both are clear and opposite; else 0."""
    clear = min(abs(left), abs(right)) > least and left * right < 0
    return float(np.sign(left)) if clear else 0.0


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
    ways = []
    for way in (moved @ (points - middle), moved[triangles].mean(axis=1) @ outwards):
        across = way - (way @ mirror.normal) * mirror.normal
        ways.append(across / max(float(np.linalg.norm(across)), 1e-300))
    axis = int(np.abs(ways[0]).argmax())
    front = np.sign(ways[0][axis]) * np.eye(3)[axis]
    if min(float(way @ front) for way in ways) < _FACES:
        return 0.0
    up = np.eye(3)[2 if axis == 1 else 1]
    return float(np.sign(np.cross(up, front) @ mirror.normal))
