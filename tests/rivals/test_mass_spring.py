from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.distance import pdist
from sheets import between, plate_of, turn

import elastomorph as em
from elastomorph.rivals import MassSpring
from elastomorph.rivals.mass_spring import Springs

AXIS = np.array([1.0, 2.0, -0.5])
TIMES = np.array([0.0, 0.25, 0.5, 0.75, 1.0])


def springs_of(mesh: em.Mesh) -> Springs:
    held = np.zeros(len(mesh.vertices), dtype=bool)
    return Springs.between(mesh, held, across=0.5, anchors=8)


def test_springs_go_along_edges_and_to_second_neighbours(sheet: em.Mesh) -> None:
    """In the midst of a grid 4 edges, 4 across the quads and 4 straight on."""
    springs = springs_of(sheet)
    middle = 2 * 6 + 2
    own = springs.pairs[(springs.pairs == middle).any(axis=1)]
    others = own[own != middle] - middle
    assert sorted(others) == sorted([1, -1, 6, -6, 7, 5, -5, -7, 2, -2, 12, -12])
    assert len(np.unique(np.sort(springs.pairs, axis=1), axis=0)) == len(springs.pairs)


def test_what_only_shifts_is_shifted(sheet: em.Mesh) -> None:
    shift = np.array([1.0, -2.0, 0.5])
    found = MassSpring().poses(between(sheet, sheet.vertices + shift), TIMES)
    np.testing.assert_allclose(found, sheet.vertices + TIMES[:, None, None] * shift, atol=1e-9)


def test_a_body_that_turns_stays_rigid(sheet: em.Mesh) -> None:
    """Lengths do not change, so its shape does not, and nothing holds it from turning evenly."""
    centre = sheet.vertices.mean(axis=0)
    arms = sheet.vertices - centre
    end = arms @ turn(AXIS, 1.6).T + centre
    found = MassSpring().poses(between(sheet, end), TIMES)
    for face in found:
        np.testing.assert_allclose(pdist(face), pdist(sheet.vertices), atol=1e-4)
    np.testing.assert_allclose(found[2], arms @ turn(AXIS, 0.8).T + centre, atol=1e-4)


def test_no_energy_at_the_ends_and_ever_less_on_the_way(sheet: em.Mesh) -> None:
    """An equilibrium: what is found has less energy than what is near it."""
    end = sheet.vertices.copy()
    end[12:, 2] += np.linspace(0, 1.0, 24)
    end[12:, 0] *= 1.1
    recording = between(sheet, end)
    found = MassSpring(tolerance=1e-9).poses(recording, TIMES)
    np.testing.assert_allclose(found[[0, -1]], recording.frames, atol=1e-4)
    springs = springs_of(sheet)
    assert springs.energy(found[-1], springs.lengths(end)) < 1e-12
    rest = 0.5 * (springs.lengths(sheet.vertices) + springs.lengths(end))
    least = springs.energy(found[2], rest)
    assert least < springs.energy(0.5 * (sheet.vertices + end), rest)
    rng = np.random.default_rng(0)
    for _ in range(20):
        other = found[2].copy()
        other[12:] += rng.normal(scale=1e-3, size=(24, 3))
        assert least < springs.energy(other, rest)


def test_a_part_that_turns_about_a_hinge_is_held_by_what_stays(sheet: em.Mesh) -> None:
    """It keeps its shape within 1 %, meets its end, and swings out beyond the chord."""
    count = len(sheet.vertices)
    faces = [*sheet.faces, *(np.asarray(face) + count for face in sheet.faces)]
    jaw = sheet.vertices * 0.5 + [0.0, -3.0, 0.0]
    end = jaw @ turn(np.array([1.0, 0.0, 0.0]), 0.8).T
    both = em.Mesh(np.concatenate([sheet.vertices, jaw]), faces)
    target = np.concatenate([sheet.vertices, end])
    found = MassSpring().poses(between(both, target), TIMES)
    assert (found[:, :count] == sheet.vertices).all()
    np.testing.assert_allclose(found[-1], target, atol=1e-3)
    halfway = found[2, count:]
    np.testing.assert_allclose(pdist(halfway), pdist(jaw), rtol=0.01)
    chord = np.linalg.norm(0.5 * (jaw + end).mean(axis=0))
    assert np.linalg.norm(halfway.mean(axis=0)) > chord + 0.05


@pytest.mark.parametrize("moved", [0.0, 1.0])
def test_nothing_or_everything_held(sheet: em.Mesh, moved: float) -> None:
    end = sheet.vertices + [0.0, 0.0, moved]
    found = MassSpring().poses(between(sheet, end), [0.5])
    np.testing.assert_allclose(found[0], sheet.vertices + [0.0, 0.0, moved / 2], atol=1e-9)


@pytest.mark.parametrize("angle", [2.0, 4.0, 5.5])
def test_a_sheet_that_is_rolled_up_reaches_its_target(angle: float) -> None:
    """Held by one row; no lengths are wrong at the target, whatever faces were asked for before."""
    flat = plate_of(7)
    x, y = flat.vertices[:, 0], flat.vertices[:, 1]
    start = flat.with_vertices(np.stack([x, y, 0 * x], axis=1))
    around = (x + 1) * angle / 2
    end = np.stack([2 / angle * np.sin(around) - 1, y, 2 / angle * (1 - np.cos(around))], axis=1)
    recording = between(start, end)
    found = MassSpring().poses(recording, TIMES)
    np.testing.assert_allclose(found[[0, -1]], recording.frames, atol=1e-6)
    np.testing.assert_array_equal(MassSpring().poses(recording, [0.5])[0], found[2])


def test_springs_across_are_half_as_stiff_as_edges() -> None:
    """A strip held at both ends, its middle lifted: two unknowns, minimised by themselves."""
    x, y = np.meshgrid([0.0, 1.0, 2.0], [0.0, 1.0], indexing="ij")
    rest = np.stack([x, y, 0 * x], axis=2).reshape(-1, 3)
    strip = em.Mesh(rest, [[0, 2, 3, 1], [2, 4, 5, 3]])
    lift = np.zeros_like(rest)
    lift[2:4, 2] = 2.0
    found = MassSpring().poses(between(strip, rest + lift), [0.5])[0]

    def lengths(unknown: np.ndarray) -> np.ndarray:
        height, half = unknown
        return np.array(
            [np.hypot(np.hypot(1, height), 0.5 - half), np.hypot(np.hypot(1, height), 0.5 + half)]
        )

    wanted = (lengths(np.array([0.0, 0.5])) + lengths(np.array([2.0, 0.5]))) / 2

    def energy(unknown: np.ndarray, across: float) -> float:
        off = (lengths(unknown) - wanted) ** 2
        return float(4 * off[0] + 4 * across * off[1] + (2 * unknown[1] - 1) ** 2)

    def least(across: float) -> np.ndarray:
        return minimize(
            energy, [1.0, 0.5], (across,), "Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-16}
        ).x

    own = np.array([found[2, 2], (found[3, 1] - found[2, 1]) / 2])
    np.testing.assert_allclose(own, least(0.5), atol=1e-5)
    for other in (0.25, 0.4, 0.6, 1.0):
        assert np.abs(least(other) - own).max() > 1e-3
