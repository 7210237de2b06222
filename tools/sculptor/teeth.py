"""Two rows of teeth in their gums and a tongue, for an open mouth."""

from __future__ import annotations

import numpy as np

from sculptor import groups
from sculptor.anatomy import MOUTH_HEIGHT
from sculptor.implicit import Points
from sculptor.lips import skin_depth

__all__ = ["Piece", "pieces"]

Piece = tuple[str, Points, list[list[int]], list[str], list[int]]

_SPANS = 14  # cells from the midline to the last molar, two a tooth
_BITE = MOUTH_HEIGHT - 0.2
# Across a row, from the gum in front over the biting edge to the gum behind: how far outwards,
# how far from the bite towards the root, and how deep the seams between teeth are.
_SECTION = (
    (-0.05, 1.75, 0.0),
    (0.06, 1.32, 0.0),
    (0.00, 1.10, 0.04),
    (0.06, 0.50, 0.14),
    (0.02, 0.00, 0.13),
    (-0.32, 0.00, 0.0),
    (-0.50, 0.90, 0.0),
    (-0.60, 1.75, 0.0),
)
_GUMS = (0, 1, 6, 7)  # cells of the section that are gum


def pieces() -> list[Piece]:
    """Part name, left half (N, 3), polygons, groups and midline vertices of each piece."""
    front = float(skin_depth(np.zeros(1), np.array([MOUTH_HEIGHT]))[0])
    return [
        _row("upper_teeth", front - 0.98, 2.55, 4.0),
        _row("lower_teeth", front - 1.14, 2.3, 3.8),
        _tongue(front - 1.9),
    ]


def _row(part: str, front: float, width: float, length: float) -> Piece:
    sign = 1.0 if part == "upper_teeth" else -1.0
    share = np.arange(_SPANS + 1) / _SPANS
    angle = 0.5 * np.pi * share**0.92
    arch = np.stack([width * np.sin(angle), 0 * angle, front - length * (1 - np.cos(angle))], 1)
    outward = np.stack([np.sin(angle) * length, 0 * angle, np.cos(angle) * width], axis=1)
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    seam = (np.arange(_SPANS + 1) % 2 == 0).astype(float)
    seam[-1] = 0.0
    low = 1.0 - 0.3 * share  # molars are shorter than incisors
    overlap = 0.10 * np.cos(angle) if sign > 0 else 0.0
    count = len(_SECTION)
    points = np.empty((_SPANS + 1, count, 3))
    for k, (out, root, gap) in enumerate(_SECTION):
        points[:, k] = arch + (out - gap * seam)[:, None] * outward
        reach = root * low + 0.15 * gap * seam - (overlap if root == 0.0 else 0.0)
        points[:, k, 1] = _BITE + sign * (0.03 + reach) - (0.25 * share**2 if sign < 0 else 0.0)
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


def _tongue(tip: float) -> Piece:
    along = np.array([0.0, 0.03, 0.12, 0.3, 0.5, 0.7, 0.88, 0.97, 1.0])
    half_width = 1.35 * np.sqrt(np.clip(1.0 - (1.0 - along) ** 3, 0, 1))
    half_width[-2:] *= (0.75, 0.0)
    thick = 0.42 * np.sqrt(np.clip(1.0 - (2.0 * along - 1.0) ** 4, 0, 1)) + 0.0
    arch = _BITE - 0.95 + 0.55 * np.sin(0.8 * np.pi * along)
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
