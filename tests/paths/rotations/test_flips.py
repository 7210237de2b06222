"""Bends are eased where polygons would turn over, and nowhere else."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import elastomorph as em
from elastomorph.evaluation.shape import ShapeProbe
from elastomorph.model.bend_curve import BendCurve
from elastomorph.paths.rotations import Neighbourhoods
from elastomorph.paths.rotations.flips import without_flips

Sheet = Callable[[int, int], em.Mesh]


def around(mesh: em.Mesh) -> Neighbourhoods:
    return Neighbourhoods.of(len(mesh.vertices), mesh.edges)


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
    eased = without_flips(morph, around(mesh))
    assert max(flips(eased)) == 0
    shares = eased.bends[0, :, 2] / 0.01
    assert shares.min() <= 0.5
    away = np.linalg.norm(mesh.vertices - mesh.vertices[len(shares) // 2], axis=1)
    np.testing.assert_array_equal(shares[away > 8], 1.0)
    assert (np.abs(np.diff(shares[mesh.edges], axis=1)) < 0.45).all()


def test_a_path_without_flips_is_returned_as_it_is(sheet: Sheet) -> None:
    mesh = sheet(6, 6)
    morph = pushed(mesh, 0.3)
    assert without_flips(morph, around(mesh)) is morph


def test_parts_that_turn_as_a_whole_are_left_alone(sheet: Sheet) -> None:
    mesh = sheet(6, 6)
    morph = pushed(mesh, 2.5)
    assert without_flips(morph, around(mesh), [np.arange(len(mesh.vertices))]) is morph


def test_nothing_bent_or_no_polygons_is_no_fold(sheet: Sheet) -> None:
    mesh = sheet(3, 3)
    straight = em.Morph(mesh, mesh, np.zeros((0, *mesh.vertices.shape)), ())
    assert without_flips(straight, around(mesh)) is straight
    markers = em.Mesh(mesh.vertices)
    morph = pushed(markers, 2.0)
    assert without_flips(morph, around(markers)) is morph


def new_folds(morph: em.Morph) -> int:
    """Polygons turned over at one of 63 times and not on the straight line, one by one.

    Written with triangles about the first corner instead of Newell's formula.
    """
    straight = em.interpolate(morph.neutral, morph.target, "linear")
    triangles = [[p[0], p[i], p[i + 1]] for p in morph.neutral.faces for i in range(1, len(p) - 1)]
    owner = np.repeat(np.arange(len(morph.neutral.faces)), morph.neutral.faces.sizes - 2)

    def normals(points: NDArray[np.float64]) -> NDArray[np.float64]:
        a, b, c = points[np.array(triangles)].transpose(1, 0, 2)
        found = np.zeros((len(morph.neutral.faces), 3))
        np.add.at(found, owner, np.cross(b - a, c - a))
        return found

    ends = normals(morph.neutral.vertices), normals(morph.target.vertices)

    def over(points: NDArray[np.float64], least: float) -> NDArray[np.bool_]:
        found = normals(points)
        against = [(found * e).sum(axis=1) / np.maximum((e * e).sum(axis=1), 1e-30) for e in ends]
        return np.maximum(*against) < least

    new = np.zeros(len(morph.neutral.faces), dtype=bool)
    for t in np.arange(1, 64) / 64:
        new |= over(morph.at(t), -1e-9) & ~over(straight.at(t), 1e-9)
    return int(new.sum())


def wild(mesh: em.Mesh, seed: int, size: float) -> em.Morph:
    """Bends that carry a sheet far away as one piece, but for a few vertices.

    Easing those alone leaves a rift between what is carried and what is not.
    """
    rng = np.random.default_rng(seed)
    bends = np.tile(size * rng.normal(size=(2, 1, 3)), (1, len(mesh.vertices), 1))
    few = rng.random(len(mesh.vertices)) < 0.05
    bends[:, few] += 2.0 * rng.normal(size=(2, int(few.sum()), 3))
    target = mesh.with_vertices(mesh.vertices + 0.2 * rng.normal(size=mesh.vertices.shape))
    return em.Morph(mesh, target, bends, (BendCurve.power(2), BendCurve.power(3)))


@given(st.integers(0, 10**6), st.floats(0.5, 30.0))
@settings(max_examples=40, deadline=None)
def test_no_polygon_turns_over_that_does_not_on_the_straight_line(
    sheet: Sheet, seed: int, size: float
) -> None:
    """Not the neighbours of eased vertices either, by independent code at all 63 times."""
    morph = wild(sheet(9, 9), seed, size)
    eased = without_flips(morph, around(morph.neutral))
    assert new_folds(eased) == 0
    shares = eased.bends[0, :, 0] / np.where(morph.bends[0, :, 0] == 0, 1, morph.bends[0, :, 0])
    assert (shares >= 0).all()
    assert (shares <= 1).all()


def test_what_cannot_be_halved_enough_goes_straight(sheet: Sheet) -> None:
    """A bend of 10⁹ edges is still too long after twelve halvings: nothing is left of it."""
    mesh = sheet(9, 9)
    morph = pushed(mesh, 1e9)
    eased = without_flips(morph, around(mesh))
    assert new_folds(eased) == 0
    assert not eased.bends[0, len(mesh.vertices) // 2].any()
    assert eased.bends.any()


def test_polygons_called_safe_do_not_turn_over(sheet: Sheet) -> None:
    """The bound is one: whatever turns over with full bends was looked at."""
    for seed in range(30):
        morph = wild(sheet(9, 9), seed, 0.02 * 1.2**seed)
        unchanged = without_flips(morph, around(morph.neutral)) is morph
        assert unchanged == (new_folds(morph) == 0)
