"""The face's movements, each a function of how far it goes.

Every movement returns the displacement of all vertices from the neutral. Those named for a side
move the character's left; :func:`mirrored` gives the right.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from sculptor.assembly import build
from sculptor.implicit import Points
from sculptor.mouth import sealed
from sculptor.mouth_shapes import MOUTHS
from sculptor.tongue import put_out
from sculptor.turns import turn_aside, turn_jaw
from sculptor.weights import hill, jaw_weights

__all__ = [
    "JAW_DEGREES",
    "Movement",
    "brow_raise",
    "mirrored",
    "movements",
]

Movement = Callable[[float], Points]
JAW_DEGREES = 24.0  # of a fully open jaw
SWING_DEGREES = 6.5  # of the jaw to a side
TONGUE_DEGREES = 11.0  # of the jaw for a tongue put out
_PAIRED = (
    "cheekSquint", "mouthDimple", "mouthFrown", "mouthLowerDown", "mouthPress", "mouthSmile",
    "mouthStretch", "mouthUpperUp", "noseSneer",
)  # fmt: skip
_WHOLE = (
    "cheekPuff", "mouthFunnel", "mouthLeft", "mouthPucker", "mouthRollLower", "mouthRollUpper",
    "mouthShrugLower", "mouthShrugUpper",
)  # fmt: skip


def mirrored(displacement: Points) -> Points:
    """The same movement on the other side of the face."""
    image: Points = displacement[build().partner] * np.array([-1.0, 1.0, 1.0])
    return image


def _push(weights: NDArray[np.float64], way: tuple[float, float, float]) -> Points:
    pushed: Points = weights[:, None] * np.array(way)
    return pushed


def _brow_down(a: float) -> Points:
    return _push(hill(1.7, 1.8, 1.1, 0.85), (-0.28 * a, -0.6 * a, 0.16 * a)) + _push(
        hill(3.9, 1.9, 1.2, 0.8), (-0.1 * a, -0.22 * a, 0.08 * a)
    )


def _brow_inner_up(a: float) -> Points:
    return _push(hill(1.5, 2.1, 1.0, 1.1), (0.0, 0.85 * a, -0.05 * a)) + _push(
        hill(4.4, 1.7, 0.9, 0.7), (0.0, -0.12 * a, 0.0)
    )


def _brow_outer_up(a: float) -> Points:
    return _push(hill(4.1, 2.1, 1.7, 1.2), (0.0, 0.78 * a, -0.14 * a))


def brow_raise(a: float) -> Points:
    """The whole left brow lifted, which is no shape of its own."""
    return _push(hill(3.5, 2.1, 1.9, 1.2), (0.0, 0.85 * a, -0.15 * a))


def _both_sides(movement: Movement) -> Movement:
    def both(a: float) -> Points:
        left = movement(a)
        return left + mirrored(left)

    return both


def _jaw_open(a: float) -> Points:
    neutral = build().mesh.vertices
    lips_moved = neutral + MOUTHS["jawOpen"].displacement(a)
    return turn_jaw(lips_moved, JAW_DEGREES * a, (0.6 * a, 0.2 * a)) - neutral


def _mouth_close(a: float) -> Points:
    return sealed(_jaw_open(a))


def _tongue_out(a: float) -> Points:
    """The jaw a little open, and the tongue over the lower lip."""
    neutral = build().mesh.vertices
    parted = neutral + MOUTHS["tongueOut"].displacement(a)
    return put_out(turn_jaw(parted, TONGUE_DEGREES * a), a) - neutral


def _jaw_left(a: float) -> Points:
    swung = turn_aside(build().mesh.vertices, SWING_DEGREES * a)
    return MOUTHS["jawLeft"].displacement(a) + swung


def _split(movement: Movement) -> Movement:
    """The left share of a symmetric movement; both shares add up to it."""
    share = 0.5 * (1.0 + np.sin(0.5 * np.pi * np.clip(build().mesh.vertices[:, :1], -1.0, 1.0)))
    return lambda a: share * movement(a)


def _right(movement: Movement) -> Movement:
    return lambda a: mirrored(movement(a))


def movements() -> dict[str, Movement]:
    """Every movement of the skin by its ARKit name; the turns of lids and eyes are in `shapes`."""
    left = {
        "browDown": _brow_down,
        "browOuterUp": _brow_outer_up,
        "eyeSquint": lambda a: 0.35 * _split(MOUTHS["cheekSquint"].displacement)(a),
        **{name: _split(MOUTHS[name].displacement) for name in _PAIRED},
    }
    out: dict[str, Movement] = {
        "browInnerUp": _both_sides(_brow_inner_up),
        "jawForward": lambda a: _push(jaw_weights(), (0.0, 0.0, 0.85 * a)),
        "jawLeft": _jaw_left,
        "jawRight": _right(_jaw_left),
        "jawOpen": _jaw_open,
        "mouthClose": _mouth_close,
        "mouthRight": _right(MOUTHS["mouthLeft"].displacement),
        "tongueOut": _tongue_out,
        **{name: MOUTHS[name].displacement for name in _WHOLE},
    }
    for name, movement in left.items():
        out[f"{name}_L"] = movement
        out[f"{name}_R"] = _right(movement)
    return out
