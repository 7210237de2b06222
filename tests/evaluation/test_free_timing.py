"""Free timing: what each frame picks, and that no order of moments leaves a smaller error."""

from __future__ import annotations

import itertools
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from elastomorph.curves import Curve, CurveNetwork
from elastomorph.errors import ParameterError
from elastomorph.evaluation.curve_errors import (
    CurveVertices,
    curve_errors,
    free_timing,
    least_in_order,
)
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence

SEEDS = st.integers(0, 2**32 - 1)


def fields(neutral: Mesh, count: int, seed: int) -> NDArray[np.float64]:
    """(count, V, 3) random displacements."""
    return np.random.default_rng(seed).normal(size=(count, *neutral.vertices.shape))


def powers(count: int) -> tuple[BendCurve, ...]:
    """The bend curves t² - t, t³ - t and so on."""
    return tuple(BendCurve.power(k) for k in range(2, count + 2))


def timed(
    morph: Morph,
    frames: NDArray[np.float64],
    curves: list[list[int]] | None = None,
    measure: str = "lme",
) -> NDArray[np.float64]:
    """Free timing along curves, by default one through all vertices."""
    along = vertices_of(morph, curves)
    return free_timing(morph, MeshSequence(morph.neutral, frames), along, measure)


def vertices_of(morph: Morph, curves: list[list[int]] | None) -> CurveVertices:
    count = len(morph.neutral.vertices)
    chosen = [Curve(curve) for curve in ([list(range(count))] if curves is None else curves)]
    return CurveVertices.of(CurveNetwork(chosen, count), count)


def errors(
    morph: Morph, frames: NDArray[np.float64], moments: NDArray[np.float64], along: CurveVertices
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(T,) largest mean of a curve and (T,) largest distance, frame by frame."""
    pairs = [
        curve_errors(morph.at(float(t)), f, along, 1.0)
        for t, f in zip(moments, frames, strict=True)
    ]
    average, maximum = zip(*((a.max(), m.max()) for a, m in pairs), strict=True)
    return np.array(average), np.array(maximum)


@settings(max_examples=40, deadline=None)
@given(seed=SEEDS, bends=st.integers(0, 3), frames=st.integers(2, 12))
def test_a_truth_on_the_path_is_found_at_its_own_times(
    neutral: Mesh, target: Mesh, seed: int, bends: int, frames: int
) -> None:
    """Played at any monotone time warp, a path is followed exactly."""
    rng = np.random.default_rng(seed)
    morph = Morph(neutral, target, fields(neutral, bends, seed), powers(bends))
    warp = np.concatenate([[0.0], np.sort(rng.random(frames - 2)), [1.0]])
    found = timed(morph, morph.at(warp))
    np.testing.assert_allclose(found, warp, atol=1e-9)
    assert np.abs(morph.at(found) - morph.at(warp)).max() < 1e-9


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e4])
@pytest.mark.parametrize("law", [BendCurve.power(3), BendCurve.polynomial([0, -0.5, 0, 0.5])])
def test_a_straight_line_at_another_pace_is_found(
    neutral: Mesh, target: Mesh, law: BendCurve, size: float
) -> None:
    """The line from neutral to target at any law has the path of linear, whatever the unit."""
    small, large = (mesh.with_vertices(size * mesh.vertices) for mesh in (neutral, target))
    times = np.linspace(0, 1, 9)
    delta = large.vertices - small.vertices
    linear = Morph(small, large, np.zeros((0, *delta.shape)), ())
    eased = Morph(small, large, delta[None], (law,))
    expected = times + law(times)
    np.testing.assert_allclose(timed(linear, eased.at(times)), expected, atol=1e-9)
    np.testing.assert_allclose(timed(eased, linear.at(expected)), times, atol=1e-8)


@settings(max_examples=100, deadline=None)
@given(seed=SEEDS)
def test_on_a_straight_line_the_least_largest_error_has_a_closed_form(
    neutral: Mesh, target: Mesh, seed: int
) -> None:
    """On V₀ + tΔ a frame at s is |t - s|·max‖Δ_v‖ away from t.

    Two frames in the wrong order, s_i > s_j, meet halfway at best; a frame beyond an end is as far
    away as it is beyond.
    """
    morph = Morph(neutral, target, np.zeros((0, *neutral.vertices.shape)), ())
    wanted = np.random.default_rng(seed).uniform(-0.2, 1.2, size=8)
    frames = morph.at(np.concatenate([[0.0], wanted, [1.0]]))
    found = timed(morph, frames)
    turned = max(max(wanted[: j + 1]) - wanted[j] for j in range(8)) / 2
    least = max(turned, (wanted - 1).max(), (-wanted).max(), 0.0)
    longest = np.linalg.norm(morph.delta, axis=1).max()
    _, maximum = errors(morph, frames, found, vertices_of(morph, None))
    assert maximum.max() == pytest.approx(longest * least, rel=1e-9, abs=1e-9)
    assert (np.diff(found) >= 0).all()
    assert found[0] == 0
    assert found[-1] == 1


ROWS = [[0, 1, 2, 3, 4], [5, 6, 7], [8, 9, 10, 11, 12, 13], [14]]


@settings(max_examples=15, deadline=None)
@given(seed=SEEDS)
@pytest.mark.parametrize(("measure", "which"), [("lae", 0), ("lme", 1)])
def test_no_order_of_moments_on_a_grid_is_better(
    curved: Morph, seed: int, measure: str, which: int
) -> None:
    """Brute force over every rising triple of 41 moments, for the largest and then the sum."""
    rng = np.random.default_rng(seed)
    frames = curved.at([0.0, *rng.random(3), 1.0])
    frames[1:-1] += 0.5 * fields(curved.neutral, 3, seed)
    along = vertices_of(curved, ROWS)
    grid = np.linspace(0, 1, 41)
    costs = np.array(
        [errors(curved, np.repeat(f[None], 41, axis=0), grid, along)[which] for f in frames[1:-1]]
    )

    def judged(order: tuple[int, ...]) -> tuple[float, float]:
        own = costs[np.arange(3), list(order)]
        return float(own.max()), float(own.sum())

    brute = min(map(judged, itertools.combinations_with_replacement(range(41), 3)))
    on_grid = least_in_order(np.broadcast_to(grid, (3, 41)), costs)
    chosen = np.searchsorted(grid, on_grid)
    assert (np.diff(chosen) >= 0).all()
    assert judged(tuple(chosen)) == pytest.approx(brute, rel=1e-12)
    found = timed(curved, frames, ROWS, measure)
    assert (np.diff(found) >= 0).all()
    assert errors(curved, frames, found, along)[which].max() <= brute[0] * (1 + 1e-9)


@settings(max_examples=40, deadline=None)
@given(seed=SEEDS, bends=st.integers(0, 3), noise=st.sampled_from([0.0, 0.01, 1.0]))
@pytest.mark.parametrize(("measure", "which"), [("lae", 0), ("lme", 1)])
def test_it_is_never_worse_than_the_recorded_times(
    neutral: Mesh, target: Mesh, seed: int, bends: int, noise: float, measure: str, which: int
) -> None:
    """They are one order of moments of many, whatever the path and the frames."""
    rng = np.random.default_rng(seed)
    morph = Morph(neutral, target, fields(neutral, bends, seed), powers(bends))
    frames = morph.at(np.concatenate([[0.0], np.sort(rng.random(7)), [1.0]]))
    frames[1:-1] += noise * rng.normal(size=frames[1:-1].shape)
    along, recorded = vertices_of(morph, ROWS), np.linspace(0, 1, 9)
    found = timed(morph, frames, ROWS, measure)
    free, fixed = (errors(morph, frames, when, along)[which] for when in (found, recorded))
    assert free.max() <= fixed.max() * (1 + 1e-12)
    assert (np.diff(found) >= 0).all()


@pytest.mark.parametrize(("measure", "which"), [("lae", 0), ("lme", 1)])
@pytest.mark.parametrize("seed", range(5))
def test_witnesses_stand_for_all_vertices(
    curved: Morph, monkeypatch: pytest.MonkeyPatch, seed: int, measure: str, which: int
) -> None:
    """Looking at a few vertices first leads to the same errors as looking at all at once."""
    frames = curved.at(np.linspace(0, 1, 9) ** 2)
    frames[1:-1] += 0.3 * fields(curved.neutral, 7, seed)
    along = vertices_of(curved, ROWS)
    every, some = [], []
    for few, found in ((10**6, every), (0, some)):
        monkeypatch.setattr(sys.modules[free_timing.__module__], "_FEW", few)
        own = errors(curved, frames, timed(curved, frames, ROWS, measure), along)[which]
        found += [own.max(), own.sum()]
    assert some == pytest.approx(every, rel=1e-6)


def test_an_unknown_measure(curved: Morph) -> None:
    with pytest.raises(ParameterError, match="lme, lae, found 'mean'"):
        timed(curved, curved.at([0.0, 0.5, 1.0]), measure="mean")


def test_only_the_vertices_named_count(curved: Morph) -> None:
    """A vertex that is not on a curve may be anywhere."""
    warp = np.array([0.0, 0.1, 0.7, 1.0])
    frames = curved.at(warp)
    frames[1:-1, 10:] += 50.0
    np.testing.assert_allclose(timed(curved, frames, [list(range(10))]), warp, atol=1e-9)


def test_a_path_that_turns_back_is_searched_globally(neutral: Mesh, target: Mesh) -> None:
    """On a path that overshoots and returns, the frames pick the branch that keeps their order."""
    delta = target.vertices - neutral.vertices
    # s(t) = t + 3(t - t²) passes 0.9 on the way out, turns at 4/3 and comes back to 1.
    morph = Morph(neutral, target, delta[None], (BendCurve.polynomial([0, 3, -3]),))
    frames = morph.at([0.0, 0.4, 0.6, 0.9, 1.0])
    found = timed(morph, frames)
    np.testing.assert_allclose(morph.at(found), frames, atol=1e-9)
    assert (np.diff(found) >= 0).all()


def test_a_motion_without_motion_has_some_timing(neutral: Mesh) -> None:
    """Where nothing moves every moment is as good as another."""
    still = Morph(neutral, neutral, np.zeros((0, *neutral.vertices.shape)), ())
    found = timed(still, np.repeat(neutral.vertices[None], 4, axis=0))
    assert found[0] == 0
    assert found[-1] == 1
    assert (np.diff(found) >= 0).all()
