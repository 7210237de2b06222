"""Numerical solutions converge to the closed form: the proof that the closed form is right."""

from __future__ import annotations

import numpy as np
import pytest
from sheets import between

import elastomorph as em
from elastomorph.physics import Load, Material
from elastomorph.rivals import FiniteDifference, FiniteElement
from elastomorph.rivals.stepped_beams import (
    CurveProblem,
    by_differences,
    by_elements,
    integrate,
    newmark,
)


def smooth_problem(size: int, closed: bool, load: Load, closure: str = "limit") -> CurveProblem:
    """One fixed pair of smooth curves, sampled at any number of vertices."""
    u = (np.arange(size) / size if closed else (np.arange(size) + 0.5) / size)[:, None]
    turn = np.pi * (2 if closed else 1) * u
    start = np.concatenate([np.cos(turn), np.sin(turn) if closed else np.cos(2 * turn), u * 0], 1)
    delta = np.concatenate(
        [0.4 + 0.2 * np.cos(turn), 0.3 * np.cos(2 * turn), 0.1 - 0.25 * np.cos(turn)], 1
    )
    return CurveProblem(start, start + delta, closed, Material(0.8, 1.2, 0.01), load, closure)


def error(size: int, steps: int, closed: bool, load: Load, closure: str = "limit") -> float:
    problem = smooth_problem(size, closed, load, closure)
    exact = problem.solution(np.linspace(0, 1, steps + 1))
    return float(np.abs(integrate(problem, steps) - exact).max())


@pytest.mark.parametrize("closed", [True, False])
@pytest.mark.parametrize("load", [Load.power(1), Load.power(2), Load.power(3), Load([1, 0, 0, 2])])
def test_converges_at_second_order(closed: bool, load: Load) -> None:
    """Halving both steps divides the error by four."""
    errors = np.array([error(n, 2 * n, closed, load) for n in (24, 48, 96, 192)])
    orders = np.log2(errors[:-1] / errors[1:])
    assert orders[-1] == pytest.approx(2.0, abs=0.1)
    assert errors[-1] < 2e-3


@pytest.mark.parametrize("closure", ["unforced", "rest", "linear", "compatible"])
def test_converges_for_every_closure(closure: str) -> None:
    errors = [error(n, 2 * n, True, Load.power(2), closure) for n in (48, 96)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.15)


@pytest.mark.parametrize("closed", [True, False])
def test_closed_form_starts_and_ends_at_the_shapes(closed: bool) -> None:
    problem = smooth_problem(15, closed, Load.power(3))
    ends = problem.solution(np.array([0.0, 1.0]))
    np.testing.assert_allclose(ends, [problem.start, problem.end], atol=1e-13)


def test_force_balances_the_equation_of_motion_at_any_time() -> None:
    """Differences of the closed form in time, its own modes in u: m ẅ + c ẇ + k w⁗ = f."""
    problem = smooth_problem(16, True, Load.power(3))
    m, c, k = problem.material.mass, problem.material.damping, problem.material.rigidity
    t, h = 0.37, 1e-3
    before, now, after = problem.solution(np.array([t - h, t, t + h]))
    transform = problem.transform
    elastic = transform.inverse(transform.stiffness(k)[:, None] * transform.forward(now))
    left = m * (after - 2 * now + before) / h**2 + c * (after - before) / (2 * h) + elastic
    force = np.stack([transform.inverse(modes) for modes in problem.force()])
    right = np.tensordot(t ** np.arange(len(force)), force, axes=1)
    np.testing.assert_allclose(left, right, atol=1e-5)


def one_mode(size: int, mode: int, closed: bool, order: int) -> CurveProblem:
    """A straight line that bends into one wave."""
    u = (np.arange(size) + (0.0 if closed else 0.5)) / size
    wave = np.cos(np.pi * (2 if closed else 1) * mode * u)[:, None]
    return CurveProblem(
        np.zeros_like(wave), wave, closed, Material(0.8, 1.2, 0.01), Load.power(order)
    )


def element_error(problem: CurveProblem, steps: int) -> float:
    exact = problem.solution(np.linspace(0, 1, steps + 1))
    found = newmark(by_elements(problem), problem.material, steps)
    return float(np.abs(np.stack([each.place for each in found]) - exact).max())


@pytest.mark.usefixtures("skfem")
@pytest.mark.parametrize("closed", [True, False])
@pytest.mark.parametrize("mode", [1, 2, 3])
@pytest.mark.parametrize("order", [2, 3])
def test_elements_converge_mode_by_mode_at_fourth_order_in_u(
    closed: bool, mode: int, order: int
) -> None:
    """Steps in t shrink as the square of those in u, so that both errors fall as h⁴."""
    sizes = [8 * mode, 16 * mode, 32 * mode]
    errors = [
        element_error(one_mode(size, mode, closed, order), (size // mode) ** 2 // 2)
        for size in sizes
    ]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert orders[-1] == pytest.approx(4.0, abs=0.3), errors
    assert errors[-1] < 1e-4


@pytest.mark.usefixtures("skfem")
@pytest.mark.parametrize("closed", [True, False])
def test_elements_converge_at_second_order_in_t(closed: bool) -> None:
    problem = smooth_problem(96, closed, Load.power(3))
    errors = [element_error(problem, steps) for steps in (8, 16, 32)]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert orders[-1] == pytest.approx(2.0, abs=0.1), errors


@pytest.mark.usefixtures("skfem")
@pytest.mark.parametrize("closed", [True, False])
def test_elements_have_the_frequencies_of_a_beam(closed: bool) -> None:
    """Generalised eigenvalues of both matrices are (nπ)⁴, of closed curves (2nπ)⁴ twice."""
    from scipy.linalg import eigh

    discrete = by_elements(one_mode(24, 1, closed, 2))
    found = eigh(discrete.elastic.toarray(), discrete.mass.toarray(), eigvals_only=True)
    numbers = np.array([1, 1, 2, 2]) * 2 if closed else np.array([1, 2, 3, 4])
    np.testing.assert_allclose(found[1:5], 0.01 * (numbers * np.pi) ** 4, rtol=2e-5)
    assert abs(found[0]) < 1e-6


@pytest.mark.parametrize("closed", [True, False])
def test_points_between_vertices_lie_on_the_curve(closed: bool) -> None:
    """The series through them goes through the vertices, and its closed form is the same."""
    problem = smooth_problem(12, closed, Load.power(2))
    finer = by_differences(problem, 3)
    np.testing.assert_allclose(finer.start[finer.shown], problem.start, atol=1e-12)
    velocity = problem.transform.inverse(problem.initial_velocity())
    np.testing.assert_allclose(finer.velocity[finer.shown], velocity, atol=1e-12)


@pytest.mark.usefixtures("skfem")
@pytest.mark.parametrize("rival", [FiniteDifference(), FiniteElement()], ids=lambda r: r.name)
def test_a_face_comes_out_as_the_closed_form_has_it(
    rival: FiniteDifference | FiniteElement, sheet: em.Mesh
) -> None:
    """Within 1 % of what moves, vertices on no curve and times between steps too."""
    x, y = sheet.vertices[:, 0], sheet.vertices[:, 1]
    end = sheet.vertices + np.stack([0 * x, 0 * x, np.cos(x) * np.cos(2 * y)], axis=1)
    every = em.extract_curves(sheet)
    some = every.restricted(np.concatenate([every[i].vertices for i in range(4)]))
    times = np.array([0.0, 0.123, 0.5, 1.0])
    for curves in (every, some):
        morph = em.interpolate(sheet, sheet.with_vertices(end), "beam:2", curves=curves)
        found = rival.poses(between(sheet, end), times, curves)
        np.testing.assert_allclose(found, morph.at(times), atol=1e-2)
        assert (found[0] == sheet.vertices).all()
