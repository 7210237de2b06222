"""Lids that meet: what takes back by how far they slide past each other where several shapes shut.

Lids move by sums: a blink, a look down, a squint and a smile each shut the eye in part, and beyond
what shuts it the upper lid goes on through the lower one. How far a slider shuts it, κ, is known
from its target. Correctives of the weight

    h = max(0, Σ κ_i w_i - 1)

are 0 until the eye is shut and then take the rest back: less of the blink, and what else brings the
margin of the upper lid onto that of the lower one, by least squares over faces.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from elastomorph.holding.correction import Correction, straight_morph
from elastomorph.holding.eyes import Eye, Points, faces_of, find_eyes, part_rig
from elastomorph.model.morph import Morph
from elastomorph.rig import Rig
from elastomorph.rig.laws import Corrective

HINGES = 2
"""Correctives an eye, for the two halves of the slit: one leaves twice as much, three no less."""
_OVERLAP = 0.06
"""By which lids that are shut lie over each other, in parts of the widest opening.

From below one sees between lids that meet as seen from the eyeball."""
_LEAST_GAIN = 0.01
_LEAST_BLINK = 0.5
"""Part of the opening that a slider takes away which is to be a blink."""
_TAKE, _RANDOM = 400, 100
"""Faces of a take that a fit is made to, and of combinations drawn beside them; four times as many
of those where there is no take."""
_MOST = 1.0
"""Weight of a corrective up to which faces count: farther no face of a take shuts an eye."""
_CHANCES = 0.5, 0.1
"""Faces that shut their eyes use much of what shuts them, and little of what opens them."""
_ROUNDS = 4
"""Of the fit: where margins are is linear in the correctives, but what lies opposite changes."""
_RIDGE = 0.02
_BACK = 1.25
"""Of the blink, what a corrective takes back of a vertex at most."""
_NOTHING = 1e-5
"""What a corrective moves by less, as a fraction of D, it does not move."""


@dataclass(frozen=True, eq=False)
class Gains:
    """How far each slider shuts an eye.

    Attributes:
        names: (J,) the sliders.
        table: (J, H) κ of each for each corrective.
        overlap: (K,) height by which lids lie over each other where the eye is shut: that which one
            slider alone leads them to, and at least a little.
        shares: (H, K) part of each corrective at each column, which sum to 1.
    """

    names: tuple[str, ...]
    table: Points
    overlap: Points
    shares: Points

    @classmethod
    def of(cls, eye: Eye, part: Rig) -> Gains:
        """From the targets alone: how much of the opening each slider takes away.

        By no more than 1, so that a slider alone never drives a corrective. One that shuts one half
        and opens another shuts nothing: an eye that looks aside takes its bulge along. Sliders of
        correctives drive nothing else.
        """
        alone = eye.slit(faces_of(part, np.eye(len(part.names))))
        overlap = np.maximum(_OVERLAP * eye.open.max(), -alone.min(axis=0))
        shares = _halves(np.linspace(0, 1, len(eye.columns)))
        table = (eye.open - alone) @ shares.T / ((eye.open + overlap) @ shares.T)
        table[np.abs(table) < _LEAST_GAIN] = 0
        table[(table.min(axis=1) < 0)[:, None] & (table > 0)] = 0
        table[[name in part.sliders.correctives for name in part.names]] = 0
        return cls(part.names, np.minimum(np.round(table, 4), 1), overlap, shares)

    def weights(self, faces: Points) -> Points:
        """(S, H) weight of each corrective from (S, J) slider weights."""
        return np.asarray(np.maximum(faces @ self.table - 1, 0))

    def corrective(self, half: int) -> Corrective:
        """The law of one of the correctives."""
        own = np.flatnonzero(self.table[:, half])
        gains = tuple(self.table[own, half].tolist())
        return Corrective(tuple(self.names[i] for i in own), "hinge", gains)


def _halves(along: Points) -> Points:
    """(H, N) shares of the correctives at places from 0 to 1 along the slit."""
    middles = (np.arange(HINGES) + 0.5) / HINGES
    return np.stack([np.interp(along, middles, row) for row in np.eye(HINGES)])


def lid_corrections(rig: Rig, take: Points | None) -> Iterator[tuple[Correction, Morph | None]]:
    """The correctives of the lids of a rig, or why an eye has none.

    Args:
        rig: The rig.
        take: (T, J) weights of its sliders, if any.

    Yields:
        A row, and the morph that it tells of, if any.

    Raises:
        ParameterError: The rig has no slider that blinks, or no polygons.
    """
    present = [c for c in rig.sliders.correctives.values() if c.law == "hinge"]
    done: list[Eye] = []
    for eye in find_eyes(rig):
        if isinstance(eye, str):
            yield Correction(eye.partition(":")[0], note=eye), None
        elif any(np.linalg.norm(eye.centre - other.centre) < eye.radius for other in done):
            continue  # which another slider shuts as well
        elif any(eye.name in corrective.drivers for corrective in present):
            yield Correction(eye.name, note=f"{eye.name} is held already, and kept"), None
        else:
            before = sum(other.name == eye.name for other in done)
            yield from _held_eye(eye, rig, take, HINGES * before)
            done.append(eye)


def _held_eye(
    eye: Eye, rig: Rig, take: Points | None, number: int
) -> Iterator[tuple[Correction, Morph | None]]:
    part = part_rig(rig, eye.vertices)
    gains = Gains.of(eye, part)
    blink = gains.table[part.names.index(eye.name)].max()
    if blink < _LEAST_BLINK:
        shut = f"{eye.name} takes away only {100 * blink:.0f} % of the opening of the eye"
        yield Correction(eye.name, note=f"{shut}, so that what shuts it is not known"), None
        return
    faces = shutting_faces(eye, gains, take)
    if not len(faces):
        yield Correction(eye.name, note=f"nothing shuts the eye beyond {eye.name}"), None
        return
    shifts = _fit(eye, part, gains, faces)
    shifts[np.linalg.norm(shifts, axis=2) < _NOTHING * rig.neutral.diameter] = 0
    seen = faces if take is None else take[gains.weights(take).any(axis=1)]
    straight = faces_of(part, seen)
    driven = gains.weights(seen)
    slits = [eye.slit(p) for p in (straight, straight + np.tensordot(driven, shifts, 1))]
    # Past each other, or open where they would be shut.
    past = [np.maximum(-slit - gains.overlap, 0) for slit in slits]
    past[1] = np.maximum(past[1], np.where(slits[0] <= 0, slits[1], 0))
    for half, shift in enumerate(shifts):
        own, law = gains.shares[half] >= 1 / HINGES, gains.corrective(half)
        before, after = (float(each[:, own].max(initial=0.0)) for each in past)
        name, size = f"hold_{eye.name}_{number + half + 1}", rig.neutral.diameter
        in_use = 0 if take is None else int((gains.weights(take)[:, half] > 0).sum())
        what = name, law.drivers, law.law, law.numbers
        row = Correction(*what, before, after, size, in_use, targets=1)
        yield row, straight_morph(rig, eye.vertices, shift)


def shutting_faces(eye: Eye, gains: Gains, take: Points | None) -> Points:
    """(S, J) weights at which the eye is more than shut, of a take and drawn at random."""
    random = np.random.default_rng(0)
    chance = np.select([gains.table.max(axis=1) > 0, gains.table.any(axis=1)], _CHANCES)
    drawn = random.random((20 * _TAKE, len(chance)))
    drawn *= random.random(drawn.shape) < chance
    drawn[:, gains.names.index(eye.name)] = random.uniform(0.2, 1, len(drawn))
    chosen = []
    for faces, most in ((take, _TAKE), (drawn, _RANDOM if take is not None else 4 * _RANDOM)):
        if faces is not None:
            weight = gains.weights(faces).max(axis=1)
            past = faces[(weight > 0) & (weight < _MOST)]
            spread = np.linspace(0, max(len(past) - 1, 0), min(most, len(past))).astype(int)
            chosen.append(past[spread])
    return np.concatenate(chosen)


def _fit(eye: Eye, part: Rig, gains: Gains, table: Points) -> Points:
    """(H, N, 3) what a weight of 1 of each corrective adds to the vertices of the eye."""
    rest, blink = part.neutral.vertices, part[eye.name].delta
    longitude, _, distance = eye.places(rest)
    along = np.interp(longitude, eye.columns, np.linspace(0, 1, len(eye.columns)))
    shares = _halves(along)
    shifts = -shares[:, :, None] * blink
    ratio = np.where(distance < 2 * eye.radius, _ridden(eye, rest, blink), 0)
    straight, driven = faces_of(part, table), gains.weights(table)
    lowest = lowest_alone(eye, part)
    normal = driven.T @ driven
    local = shares.T[:, :, None] * normal * shares.T[:, None, :]
    local += _RIDGE * np.trace(normal) / HINGES * np.eye(HINGES)
    for _ in range(_ROUNDS):
        faces = straight + np.tensordot(driven, shifts, 1)
        upper, lower = eye.margins(faces)
        lift = lower - upper - gains.overlap / eye.radius
        across, up, far = eye.places(faces)
        lifts = [np.interp(a, eye.columns, row) for a, row in zip(across, lift, strict=True)]
        left = eye.at(across, up + ratio * lifts, np.maximum(far, lowest)) - faces
        pull = np.einsum("hn,sh,sni->nhi", shares, driven, left)
        shifts = shifts + shares[:, :, None] * np.linalg.solve(local, pull).transpose(1, 0, 2)
    # Where the slit ends there is little to fit to, and a step from vertex to vertex is a dent.
    most = _BACK * shares * np.linalg.norm(blink, axis=1) + _NOTHING * eye.radius
    far = np.maximum(np.linalg.norm(shifts, axis=2), most)
    return np.asarray(shifts * (most / far)[:, :, None])


def _ridden(eye: Eye, rest: Points, blink: Points) -> Points:
    """(N,) by how much each vertex moves where the margin of the upper lid moves by 1.

    In the ratio in which the blink moves them, as lashes move farther; nothing of the lower lid,
    and what lies in the slit in part.
    """
    size = np.linalg.norm(blink, axis=1)
    longitude, latitude, _ = eye.places(rest)
    upper, lower = eye.margins(rest[None])
    middle = np.interp(longitude, eye.columns, (upper + lower)[0] / 2)
    wide = np.interp(longitude, eye.columns, eye.open / eye.radius)
    rim = np.unique(eye.upper)
    rim = rim[np.argsort(longitude[rim])]
    there = np.maximum(np.interp(longitude, longitude[rim], size[rim]), 0.1 * size[rim].max())
    return np.asarray(size / there * np.clip((latitude - middle) / wide + 0.5, 0, 1))


def lowest_alone(eye: Eye, part: Rig) -> Points:
    """(N,) least distance from the middle of the eyeball that a vertex has by one slider alone.

    At most the radius, outside which all is well, and 0 for what is no skin round an eyeball.
    """
    if not eye.ball:
        return np.zeros(len(eye.vertices))
    floor = np.full(len(eye.vertices), eye.radius)
    for weight in np.linspace(0, 1, 5):
        faces = faces_of(part, weight * np.eye(len(part.names)))
        floor = np.minimum(floor, np.linalg.norm(faces - eye.centre, axis=2).min(axis=0))
    return np.where(eye.skin, floor, 0)
