"""Free timing: what each frame picks, and that no better order of moments exists."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from elastomorph.bend_curve import BendCurve
from elastomorph.evaluation.timing import best_in_order, free_timing
from elastomorph.mesh import Mesh
from elastomorph.morph import Morph

SEEDS = st.integers(0, 2**32 - 1)


def fields(neutral: Mesh, count: int, seed: int) -> NDArray[np.float64]:
    """(count, V, 3) random displacements."""
    return np.random.default_rng(seed).normal(size=(count, *neutral.vertices.shape))


def powers(count: int) -> tuple[BendCurve, ...]:
    """The bend curves t² - t, t³ - t and so on."""
    return tuple(BendCurve.power(k) for k in range(2, count + 2))


def everything(morph: Morph) -> NDArray[np.int64]:
    return np.arange(len(morph.neutral.vertices))


@settings(max_examples=40, deadline=None)
@given(seed=SEEDS, bends=st.integers(0, 3), frames=st.integers(2, 12))
def test_a_truth_on_the_path_is_found_at_its_own_times(
    neutral: Mesh, target: Mesh, seed: int, bends: int, frames: int
) -> None:
    """Played at any monotone time warp, a path is followed exactly."""
    rng = np.random.default_rng(seed)
    morph = Morph(neutral, target, fields(neutral, bends, seed), powers(bends))
    warp = np.concatenate([[0.0], np.sort(rng.random(frames - 2)), [1.0]])
    found = free_timing(morph, morph.at(warp), everything(morph))
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
    np.testing.assert_allclose(
        free_timing(linear, eased.at(times), everything(linear)), expected, atol=1e-9
    )
    np.testing.assert_allclose(
        free_timing(eased, linear.at(expected), everything(linear)), times, atol=1e-8
    )


def monotone_regression(wanted: NDArray[np.float64]) -> NDArray[np.float64]:
    """The least-squares rising fit by its minimax formula: max over j ≤ i of min over k ≥ i."""
    count = len(wanted)
    return np.array(
        [
            max(min(wanted[j : k + 1].mean() for k in range(i, count)) for j in range(i + 1))
            for i in range(count)
        ]
    )


@settings(max_examples=100, deadline=None)
@given(seed=SEEDS)
def test_on_a_straight_line_it_is_monotone_regression(
    neutral: Mesh, target: Mesh, seed: int
) -> None:
    """On V₀ + tΔ the squared distance is ‖Δ‖²(t - s)², so the best order has a closed form."""
    rng = np.random.default_rng(seed)
    morph = Morph(neutral, target, np.zeros((0, *neutral.vertices.shape)), ())
    wanted = rng.uniform(-0.2, 1.2, size=8)
    positions = morph.at(np.concatenate([[0.0], wanted, [1.0]]))
    noise = fields(neutral, 10, seed)  # orthogonal to the path: must not matter
    direction = morph.delta / np.linalg.norm(morph.delta)
    noise -= np.einsum("tvi,vi->t", noise, direction)[:, None, None] * direction
    noise[[0, -1]] = 0
    found = free_timing(morph, positions + noise, everything(morph))
    expected = np.clip(monotone_regression(wanted), 0, 1)
    # Where frames share a moment the cost is above 0, and near its minimum flat to half the digits.
    np.testing.assert_allclose(found[1:-1], expected, atol=1e-7)
    assert (np.diff(found) >= 0).all()
    assert found[0] == 0
    assert found[-1] == 1


@settings(max_examples=15, deadline=None)
@given(seed=SEEDS)
def test_no_order_of_moments_on_a_grid_is_better(neutral: Mesh, curved: Morph, seed: int) -> None:
    """Brute force over every rising triple of 41 moments costs at least as much."""
    rng = np.random.default_rng(seed)
    frames = curved.at([0.0, *rng.random(3), 1.0]) + 0.5 * fields(neutral, 5, seed)
    grid = np.linspace(0, 1, 41)
    path = curved.at(grid)
    costs = np.array([((path - frame) ** 2).sum(axis=(1, 2)) for frame in frames[1:-1]])
    brute = min(
        sum(costs[i, j] for i, j in enumerate(order))
        for order in itertools.combinations_with_replacement(range(41), 3)
    )
    on_grid = best_in_order(np.broadcast_to(grid, (3, 41)), costs)
    chosen = np.searchsorted(grid, on_grid)
    assert (np.diff(chosen) >= 0).all()
    assert costs[np.arange(3), chosen].sum() == pytest.approx(brute, rel=1e-12)
    found = free_timing(curved, frames, everything(curved))
    assert (np.diff(found) >= 0).all()
    own = ((curved.at(found) - frames)[1:-1] ** 2).sum()
    assert own <= brute * (1 + 1e-9)


def test_only_the_vertices_named_count(curved: Morph) -> None:
    """A vertex that is not on a curve may be anywhere."""
    warp = np.array([0.0, 0.1, 0.7, 1.0])
    frames = curved.at(warp)
    frames[1:-1, 10:] += 50.0
    np.testing.assert_allclose(free_timing(curved, frames, np.arange(10)), warp, atol=1e-9)


def test_a_path_that_turns_back_is_searched_globally(neutral: Mesh, target: Mesh) -> None:
    """On a path that overshoots and returns, the frames pick the branch that keeps their order."""
    delta = target.vertices - neutral.vertices
    # s(t) = t + 3(t - t²) passes 0.9 on the way out, turns at 4/3 and comes back to 1.
    morph = Morph(neutral, target, delta[None], (BendCurve.polynomial([0, 3, -3]),))
    frames = morph.at([0.0, 0.4, 0.6, 0.9, 1.0])
    found = free_timing(morph, frames, everything(morph))
    np.testing.assert_allclose(morph.at(found), frames, atol=1e-9)
    assert (np.diff(found) >= 0).all()


def test_a_motion_without_motion_has_some_timing(neutral: Mesh) -> None:
    """Where nothing moves every moment is as good as another."""
    still = Morph(neutral, neutral, np.zeros((0, *neutral.vertices.shape)), ())
    found = free_timing(still, np.repeat(neutral.vertices[None], 4, axis=0), everything(still))
    assert found[0] == 0
    assert found[-1] == 1
    assert (np.diff(found) >= 0).all()
