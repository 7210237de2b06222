"""Bends are eased where polygons would turn over, and nowhere else."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.sparse import csr_array

import elastomorph as em
from elastomorph.bend_curve import BendCurve
from elastomorph.evaluation.shape import ShapeProbe
from elastomorph.rotations import Neighbourhoods
from elastomorph.rotations.folds import without_folds

Sheet = Callable[[int, int], em.Mesh]


def adjacency(mesh: em.Mesh) -> csr_array:
    return Neighbourhoods.of(len(mesh.vertices), mesh.edges).adjacency


def pushed(mesh: em.Mesh, by: float) -> em.Morph:
    """One vertex in the middle is pushed across its neighbours halfway; all rise a little."""
    bends = np.zeros((1, *mesh.vertices.shape))
    bends[0, :, 2] = 0.01
    bends[0, len(mesh.vertices) // 2, 0] = by
    return em.Morph(mesh, mesh, bends, (BendCurve.polynomial([0.0, 4.0, -4.0]),))


def flips(morph: em.Morph) -> list[int]:
    probe = ShapeProbe.of(morph.neutral, morph.target, np.zeros(len(morph.neutral.vertices), int))
    return [probe.flips(morph.at(t)) for t in np.linspace(0, 1, 17)]


def test_a_fold_is_eased_and_what_is_far_keeps_its_bend(sheet: Sheet) -> None:
    mesh = sheet(14, 14)
    morph = pushed(mesh, 2.5)
    assert max(flips(morph)) > 0
    eased = without_folds(morph, adjacency(mesh))
    assert max(flips(eased)) == 0
    shares = eased.bends[0, :, 2] / 0.01
    assert shares.min() <= 0.5
    away = np.linalg.norm(mesh.vertices - mesh.vertices[len(shares) // 2], axis=1)
    np.testing.assert_array_equal(shares[away > 8], 1.0)
    assert (np.abs(np.diff(shares[mesh.edges], axis=1)) < 0.45).all()


def test_a_path_without_folds_is_returned_as_it_is(sheet: Sheet) -> None:
    mesh = sheet(6, 6)
    morph = pushed(mesh, 0.3)
    assert without_folds(morph, adjacency(mesh)) is morph


def test_parts_that_turn_as_a_whole_are_left_alone(sheet: Sheet) -> None:
    mesh = sheet(6, 6)
    morph = pushed(mesh, 2.5)
    assert without_folds(morph, adjacency(mesh), [np.arange(len(mesh.vertices))]) is morph


def test_nothing_bent_or_no_polygons_is_no_fold(sheet: Sheet) -> None:
    mesh = sheet(3, 3)
    straight = em.Morph(mesh, mesh, np.zeros((0, *mesh.vertices.shape)), ())
    assert without_folds(straight, adjacency(mesh)) is straight
    markers = em.Mesh(mesh.vertices)
    morph = pushed(markers, 2.0)
    assert without_folds(morph, adjacency(markers)) is morph
