"""Two rows of teeth in their gums and a tongue, for an open mouth."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from sculptor import groups
from sculptor.anatomy import MOUTH_HEIGHT
from sculptor.implicit import Points
from sculptor.lips import skin_depth

__all__ = ["Piece", "pieces", "push_out"]

Piece = tuple[str, Points, list[list[int]], list[str], list[int]]

# Ends of the cells from the midline to the last molar, in teeth: three cells for each of the two
# incisors, whose faces are flat, two for every other tooth; a whole number is a seam.
_CELLS = np.array([0, 0.2, 0.8, 1, 1.22, 1.78, 2, 2.5, 3, 3.5, 4, 4.5, 5, 5.5, 6])
_WIDTHS = (0.0, 0.86, 0.68, 0.78, 0.72, 0.72, 1.05)  # of the teeth, in cm, from 0
_SPANS = len(_CELLS) - 1
_SQUARE = 2.5  # exponent of the arch; 2 is an ellipse
_STEEP = _SQUARE - 1.0
_CLEAR = 0.14  # of the lips in front of the row
_BITE = MOUTH_HEIGHT - 0.2
# Across a row, from the gum in front over the biting edge to the gum behind: how far outwards,
# how far from the bite towards the root, how deep the seams between teeth are, and how far the
# gum reaches towards the bite between the teeth.
_SECTION = (
    (-0.05, 1.75, 0.0, 0.0),
    (0.065, 1.24, 0.0, 0.0),
    (0.045, 1.04, 0.06, 0.20),
    (0.09, 0.55, 0.12, 0.0),
    (0.04, 0.05, 0.15, 0.0),
    (-0.26, 0.00, 0.05, 0.0),
    (-0.50, 0.90, 0.0, 0.0),
    (-0.60, 1.75, 0.0, 0.0),
)
_GUMS = (0, 1, 6, 7)  # cells of the section that are gum


def pieces() -> list[Piece]:
    """Part name, left half (N, 3), polygons, groups and midline vertices of each piece."""
    front = float(skin_depth(np.zeros(1), np.array([MOUTH_HEIGHT]))[0])
    return [
        _row("upper_teeth", *_arch(0)),
        _row("lower_teeth", *_arch(1)),
        _tongue(front - 1.62),
    ]


@cache
def _arch(row: int) -> tuple[float, float, float]:
    """z of the front of the upper or the lower row, its half width and its length."""
    front = float(skin_depth(np.zeros(1), np.array([MOUTH_HEIGHT]))[0])
    return ((front - 0.70, 2.45, 4.0), (front - 0.85, 2.12, 3.8))[row]


def push_out(points: Points) -> NDArray[np.float64]:
    """How far forwards points must go to lie in front of the upper row.

    Args:
        points: (..., 3).
    """
    front, width, length = _arch(0)
    beside = np.clip(np.abs(points[..., 0]) / (width + _CLEAR), 0.0, 1.0)
    surface = front - length * (1.0 - (1.0 - beside**_SQUARE) ** (1.0 / _SQUARE)) + _CLEAR
    pushed: NDArray[np.float64] = np.clip(surface - points[..., 2], 0.0, 0.6)
    return pushed


def _row(part: str, front: float, width: float, length: float) -> Piece:
    sign = 1.0 if part == "upper_teeth" else -1.0
    place = np.interp(_CELLS, np.arange(len(_WIDTHS)), np.cumsum(_WIDTHS))
    share = place / place[-1]
    beside, ahead = _around(share, width, length)
    zero = np.zeros_like(beside)
    arch = np.stack([width * beside, zero, front - length * (1.0 - ahead)], axis=1)
    outward = np.stack([beside**_STEEP / width, zero, ahead**_STEEP / length], axis=1)
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    seam = (np.mod(_CELLS, 1.0) == 0.0).astype(float)
    seam[-1] = 0.0
    # molars are shorter than incisors, the canine is pointed, the lateral incisor higher
    low = 1.0 - 0.3 * share
    lean = 0.0 if sign > 0 else 0.17  # of the roots, backwards
    overlap = 0.10 * ahead if sign > 0 else 0.0
    count = len(_SECTION)
    points = np.empty((_SPANS + 1, count, 3))
    for k, (out, root, gap, between) in enumerate(_SECTION):
        back = out - gap * seam - lean * root
        points[:, k] = arch + back[:, None] * outward
        reach = root * low + (0.5 * gap * (root < 0.3) - between) * seam
        reach -= overlap if root < 0.3 else 0.0
        points[:, k, 1] = (
            _BITE + sign * (0.03 + 0.2 * share + reach) - (0.45 * share**2 if sign < 0 else 0.0)
        )
    points[0, :, 0] = 0.0
    index = np.arange(points.size // 3).reshape(points.shape[:2])
    faces, names = [], []
    for s in range(_SPANS):
        for k in range(count):
            n = (k + 1) % count
            faces.append([index[s, k], index[s, n], index[s + 1, n], index[s + 1, k]])
            names.append(groups.GUMS if k in _GUMS else groups.TEETH)
    end = index[-1]
    for a, b in ((0, 7), (1, 6), (2, 5)):
        faces.append([end[a], end[a + 1], end[b - 1], end[b]])
        names.append(groups.GUMS if a < 2 else groups.TEETH)
    whole = [[int(v) for v in (face if sign > 0 else face[::-1])] for face in faces]
    return part, points.reshape(-1, 3), whole, names, [int(v) for v in index[0]]


def _around(
    share: NDArray[np.float64], width: float, length: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """x and z, over width and length, at shares of the arch's length from its front."""
    angle = np.linspace(0.0, 0.5 * np.pi, 2000)
    beside, ahead = np.sin(angle) ** (2.0 / _SQUARE), np.cos(angle) ** (2.0 / _SQUARE)
    ahead[-1] = 0.0
    steps = np.hypot(width * np.diff(beside), length * np.diff(ahead))
    gone = np.append(0.0, np.cumsum(steps))
    return np.interp(share * gone[-1], gone, beside), np.interp(share * gone[-1], gone, ahead)


def _tongue(tip: float) -> Piece:
    along = np.array([0.0, 0.03, 0.12, 0.3, 0.5, 0.7, 0.88, 0.97, 1.0])
    half_width = 1.35 * np.sqrt(np.clip(1.0 - (1.0 - along) ** 3, 0, 1))
    half_width[-2:] *= (0.75, 0.0)
    thick = 0.42 * np.sqrt(np.clip(1.0 - (2.0 * along - 1.0) ** 4, 0, 1)) + 0.0
    arch = _BITE - 0.75 + 0.55 * np.sin(0.8 * np.pi * along)
    z = tip - 3.6 * along
    turn = np.linspace(0.5 * np.pi, -0.5 * np.pi, 7)
    sections = range(1, len(along) - 1)
    points = [np.array([0.0, arch[0], z[0]])]
    for s in sections:
        x = half_width[s] * np.cos(turn)
        y = arch[s] + thick[s] * np.sin(turn) - 0.10 * np.exp(-((x / 0.3) ** 2)) * (turn > 0)
        x[[0, -1]] = 0.0
        points += list(np.stack([x, y, np.full_like(x, z[s])], axis=1))
    points.append(np.array([0.0, arch[-1], z[-1]]))
    count, last = len(turn), len(points) - 1
    faces = []
    for k in range(0, count - 1, 2):  # pairs of sectors: quads at both ends
        faces.append([0, 1 + k + 2, 1 + k + 1, 1 + k])
        base = last - count
        faces.append([last, base + k, base + k + 1, base + k + 2])
    for s in range(len(sections) - 1):
        for k in range(count - 1):
            a, b = 1 + s * count + k, 1 + (s + 1) * count + k
            faces.append([a, a + 1, b + 1, b])
    middle = [0, last, *(1 + s * count + k for s in range(len(sections)) for k in (0, count - 1))]
    return "tongue", np.array(points), faces, [groups.TONGUE] * len(faces), middle
