"""Correctives undo the folds they are fitted to, move little, and cost nothing elsewhere."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from numpy.typing import NDArray
from sheets import moved, sheet

import elastomorph as em
from elastomorph.holding.damage import Surface
from elastomorph.holding.folds import LARGEST, fold_correctives
from elastomorph.model.mesh import Mesh
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


@pytest.mark.parametrize("with_take", [False, True])
def test_all_sixteen_weights_are_mended(*, with_take: bool) -> None:
    rig = wide_rig()
    take = Performance(["a", "b"], np.arange(8) / 30, [[1, 1]] * 8, 30) if with_take else None
    ((name, morph, corrective, row),) = fold_correctives(rig, 3, take)
    assert name == "fold_a_b"
    assert corrective.drivers == ("a", "b")
    assert corrective.law == "min"
    assert (morph.neutral.vertices == rig.neutral.vertices).all()
    assert not len(morph.bends)
    assert sum(folds_on_the_grid(rig, 0.0)) > 0
    assert sum(folds_on_the_grid(rig, morph.delta)) == 0
    assert row.before > row.after == 0
    assert row.share <= LARGEST * (1 + 1e-9)
    assert row.moved == pytest.approx(np.linalg.norm(morph.delta, axis=1).max())


def test_only_the_first_half_of_a_take_is_looked_at() -> None:
    """Where the two meet in the second half alone, nothing is proposed."""
    frames = [[1, 0]] * 4 + [[1, 1]] * 4
    take = Performance(["a", "b"], np.arange(8) / 30, frames, 30)
    assert fold_correctives(wide_rig(), 3, take) == []


def test_a_corrective_moves_what_is_near_only() -> None:
    rig = wide_rig()
    ((_, morph, _, _),) = fold_correctives(rig, 1)
    far = np.abs(rig.neutral.vertices - rig.neutral.vertices[CENTRE]).max(axis=1) > 12
    assert not morph.delta[far].any()


def test_errors() -> None:
    with pytest.raises(em.ParameterError, match="at least 1, found 0"):
        fold_correctives(wide_rig(), 0)
    points, faces = sheet()
    neutral = Mesh(points, faces)
    one = Rig(neutral, {"a": neutral.with_vertices(points + 1)}, method="linear")
    with pytest.raises(em.ParameterError, match="two sliders or more"):
        fold_correctives(one, 1)
