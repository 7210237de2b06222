"""The numerical solution converges to the closed form: the proof that the closed form is right."""

from __future__ import annotations

import numpy as np
import pytest

from elastomorph.physics import Load, Material
from newmark import CurveProblem, integrate


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
    force = problem.force()
    right = np.tensordot(t ** np.arange(len(force)), force, axes=1)
    np.testing.assert_allclose(left, right, atol=1e-5)
