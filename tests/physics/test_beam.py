"""Beams on curves: exact at every vertex, mode by mode."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from elastomorph.physics import BeamModes, Load, Material, mean_response, modal_response
from elastomorph.physics.beam import ModeTransform

UNIT = Material()


def field(size: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(size, 3))


@given(st.integers(1, 60), st.booleans())
def test_transform_and_back_is_the_identity(size: int, closed: bool) -> None:
    transform = ModeTransform(size, closed)
    values = field(size)
    np.testing.assert_allclose(transform.inverse(transform.forward(values)), values, atol=1e-13)


@pytest.mark.filterwarnings("ignore::elastomorph.errors.TimeLawWarning")
@pytest.mark.parametrize("closed", [True, False])
@pytest.mark.parametrize("closure", ["limit", "rest", "unforced", "compatible", "linear"])
@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_a_single_mode_follows_its_own_law(closed: bool, closure: str, order: int) -> None:
    """A displacement that is one cosine moves as φ_n, the mean as φ₀."""
    size, n = 24, 3
    u = np.arange(size) / size if closed else (np.arange(size) + 0.5) / size
    wave = np.cos((2 if closed else 1) * np.pi * n * u)[:, None] * [1.0, -2.0, 0.5]
    load = Load.power(order)
    modes = BeamModes.prepare([(np.arange(size), closed)], UNIT, load, closure=closure)
    stiffness = ((2 if closed else 1) * np.pi * n) ** 4
    for delta, law in (
        (wave, modal_response(stiffness, load, UNIT)),
        (np.ones((size, 3)), mean_response(closure, load, UNIT)),
    ):
        bends = modes.bends(delta)
        for power, bend in enumerate(bends, start=2):
            expected = (law[power - 1] if power <= len(law) else 0.0) * delta
            np.testing.assert_allclose(bend, expected, atol=1e-12)


def test_dense_matrix_gives_the_same_bends() -> None:
    """The transforms against a solution with the explicit modal matrix of an open curve."""
    size, load = 11, Load([0.3, 0.2, 1.0])
    delta = field(size, 4)
    u = (np.arange(size) + 0.5) / size
    basis = np.cos(np.pi * np.outer(u, np.arange(size)))
    amplitudes = np.linalg.solve(basis, delta)
    laws = np.zeros((size, 3))
    laws[0] = load.limit_law
    laws[1:] = modal_response((np.pi * np.arange(1, size)) ** 4, load, UNIT)
    expected = [basis @ (laws[:, r, None] * amplitudes) for r in (1, 2)]
    found = BeamModes.prepare([(np.arange(size), False)], UNIT, load).bends(delta)
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_no_harmonics_leave_the_limit_law() -> None:
    delta = field(20)
    load = Load.power(3)
    none = BeamModes.prepare([(np.arange(20), True)], UNIT, load, harmonics=0)
    np.testing.assert_allclose(none.bends(delta), [0 * delta, delta], atol=1e-13)


def test_all_harmonics_are_the_default() -> None:
    delta, curve = field(20), [(np.arange(20), True)]
    every = BeamModes.prepare(curve, UNIT, Load.power(3), harmonics=10).bends(delta)
    default = BeamModes.prepare(curve, UNIT, Load.power(3)).bends(delta)
    np.testing.assert_array_equal(every, default)


def test_a_curve_as_long_as_the_face_is_no_stiffer() -> None:
    delta, curve = field(12), [(np.arange(12), False)]
    plain = BeamModes.prepare(curve, UNIT, Load.power(3))
    same = BeamModes.prepare(curve, UNIT, Load.power(3), lengths=np.array([1.0]))
    np.testing.assert_allclose(plain.bends(delta), same.bends(delta), atol=1e-14)


def test_half_the_length_is_sixteen_times_the_rigidity() -> None:
    delta, curve = field(12), [(np.arange(12), False)]
    short = BeamModes.prepare(curve, UNIT, Load.power(3), lengths=np.array([0.5]))
    stiff = BeamModes.prepare(curve, Material(rigidity=16), Load.power(3))
    np.testing.assert_allclose(short.bends(delta), stiff.bends(delta), atol=1e-14)


def test_vertices_on_no_curve_follow_the_limit_law() -> None:
    delta = field(10)
    modes = BeamModes.prepare([(np.arange(5), False)], UNIT, Load.power(2))
    np.testing.assert_array_equal(modes.bends(delta)[0, 5:], delta[5:])


def test_fourier_basis_treats_an_open_curve_as_closed() -> None:
    delta = field(9)
    open_curve = BeamModes.prepare([(np.arange(9), False)], UNIT, Load.power(2), basis="fourier")
    closed = BeamModes.prepare([(np.arange(9), True)], UNIT, Load.power(2))
    np.testing.assert_array_equal(open_curve.bends(delta), closed.bends(delta))


def test_curves_of_different_sizes_do_not_mix() -> None:
    """Many curves at once move as each alone."""
    sizes = [(4, True), (7, False), (7, True), (1, False), (4, True)]
    order = np.random.default_rng(1).permutation(sum(size for size, _ in sizes))
    curves, start = [], 0
    for size, closed in sizes:
        curves.append((order[start : start + size], closed))
        start += size
    delta = field(start)
    together = BeamModes.prepare(curves, UNIT, Load.power(3)).bends(delta)
    for vertices, closed in curves:
        own = BeamModes.prepare([(np.arange(len(vertices)), closed)], UNIT, Load.power(3))
        np.testing.assert_allclose(together[:, vertices], own.bends(delta[vertices]), atol=1e-13)
