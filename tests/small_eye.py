"""An eye whose geometry is known: lids on a sphere, about a ball, and what sliders do to them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import elastomorph as em

Points = NDArray[np.float64]

LONGITUDES = np.linspace(-1.3, 1.3, 53)
ROWS = 12
HEIGHT = 0.4  # radians from the middle of the slit to each margin, where it is widest
SKIN, BALL = 1.05, 1.0
OPENING = HEIGHT * np.clip(1 - LONGITUDES**2, 0, None)
SKIN_VERTICES = 2 * ROWS * len(LONGITUDES)
MIDDLE = slice(13, 40)  # longitudes at which the slit is wide
MOVES = {"eyeBlinkLeft": (-1.1, 0.0), "eyeSquintLeft": (-0.15, 0.15), "eyeWideLeft": (0.2, 0.0)}


def on_sphere(longitude: Points, latitude: Points, radius: float) -> Points:
    """Return (…, 3) positions; the eye looks along +Z with +Y up."""
    level = np.cos(latitude)
    seen = [level * np.sin(longitude), np.sin(latitude), level * np.cos(longitude)]
    return radius * np.stack(np.broadcast_arrays(*seen), axis=-1)


def lids(upper: Points, lower: Points) -> Points:
    """Return the skin with margins at these latitudes: rows from each margin to the far edge."""
    away = np.linspace(0, 1, ROWS)[:, None]
    sides = [
        on_sphere(LONGITUDES, margin + away * (far - margin), SKIN)
        for margin, far in ((upper, 1.2), (lower, -1.2))
    ]
    return np.concatenate([side.reshape(-1, 3) for side in sides])


def eye(**moves: tuple[float, float]) -> em.Rig:
    """Return an eye, and sliders that move both margins by parts of the opening, up above 0."""
    count, columns = SKIN_VERTICES, len(LONGITUDES)
    grid = np.arange(count).reshape(2, ROWS, columns)
    # Where the slit ends, margins are one: the upper lid's vertices stand for both.
    joined = np.arange(count)
    joined[grid[1, 0][OPENING == 0]] = grid[0, 0][OPENING == 0]
    quads = []
    for lid, turn in ((0, 1), (1, -1)):
        corners = [grid[lid, :-1, :-1], grid[lid, :-1, 1:], grid[lid, 1:, 1:], grid[lid, 1:, :-1]]
        quads.append(np.stack(corners[::turn], axis=-1).reshape(-1, 4))
    across, up = np.meshgrid(np.linspace(-np.pi, np.pi, 24), np.linspace(-1.5, 1.5, 12))
    ball = on_sphere(across, up, BALL).reshape(-1, 3)
    cells = count + np.arange(len(ball)).reshape(across.shape)
    shell = [cells[:-1, :-1], cells[:-1, 1:], cells[1:, 1:], cells[1:, :-1]]
    faces = [*joined[np.concatenate(quads)], *np.stack(shell, axis=-1).reshape(-1, 4)]
    rest = np.concatenate([lids(OPENING, -OPENING), ball])
    neutral = em.Mesh(rest, [list(face) for face in faces])
    targets = {}
    for name, (above, below) in moves.items():
        skin = lids(OPENING * (1 + 2 * above), -OPENING * (1 - 2 * below))
        targets[name] = neutral.with_vertices(np.concatenate([skin, ball]))
    return em.Rig(neutral, targets, method="linear")


def slit(positions: Points) -> Points:
    """Return how far margins are apart, in parts of the widest opening; past each other < 0."""
    columns = len(LONGITUDES)
    margins = (positions[start : start + columns] for start in (0, ROWS * columns))
    upper, lower = (np.arctan2(m[:, 1], np.hypot(m[:, 0], m[:, 2])) for m in margins)
    return np.asarray((upper - lower) / (2 * HEIGHT))[MIDDLE]
