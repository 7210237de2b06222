"""Joints and lids: true rotations of the jaw about its hinge and of the lids about the eyeballs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sculptor import lids
from sculptor.anatomy import EYE_CENTRE, EYE_RADIUS, JAW_AXIS, LID_THICKNESS
from sculptor.assembly import build
from sculptor.implicit import Points
from sculptor.weights import jaw_weights

__all__ = ["Lids", "keep_off_eyes", "turn_aside", "turn_eyes", "turn_jaw", "turn_lids"]

Lids = tuple[float, float, float]
"""How far the upper and the lower lid close, and degrees that both slide towards the temple."""


# How much of a lid's turn each ring around the eye makes, from the outline inwards.
_LID_SHARES = np.array([0.0, 0.0, 0.0, 0.04, 0.22, 0.62, 1.0, 1.0, 1.0, 1.0])
_SWING_Z = 3.0  # of the axis about which the jaw swings
_LID_SHARES.flags.writeable = False
_TURNING = np.flatnonzero(_LID_SHARES)
_TURNING.flags.writeable = False


def turn_jaw(points: Points, degrees: float, glide: tuple[float, float] = (0.0, 0.0)) -> Points:
    """Points after the jaw has turned about the joints near the ears.

    Args:
        points: (V, 3) positions of the head's vertices.
        degrees: How far the jaw opens; each vertex turns by its share of it.
        glide: How far the joint has slid forwards and down, in cm.
    """
    share = jaw_weights()
    angle = np.radians(degrees) * share
    y, z = points[:, 1] - JAW_AXIS[1], points[:, 2] - JAW_AXIS[2]
    cosine, sine = np.cos(angle), np.sin(angle)
    out = points.copy()
    moved = share > 0.0
    out[moved, 1] = (JAW_AXIS[1] + y * cosine - z * sine - glide[1] * share)[moved]
    out[moved, 2] = (JAW_AXIS[2] + y * sine + z * cosine + glide[0] * share)[moved]
    return out


def turn_aside(points: Points, degrees: float) -> Points:
    """Displacements by which the jaw swings to the left, about an upright axis behind its teeth.

    Args:
        points: (V, 3) positions of the head's vertices.
        degrees: How far; each vertex turns by its share of the jaw's movements.
    """
    offset = points - [0.0, 0.0, _SWING_Z]
    return _aside(offset, np.radians(degrees) * jaw_weights()) - offset


def turn_lids(points: Points, closing: dict[str, Lids]) -> Points:
    """Points after the lids have swept over the eyeballs.

    A lid's vertex turns about the axis along x through the centre of its eyeball, and then about
    the axis along y, so that its distance from the centre stays what it was. What does not turn
    keeps every bit.

    Args:
        points: (V, 3) positions of the head's vertices.
        closing: For "L" and "R", how far the upper and the lower lid go: 1 and 0 close the eye
            with the upper lid alone, and negative opens it wider; then degrees that both slide
            towards the temple.
    """
    head = build()
    out = points.copy()
    for side, (upper, lower, aside) in closing.items():
        rings = head.lay.eye if side == "L" else head.partner[head.lay.eye]
        centre = EYE_CENTRE * [1.0 if side == "L" else -1.0, 1.0, 1.0]
        edge = head.mesh.vertices[rings[lids.MARGIN + 1]] - centre
        height = np.arctan2(edge[:, 1], edge[:, 2])
        for above, amount in ((True, upper), (False, lower)):
            if amount == aside == 0.0:
                continue
            for step in range(1, lids.STEPS):
                here, there = lids.place(step, above), lids.place(step, not above)
                gap = height[there] - height[here]
                angle = amount * gap * _LID_SHARES[_TURNING]
                column = rings[_TURNING, here]
                slide = np.sin(np.pi * step / lids.STEPS) * _LID_SHARES[_TURNING]
                yaw = np.radians(aside) * slide * (1.0 if side == "L" else -1.0)
                out[column] = centre + _aside(_turned(out[column] - centre, angle), yaw)
    return out


def turn_eyes(points: Points, gaze: dict[str, tuple[float, float]]) -> Points:
    """Points after the eyeballs have turned about their centres.

    Args:
        points: (V, 3) positions of the head's vertices.
        gaze: For "L" and "R", degrees that the eye looks up and towards the temple.
    """
    head = build()
    out = points.copy()
    for side, (up, aside) in gaze.items():
        sign = 1.0 if side == "L" else -1.0
        eye = head.part == f"eye_{side}"
        if up == aside == 0.0:
            continue
        offset = out[eye] - EYE_CENTRE * [sign, 1.0, 1.0]
        yaw, pitch = np.radians(sign * aside), np.radians(up)
        out[eye] = EYE_CENTRE * [sign, 1.0, 1.0] + _aside(_turned(offset, pitch), yaw)
    return out


def _aside(offsets: Points, angle: NDArray[np.float64] | float) -> Points:
    cosine, sine = np.cos(angle), np.sin(angle)
    x, y, z = offsets.T
    return np.stack([x * cosine + z * sine, y, z * cosine - x * sine], axis=1)


def _turned(offsets: Points, angle: NDArray[np.float64] | float) -> Points:
    cosine, sine = np.cos(angle), np.sin(angle)
    x, y, z = offsets.T
    return np.stack([x, y * cosine + z * sine, z * cosine - y * sine], axis=1)


def keep_off_eyes(points: Points) -> Points:
    """Points with the skin around the eyes pushed out of the eyeballs and their lids."""
    head = build()
    out = points.copy()
    least = EYE_RADIUS + LID_THICKNESS - 0.02
    for rings, sign in ((head.lay.eye, 1.0), (head.partner[head.lay.eye], -1.0)):
        near = rings[: lids.CREASE + 1].ravel()
        centre = EYE_CENTRE * [sign, 1.0, 1.0]
        offset = out[near] - centre
        distance = np.linalg.norm(offset, axis=1)
        inside = distance < least
        out[near[inside]] = centre + offset[inside] * (least / distance[inside])[:, None]
    return out
