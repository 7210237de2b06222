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
    deltas = [whole_units(vertices) - neutral for vertices in faces.values()]
    moved = [np.flatnonzero(delta.any(axis=1)) for delta in deltas]
    return {
        "unit": np.float64(UNIT),
        "neutral": neutral,
        "corners": mesh.faces.indices.astype(np.uint16),
        "sizes": mesh.faces.sizes.astype(np.uint8),
        "group_names": np.array(mesh.groups.names),
        "group_of_polygon": mesh.groups.of_face.astype(np.uint8),
        "kinds": np.array([kind for kind, _ in faces]),
        "names": np.array([name for _, name in faces]),
        "counts": np.array([len(rows) for rows in moved], dtype=np.uint16),
        "moved": np.concatenate(moved).astype(np.uint16),
        "deltas": np.concatenate([delta[rows] for delta, rows in zip(deltas, moved, strict=True)]),
    }


if __name__ == "__main__":
    with FILE.open("wb") as file:
        np.savez_compressed(file, **arrays())
    print(f"{FILE.name}: {FILE.stat().st_size:,} bytes")
