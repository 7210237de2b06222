"""A rig poses, blends and batches the same faces."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import elastomorph as em
from elastomorph.rig import Rig

weights_of_three = arrays(np.float64, 3, elements=st.floats(-1.5, 1.5))


def named(row: np.ndarray) -> dict[str, float]:
    return dict(zip("abc", row.tolist(), strict=True))


@given(row=weights_of_three)
def test_pose_is_the_sum_of_the_paths(small: Rig, row: np.ndarray) -> None:
    start = small.neutral.vertices
    expected = start + sum(small.morphs[name].at(t) - start for name, t in named(row).items())
    np.testing.assert_allclose(small.pose(named(row)), expected, atol=1e-13)


@given(row=weights_of_three, t=st.floats(-0.5, 1.5))
def test_blend_is_the_weighted_sum_of_the_paths(small: Rig, row: np.ndarray, t: float) -> None:
    start = small.neutral.vertices
    expected = start + sum(
        zeta * (small.morphs[name].at(t) - start) for name, zeta in named(row).items()
    )
    np.testing.assert_allclose(small.blend(named(row), t), expected, atol=1e-12)


@given(rows=arrays(np.float64, (4, 3), elements=st.floats(-1, 1)))
def test_batch_is_pose_and_blend_row_by_row(small: Rig, rows: np.ndarray) -> None:
    times = np.array([0.1, 0.6, 1.0, 1.3])
    posed = small.batch(rows, dtype=np.float64)
    blended = small.batch(rows, times, dtype=np.float64)
    own = small.batch(rows, np.tile(times[:, None], 3), dtype=np.float64)
    np.testing.assert_allclose(blended, own, rtol=0, atol=1e-13)
    for i, row in enumerate(rows):
        np.testing.assert_allclose(posed[i], small.pose(named(row)), atol=1e-12)
        np.testing.assert_allclose(blended[i], small.blend(named(row), times[i]), atol=1e-12)


def test_equal_weights_of_sum_one_are_equation_38(small: Rig) -> None:
    """With Σζ = 1, Σ ζ_j w^j(t) is the same as V₀ + Σ ζ_j (w^j(t) - V₀)."""
    zeta = {"a": 0.2, "b": 0.5, "c": 0.3}
    plain = sum(w * small.morphs[name].at(0.4) for name, w in zeta.items())
    np.testing.assert_allclose(small.blend(zeta, 0.4), plain, atol=1e-13)
    larger = {name: 3 * w for name, w in zeta.items()}
    np.testing.assert_allclose(small.blend(larger, 0.4, normalize=True), plain, atol=1e-13)
    rows = np.array([[0.6, 1.5, 0.9], [0.02, 0.05, 0.03]])
    faces = small.batch(rows, 0.4, normalize=True, dtype=np.float64)
    np.testing.assert_allclose(faces, [plain, plain], atol=1e-13)


@pytest.mark.parametrize("row", [[0, 0, 0], [0.5, -0.5, 0], [0.1, 0.2, -0.3]])
def test_weights_without_a_sum_cannot_be_normalized(small: Rig, row: list[float]) -> None:
    """The last sum is 5.6e-17 in floating point: weights divided by it are nobody's wish."""
    with pytest.raises(em.ParameterError, match="the weights sum to 0"):
        small.blend(dict(zip("abc", row, strict=True)), 0.4, normalize=True)
    with pytest.raises(em.ParameterError, match="the weights of face 1 sum to 0"):
        small.batch(np.array([[1, 2, 3], row]), 0.4, normalize=True)


def test_each_expression_may_have_its_own_time(small: Rig) -> None:
    start = small.neutral.vertices
    expected = (
        start
        + 0.5 * (small.morphs["a"].at(0.2) - start)
        + 0.7 * (small.morphs["c"].at(1.0) - start)
    )
    np.testing.assert_allclose(small.blend({"a": 0.5, "c": 0.7}, {"a": 0.2}), expected, atol=1e-13)


def test_default_batch_is_float32_into_the_buffer(rig: Rig) -> None:
    rows = np.random.default_rng(0).random((3, 5))
    out = np.empty((3, *rig.neutral.vertices.shape), dtype=np.float32)
    assert rig.batch(rows, 0.5, out) is out
    exact = rig.batch(rows, 0.5, dtype=np.float64)
    assert np.abs(out - exact).max() < 1e-6 * rig.neutral.diameter
    np.testing.assert_array_equal(out, rig.batch(rows, 0.5))


def test_only_what_moves_is_stored(small: Rig) -> None:
    """Runs from the first to the last vertex moved; far ones are runs of their own."""
    runs = [[(s.start, s.fields.shape[1]) for s in m.spans] for m in small.fields.morphs]
    assert runs == [[(0, 10)], [(2, 6)], [(4, 5)]]
    assert len(small.fields.matrix(np.float32)) == 1 + 9
    far = em.Mesh(np.zeros((2000, 3)))
    moved = far.vertices.copy()
    moved[[3, 5, 1500]] = 1
    target = far.with_vertices(moved)
    rig = Rig(far, {"a": em.interpolate(far, target, "linear")})
    assert [(s.start, s.fields.shape[1]) for s in rig.fields.morphs[0].spans] == [(3, 3), (1500, 1)]
    np.testing.assert_array_equal(rig.pose({"a": 1.0}), moved)


@settings(max_examples=20)
@given(count=st.integers(0, 23), block=st.integers(1, 9))
def test_stream_is_batch_in_pieces(small: Rig, count: int, block: int) -> None:
    rows = np.random.default_rng(count).random((count, 3))
    times = np.linspace(0, 1, count)
    pieces = [part.copy() for part in small.stream(rows, times, block=block)]
    assert all(len(part) == block for part in pieces[:-1])
    whole = small.batch(rows, times)
    np.testing.assert_allclose(np.concatenate([*pieces, whole[:0]]), whole, atol=1e-6)


def test_velocity_is_the_derivative_of_the_pose(small: Rig) -> None:
    at, rates, h = {"a": 0.3, "c": 0.8}, {"a": 2.0, "b": 1.0, "c": -0.5}, 1e-6

    def pose(s: float) -> np.ndarray:
        return small.pose({n: at.get(n, 0) + s * rate for n, rate in rates.items()})

    numerical = (pose(h) - pose(-h)) / (2 * h)
    np.testing.assert_allclose(small.velocity(at, rates), numerical, atol=1e-6)


class TestCorrectives:
    """A corrective's weight is the product of the weights of its drivers."""

    @pytest.fixture
    def driven(self, small: Rig) -> Rig:
        return Rig(small.neutral, small.morphs, correctives={"c": ("a", "b")})

    def test_has_no_slider(self, driven: Rig) -> None:
        assert driven.names == ("a", "b")
        with pytest.raises(em.ParameterError, match="no slider 'c'"):
            driven.pose({"c": 1})

    def test_product(self, driven: Rig, small: Rig) -> None:
        for a, b in ((0.0, 1.0), (0.5, 0.6), (1.0, 1.0)):
            np.testing.assert_allclose(
                driven.pose({"a": a, "b": b}),
                small.pose({"a": a, "b": b, "c": a * b}),
                atol=1e-14,
            )
            np.testing.assert_allclose(
                driven.batch(np.array([[a, b]]), 0.7, dtype=np.float64)[0],
                small.blend({"a": a, "b": b, "c": a * b}, 0.7),
                atol=1e-13,
            )

    def test_slider_of_its_own(self, small: Rig) -> None:
        on_top = Rig(small.neutral, small.morphs, correctives={"c": ("a", "c")})
        assert on_top.names == ("a", "b", "c")
        np.testing.assert_allclose(
            on_top.pose({"a": 0.5, "c": 0.8}), small.pose({"a": 0.5, "c": 0.4}), atol=1e-14
        )

    def test_velocity(self, driven: Rig) -> None:
        at, rates, h = {"a": 0.3, "b": 0.8}, {"a": 1.0, "b": -2.0}, 1e-6
        numerical = (
            driven.pose({n: at[n] + h * rates[n] for n in at})
            - driven.pose({n: at[n] - h * rates[n] for n in at})
        ) / (2 * h)
        np.testing.assert_allclose(driven.velocity(at, rates), numerical, atol=1e-6)

    @pytest.mark.parametrize(
        ("correctives", "message"),
        [
            ({"c": ()}, "no drivers"),
            ({"c": ("a", "x")}, "no slider 'x'"),
            ({"d": ("a",)}, "no slider 'd'"),
            ({"c": ("a",), "b": ("c",)}, "corrective itself"),
        ],
    )
    def test_mistakes(self, small: Rig, correctives: dict, message: str) -> None:
        with pytest.raises(em.ParameterError, match=message):
            Rig(small.neutral, small.morphs, correctives=correctives)


class TestMistakes:
    """One clear error each."""

    def test_unknown_name_suggests_the_nearest(self, rig: Rig) -> None:
        with pytest.raises(em.ParameterError, match="did you mean 'grinning'"):
            rig.pose({"grining": 1})

    @pytest.mark.parametrize("weight", [np.nan, np.inf, "much", None])
    def test_weights_that_are_not_numbers(self, small: Rig, weight: object) -> None:
        with pytest.raises(em.ParameterError, match="'a'"):
            small.pose({"a": weight})  # type: ignore[dict-item]

    @pytest.mark.parametrize(
        ("weights", "times", "message"),
        [
            (np.zeros((2, 4)), 0.5, r"shape \(S, 3\)"),
            (np.zeros(3), 0.5, "shape"),
            (np.full((2, 3), np.nan), 0.5, "row 0"),
            (np.zeros((2, 3)), np.nan, "nan"),
            (np.zeros((2, 3)), [0.1, 0.2, 0.3], "times must be"),
            (np.zeros((2, 3)), np.zeros((2, 2)), "times"),
            ([["x", 0, 0]], 0.5, "numbers"),
        ],
    )
    def test_arrays(self, small: Rig, weights: object, times: object, message: str) -> None:
        with pytest.raises(em.ParameterError, match=message):
            small.batch(weights, times)  # type: ignore[arg-type]

    @pytest.mark.parametrize(
        "out",
        [
            np.empty((2, 10, 3), dtype=np.int32),
            np.empty((3, 10, 3), dtype=np.float32),
            np.empty((2, 3, 10), dtype=np.float32).transpose(0, 2, 1),
            np.broadcast_to(np.zeros((1, 10, 3), dtype=np.float32), (2, 10, 3)),
            [[0.0]],
        ],
    )
    def test_buffers(self, small: Rig, out: object) -> None:
        with pytest.raises(em.ParameterError, match="out must"):
            small.batch(np.zeros((2, 3)), 0.5, out)  # type: ignore[arg-type]

    def test_morphs_of_another_face(self, small: Rig, rig: Rig) -> None:
        with pytest.raises(em.TopologyError):
            Rig(small.neutral, {"sad": rig.morphs["sad"]})
        moved = small.neutral.with_vertices(small.neutral.vertices + 1)
        with pytest.raises(em.ParameterError, match="another neutral"):
            Rig(moved, small.morphs)

    def test_halves_and_blocks(self, small: Rig) -> None:
        with pytest.raises(em.ParameterError, match="float32 or float64"):
            small.batch(np.zeros((1, 3)), 0.5, dtype=np.float16)
        with pytest.raises(em.ParameterError, match="block"):
            next(small.stream(np.zeros((1, 3)), 0.5, block=0))
