"""The closed-form time laws against the differential equation they solve."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp
from hypothesis import assume, given
from hypothesis import strategies as st

from elastomorph.errors import ParameterError
from elastomorph.physics import CLOSURES, Load, Material, mean_response, modal_response

T = sp.Symbol("t")
UNIT = Material()


def exact_modal_law(order: int, b: sp.Expr, m: sp.Expr, c: sp.Expr, load: sp.Expr) -> sp.Expr:
    """φ found by undetermined coefficients, without the recurrence: the independent computation."""
    e0, e1 = sp.symbols("e0 e1")
    unknowns = sp.symbols(f"g1:{order + 1}")
    law = sum(g * T ** (r + 1) for r, g in enumerate(unknowns))
    residual = sp.expand(m * sp.diff(law, T, 2) + c * sp.diff(law, T) + b * law - e0 - e1 * load)
    equations = [*sp.Poly(residual, T).coeffs(), law.subs(T, 1) - 1]
    solution = sp.solve(equations, [*unknowns, e0, e1], dict=True)
    assert len(solution) == 1
    return sp.expand(law.subs(solution[0]))


@pytest.mark.parametrize("order", range(1, 7))
def test_modal_law_solves_the_equation_of_motion(order: int) -> None:
    """m φ″ + c φ′ + B φ is a constant plus a multiple of t^R, for symbols m, c, B."""
    m, c, b = sp.symbols("m c B", positive=True)
    law = exact_modal_law(order, b, m, c, T**order)
    values = {m: sp.Rational(3, 2), c: sp.Rational(2, 5), b: sp.Integer(70)}
    expected = sp.Poly(law.subs(values), T).all_coeffs()[::-1][1:]
    found = modal_response(70.0, Load.power(order), Material(1.5, 0.4, 1.0))
    np.testing.assert_allclose(found, [float(e) for e in expected], rtol=1e-12)


@pytest.mark.parametrize("order", [1, 2, 3, 5])
@pytest.mark.parametrize("closure", sorted(CLOSURES))
def test_which_closures_solve_the_equation_of_the_mean(closure: str, order: int) -> None:
    """Eq. 8 has a force e0 + e1 t^R: m φ″ + c φ′ has no other power, but of `limit` for R > 1."""
    law = np.concatenate([[0.0], mean_response(closure, Load.power(order), Material(0.7, 1.9, 1))])
    polynomial = np.polynomial.Polynomial(law)
    force = (0.7 * polynomial.deriv(2) + 1.9 * polynomial.deriv()).coef
    others = np.delete(force, [power for power in (0, order) if power < len(force)])
    assert (np.abs(others).max(initial=0.0) < 1e-12) == (closure != "limit" or order == 1)


@given(
    m=st.floats(0.01, 50),
    c=st.floats(0.01, 50),
    b=st.floats(200, 1e9),
    p=st.lists(st.floats(0.1, 3), min_size=1, max_size=8),
)
def test_any_load_leaves_no_other_power_of_time(
    m: float, c: float, b: float, p: list[float]
) -> None:
    """m φ″ + c φ′ + B φ - λ p(t) is constant for one λ: the residual has no power of t left."""
    material, load = Material(m, c, 1.0), Load(p)
    law = np.concatenate([[0.0], modal_response(b, load, material)])
    assume(np.isfinite(law).all() and np.abs(law).sum() < 1e6)
    polynomial = np.polynomial.Polynomial(law)
    force = m * polynomial.deriv(2) + c * polynomial.deriv() + b * polynomial
    coefficients = np.zeros(len(p) + 1)
    coefficients[: len(force.coef)] = force.coef
    factor = coefficients[-1] / p[-1]
    rest = coefficients[1:] - factor * np.array(p)
    assert np.abs(rest).max() <= 1e-9 * np.abs(coefficients).max()
    assert law.sum() == pytest.approx(1.0, abs=1e-9 * np.abs(law).sum())


def test_table_of_the_first_harmonic() -> None:
    """The laws for R = 1, 2, 3 in closed form, at B₁ = 16π⁴."""
    b, m, c = 16 * np.pi**4, 1.0, 1.0
    np.testing.assert_array_equal(modal_response(b, Load.power(1), UNIT), [1.0])
    np.testing.assert_allclose(
        modal_response(b, Load.power(2), UNIT), np.array([-2 * c, b]) / (b - 2 * c), rtol=1e-14
    )
    np.testing.assert_allclose(
        modal_response(b, Load.power(3), UNIT),
        np.array([6 * c**2 - 6 * b * m, -3 * b * c, b**2])
        / (b**2 - 3 * b * c - 6 * b * m + 6 * c**2),
        rtol=1e-14,
    )
    np.testing.assert_allclose(
        modal_response(b, Load.power(2), UNIT), [-0.0012849, 1.0012849], atol=5e-8
    )
    np.testing.assert_allclose(
        modal_response(b, Load.power(3), UNIT), [-0.00386961, -0.00193605, 1.00580566], atol=5e-9
    )


def test_quadratic_law_does_not_depend_on_the_mass() -> None:
    laws = [modal_response(300.0, Load.power(2), Material(m, 1, 1)) for m in (0.1, 1, 10)]
    np.testing.assert_allclose(laws[0], laws[1], rtol=1e-14)
    np.testing.assert_allclose(laws[0], laws[2], rtol=1e-14)


@pytest.mark.parametrize("order", range(1, 7))
def test_limits_of_stiffness(order: int) -> None:
    """φ → t^R for B → ∞ and φ → t for B → 0, without overflow on the way."""
    load = Load.power(order)
    stiff = modal_response([1e15, np.inf], load, UNIT)
    np.testing.assert_allclose(stiff, [load.limit_law] * 2, atol=1e-12)
    soft = modal_response([1e-12, 1e-300], load, UNIT)
    np.testing.assert_allclose(soft, [[1.0] + [0.0] * (order - 1)] * 2, atol=1e-9)


@given(st.floats(0.1, 10), st.floats(0.1, 10), st.floats(0.1, 10), st.floats(0.01, 100))
def test_only_ratios_of_the_material_matter(m: float, c: float, k: float, s: float) -> None:
    """Scaling m, c and k together changes nothing."""
    load = Load.power(3)
    one = modal_response(1000 * k, load, Material(m, c, k))
    other = modal_response(1000 * k * s, load, Material(m * s, c * s, k * s))
    np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(
    ("closure", "expected"),
    [
        ("unforced", [["2", "-1"], ["3/2", "-3/4", "1/4"], ["8/5", "-4/5", "4/15", "-1/15"]]),
        ("rest", [["0", "1"], ["0", "3/2", "-1/2"], ["0", "4/3", "-4/9", "1/9"]]),
        ("linear", [["1", "0"], ["1", "0", "0"], ["1", "0", "0", "0"]]),
        ("limit", [["1", "0"], ["0", "1", "0"], ["0", "0", "1", "0"]]),
    ],
)
def test_means_at_unit_material(closure: str, expected: list[list[str]]) -> None:
    """The table of closures, as exact fractions."""
    for order, row in enumerate(expected, start=1):
        found = mean_response(closure, Load.power(order), UNIT)
        np.testing.assert_allclose(found, [float(sp.Rational(e)) for e in row], atol=1e-14)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
@pytest.mark.parametrize("closure", ["unforced", "rest", "compatible", "linear"])
def test_mean_solves_its_equation(order: int, closure: str) -> None:
    """m φ₀″ + c φ₀′ is a constant plus a multiple of t^R."""
    m, c = 0.7, 1.9
    law = np.polynomial.Polynomial(
        [0.0, *mean_response(closure, Load.power(order), Material(m, c, 1.0))]
    )
    force = m * law.deriv(2) + c * law.deriv()
    middle = force.coef[1:order]
    np.testing.assert_allclose(middle, 0.0, atol=1e-11)
    assert law(1.0) == pytest.approx(1.0, abs=1e-12)
    if closure == "rest":
        assert law.deriv()(0.0) == 0.0
    if closure == "unforced":
        assert force.coef[0] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_compatible_mean_is_the_nearest_of_its_family(order: int) -> None:
    """Exact minimisation over b₁ with symbols gives the same law."""
    m, c = sp.Rational(3, 4), sp.Rational(5, 4)
    b = {order + 2: sp.Integer(0)}
    for r in range(order, 0, -1):
        p = 1 if r == order else 0
        b[r + 1] = (p - m * (r + 2) * (r + 1) * b.get(r + 2, 0)) / (c * (r + 1))
    free = sp.Symbol("b1")
    numerator = free * T + sum(b[r] * T**r for r in range(2, order + 2))
    law = numerator / numerator.subs(T, 1)
    distance = sp.integrate(sp.expand((law - T**order) ** 2), (T, 0, 1))
    found = mean_response("compatible", Load.power(order), Material(0.75, 1.25, 1.0))
    if order == 1:
        np.testing.assert_allclose(found, [1.0, 0.0], atol=1e-14)
        return
    stationary = sp.solve(sp.cancel(sp.together(sp.diff(distance, free))), free)
    best = min(stationary, key=lambda s: float(distance.subs(free, s)))
    expected = sp.Poly(sp.expand(law.subs(free, best)), T).all_coeffs()[::-1][1:]
    np.testing.assert_allclose(found, [float(e) for e in expected], rtol=1e-10)


def test_compatible_means_of_the_table() -> None:
    """The printed coefficients at m = c = 1."""
    rows = {
        1: [1, 0],
        2: [-0.3125, 1.96875, -0.65625],
        3: [-0.71924, 2.29232, -0.764107, 0.191027],
    }
    for order, row in rows.items():
        found = mean_response("compatible", Load.power(order), UNIT)
        np.testing.assert_allclose(found, row, atol=5e-6)


def test_unknown_closure_is_refused_with_the_known_ones() -> None:
    with pytest.raises(ParameterError, match="unforced, rest, linear, compatible, limit"):
        mean_response("free", Load.power(2), UNIT)
    assert len(CLOSURES) == 5
