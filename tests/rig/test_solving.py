"""Handles come to their positions, by the sliders that are needed, on the bent paths."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.optimize import least_squares

import elastomorph as em
from elastomorph.rig import Rig
from elastomorph.rig.handles import HandledPoints, asked
from elastomorph.rig.tracking import Box, nearest

EVERY = range(10)


def everywhere(face: np.ndarray) -> dict:
    return {int(vertex): face[vertex] for vertex in EVERY}


@pytest.fixture(scope="module")
def driven(small: Rig) -> Rig:
    """The small rig with c on top of a and b, by a slider of its own."""
    return Rig(small.neutral, small.morphs, correctives={"c": ("a", "b", "c")})


@pytest.fixture(scope="module")
def wide(many: Callable[[int, float, float], Rig]) -> Rig:
    """Thirty vertices and twelve gently bent morphs."""
    return many(12, 1.0, 0.3)


@given(row=arrays(np.float64, 3, elements=st.floats(0, 1)))
def test_handled_points_are_those_of_the_pose(driven: Rig, row: np.ndarray) -> None:
    mix, _ = asked({3: (0, 0, 0), ((7, 4), (0.25, 0.75)): (0, 0, 0)}, None, 10)
    face = driven.pose(row)
    positions = HandledPoints.of(driven, mix).at(row).positions
    np.testing.assert_allclose(positions, [face[3], 0.25 * face[7] + 0.75 * face[4]], atol=1e-13)


@given(row=arrays(np.float64, 3, elements=st.floats(-0.5, 1.5)))
def test_rates_are_the_velocity(driven: Rig, row: np.ndarray) -> None:
    mix, _ = asked(dict.fromkeys(EVERY, (0, 0, 0)), None, 10)
    rates = HandledPoints.of(driven, mix).at(row).rates
    for column, direction in zip(rates.T, np.eye(3), strict=True):
        expected = driven.velocity(row, direction)
        np.testing.assert_allclose(column.reshape(-1, 3), expected, atol=1e-12)


@pytest.mark.parametrize("time", [-0.3, 0.0, 0.2, 0.5, 0.75, 1.0, 1.4])
def test_derivatives_of_a_bend_curve(time: float) -> None:
    curve = em.BendCurve([0.0, 0.5, 1.0], [[0.0, 1.0, 2.0, -1.0], [0.875, 0.0, -3.5, 0.0]])
    value, slope, second = curve.derivatives_at(time)
    assert value == pytest.approx(curve(time))
    assert slope == pytest.approx(curve.slope(time))
    step = 1e-6
    inside = 0 <= time < 1
    ahead = (curve.slope(time + step) - curve.slope(time)) / step
    assert not inside or second == pytest.approx(ahead, abs=1e-4)
    assert 0 <= time <= 1 or second == 0


@pytest.mark.parametrize("count", [1, 3, 12])
def test_weights_are_found_again(wide: Rig, count: int) -> None:
    random = np.random.default_rng(count)
    row = np.zeros(12)
    row[random.choice(12, count, replace=False)] = random.uniform(0.1, 1, count)
    face = wide.pose(row)
    solved = wide.solve({v: face[v] for v in range(20)})
    np.testing.assert_allclose(list(solved.weights.values()), row, atol=1e-5)
    assert solved.reached
    assert f"20 of 20 handles reached; m{np.flatnonzero(row)[0]} " in str(solved)


def test_weights_of_a_corrective_are_found_again(driven: Rig) -> None:
    weights = {"a": 0.8, "b": 0.5, "c": 0.7}
    solved = driven.solve(everywhere(driven.pose(weights)), {"a": 0.5, "b": 0.5, "c": 0.5})
    assert solved.weights == pytest.approx(weights, abs=1e-5)


def test_noise_moves_weights_no_more_than_least_squares_says(wide: Rig) -> None:
    """Within four standard deviations of the Gauss-Markov covariance σ² (JᵀJ)⁻¹."""
    random = np.random.default_rng(2)
    row, noise = random.uniform(0.3, 0.7, 12), 0.01
    face = wide.pose(row)
    mix, _ = asked(dict.fromkeys(range(20), (0, 0, 0)), None, 30)
    rates = HandledPoints.of(wide, mix).at(row).rates
    deviation = noise * np.sqrt(np.linalg.inv(rates.T @ rates).diagonal())
    for _ in range(5):
        noisy = face + random.normal(scale=noise, size=face.shape)
        found = np.array(list(wide.solve({v: noisy[v] for v in range(20)}).weights.values()))
        assert (np.abs(found - row) < 4 * deviation).all()


def test_the_bent_rig_is_nearer_than_the_straight_one_where_the_truth_is_bent(wide: Rig) -> None:
    straight = Rig(wide.neutral, {n: m.target for n, m in wide.morphs.items()}, method="linear")
    face = wide.pose(np.full(12, 0.5))
    handles = {v: face[v] for v in range(20)}
    bent, linear = wide.solve(handles), straight.solve(handles)
    assert np.abs(wide.pose(bent.weights) - face).max() < 1e-4
    assert np.abs(straight.pose(linear.weights) - face).max() > 0.1
    assert not linear.reached


@pytest.mark.parametrize("handles", [1, 10])
def test_paths_without_speed_at_rest_are_left(small: Rig, handles: int) -> None:
    """V0 + t² Δ is 0.49 Δ away at t = 0.7, and goes nowhere at t = 0."""
    slow = em.BendCurve.power(2)
    eased = {
        name: em.Morph(small.neutral, morph.target, morph.delta[None], (slow,))
        for name, morph in small.morphs.items()
    }
    rig = Rig(small.neutral, eased)
    goals = small.neutral.vertices + 0.49 * small["a"].delta
    solved = rig.solve({vertex: goals[vertex] for vertex in (0, *range(10))[:handles]})
    assert solved.reached
    assert solved.weights == pytest.approx({"a": 0.7, "b": 0.0, "c": 0.0}, abs=2e-3)


def test_what_is_not_needed_stays_where_it_was(small: Rig) -> None:
    face = small.pose({"a": 0.6})
    at_rest = small.solve(everywhere(face))
    assert at_rest.weights["b"] == at_rest.weights["c"] == 0.0
    # Vertices 2 and 7 belong to a and b alone (7 to c too), so c keeps its place exactly.
    start = {"a": 0.0, "b": 0.0, "c": 0.3}
    face = small.pose({"a": 0.6, "c": 0.3})
    solved = small.solve({2: face[2], 3: face[3]}, start)
    assert solved.weights == pytest.approx({"a": 0.6, "b": 0.0, "c": 0.3}, abs=1e-5)
    assert solved.weights["c"] == 0.3


def test_nothing_moves_where_handles_are_already(small: Rig) -> None:
    start = {"a": 0.2, "b": 0.9, "c": 0.0}
    solved = small.solve(everywhere(small.pose(start)), start)
    assert solved.weights == start
    assert max(solved.distances.values()) < 1e-12
    assert str(small.solve({0: small.neutral.vertices[0]})).endswith("every slider at 0")


def test_an_unreachable_handle_ends_nearest_and_says_so(small: Rig) -> None:
    """Vertex 2 of a alone, pulled far along Δ: the slider stops at its bound."""
    only = small.only(["b"])
    delta = only["b"].delta[2]
    goal = only["b"].target.vertices[2] + 3.0 * delta
    solved = only.solve({2: goal})
    assert solved.weights == {"b": 1.0}
    assert solved.distances[2] == pytest.approx(3.0 * np.linalg.norm(delta))
    assert not solved.reached
    assert str(solved).startswith("0 of 1 handles reached, 2 left ")


def test_contradictory_handles_share_what_is_left(small: Rig) -> None:
    place = small.pose({"b": 0.5})[2]
    apart = np.array([0.0, 0.0, 1e-3])
    both = {2: place + apart, ((2, 5), (1.0, 0.0)): place - apart}
    solved = small.solve(both, {"b": 0.5}, bounds={"b": (0.5, 0.5), "a": (0, 0), "c": (0, 0)})
    assert list(solved.distances.values()) == pytest.approx([1e-3, 1e-3])
    assert solved.weights == {"a": 0.0, "b": 0.5, "c": 0.0}


def test_bounds_by_name_and_for_all(small: Rig) -> None:
    handles = everywhere(small.pose({"a": 0.9, "b": -0.2}))
    free = small.solve(handles, bounds=(-1, 1))
    assert free.weights == pytest.approx({"a": 0.9, "b": -0.2, "c": 0.0}, abs=1e-5)
    held = small.solve(handles, {"a": 0.9}, bounds={"a": (0, 0.4)})
    assert 0 <= held.weights["a"] <= 0.4
    assert held.weights["b"] == 0.0


def test_landmarks_are_places_with_names(small: Rig) -> None:
    face = small.pose({"a": 0.5})
    between = ((1, 3, 6), (0.2, 0.3, 0.5))
    named = small.solve(
        {"chin": face[0], "lip": face[[1, 3, 6]].T @ between[1]},
        landmarks={"chin": 0, "lip": between, "nose": 4},
    )
    assert named.weights == pytest.approx({"a": 0.5, "b": 0, "c": 0}, abs=1e-5)
    assert set(named.distances) == {"chin", "lip"}


def test_a_rig_without_sliders_says_how_far_handles_are(small: Rig) -> None:
    solved = Rig(small.neutral, {}).solve({0: small.neutral.vertices[0] + [0, 0, 2]})
    assert (solved.weights, solved.distances) == ({}, {0: pytest.approx(2.0)})


@settings(max_examples=60)
@example(seed=2988, prior=1.0)
@given(seed=st.integers(0, 10_000), prior=st.sampled_from([0.0, 0.1, 1.0]))
def test_nearest_is_no_farther_than_a_general_solver(seed: int, prior: float) -> None:
    """Of linear residuals the problem is convex: as good as splitting x into x⁺ - x⁻ in SciPy.

    Where residuals are to be fine; else the search ends where little of the cost is to be won.
    """
    random = np.random.default_rng(seed)
    count = int(random.integers(1, 8))
    rows, goal = random.normal(size=(2, count + 2, count))
    goal = goal[:, 0]
    low, high = -random.random(count), random.random(count)
    start = np.clip(random.normal(size=count) * 0.3, low, high)
    assume((low < start).all() and (start < high).all())
    box = Box(low, high, start, prior, 1e-9, fine=1e-4)
    found = nearest(lambda x: (rows @ x - goal, rows, np.zeros((count, count))), box, start)
    assert ((low <= found) & (found <= high)).all()

    def cost(x: np.ndarray) -> float:
        return 0.5 * float(np.square(rows @ x - goal).sum()) + box.cost(x)

    # 2·prior·u = (√(2·prior·u))², so the prior is a residual of u, v ≥ 0.
    def residuals(parts: np.ndarray) -> np.ndarray:
        up, down = np.split(parts, 2)
        return np.concatenate(
            [rows @ (start + up - down) - goal, np.sqrt(2 * prior * parts + 1e-18)]
        )

    most = np.concatenate([high - start, start - low])
    other = least_squares(residuals, 0.5 * most, bounds=(0 * most, most)).x
    up, down = np.split(other, 2)
    assert cost(found) <= cost(start + up - down) + 1e-7


def test_least_sums_at_the_end_of_a_curved_way_are_found_in_few_looks() -> None:
    """y = (1 - x)² is reached by many; x + y is least where its derivative 1 - 2(1 - x) is 0.

    Straight steps leave the curve: without a correction they must be so short that there are forty.
    """
    looks = 0

    def residuals(at: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        nonlocal looks
        looks += 1
        left = (1 - at[0]) ** 2 - at[1]
        rates = np.array([[-2 * (1 - at[0]), -1.0]])
        return np.array([left]), rates, np.diag([max(2 * left, 0.0), 0.0])

    box = Box(np.zeros(2), np.ones(2), np.zeros(2), prior=1e-4, ridge=1e-12)
    found = nearest(residuals, box, np.array([0.05, 0.9]))
    np.testing.assert_allclose(found, [0.5, 0.25], atol=2e-3)
    assert looks <= 12


def test_damping_is_raised_ever_more_while_steps_fail() -> None:
    """Tenfold, then by ten times more each time: from far out on an arc tangent, where they do.

    With damping λ of the one diagonal element a step is that of Gauss and Newton over 1 + λ.
    """
    start, tried = 20.0, list[float]()

    def residuals(x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        tried.append(float(x[0]))
        return np.arctan(x), np.diag(1 / (1 + x**2)), np.zeros((1, 1))

    wide = np.array([1e6])
    found = nearest(residuals, Box(-wide, wide, np.zeros(1), 0.0, 0.0), np.array([start]))
    assert abs(found[0]) < 1e-6
    full = -np.arctan(start) * (1 + start**2)
    # After a step that fails, its correction is tried.
    steps = np.array(tried[1::2][:5]) - start
    damping = full / steps - 1
    expected = 1e-8 * 10.0 ** np.cumsum(range(5))
    np.testing.assert_allclose(damping[2:], expected[2:], rtol=1e-3)
