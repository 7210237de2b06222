"""The straight line where turning would hardly differ from it, else least distortion.

A rig owns the path and a performance owns the timing, so either path has even timing. Most targets
of a face hardly turn anything, and a straight line costs nothing to store or play.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from elastomorph.curves import CurveNetwork
from elastomorph.mesh import Mesh
from elastomorph.morph import Choice, Morph
from elastomorph.paths import linear, rotation
from elastomorph.paths.method import Method

__all__ = ["prepare"]


def prepare(
    neutral: Mesh,
    method: Method,
    curves: CurveNetwork | None = None,
    *,
    extent: float | None = None,
) -> Callable[[Mesh], Morph]:
    """A function from target to path, which says what it chose and why in `Morph.choice`.

    Args:
        neutral: The mesh at t = 0.
        method: ``straight_within`` decides, ``tolerance`` is that of bends.
        curves: Not used: the path follows the surface.
        extent: D, which ``straight_within`` is a fraction of; ``neutral.diameter`` by default.

    Raises:
        BakeError: A turn is too sharp to be stored.
    """
    scale = (neutral.diameter if extent is None else extent) or 1.0
    straight = linear.prepare(neutral, replace(method, name="linear"))
    bent = rotation.prepare(neutral, replace(method, name="rotation"))

    def to(target: Mesh) -> Morph:
        morph = bent(target)
        middle = (neutral.vertices + target.vertices) / 2
        off = np.linalg.norm(morph.at(0.5) - middle, axis=1)
        choice = Choice(float(off.max()) / scale, method.straight_within)
        return replace(straight(target) if choice.straight else morph, choice=choice)

    return to
