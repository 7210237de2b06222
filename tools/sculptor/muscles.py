"""The face's movements, each a function of how far it goes.

Every movement returns the displacement of all vertices from the neutral. Those named for a side
move the character's left; :func:`mirrored` gives the right.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from sculptor.anatomy import MOUTH_HEIGHT
from sculptor.assembly import build
from sculptor.implicit import Points
from sculptor.turns import turn_jaw
from sculptor.weights import hill, jaw_weights

__all__ = [
    "JAW_DEGREES",
    "Movement",
    "mirrored",
    "movements",
]

Movement = Callable[[float], Points]
JAW_DEGREES = 24.0  # of a fully open jaw
_ARCH_Z = 4.6  # the lips slide around a vertical axis here, as over the dental arch


def mirrored(displacement: Points) -> Points:
    """The same movement on the other side of the face."""
    image: Points = displacement[build().partner] * np.array([-1.0, 1.0, 1.0])
    return image


def _push(weights: NDArray[np.float64], way: tuple[float, float, float]) -> Points:
    pushed: Points = weights[:, None] * np.array(way)
    return pushed


def _around_arch(weights: NDArray[np.float64], degrees: float) -> Points:
    """Turn about the vertical axis of the dental arch, towards the character's left."""
    points = build().mesh.vertices
    angle = np.radians(degrees) * weights
    x, z = points[:, 0], points[:, 2] - _ARCH_Z
    return np.stack(
        [
            x * np.cos(angle) + z * np.sin(angle) - x,
            np.zeros_like(x),
            z * np.cos(angle) - x * np.sin(angle) - z,
        ],
        axis=1,
    )


def _upper() -> NDArray[np.float64]:
    return 1.0 - jaw_weights()


def _smile(a: float) -> Points:
    corner = hill(2.6, -7.0, 1.5, 1.3)
    return (
        _around_arch(corner, 11.5 * a)
        + _push(corner, (0.0, 0.85 * a, -0.05 * a))
        + _thin_lips(0.22 * a)
        + _push(hill(0.6, -7.2, 1.2, 0.9), (0.0, -0.08 * a, -0.16 * a))
        + _push(hill(1.5, -6.4, 1.2, 0.8) * _upper(), (0.0, 0.22 * a, 0.0))
        + _push(hill(3.9, -3.7, 1.2, 1.2), (0.12 * a, 0.35 * a, 0.5 * a))
        + _push(hill(3.9, -6.2, 0.8, 1.2), (0.2 * a, 0.0, 0.1 * a))
        + _push(hill(2.3, -4.9, 0.4, 0.6) + hill(2.95, -5.9, 0.4, 0.6), (0.0, 0.0, -0.16 * a))
    )


def _frown(a: float) -> Points:
    corner = hill(2.5, -7.3, 1.2, 1.1)
    return (
        _push(corner, (0.05 * a, -0.72 * a, -0.1 * a))
        + _push(hill(1.9, -8.9, 0.9, 0.8), (0.0, -0.1 * a, 0.12 * a))
        + _push(hill(3.1, -8.0, 0.45, 0.7), (0.0, 0.0, -0.15 * a))
    )


def _thin_lips(a: float) -> Points:
    pinch = hill(1.0, -7.1, 1.5, 0.75)
    from_line = build().mesh.vertices[:, 1] - MOUTH_HEIGHT
    return _push(-np.tanh(from_line / 0.9) * pinch, (0.0, a, 0.0))


def _press(a: float) -> Points:
    return _thin_lips(0.55 * a) + _push(hill(1.0, -7.1, 1.5, 0.75), (0.0, 0.0, -0.22 * a))


def _brow_down(a: float) -> Points:
    return _push(hill(1.7, 1.8, 1.1, 0.85), (-0.28 * a, -0.6 * a, 0.16 * a)) + _push(
        hill(3.9, 1.9, 1.2, 0.8), (-0.1 * a, -0.22 * a, 0.08 * a)
    )


def _brow_inner_up(a: float) -> Points:
    return _push(hill(1.5, 2.1, 1.0, 1.1), (0.0, 0.85 * a, -0.05 * a)) + _push(
        hill(4.4, 1.7, 0.9, 0.7), (0.0, -0.12 * a, 0.0)
    )


def _brow_outer_up(a: float) -> Points:
    return _push(hill(3.5, 2.1, 1.9, 1.2), (0.0, 0.85 * a, -0.15 * a))


def _cheek_squint(a: float) -> Points:
    return _push(hill(3.7, -2.5, 1.4, 0.9), (0.0, 0.45 * a, 0.3 * a))


def _sneer(a: float) -> Points:
    wing = hill(1.6, -4.2, 0.75, 0.8)
    return (
        _push(wing, (0.12 * a, 0.45 * a, -0.05 * a))
        + _push(hill(1.5, -5.9, 0.9, 0.6) * _upper(), (0.0, 0.3 * a, 0.08 * a))
        + _push(hill(0.9, 0.5, 0.6, 0.8), (0.0, -0.12 * a, 0.08 * a))
    )


def _upper_up(a: float) -> Points:
    return _push(hill(1.1, -6.5, 1.15, 0.9) * _upper(), (0.0, 0.72 * a, 0.04 * a))


def _lower_down(a: float) -> Points:
    return _push(hill(1.1, -7.8, 1.15, 0.9) * jaw_weights(), (0.0, -0.55 * a, 0.02 * a))


def _puff(a: float) -> Points:
    return _push(hill(4.3, -6.1, 1.4, 1.5), (1.05 * a, 0.0, 0.9 * a)) + _push(
        hill(1.2, -6.6, 1.6, 1.4), (0.0, 0.0, 0.22 * a)
    )


def _both_sides(movement: Movement) -> Movement:
    def both(a: float) -> Points:
        left = movement(a)
        return left + mirrored(left)

    return both


def _shrug_lower(a: float) -> Points:
    return _push(hill(0.0, -8.1, 1.7, 0.75), (0.0, 0.4 * a, 0.28 * a))


def _mouth_left(a: float) -> Points:
    return _around_arch(hill(0.0, -7.1, 2.2, 1.4), 15.0 * a)


def _pucker(a: float) -> Points:
    points = build().mesh.vertices
    ring = hill(0.0, -7.1, 1.9, 1.3)
    return np.stack([-0.42 * a * ring * points[:, 0], 0.0 * ring, 0.75 * a * ring], axis=1)


def _funnel(a: float) -> Points:
    ring = hill(0.0, -7.1, 1.9, 1.3)
    out = _pucker(0.6 * a)
    open_ = (1.0 - 2.0 * jaw_weights()) * ring
    return out + _push(open_, (0.0, 0.45 * a, 0.0))


def _stretch(a: float) -> Points:
    corner = hill(2.6, -7.2, 1.4, 1.2)
    return (
        _around_arch(corner, 9.0 * a) + _push(corner, (0.0, -0.3 * a, 0.0)) + _thin_lips(0.15 * a)
    )


def _dimple(a: float) -> Points:
    return _around_arch(hill(2.6, -7.0, 1.1, 0.8), 6.0 * a) + _push(
        hill(3.2, -7.0, 0.5, 0.6), (0.0, 0.0, -0.22 * a)
    )


def _shrug_upper(a: float) -> Points:
    return _push(hill(0.0, -6.4, 1.7, 0.75), (0.0, 0.35 * a, 0.2 * a))


def _jaw_open(a: float) -> Points:
    neutral = build().mesh.vertices
    return turn_jaw(neutral, JAW_DEGREES * a, (0.25 * a, 0.1 * a)) - neutral


def _jaw_slide(way: tuple[float, float, float]) -> Movement:
    return lambda a: a * _push(jaw_weights(), way)


def _right(movement: Movement) -> Movement:
    return lambda a: mirrored(movement(a))


def movements() -> dict[str, Movement]:
    """Every movement of the skin by its ARKit name; the lids' turns are in ``shapes``."""
    left = {
        "browDown": _brow_down,
        "browOuterUp": _brow_outer_up,
        "cheekSquint": _cheek_squint,
        "eyeSquint": lambda a: 0.35 * _cheek_squint(a),
        "mouthDimple": _dimple,
        "mouthFrown": _frown,
        "mouthLowerDown": _lower_down,
        "mouthPress": _press,
        "mouthSmile": _smile,
        "mouthStretch": _stretch,
        "mouthUpperUp": _upper_up,
        "noseSneer": _sneer,
    }
    out: dict[str, Movement] = {
        "browInnerUp": _both_sides(_brow_inner_up),
        "cheekPuff": _both_sides(_puff),
        "jawForward": _jaw_slide((0.0, 0.0, 0.6)),
        "jawLeft": _jaw_slide((0.7, 0.0, 0.0)),
        "jawRight": _jaw_slide((-0.7, 0.0, 0.0)),
        "jawOpen": _jaw_open,
        "mouthFunnel": _funnel,
        "mouthLeft": _mouth_left,
        "mouthRight": _right(_mouth_left),
        "mouthPucker": _pucker,
        "mouthShrugLower": _shrug_lower,
        "mouthShrugUpper": _shrug_upper,
    }
    for name, movement in left.items():
        out[f"{name}_L"] = movement
        out[f"{name}_R"] = _right(movement)
    return out
