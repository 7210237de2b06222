"""Small masks whose skin is a formula: a rig of 572 vertices, and scans of it in other grids."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import elastomorph as em
from elastomorph.capturing.landmarks import Landmarks, write_landmarks

Points = NDArray[np.float64]

PLACES = {
    **{"nose_tip": (0, -0.5), "right_eye_outer": (-2.6, 2), "left_eye_outer": (2.6, 2)},
    **{"chin": (0, -5.6), "mouth_right": (-3, -3.6), "mouth_left": (3, -3.6)},
}


def height(x: Points, y: Points) -> Points:
    """Of a bowl with a nose, eyes that lie deep, lips and a chin."""
    found = 5 * np.sqrt(np.maximum(1 - (x / 9) ** 2 - (y / 11) ** 2, 0))
    for a, b, high, wide in (
        *((0, -0.5, 2.5, 1.2), (-2.6, 2, -0.9, 1.2), (2.6, 2, -0.9, 1.2)),
        *((0, -3.6, 0.8, 1.0), (0, -5.6, 0.9, 1.1)),
    ):
        found += high * np.exp(-((x - a) ** 2 + (y - b) ** 2) / wide**2)
    return found


def face(x: Points, y: Points, jaw: float = 0.0, smile: float = 0.0) -> Points:
    """(N, 3) the skin that is at x and y at rest."""
    places = np.stack([x, y, height(x, y)], axis=-1)
    low = np.exp(-((x / 3) ** 2) - ((y + 5) / 2) ** 2)
    places -= jaw * low[:, None] * [0, 1.5, 0.5]
    for side in (-1, 1):
        corner = np.exp(-((x - 2 * side) ** 2 + (y + 3.6) ** 2) / 2)
        places += smile * corner[:, None] * [0.9 * side, 0.6, 0]
    return places


def grid(columns: int, rows: int, turn: float = 0.0, shift: float = 0.0) -> tuple[Points, ...]:
    """x and y of (N,) places, and (F, 4) quads."""
    across, up = np.meshgrid(np.linspace(-6, 6, columns) + shift, np.linspace(-8, 7, rows) + shift)
    cosine, sine = np.cos(turn), np.sin(turn)
    number = np.arange(columns * rows).reshape(rows, columns)
    quads = np.stack([number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], -1)
    x, y = cosine * across - sine * up, sine * across + cosine * up
    return x.ravel(), y.ravel(), quads.reshape(-1, 4)


def mask_rig() -> em.Rig:
    """Two targets, straight."""
    x, y, quads = grid(22, 26)
    neutral = em.Mesh(face(x, y), quads)
    targets = {name: neutral.with_vertices(face(x, y, **{name: 1.0})) for name in ("jaw", "smile")}
    return em.Rig(neutral, targets, method="linear")


def mask_scan(seed: int, **weights: float) -> tuple[em.Mesh, Points, Points]:
    """A scan with noise in a grid of its own, and how it was turned and moved."""
    random = np.random.default_rng(seed)
    x, y, quads = grid(44, 50, 0.1 * random.normal(), 0.03 * random.normal())
    places = face(x, y, **weights) + 0.005 * random.normal(size=(len(x), 3))
    turn = Rotation.from_rotvec(0.03 * random.normal(size=3)).as_matrix()
    shift = 0.1 * random.normal(size=3)
    return em.Mesh(places @ turn.T + shift, quads), turn, shift


def write_take(folder: Path, weights: list[dict[str, float]]) -> list[str]:
    """The scans of a take, its template and landmarks; the words that register it."""
    rig = mask_rig()
    em.write(folder / "rig.npz", rig)
    scans = [f"frame{number:03d}.ply" for number in range(len(weights))]
    for number, name in enumerate(scans):
        scan, turn, shift = mask_scan(number, **weights[number])
        em.write(folder / name, scan)
        if not number:
            own = {mark: face(*np.array([[a], [b]]))[0] for mark, (a, b) in PLACES.items()}
            clicks = {mark: tuple((turn @ place + shift).tolist()) for mark, place in own.items()}
    x, y = rig.neutral.vertices[:, :2].T
    marks = {name: int(np.hypot(x - a, y - b).argmin()) for name, (a, b) in PLACES.items()}
    write_landmarks(folder / "marks.json", Landmarks(marks, points={scans[0]: clicks}))
    return ["register", *scans, "--template", "rig.npz", "--landmarks", "marks.json"]
