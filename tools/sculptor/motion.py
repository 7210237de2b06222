"""A recorded motion of the built-in head: from the neutral into a wide laugh.

The motion comes from joints, not from any law that the interpolations assume: the jaw turns about
its hinge while the hinge glides forwards, the lids turn about the eyeballs, and lips, cheeks and
brows follow, each with its own start and pace.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from elastomorph.model.sequence import MeshSequence
from sculptor.assembly import build
from sculptor.implicit import Points
from sculptor.muscles import brow_raise, mirrored, movements
from sculptor.turns import keep_off_eyes, turn_jaw, turn_lids

__all__ = ["FRAMES", "JAW_TURN", "jaw_angle", "recorded_motion"]

FRAMES = 11
JAW_TURN = 23.0  # degrees at the end of the motion

# When each part is halfway and how quickly it moves (a logistic curve), and how far it goes.
_PACE = {
    "jaw": (0.42, 0.105, JAW_TURN),
    "glide": (0.34, 0.09, 0.35),
    "mouthSmile": (0.50, 0.11, 1.25),
    "mouthUpperUp": (0.55, 0.08, 0.55),
    "mouthLowerDown": (0.52, 0.10, 0.5),
    "cheekSquint": (0.62, 0.09, 1.1),
    "noseSneer": (0.66, 0.10, 0.25),
    "brows": (0.30, 0.08, 0.45),
    "browInnerUp": (0.27, 0.07, 0.4),
    "upper lid": (0.60, 0.07, 0.07),
    "lower lid": (0.66, 0.10, 0.36),
}


def _progress(part: str, time: float) -> float:
    """How far a part has come: a logistic curve that starts at exactly 0 and ends at its reach."""
    middle, pace, reach = _PACE[part]

    def logistic(t: float) -> float:
        return float(1.0 / (1.0 + np.exp((middle - t) / pace)))

    return reach * (logistic(time) - logistic(0.0)) / (logistic(1.0) - logistic(0.0))


def jaw_angle(time: float) -> float:
    """How far the jaw is open, in degrees, at a time between 0 and 1."""
    return _progress("jaw", time)


def _frame(time: float) -> Points:
    points = build().mesh.vertices.copy()
    if time == 0.0:
        return points
    moves = movements()
    raised = brow_raise(_progress("brows", time))
    points += raised + mirrored(raised)
    for part in _PACE:
        for name in (part, f"{part}_L", f"{part}_R"):
            if name in moves:
                points += moves[name](_progress(part, time))
    glide = _progress("glide", time)
    points = turn_jaw(points, jaw_angle(time), (glide, 0.3 * glide))
    closing = (_progress("upper lid", time), _progress("lower lid", time), 0.0)
    return keep_off_eyes(turn_lids(points, {"L": closing, "R": closing}))


@cache
def recorded_motion() -> MeshSequence:
    """Eleven poses of the head, from the neutral into a wide laugh, at times 0, 0.1, … 1.

    The jaw opens by 23° about the axis along x through (0, −0.9, 1.2), which glides forwards and
    down by up to 0.35 and 0.105 cm; the lower teeth follow rigidly. Each lid vertex turns about
    the centre of its eyeball. The first frame is ``head()``, bit for bit.
    """
    times = np.arange(FRAMES) / (FRAMES - 1)
    frames = np.stack([_frame(float(time)) for time in times])
    return MeshSequence(build().mesh, frames, times)
