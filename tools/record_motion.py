"""Make a recorded motion of ICT-FaceKit's head: from the neutral into a wide laugh.

The motion comes from anatomy and shares nothing with the interpolations that it judges: the jaw
turns about a hinge that glides, lids slide over the eyeballs, the corners of the mouth slide around
the dental arch, brows and cheeks slide over the skull, and each part keeps its own time.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

__all__ = ["FRAMES", "GLIDE", "JAW_TURN", "find_hinge", "hinge_glide", "jaw_angle", "motion"]

Points = NDArray[np.float64]

FRAMES = 11
JAW_TURN = 24.0  # degrees at the end of the motion
GLIDE = (-0.15, 0.4)  # of the hinge at the end of the motion, upwards and forwards, in cm

# Where the parts are in the list of vertices; gums and tongue lie between skin and teeth.
SKIN = slice(0, 14062)
UPPER_TEETH = slice(17039, 19247)
LOWER_TEETH = slice(19247, 21451)
SCLERAS = (slice(21451, 22221), slice(23021, 23791))
AT_LIDS = slice(24591, 26719)  # tears, shadows and lashes, behind the eyeballs

# How far each part goes, when it starts and ends, and how unevenly: below 1 it hurries at first.
_PACE = {
    "jawOpen": (1.0, 0.0, 1.0, 0.8),
    "glide": (1.0, 0.0, 1.0, 0.8),  # a condyle glides in step with the turn
    "mouthSmile": (1.0, 0.08, 0.95, 1.0),
    "mouthStretch": (0.35, 0.1, 0.9, 1.2),
    "mouthUpperUp": (0.35, 0.15, 0.95, 1.0),
    "noseSneer": (0.2, 0.25, 1.0, 1.0),
    "browInnerUp": (0.6, 0.0, 0.55, 1.0),
    "browOuterUp": (0.3, 0.0, 0.6, 1.0),
    "cheekSquint": (0.7, 0.2, 1.0, 1.1),
    "eyeSquint": (0.5, 0.35, 1.0, 1.2),
    "eyeBlink": (0.5, 0.2, 0.95, 1.1),
}
_JAW = ("jawOpen", "glide")
_AROUND_TEETH = ("mouthSmile", "mouthStretch")
_JOINT = 0.7  # cm from the hinge: nearer, a displacement tells little about a turn
_LID = (0.35, 1.2)  # cm from the eyeball: all is lid up to here, and no lid is left from there
_ARCH = (1.0, 2.5)  # cm from the axis of the dental arch, where its arcs begin to count


def _progress(part: str, time: float) -> float:
    """Tell how far a part has come: from rest to rest with the least jerk, as muscles move."""
    reach, start, end, skew = _PACE[part]
    u = float(np.clip((time - start) / (end - start), 0.0, 1.0)) ** skew
    return float(reach * u**3 * (10.0 - 15.0 * u + 6.0 * u**2))


def jaw_angle(time: float) -> float:
    """Tell how far the jaw is open, in degrees, at a time between 0 and 1."""
    return JAW_TURN * _progress("jawOpen", time)


def hinge_glide(time: float) -> Points:
    """Tell how far the hinge has gone up and forwards: first ahead, then down its slope."""
    gone = _progress("glide", time)
    return np.array([GLIDE[0] * gone**1.5, GLIDE[1] * gone])


def find_hinge(closed: Points, opened: Points) -> tuple[Points, float]:
    """Find y and z of the jaw's axis, which runs along x, and its turn in radians.

    Args:
        closed: (N, 3) vertices of the lower teeth in the neutral.
        opened: The same in jawOpen.
    """
    a, b = closed[:, 1:].mean(axis=0), opened[:, 1:].mean(axis=0)
    before, after = closed[:, 1:] - a, opened[:, 1:] - b
    angle = float(np.arctan2(_cross(before, after).sum(), (before * after).sum()))
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return np.linalg.solve(np.eye(2) - turn, b - turn @ a), angle


class _Jaw:
    """What follows the jaw, and how far."""

    def __init__(self, neutral: Points, opened: Points) -> None:
        self.hinge, self.angle = find_hinge(neutral[LOWER_TEETH], opened[LOWER_TEETH])
        before, after = neutral[:, 1:] - self.hinge, opened[:, 1:] - self.hinge
        # The turn that explains a displacement best, drawn to 0 where the hinge is near.
        turned = np.arctan2(_cross(before, after), (before * after).sum(axis=1)) / self.angle
        squared = (before**2).sum(axis=1)
        self.share = np.clip(turned, 0.0, 1.0) * squared / (squared + _JOINT**2)
        # Teeth, gums and tongue are on one bone or on the other, and eyeballs on none.
        self.share[SKIN.stop :] = np.rint(np.clip(turned[SKIN.stop :], 0.0, 1.0))
        self.share[LOWER_TEETH.stop :] = 0.0
        # What no turn explains, as seen from the turned skin.
        self.rest = self._turn(opened, -self.angle) - neutral
        self.rest[SKIN.stop :] = 0.0

    def _turn(self, points: Points, angle: float) -> Points:
        """Turn each point about the hinge by its share of an angle."""
        less, sin = np.cos(angle * self.share) - 1.0, np.sin(angle * self.share)
        y, z = (points[:, 1:] - self.hinge).T
        way = np.stack([0.0 * y, less * y - sin * z, sin * y + less * z], axis=1)
        turned: Points = points + way
        return turned

    def at(self, time: float, points: Points) -> Points:
        """Open the jaw under (V, 3) points that have slid where they are."""
        angle = np.radians(jaw_angle(time))
        moved = self._turn(points + angle / self.angle * self.rest, angle)
        moved[:, 1:] += self.share[:, None] * hinge_glide(time)
        return moved


class _Lids:
    """Skin and lashes around one eyeball, which turn about its centre."""

    def __init__(self, neutral: Points, moved: Points, sclera: slice) -> None:
        self.centre, radius = _sphere(neutral[sclera])
        away = np.linalg.norm(neutral - self.centre, axis=1)
        share = 1.0 - _ramp(away - radius, *_LID)
        share[SKIN.stop :] = 0.0
        share[AT_LIDS] = neutral[AT_LIDS, 0] * self.centre[0] > 0.0
        self.vertices = np.flatnonzero(share)
        self.share, self.away = share[self.vertices, None], away[self.vertices, None]
        self.way = (neutral[self.vertices] - self.centre) / self.away
        ends = (neutral + moved)[:, self.vertices] - self.centre
        far = np.linalg.norm(ends, axis=2, keepdims=True)
        # Along great circles: axis times angle, which add up as long as the axes nearly agree.
        normal = np.cross(self.way, ends / far)
        sine = np.linalg.norm(normal, axis=2, keepdims=True)
        angle = np.arctan2(sine, np.sum(self.way * ends / far, axis=2, keepdims=True))
        self.turns, self.out = normal * angle / np.maximum(sine, 1e-12), far - self.away

    def at(self, reached: Points, ends: Points) -> Points:
        """(N, 3) positions where the (K,) shapes have come this far, of what they reach."""
        turn = np.tensordot(reached, self.turns, 1)
        angle = np.linalg.norm(turn, axis=1, keepdims=True)
        axis = turn / np.maximum(angle, 1e-12)
        along = axis * np.sum(axis * self.way, axis=1, keepdims=True)
        way = along + np.cos(angle) * (self.way - along) + np.sin(angle) * np.cross(axis, self.way)
        away, end = (self.away + np.tensordot(each, self.out, 1) for each in (reached, ends))
        # Shapes that come at different times never press a lid deeper than both ends are.
        placed: Points = self.centre + np.maximum(away, np.minimum(self.away, end)) * way
        return placed


def _around(neutral: Points, moved: Points, reached: Points) -> Points:
    """(V, 3) displacements of (K, V, 3) ones that slide around the dental arch."""
    middle, _ = _sphere(neutral[UPPER_TEETH][:, [0, 2]])
    axis = np.array([0.0, middle[1]])

    def polar(points: Points) -> Points:
        flat = points[..., [0, 2]] - axis
        return np.stack([np.arctan2(flat[..., 0], flat[..., 1]), np.linalg.norm(flat, axis=-1)])

    start, straight = polar(neutral), np.tensordot(reached, moved, 1)
    turned, out = polar(neutral + moved) - start[:, None]
    angle = start[0] + reached @ ((turned + np.pi) % (2.0 * np.pi) - np.pi)
    radius = start[1] + reached @ out
    arc = np.stack([np.sin(angle), np.cos(angle)], axis=1) * radius[:, None] + axis
    share = _ramp(start[1], *_ARCH)[:, None]
    straight[:, [0, 2]] += share * (arc - neutral[:, [0, 2]] - straight[:, [0, 2]])
    return straight


def _cross(a: Points, b: Points) -> Points:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def _ramp(values: Points, low: float, high: float) -> Points:
    """Rise smoothly from 0 to 1 between two values."""
    u = np.clip((values - low) / (high - low), 0.0, 1.0)
    return u**2 * (3.0 - 2.0 * u)


def _sphere(points: Points) -> tuple[Points, float]:
    """Fit centre and radius of a sphere, or of a circle, by least squares."""
    rows = np.column_stack([2.0 * points, np.ones(len(points))])
    *centre, rest = np.linalg.lstsq(rows, (points**2).sum(axis=1), rcond=None)[0]
    return np.array(centre), float(np.sqrt(rest + np.dot(centre, centre)))


def motion(neutral: Points, targets: Mapping[str, Points]) -> Points:
    """Make eleven poses of ICT-FaceKit's head, from the neutral into a wide laugh.

    Args:
        neutral: (V, 3) positions, in the order of ICT-FaceKit's files.
        targets: (V, 3) positions of shapes by their ARKit names, such as mouthSmileLeft; the halves
            of browInnerUp are one shape.

    Returns:
        (11, V, 3) poses at t = 0, 0.1, … 1; the first is the neutral, bit for bit.
    """
    parts = [part for part in _PACE if part not in _JAW]
    moved = np.zeros((len(parts), *neutral.shape))
    for part, way in zip(parts, moved, strict=True):
        for name in (part, f"{part}Left", f"{part}Right"):
            if name in targets:
                way += targets[name] - neutral
    moved[:, SKIN.stop : AT_LIDS.start] = 0.0  # what the files move there is noise
    slides = np.isin(parts, _AROUND_TEETH)
    jaw = _Jaw(neutral, targets["jawOpen"])
    eyes = [_Lids(neutral, moved, sclera) for sclera in SCLERAS]
    ends = np.array([_progress(part, 1.0) for part in parts])
    # Of vertices at one place the first leads: roots of lashes stay on the skin of the lids.
    _, first, place = np.unique(neutral, axis=0, return_index=True, return_inverse=True)
    frames = [neutral.copy()]
    for time in np.arange(1, FRAMES) / (FRAMES - 1):
        reached = np.array([_progress(part, time) for part in parts])
        pose = neutral + np.tensordot(reached * ~slides, moved, 1)
        pose[SKIN] += _around(neutral, moved[slides], reached[slides])[SKIN]
        for lids in eyes:
            pose[lids.vertices] += lids.share * (lids.at(reached, ends) - pose[lids.vertices])
        frames.append(jaw.at(time, pose)[first[place.ravel()]])
    return np.stack(frames)
