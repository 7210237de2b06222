"""Lips that two sliders push into each other: a sheet folded over itself, whose gap is known."""

from __future__ import annotations

import numpy as np
import pytest

import elastomorph as em
from elastomorph.holding.damage import Surface
from elastomorph.holding.pairs import LARGEST
from elastomorph.model.mesh import Mesh
from elastomorph.rig import Rig
from elastomorph.rig.performance import Performance

LONG = 25
GAP = 1.0
LIPS = ("mouthShrugLower", "mouthShrugUpper")


def mouth(push: float) -> Rig:
    """A lower lip of 25 × 25 vertices and an upper one over it, each of which goes up or down.

    They are joined at the back, as those of a mouth at its corners.
    """
    along, across = np.divmod(np.arange(LONG * LONG), LONG)
    lower = np.stack([across, np.zeros(LONG * LONG), -along], axis=1).astype(float)
    upper = lower[::-1] * [-1, 1, 1] + [LONG - 1, GAP, 0]
    points = np.concatenate([lower, upper])
    faces = [
        [i, i + 1, i + 1 + LONG, i + LONG]
        for i in range(LONG * (2 * LONG - 1))
        if i % LONG < LONG - 1
    ]
    neutral = Mesh(points, faces)
    middle = np.array([LONG // 2, 0, -(LONG // 2)])
    bump = push * np.exp(-(((points - middle)[:, [0, 2]] ** 2).sum(axis=1)) / 18)
    is_lower = np.arange(len(points)) < LONG * LONG
    ends = {
        name: neutral.with_vertices(points + np.outer(bump * own, [0, way, 0]))
        for name, own, way in zip(LIPS, (is_lower, ~is_lower), (1, -1), strict=True)
    }
    return Rig(neutral, ends, method="linear")


def take(*frames: tuple[float, float]) -> Performance:
    return Performance(LIPS, np.arange(len(frames)) / 30, frames, 30)


def passed(rig: Rig, face: tuple[float, float]) -> float:
    """By how much the lower lip is above the upper one at most; vertices lie over vertices."""
    points = rig.pose(dict(zip(LIPS, face, strict=True)))
    lower, upper = points[: LONG * LONG], points[LONG * LONG :][::-1]
    order = np.lexsort(np.round(rig.neutral.vertices[LONG * LONG :][::-1, [0, 2]]).T)
    own = np.lexsort(np.round(rig.neutral.vertices[: LONG * LONG, [0, 2]]).T)
    return float((lower[own, 1] - upper[order, 1]).max())


FACES = [(1.0, 1.0), (0.97, 1.0), (1.0, 0.95), (0.98, 0.98)]


def test_lips_that_pass_are_parted() -> None:
    """As far as single sliders take them, which is not through each other."""
    rig = mouth(0.55)
    held = em.hold(rig, take(*FACES * 2), lids=False, lips=3)
    (row,) = held.corrections
    scale = Surface.of(rig).diameter
    assert row.name == "lips_mouthShrugLower_mouthShrugUpper"
    assert held.rig.sliders.correctives[row.name] == em.Corrective(LIPS, "min")
    assert row.before == pytest.approx(0.1, abs=1e-3)
    assert row.after < 5e-4 * scale
    assert row.diameter == pytest.approx(scale)
    assert row.frames == 8
    assert max(passed(rig, face) for face in FACES) == pytest.approx(0.1)
    assert max(passed(held.rig, face) for face in FACES) < 5e-4 * scale
    farthest = np.linalg.norm(held.rig[row.name].delta, axis=1).max()
    assert 0 < farthest <= LARGEST * scale * (1 + 1e-9)


def test_single_sliders_stay_to_the_bit() -> None:
    rig = mouth(0.55)
    held = em.hold(rig, take(*FACES), lids=False, lips=3).rig
    for name in LIPS:
        for weight in (0.3, 1.0):
            np.testing.assert_array_equal(held.pose({name: weight}), rig.pose({name: weight}))
    assert all(held.morphs[name] is rig.morphs[name] for name in rig)


def test_nothing_is_added_where_nothing_passes() -> None:
    rig = mouth(0.49)
    held = em.hold(rig, take(*FACES), lids=False, lips=3)
    assert held.corrections == ()
    assert held.rig is rig


def test_only_the_first_half_of_a_take_is_looked_at() -> None:
    late = take(*[(1, 0)] * 4, *[(1, 1)] * 4)
    assert em.hold(mouth(0.55), late, lids=False, lips=3).corrections == ()


def test_what_is_held_is_kept() -> None:
    held = em.hold(mouth(0.55), take(*FACES), lids=False, lips=3).rig
    again = em.hold(held, take(*FACES), lids=False, lips=3)
    (row,) = again.corrections
    assert row.note == "lips_mouthShrugLower_mouthShrugUpper is there already, and kept"
    assert again.rig is held


def test_errors() -> None:
    with pytest.raises(em.ParameterError, match="number of lips must be a whole number from 0"):
        em.hold(mouth(0.55), take((1, 1)), lids=False, lips=-1)
    with pytest.raises(em.ParameterError, match="lips are found in takes"):
        em.hold(mouth(0.55), lids=False, lips=3)
    rig = mouth(0.55)
    ends = {f"slider{place}": rig[name].target for place, name in enumerate(LIPS)}
    other = Performance([*ends], [0.0], [[1.0, 1.0]], 30)
    with pytest.raises(em.ParameterError, match="no slider that moves lips"):
        em.hold(Rig(rig.neutral, ends, method="linear"), other, lids=False, lips=3)
