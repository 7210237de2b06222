"""Sculpts the built-in head and writes the file of it that the package ships.

    python tools/sculpt_head.py

The file is replaced; `tests/tools/test_sculptor.py` compares it with what is sculpted.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sculptor.assembly import build
from sculptor.motion import recorded_motion
from sculptor.shapes import expressions, shapes

FILE = Path(__file__).parents[1] / "src" / "elastomorph" / "samples" / "head.npz"
UNIT = 2.0**-26  # cm: whole multiples of it up to 32 cm are int32, and exact in float64


def whole_units(positions: NDArray[np.float64]) -> NDArray[np.int32]:
    """Positions as whole multiples of the unit."""
    return np.rint(positions / UNIT).astype(np.int32)


def arrays() -> dict[str, Any]:
    """What the file holds, by name."""
    mesh = build().mesh
    assert mesh.groups is not None
    neutral = whole_units(mesh.vertices)
    faces = {
        **{("shape", name): face.vertices for name, face in shapes().items()},
        **{("expression", name): face.vertices for name, face in expressions().items()},
        **{("frame", str(k)): frame for k, frame in enumerate(recorded_motion().frames) if k > 0},
    }
    halves = _Halves(build().partner)
    pairs = [halves.of(whole_units(vertices) - neutral) for vertices in faces.values()]
    return {
        "unit": np.float64(UNIT),
        "neutral": neutral,
        "corners": mesh.faces.indices.astype(np.uint16),
        "sizes": mesh.faces.sizes.astype(np.uint8),
        "group_names": np.array(mesh.groups.names),
        "group_of_polygon": mesh.groups.of_face.astype(np.uint8),
        "partner": build().partner.astype(np.uint16),
        "kinds": np.array([kind for kind, _ in faces]),
        "names": np.array([name for _, name in faces]),
        "halves": np.array(pairs, dtype=np.uint8),
        "counts": np.array([len(rows) for rows, _ in halves.kept], dtype=np.uint16),
        "moved": np.concatenate([rows for rows, _ in halves.kept]).astype(np.uint16),
        "deltas": np.concatenate([delta for _, delta in halves.kept]),
    }


class _Halves:
    """Displacements of the left half of the head, those that are alike kept once.

    A face is two of them, one for the left and one to be mirrored; a symmetric face has one twice,
    and the faces of two sides share theirs.
    """

    def __init__(self, partner: NDArray[np.int64]) -> None:
        self._partner = partner
        self._left = np.arange(len(partner)) <= partner
        self._numbers: dict[bytes, int] = {}
        self.kept: list[tuple[NDArray[np.int64], NDArray[np.int32]]] = []

    def of(self, delta: NDArray[np.int32]) -> tuple[int, int]:
        """Numbers of a face's left half and of its mirrored right half."""
        mirrored = delta[self._partner] * np.array([-1, 1, 1], dtype=np.int32)
        return self._number(delta), self._number(mirrored)

    def _number(self, delta: NDArray[np.int32]) -> int:
        rows = np.flatnonzero(delta.any(axis=1) & self._left)
        key = rows.tobytes() + delta[rows].tobytes()
        if key not in self._numbers:
            self._numbers[key] = len(self.kept)
            self.kept.append((rows, delta[rows]))
        return self._numbers[key]


if __name__ == "__main__":
    with FILE.open("wb") as file:
        np.savez_compressed(file, **arrays())
    print(f"{FILE.name}: {FILE.stat().st_size:,} bytes")
