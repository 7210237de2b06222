"""Materials, loads and the guard against resonance."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from elastomorph.errors import ElastomorphError, ParameterError, ResonanceError, TimeLawWarning
from elastomorph.physics import Load, Material, mean_response, modal_response
from elastomorph.physics.beam import mode_stiffness
from elastomorph.physics.response import excursion, guard_laws

MODES = [("closed curves", mode_stiffness(np.arange(1, 40), True, 1.0))]


@pytest.mark.parametrize("name", ["mass", "damping", "rigidity"])
@pytest.mark.parametrize("value", [0, -1, float("nan"), float("inf"), "1", None, True])
def test_material_constants_must_be_positive(name: str, value: object) -> None:
    with pytest.raises(ParameterError, match=name):
        Material(**{name: value})  # type: ignore[arg-type]


@pytest.mark.parametrize("order", [0, -2, 1.5, 21, True, float("nan"), "2"])
def test_order_must_be_a_whole_number_from_one(order: object) -> None:
    with pytest.raises(ParameterError, match="order R"):
        Load.power(order)  # type: ignore[arg-type]


@pytest.mark.parametrize("coefficients", [[], [0, 0], [1, -1], [float("inf")], ["x"], [0] * 30])
def test_loads_that_cannot_tell_the_ends_apart_are_refused(coefficients: list[object]) -> None:
    with pytest.raises(ParameterError):
        Load(coefficients)  # type: ignore[arg-type]


def test_power_load() -> None:
    assert Load.power(3).coefficients == (0.0, 0.0, 1.0)
    assert Load([0, 2, 0, 0]).order == 2
    np.testing.assert_array_equal(Load([1, 3]).limit_law, [0.25, 0.75])


def test_excursion_of_hand_made_laws() -> None:
    """t stays in range; t² too; 2t - t² too; 3t - 2t² peaks at 9/8; 4t² - 3t dips to -9/16."""
    laws = np.array([[1, 0], [0, 1], [2, -1], [3, -2], [-3, 4]], dtype=float)
    np.testing.assert_allclose(excursion(laws), [0, 0, 0, 1 / 8, 9 / 16], atol=2e-4)


@pytest.mark.parametrize("offset", [0.0, 1e-9, 1e-3, -1e-3])
def test_quadratic_resonance_is_at_twice_the_damping(offset: float) -> None:
    """B₁ = 2c: refused at the singularity and close to it, with a damping that works."""
    damping = MODES[0][1][0] / 2 * (1 + offset)
    with pytest.raises(ResonanceError, match="mode 1 of the closed curves") as caught:
        guard_laws(MODES, "limit", Load.power(2), Material(1, damping, 1))
    assert caught.value.mode == 1
    assert caught.value.stiffness == pytest.approx(16 * np.pi**4)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        guard_laws(MODES, "limit", Load.power(2), Material(1, caught.value.safe_damping, 1))


def test_cubic_resonance_is_at_the_root_of_its_denominator() -> None:
    """B² - 3Bc - 6Bm + 6c² = 0, solved for m at c = 1 and B = B₁."""
    b = float(MODES[0][1][0])
    mass = (b**2 - 3 * b + 6) / (6 * b)
    with pytest.raises(ResonanceError) as caught:
        guard_laws([("open curves", MODES[0][1][:1])], "limit", Load.power(3), Material(mass, 1, 1))
    assert caught.value.mode == 1
    safe = Material(mass, caught.value.safe_damping, 1)
    assert excursion(modal_response(b, Load.power(3), safe)) <= 0.01


def test_the_safe_damping_is_safe_for_every_mode() -> None:
    """A mass at the cubic resonance of mode 2 leaves mode 1 astray as well."""
    b = float(MODES[0][1][1])
    mass = (b**2 - 3 * b + 6) / (6 * b)
    with pytest.raises(ResonanceError) as caught:
        guard_laws(MODES, "limit", Load.power(3), Material(mass, 1, 1))
    assert caught.value.mode == 2
    safe = Material(mass, caught.value.safe_damping, 1)
    assert excursion(modal_response(MODES[0][1], Load.power(3), safe)).max() <= 0.01


def test_without_a_safe_damping_the_message_says_what_else_to_change() -> None:
    """At B = 6m the cubic law is singular for any small damping; a safe one is out of reach."""
    modes = [("open curves", np.array([6e12]))]
    with pytest.raises(ResonanceError, match="change the mass, the rigidity") as caught:
        guard_laws(modes, "limit", Load.power(3), Material(1e12, 1, 1))
    assert np.isnan(caught.value.safe_damping)


@pytest.mark.parametrize(("closure", "order", "damping"), [("unforced", 1, 2.0), ("rest", 2, 3.0)])
def test_resonance_of_the_mean(closure: str, order: int, damping: float) -> None:
    with pytest.raises(ResonanceError, match="mode 0") as caught:
        guard_laws(MODES, closure, Load.power(order), Material(1, damping, 1))
    safe = Material(1, caught.value.safe_damping, 1)
    assert excursion(mean_response(closure, Load.power(order), safe)) <= 0.01


def test_overshoot_is_warned_of() -> None:
    """At c = 0.2 B₁ the quadratic law of mode 1 dips by c²/(B(B - 2c)) = 6.7 %."""
    b = float(MODES[0][1][0])
    with pytest.warns(TimeLawWarning, match=r"mode 1 .*6\.[67]"):
        guard_laws(MODES, "limit", Load.power(2), Material(1, 0.2 * b, 1))


@pytest.mark.parametrize("share", [0.3, 0.47, 0.53, 0.6])
def test_the_warning_names_a_damping_that_is_better_and_good_enough(share: float) -> None:
    """On both sides of the resonance at c = B₁/2: beyond it, a smaller damping would be worse."""
    b = float(MODES[0][1][0])

    def dip(damping: float) -> float:
        law = modal_response(MODES[0][1], Load.power(2), Material(1, damping, 1))
        return float(excursion(law).max())

    with pytest.warns(TimeLawWarning, match="nearest safe damping is") as caught:
        guard_laws(MODES, "limit", Load.power(2), Material(1, share * b, 1))
    named = float(str(caught[0].message).rsplit(" ", 1)[1])
    assert dip(named) <= 0.01 < dip(share * b)
    # One that is nearer by more than a step of the search is not good enough.
    assert dip(named + 0.1 * (share * b - named)) > 0.01


def test_a_load_that_overshoots_by_itself_needs_no_warning() -> None:
    load = Load([3, -2])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        guard_laws(MODES, "limit", load, Material())


@settings(max_examples=60)
@given(
    st.floats(1e-3, 1e4),
    st.floats(1e-3, 1e4),
    st.integers(1, 6),
    st.sampled_from(["unforced", "rest", "compatible", "linear", "limit"]),
)
def test_every_material_is_solved_or_refused(m: float, c: float, order: int, closure: str) -> None:
    """What passes the guard stays within ten times the way to the target."""
    material, load = Material(m, c, 1.0), Load.power(order)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", TimeLawWarning)
        try:
            guard_laws(MODES, closure, load, material)
        except ElastomorphError:
            return
    laws = modal_response(MODES[0][1], load, material)
    assert np.isfinite(laws).all()
    assert excursion(laws).max() <= 10
