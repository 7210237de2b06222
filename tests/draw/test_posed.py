"""Weights that run together with one time."""

from __future__ import annotations

import numpy as np
import pytest

from elastomorph.draw.posed import PosedRig, swing, with_paths
from elastomorph.errors import ParameterError
from elastomorph.model.mesh import Mesh
from elastomorph.paths import Method, prepare
from elastomorph.rig import Rig
from elastomorph.rig.timing import by_name, from_keys


@pytest.fixture(scope="module")
def rig() -> Rig:
    """A square whose corners go to different places; c corrects a and b together."""
    neutral = Mesh([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
    steps = np.random.default_rng(1).normal(size=(4, 4, 3))
    to = prepare(neutral, "ease:2")
    morphs = {
        name: to(neutral.with_vertices(neutral.vertices + step))
        for name, step in zip("abcd", steps, strict=True)
    }
    return Rig(neutral, morphs, correctives={"c": ("a", "b")})


def test_every_path_is_at_its_weight_times_t(rig: Rig) -> None:
    posed = PosedRig("", rig, {"a": 0.8, "d": 1.5})
    np.testing.assert_allclose(posed.at(0.5), rig.pose({"a": 0.4, "d": 0.75}))
    np.testing.assert_allclose(posed.at(0.0), rig.neutral.vertices)
    with pytest.raises(ParameterError, match="finite"):
        posed.at(float("nan"))


@pytest.mark.parametrize("sliders", [{"a": 0.7}, {"a": 0.7, "b": 0.4}, {"d": 1.0, "b": 0.2}, {}])
def test_other_paths_to_the_same_targets(rig: Rig, sliders: dict[str, float]) -> None:
    """Straight ones are the sum of weighted displacements; correctives are kept where they act."""
    other = with_paths(rig, Method.parse("linear"), sliders)
    expected = rig.neutral.vertices.copy()
    for name, weight in sliders.items():
        expected += weight * rig.morphs[name].delta
    expected += sliders.get("a", 0) * sliders.get("b", 0) * rig.morphs["c"].delta
    np.testing.assert_allclose(other.pose(sliders), expected, atol=1e-12)
    same = with_paths(rig, Method.parse("ease:2"), sliders)
    np.testing.assert_allclose(same.pose(sliders), rig.pose(sliders), atol=1e-12)
    still = set(rig.morphs) - {*sliders, "c"}
    assert all(other.morphs[name] is rig.morphs[name] for name in still)


def test_unknown_sliders(rig: Rig) -> None:
    with pytest.raises(ParameterError, match="no slider"):
        with_paths(rig, Method.parse("linear"), {"e": 1.0})


def test_there_and_back_is_a_loop() -> None:
    times = swing(8, by_name("linear"))
    np.testing.assert_allclose(times, [0, 0.25, 0.5, 0.75, 1, 0.75, 0.5, 0.25])
    smooth = swing(50, by_name("smoothstep"), 0.6)
    assert smooth[0] == 0
    assert smooth[25] == pytest.approx(0.6)
    np.testing.assert_allclose(smooth[1:], smooth[1:][::-1])
    around = np.diff(np.append(smooth, smooth[0]))
    assert np.abs(around).max() < 0.6 * 1.5 / 25 + 1e-9  # the steepest slope of smoothstep is 3/2
    np.testing.assert_allclose(swing(1, by_name("linear")), [0])


def test_a_timing_that_comes_back_is_played_once() -> None:
    keys = from_keys([(0, 0), (0.25, 1), (1, 0)])
    times = swing(4, keys)
    np.testing.assert_allclose(times, keys.at([0, 0.25, 0.5, 0.75]))
    blink = swing(20, by_name("blink:0.3"))
    assert int(blink.argmax()) == 6
