"""Correctives undo the folds they are fitted to, move little, and cost nothing elsewhere."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from folded_sheets import moved, sheet
from numpy.typing import NDArray

import elastomorph as em
from elastomorph.holding.damage import Surface
from elastomorph.holding.pairs import LARGEST
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.rig import Rig
from elastomorph.rig.performance import Performance

WIDE = 61
CENTRE = WIDE * (WIDE // 2) + WIDE // 2


def wide_rig() -> Rig:
    """Two sliders that move one of 61 × 61 vertices past its neighbour, together only."""
    points, faces = sheet(side=WIDE)
    neutral = Mesh(points, faces)
    named = {name: neutral.with_vertices(moved(points, CENTRE, (0.55, 0, 0))) for name in "ab"}
    return Rig(neutral, named, method="linear")


def folds_on_the_grid(rig: Rig, displacement: NDArray[np.float64] | float) -> list[int]:
    surface, quarters = Surface.of(rig), (0.25, 0.5, 0.75, 1.0)
    return [
        int(surface.folded(rig.pose({"a": a, "b": b}) + min(a, b) * displacement).sum())
        for a, b in product(quarters, quarters)
    ]


def take(*frames: tuple[float, float]) -> Performance:
    return Performance(["a", "b"], np.arange(len(frames)) / 30, frames, 30)


def test_all_sixteen_weights_are_mended() -> None:
    rig = wide_rig()
    held = em.hold(rig, take(*[(1, 1)] * 8), lids=False, folds=3)
    (row,) = held.corrections
    morph = held.rig[row.name]
    assert row.name == "fold_a_b"
    assert held.rig.sliders.correctives[row.name] == em.Corrective(("a", "b"), "min")
    assert (morph.neutral.vertices == rig.neutral.vertices).all()
    assert not len(morph.bends)
    assert sum(folds_on_the_grid(rig, 0.0)) > 0
    assert sum(folds_on_the_grid(rig, morph.delta)) == 0
    assert sum(folds_on_the_grid(held.rig, 0.0)) == 0
    assert row.before > row.after == 0
    assert row.frames == 8
    farthest = np.linalg.norm(morph.delta, axis=1).max()
    assert farthest <= LARGEST * Surface.of(rig).diameter * (1 + 1e-9)


def test_only_the_first_half_of_a_take_is_looked_at() -> None:
    """Where the two meet in the second half alone, nothing is proposed."""
    late = take(*[(1, 0)] * 4, *[(1, 1)] * 4)
    assert em.hold(wide_rig(), late, lids=False, folds=3).corrections == ()


def test_a_corrective_moves_what_is_near_only() -> None:
    rig = wide_rig()
    held = em.hold(rig, take((1, 1), (1, 1)), lids=False, folds=1)
    far = np.abs(rig.neutral.vertices - rig.neutral.vertices[CENTRE]).max(axis=1) > 12
    assert not held.rig["fold_a_b"].delta[far].any()


def test_a_corrective_that_is_there_is_kept() -> None:
    """By its name, even where it leaves the folds as they were."""
    rig = wide_rig()
    morphs: dict[str, Morph | Mesh] = {**rig.morphs, "fold_a_b": rig.neutral}
    there = em.Rig(rig.neutral, morphs, method="linear", correctives={"fold_a_b": ("a", "b")})
    held = em.hold(there, take((1, 1), (1, 1)), lids=False, folds=3)
    assert [row.note for row in held.corrections] == ["fold_a_b is there already, and kept"]
    assert held.rig is there


def test_errors() -> None:
    with pytest.raises(em.ParameterError, match="number of folds"):
        em.hold(wide_rig(), take((1, 1)), lids=False, folds=-1)
    with pytest.raises(em.ParameterError, match="folds are found in takes"):
        em.hold(wide_rig(), lids=False, folds=3)
    points, faces = sheet()
    neutral = Mesh(points, faces)
    one = Rig(neutral, {"a": neutral.with_vertices(points + 1)}, method="linear")
    with pytest.raises(em.ParameterError, match="two sliders or more"):
        em.hold(one, take((1, 1)), lids=False, folds=1)
    other = Performance(["jawOpen"], [0.0], [[1.0]], 30, source="take.csv")
    with pytest.raises(em.ParameterError, match=r"no weight of take\.csv drives"):
        em.hold(wide_rig(), other, lids=False, folds=1)
