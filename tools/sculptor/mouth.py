"""The mouth's movements: what each lip does from its middle to the corner, and the skin after it.

A lip is a strip of cross-sections. A movement says, at four places along it, where the section
goes, how far it slides around the dental arch, how far it rolls and how much thinner it gets;
the skin around follows as smoothly as it can.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from sculptor import layout, lids, lips, teeth
from sculptor.assembly import build
from sculptor.implicit import Points
from sculptor.smooth import Pull, follow
from sculptor.weights import hill, lid_grip

__all__ = ["Lip", "Mouth", "Spot", "sealed"]

_KNOTS = (0.0, 0.35, 0.7, 1.0)
_ARCH_Z = 4.6  # the lips slide around a vertical axis here, as over the dental arch
_RINGS = np.arange(lips.BORDER - 1, lips.CONTACT + 2)  # what a lip's section is made of
_SHARE = np.array([0.4, 0.8, *[1.0] * (len(_RINGS) - 3), 0.4])  # of the roll, by ring
_APART = 0.003  # of the lips that meet, from the middle between them
_SLIGHT = 0.004  # cm that nobody sees
_FLAT = (0.0, 0.0, 0.0, 0.0)
_MIRROR = np.array([-1.0, 1.0, 1.0])

for _fixed in (_RINGS, _SHARE, _MIRROR):
    _fixed.flags.writeable = False


@dataclass(frozen=True)
class Lip:
    """What a lip does at 0, 0.35, 0.7 and 1 of the way from its middle to the corner of the mouth.

    Attributes:
        turn: Degrees around the dental arch, outwards.
        x, y, z: Centimetres outwards, up and forwards.
        roll: Degrees that the red turns outwards; negative turns it in.
        thin: Share of its height that is lost.
    """

    turn: Sequence[float] = _FLAT
    x: Sequence[float] = _FLAT
    y: Sequence[float] = _FLAT
    z: Sequence[float] = _FLAT
    roll: Sequence[float] = _FLAT
    thin: Sequence[float] = _FLAT


@dataclass(frozen=True)
class Spot:
    """Where the skin is asked to go: a hill around a place in front of the face, on both sides."""

    at: tuple[float, float]
    size: tuple[float, float]
    way: tuple[float, float, float]
    strength: float = 0.3
    sides: tuple[int, ...] = (1, -1)


@dataclass(frozen=True)
class Mouth:
    """A movement of the mouth.

    Attributes:
        upper, lower: The character's left half of each lip.
        right: The right halves, with x and turn towards the left; mirrored if not given.
        spots: Pulls at the skin around; x of their way points outwards.
    """

    upper: Lip
    lower: Lip
    right: tuple[Lip, Lip] | None = None
    spots: tuple[Spot, ...] = ()

    def displacement(self, amount: float) -> Points:
        """(V, 3) of the whole head, as far as the amount goes: only turns leave a straight line.

        It fades to exactly nothing on the lids, and where nobody sees it at full strength.
        """
        far = np.linalg.norm(_followed(self, 1.0), axis=1)
        fade = np.clip((far - _SLIGHT) / (2.0 * _SLIGHT), 0.0, 1.0) * lid_grip()
        settled: Points = fade[:, None] * _followed(self, amount)
        return settled

    def pulls(self, amount: float) -> list[Pull]:
        """What the lips and the spots ask the skin to do."""
        pulls = list(_anchors(chin=not any(spot.at[1] < -9.0 for spot in self.spots)))
        turns = [_along(k, *self._halves(k))[0] for k in (0, 1)]
        arcs = [_around_arch(_lip_points(k), amount * turns[k]) for k in (0, 1)]
        for k, straight in enumerate(self._straight(turns)):
            moved = (amount * straight + arcs[k]).reshape(-1, 3)
            pulls.append((_sections(k).ravel(), moved, 50.0))
            pulls += _behind(k, moved.reshape(len(_RINGS), -1, 3)[1])
        for spot in self.spots:
            for side in spot.sides:
                weight = spot.strength * hill(side * spot.at[0], spot.at[1], *spot.size)
                near = np.flatnonzero(weight > 0.0)
                way = amount * np.array(spot.way) * [side, 1.0, 1.0]
                pulls.append((near, np.broadcast_to(way, (len(near), 3)), weight[near]))
        return pulls

    def _halves(self, number: int) -> tuple[Lip, Lip | None]:
        """The left and the right half of the upper or the lower lip."""
        return (self.upper, self.lower)[number], None if self.right is None else self.right[number]

    def _straight(self, turns: list[NDArray[np.float64]]) -> list[Points]:
        """(R, 19, 3) of both lips at the end: displacements besides the turns around the arch."""
        ends, ways = [], []
        for k, turn in enumerate(turns):
            moved = self._rolled(k)
            ways.append(_around_arch(_lip_points(k), turn))
            ends.append(_keep_off_teeth(moved + _around_arch(moved, turn)))
        contact = list(_RINGS).index(lips.CONTACT)
        middle = 0.5 * (ends[0][contact, :, 1] + ends[1][contact, :, 1])
        inner = slice(2, None)  # the red presses flat where it meets the other lip
        ends[0][inner, 1:-1, 1] = np.maximum(ends[0][inner, :, 1], middle + _APART)[:, 1:-1]
        ends[1][inner, 1:-1, 1] = np.minimum(ends[1][inner, :, 1], middle - _APART)[:, 1:-1]
        return [ends[k] - ways[k] - _lip_points(k) for k in (0, 1)]

    def _rolled(self, number: int) -> Points:
        """(R, 19, 3) a lip's sections made thinner, rolled and carried along."""
        points = _lip_points(number)
        _, x, y, z, roll, thin = _along(number, *self._halves(number))
        line = points[list(_RINGS).index(lips.CONTACT)]
        way = -1.0 if number == 0 else 1.0
        offset = points - line
        offset[..., 1] *= 1.0 - thin
        pivot = np.array([0.0, -0.30 * way, 0.02]) * (1.0 - thin)[:, None] ** [0, 1, 0]
        angle = np.radians(way * roll) * _SHARE[:, None]
        turned = pivot + _about_tangent(offset - pivot, line, angle)
        carried: Points = line + turned + np.stack([x, y, z], axis=1)
        return carried


def _lip_points(number: int) -> Points:
    points: Points = build().mesh.vertices[_sections(number)]
    return points


@cache
def _followed(mouth: Mouth, amount: float) -> Points:
    """(V, 3) what the whole skin does after the lips and the spots."""
    followed = follow(mouth.pulls(amount))
    if mouth.right is None:
        followed = 0.5 * (followed + followed[build().partner] * _MIRROR)
    followed.flags.writeable = False
    return followed


def sealed(opened: Points) -> Points:
    """The displacement that brings the lips together after another one has parted them.

    Args:
        opened: (V, 3) displacement by which the mouth opens.
    """
    head = build()
    points = head.mesh.vertices + opened
    upper, lower = (points[_sections(number)] for number in (0, 1))
    contact = list(_RINGS).index(lips.CONTACT)
    line = 0.8 * upper[contact] + 0.2 * lower[contact]
    line[:, 2] = upper[contact, :, 2] - 0.6 * (upper[contact, :, 1] - line[:, 1])
    rest = head.mesh.vertices
    pulls = list(_anchors(chin=False))
    for number in (0, 1):
        vertices = _sections(number)
        offset = rest[vertices] - rest[vertices[contact]]
        moved = line + offset - points[vertices]
        pulls.append((vertices.ravel(), moved.reshape(-1, 3), 50.0))
        pulls += _behind(number, moved[1])
    chin = hill(0.0, -10.2, 1.6, 0.7)
    near = np.flatnonzero(chin > 0.0)
    pulls.append((near, 0.0, chin[near]))
    followed = follow(pulls)
    both = 0.5 * (followed + followed[head.partner] * _MIRROR)
    sealing: Points = np.where(np.linalg.norm(both, axis=1, keepdims=True) > _SLIGHT, both, 0.0)
    return sealing


def _behind(number: int, skin: Points) -> list[Pull]:
    """The mouth bag behind a lip, which goes with the skin in front of it: (19, 3) there."""
    aside = np.abs(np.linspace(-1.0, 1.0, len(skin)))[:, None]
    share = np.array([0.9, 0.5, 0.5])
    vestibule = skin * (share + (1.0 - share) * aside)  # at the corners it goes all the way
    vestibule[:, 2] = np.minimum(vestibule[:, 2], skin[:, 2])  # never through the skin
    return [
        (_chain(number, lips.CONTACT + 2), vestibule, 5.0),
        (_chain(number, lips.CONTACT + 3), 0.4 * skin, 1.0),
    ]


def _along(number: int, lip: Lip, other: Lip | None) -> NDArray[np.float64]:
    """(6, 19) what a lip does at each section, from the right corner to the left."""
    from scipy.interpolate import PchipInterpolator

    left = np.array(astuple(lip), dtype=float)
    right = left * np.array([-1, -1, 1, 1, 1, 1])[:, None] if other is None else astuple(other)
    values = np.concatenate([np.array(right)[:, :0:-1], left], axis=1)
    if other is None:
        values[:2, len(_KNOTS) - 1] = 0.0
    knots = np.concatenate([-np.array(_KNOTS)[:0:-1], _KNOTS])
    contact = build().mesh.vertices[_sections(number)[list(_RINGS).index(lips.CONTACT)], 0]
    found: NDArray[np.float64] = PchipInterpolator(knots, values, axis=1)(contact / contact[-1])
    return found


@cache
def _sections(number: int) -> NDArray[np.int64]:
    """(R, 19) vertices of the upper or the lower lip, from the right corner to the left."""
    return np.stack([_chain(number, ring) for ring in _RINGS])


def _chain(number: int, ring: int) -> NDArray[np.int64]:
    """(19,) vertices of a ring along the upper or the lower lip, from right to left."""
    head = build()
    half = head.lay.mouth[ring]
    half = half[: lips.CORNER + 1] if number == 0 else half[: lips.CORNER - 1 : -1]
    return np.concatenate([head.partner[half[:0:-1]], half])


def _about_tangent(offsets: Points, line: Points, angle: NDArray[np.float64]) -> Points:
    """Offsets (R, 19, 3) turned about the direction of a line (19, 3), by angles (R, 19)."""
    tangent = np.gradient(line, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    along = np.einsum("rki,ki->rk", offsets, tangent)[..., None] * tangent
    across = np.cross(np.broadcast_to(tangent, offsets.shape), offsets)
    cosine, sine = np.cos(angle)[..., None], np.sin(angle)[..., None]
    turned: Points = along + (offsets - along) * cosine + across * sine
    return turned


def _around_arch(points: Points, degrees: NDArray[np.float64]) -> Points:
    """Displacements by a turn about the vertical axis of the dental arch, towards the left."""
    angle = np.radians(degrees)
    x, z = points[..., 0], points[..., 2] - _ARCH_Z
    return np.stack(
        [
            x * np.cos(angle) + z * np.sin(angle) - x,
            np.zeros_like(x),
            z * np.cos(angle) - x * np.sin(angle) - z,
        ],
        axis=-1,
    )


def _keep_off_teeth(points: Points) -> Points:
    """Points pushed out of the dental arch and a little in front of it."""
    return points + teeth.push_out(points)[..., None] * [0.0, 0.0, 1.0]


@cache
def _anchors(chin: bool) -> tuple[Pull, ...]:
    """What stays where it is: eyes, ears, crown, back, neck and, less firmly, the nose."""
    head = build()
    lay, grid = head.lay, head.lay.grid
    nose = grid[layout.EYE.bottom + 1 : layout.MOUTH.top - 1, :5]
    firm = [
        lay.eye[lids.CREASE - 1 :], lay.ear, lay.ear_floor, lay.cap, grid[: layout.EYE.bottom - 3],
        grid[: layout.MOUTH.top, layout.EAR.front - 1 :], grid[:, layout.EAR.back - 1 :],
        grid[layout.MOUTH.bottom + 9 :], lay.mouth[-1:],
    ]  # fmt: skip
    soft = [(nose, 0.05), (lay.nostril, 0.05), (lay.eye[: lids.CREASE - 1], 0.02)]
    soft += [(each, 20.0) for each in firm]
    if chin:
        soft.append((grid[layout.MOUTH.bottom + 3 : layout.MOUTH.bottom + 6, :4], 5.0))
    pulls: list[Pull] = []
    for part, strength in soft:
        own = part[part >= 0]
        both = np.unique(np.concatenate([own, head.partner[own]]))
        pulls.append((both, 0.0, strength))
    return tuple(pulls)
