"""Time laws as functions of B: the same as mode by mode, with the known singular stiffnesses."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from elastomorph.physics import Load, Material, modal_response
from elastomorph.physics.response import rational_laws

positive = st.floats(0.05, 20)


def evaluated(load: Load, material: Material, stiffness: np.ndarray) -> np.ndarray:
    """Σ_j d_rj / Π_{i≤j} (B - β_i) + p_r/p(1), straight from its definition."""
    roots, weights = rational_laws(load, material)
    chain = np.cumprod(1 / (stiffness[:, None] - roots), axis=1)
    return load.limit_law + chain @ weights.T


@settings(max_examples=80, deadline=None)
@given(order=st.integers(1, 6), mass=positive, damping=positive, seed=st.integers(0, 99))
def test_the_partial_sums_are_the_modal_responses(order, mass, damping, seed):
    material = Material(mass, damping, 1)
    random = np.random.default_rng(seed)
    load = Load([*random.uniform(0, 1, order - 1), 1.0])
    stiffness = np.geomspace(1e3, 1e9, 40) * (mass + damping)
    found = evaluated(load, material, stiffness)
    expected = modal_response(stiffness, load, material)
    assert np.abs(found.imag).max() < 1e-9
    assert np.abs(found.real - expected).max() < 1e-9


@pytest.mark.parametrize("damping", [0.3, 1.0, 7.0])
def test_the_quadratic_load_is_singular_at_twice_the_damping(damping):
    roots, weights = rational_laws(Load.power(2), Material(2, damping, 1))
    assert roots == pytest.approx([2 * damping])
    assert weights[1] == pytest.approx([2 * damping])  # B/(B - 2c) = 1 + 2c/(B - 2c)


@pytest.mark.parametrize(("mass", "damping"), [(1.0, 1.0), (0.01, 1.0)])
def test_the_cubic_load_is_singular_where_the_formula_says(mass, damping):
    """B² - 3Bc - 6Bm + 6c² = 0; two real roots or a conjugate pair."""
    m, c = mass, damping
    roots = rational_laws(Load.power(3), Material(m, c, 1))[0]
    assert roots**2 - (3 * c + 6 * m) * roots + 6 * c**2 == pytest.approx(0, abs=1e-10)
    assert roots[0].imag >= 0
    assert roots[1].imag == -roots[0].imag
