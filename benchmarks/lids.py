"""How deep lids cut into the eyeball on their way, by method, at 11 times.

    python benchmarks/lids.py [--methods linear,auto,rotation]

Every shape of the left lids of the built-in head. A cut is how far a vertex of the skin lies below
the surface of the eyeball, in the direction from the eyeball's centre, if it was outside with the
eye at rest; the eyeballs stay as they are at rest.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import elastomorph as em
from elastomorph.samples import head, shapes

LIDS = (
    "eyeBlinkLeft", "eyeSquintLeft", "eyeWideLeft", "eyeLookDownLeft", "eyeLookInLeft",
    "eyeLookOutLeft", "eyeLookUpLeft", "cheekSquintLeft",
)  # fmt: skip
TIMES = np.linspace(0.0, 1.0, 11)
_NEAR = 1.4  # of the eyeball's radius: skin that may touch it

Points = NDArray[np.float64]


@dataclass(frozen=True)
class Eye:
    """The left eye.

    Attributes:
        centre: (3,) of the eyeball.
        radius: Of its surface, in directions (N, 3) from the centre.
        skin: Vertices of the lids and around, outside the eyeball at rest.
    """

    centre: Points
    radius: Callable[[Points], Points]
    skin: NDArray[np.int64]

    def cut(self, positions: Points) -> float:
        """How deep the skin lies in the eyeball."""
        offset = positions[self.skin] - self.centre
        far = np.linalg.norm(offset, axis=1)
        return float(np.max(self.radius(offset / far[:, None]) - far, initial=0.0))


def eye_of(neutral: em.Mesh, ball: NDArray[np.int64], face: NDArray[np.int64]) -> Eye:
    """The eye whose ball these vertices are: its surface between them is interpolated."""
    from scipy.interpolate import LinearNDInterpolator

    points = neutral.vertices[ball]
    behind = points[points[:, 2] < points[:, 2].max() - 0.25 * np.ptp(points[:, 2])]  # no cornea
    fit = np.linalg.lstsq(np.c_[2 * behind, np.ones(len(behind))], (behind**2).sum(1), rcond=None)[
        0
    ]
    centre = fit[:3]
    offset = points - centre
    far = np.linalg.norm(offset, axis=1)
    front = offset[:, 2] > -0.2 * far
    surface = LinearNDInterpolator(_flat(offset[front] / far[front, None]), far[front], 0.0)
    around = np.linalg.norm(neutral.vertices - centre, axis=1)
    near = face[around[face] < _NEAR * far.max()]
    direction = (neutral.vertices[near] - centre) / around[near, None]
    outside = (direction[:, 2] > 0.1) & (around[near] > surface(_flat(direction)))
    return Eye(centre, lambda way: surface(_flat(way)), near[outside])


def _flat(way: Points) -> Points:
    """Directions as points of a plane, whose origin is straight ahead."""
    return way[:, :2] / (1.0 + np.clip(way[:, 2:], -0.5, 1.0))


def main() -> None:
    """Print a table: the cut at the end, and the deepest between, by method."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--methods", default="linear,auto,rotation,arc")
    methods = parser.parse_args().methods.split(",")
    neutral, targets = head(), shapes()
    assert neutral.groups is not None
    label = np.array(neutral.groups.names)[neutral.groups.of_face][neutral.faces.corner_faces]
    ball, face = (
        np.unique(neutral.faces.indices[label == name]).astype(np.int64)
        for name in ("eye_L", "skin")
    )
    eye = eye_of(neutral, ball, face)
    print("| shape | at the end |", " | ".join(f"`{name}`" for name in methods), "|")
    print("|---" * (2 + len(methods)) + "|")
    for name in LIDS:
        paths = (em.interpolate(neutral, targets[name], method) for method in methods)
        row = [_words([eye.cut(path.at(float(t))) for t in TIMES[1:-1]]) for path in paths]
        at_end = eye.cut(targets[name].vertices)
        print(f"| `{name}` | {at_end:.3f} |", " | ".join(row), "|")


def _words(cuts: list[float]) -> str:
    """The deepest of the cuts between the ends, and when it is."""
    deepest = int(np.argmax(cuts))
    return f"{cuts[deepest]:.3f} at {TIMES[1 + deepest]:.1f}" if cuts[deepest] > 0.0 else "0.000"


if __name__ == "__main__":
    main()
