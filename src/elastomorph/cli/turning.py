"""How a take turns the head of a rig, for films and files."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from typing import TYPE_CHECKING

import numpy as np

from elastomorph.errors import warn

if TYPE_CHECKING:
    from elastomorph.rig import Rig
    from elastomorph.rig.performance import HeadTurn, Performance

_FARTHEST = 2 * pi


def head_turn(rig: Rig, take: Performance, *, still: bool) -> HeadTurn | None:
    """How a head is turned in each frame of a take; None where it is still, or is to be."""
    from elastomorph.draw.head import head_of, neck_of
    from elastomorph.rig.performance import HeadTurn

    angles = take.head
    if still or not angles.any():
        return None
    most = float(np.abs(angles).max())
    if most > _FARTHEST:
        _tell(
            f"{take.source} turns the head by up to {most:.3g} radians: should these be degrees, "
            "write them in radians, or leave the head still with --still-head"
        )
    morphs = rig.morphs.values()
    if head_of(rig.neutral, morphs) is not None:
        _tell(
            "the whole character turns with its head, for a rig has no bones; --still-head leaves "
            "it as it is"
        )
    return HeadTurn(neck_of(rig.neutral, morphs), angles)


def at_frames(turn: HeadTurn | None, take: Performance) -> HeadTurn | None:
    """The same turn in the frames of a take that was resampled."""
    return None if turn is None else replace(turn, angles=take.head)


def turn_line(turn: HeadTurn) -> str:
    """How far a head turns, in a line."""
    most = np.degrees(np.abs(turn.angles).max(axis=0)).tolist()
    named = zip(most, ("yaw", "pitch", "roll"), strict=True)
    return f"the head turns by up to {', '.join(f'{angle:.3g}° {name}' for angle, name in named)}"


def _tell(sentence: str) -> None:
    warn(sentence)
