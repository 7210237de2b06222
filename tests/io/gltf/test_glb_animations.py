"""Animations follow the paths between their keys, and performances the rig."""

from __future__ import annotations

import numpy as np
import pytest
from glb_samples import rigs, triangle_rig
from hypothesis import given, settings
from hypothesis import strategies as st

from elastomorph import timing
from elastomorph.errors import ParameterError
from elastomorph.io.gltf.morph_targets import MorphTargets
from elastomorph.io.gltf.writer import performance_clip, slider_clips
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.paths.through import LAWS, through
from elastomorph.rig import Rig


def drawn_positions(rig: Rig, targets: MorphTargets, weights: np.ndarray) -> np.ndarray:
    """What a viewer draws: the neutral plus every morph target times its weight."""
    position = rig.neutral.vertices.copy()
    for morph, kept in zip(rig.morphs.values(), targets.morphs, strict=True):
        for place, field in enumerate(kept.fields(morph)):
            position += weights[kept.first + place] * field
    return position


@given(rig=rigs(), tolerance=st.sampled_from([1e-2, 1e-3, 1e-4]))
@settings(max_examples=60, deadline=None)
def test_between_keys_the_path_is_followed_within_the_tolerance(rig: Rig, tolerance: float) -> None:
    targets = MorphTargets.of(rig, 0)
    clips = slider_clips(rig, targets, tolerance, 30)
    pairs = zip(rig.morphs, targets.morphs, strict=True)
    assert [clip.name for clip in clips] == [name for name, kept in pairs if kept.whole]
    for clip in clips:
        morph = rig.morphs[clip.name]
        assert clip.key_error <= tolerance or len(clip.times) > 2000
        for t in np.linspace(0, 1, 37):
            weights = [np.interp(t, clip.times, column) for column in clip.weights.T]
            away = drawn_positions(rig, targets, np.array(weights)) - morph.at(t)
            allowed = (max(clip.key_error, 1e-6) * 1.001 + 1e-6) * (rig.neutral.diameter or 1)
            assert np.linalg.norm(away, axis=1).max() <= allowed


def test_a_straight_path_needs_two_keys_and_a_parabola_as_many_as_its_curvature_asks() -> None:
    """t² - t leaves its chords by h²/4; with displacement s·D that is s·h²/4 of D."""
    rig = triangle_rig()
    size = np.sqrt(0.5) / rig.neutral.diameter
    targets = MorphTargets.of(rig, 0)
    for tolerance in (1e-2, 1e-3, 1e-4):
        clip = slider_clips(rig, targets, tolerance, 1000)[0]
        step = 2 * np.sqrt(tolerance / size)
        assert np.diff(clip.times).max() <= step * 1.0001
        assert len(clip.times) <= np.ceil(1 / (step - 1e-3)) + 1
    flat, up = rig.neutral, rig.morphs["lift"].target
    straight = Rig(flat, {"lift": Morph(flat, up, np.zeros((0, 3, 3)), ())})
    clip = slider_clips(straight, MorphTargets.of(straight, 0), 1e-9, 30)[0]
    assert clip.times.tolist() == [0, 1]
    assert clip.weights.tolist() == [[0], [1]]


def test_keys_lie_on_frames_while_these_suffice_and_on_parts_of_frames_beyond() -> None:
    rig = triangle_rig()
    targets = MorphTargets.of(rig, 0)
    for tolerance, finest in ((1e-3, 25), (2e-5, 100)):
        clip = slider_clips(rig, targets, tolerance, 25)[0]
        frames = clip.times.astype(float) * finest
        np.testing.assert_allclose(frames, np.round(frames), atol=1e-4)
        assert clip.key_error <= tolerance


@given(rig=rigs(), seed=st.integers(0, 99))
@settings(max_examples=60, deadline=None)
def test_a_performance_is_drawn_as_the_rig_poses_it(rig: Rig, seed: int) -> None:
    """Also outside [0, 1], and with correctives."""
    weights = np.random.default_rng(seed).uniform(-0.5, 1.5, size=(4, len(rig.names)))
    targets = MorphTargets.of(rig, 0)
    clip = performance_clip(rig, targets, [0, 0.1, 0.2, 5], weights, "take")
    assert clip.times.tolist() == np.float32([0, 0.1, 0.2, 5]).tolist()
    for row, expected in zip(clip.weights, rig.batch(weights, dtype=float), strict=True):
        np.testing.assert_allclose(
            drawn_positions(rig, targets, row), expected, atol=1e-5 * (rig.neutral.diameter or 1)
        )


@pytest.mark.parametrize(
    ("times", "weights", "message"),
    [
        ([0, 1], [[0.0], [1.0], [0.5]], "one time for each of its 3 rows"),
        ([0, 1], [[0.0, 0.0], [1.0, 1.0]], "must have shape"),
        ([1, 0], [[0.0], [1.0]], "rise"),
        ([-1, 0], [[0.0], [1.0]], "from 0"),
        ([1.0, 1.0 + 1e-12], [[0.0], [1.0]], "rise"),
        ([0, np.inf], [[0.0], [1.0]], "rise"),
        (["a", "b"], [[0.0], [1.0]], "must be numbers"),
        ([], np.zeros((0, 1)), "one time for each"),
    ],
)
def test_a_performance_that_does_not_fit_is_refused(
    times: list[float], weights: list[list[float]], message: str
) -> None:
    rig = triangle_rig()
    with pytest.raises(ParameterError, match=message):
        performance_clip(rig, MorphTargets.of(rig, 0), times, weights, "take")


def test_a_curve_with_a_kink_too_sharp_for_any_keys_says_how_far_they_are() -> None:
    """Halfway up h²(3 - 2h) between its corners, where no frame is, the chord is off by 0.096."""
    flat = triangle_rig().neutral
    up, down = [0, 0, 3e10, -2e15], [1, 0, -12, 16]
    spike = BendCurve([0, 0.5 - 1e-5, 0.5, 1], [[0, 0, 0, 0], up, down])
    bend = np.ones((1, 3, 3))
    rig = Rig(flat, {"spike": Morph(flat, flat, bend, (spike,))})
    clip = slider_clips(rig, MorphTargets.of(rig, 0), 1e-6, 30)[0]
    assert clip.key_error == pytest.approx(3**0.5 / flat.diameter / (6 * 3**0.5), rel=0.1)
    assert len(clip.times) < 8192


@pytest.mark.filterwarnings("ignore:the path overshoots")
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("times", [(0.123,), (0.5,), (0.2001, 0.77)])
def test_every_in_between_is_a_key_and_shown_as_it_is(law: str, times: tuple[float, ...]) -> None:
    """Frames are 1/30 apart: 0.123 lies on none of them, nor on parts of them."""
    rig = through_rig(times, law)
    targets = MorphTargets.of(rig, 0)
    (clip,) = slider_clips(rig, targets, 1e-3, 30)
    assert (np.diff(clip.times) > 0).all()
    assert clip.key_error <= 1e-3
    for time in times:
        (row,) = np.flatnonzero(np.abs(clip.times - time) < 1e-7)
        shown = drawn_positions(rig, targets, clip.weights[row])
        np.testing.assert_allclose(shown, rig.morphs["a"].at(time), atol=1e-6)
    if law == "piecewise":
        assert len(clip.times) == len(times) + 2


def test_a_key_stands_where_a_timing_passes_the_in_between() -> None:
    """A blink passes it twice: closing in 0.3 of the clip, and opening again."""
    rig, law = through_rig((0.4,), "smooth"), timing.blink(0.3)
    targets = MorphTargets.of(rig, 0)
    (clip,) = slider_clips(rig, targets, 1e-3, 30, law)
    reached = clip.times[np.abs(clip.weights[:, 0] - 0.4) < 1e-6]
    assert len(reached) == 2
    np.testing.assert_allclose(law.at(reached), 0.4, atol=1e-6)
    assert clip.weights[np.abs(clip.weights[:, 0] - 0.4) < 1e-6, 1] == pytest.approx([1, 1])


def through_rig(times: tuple[float, ...], law: str) -> Rig:
    """A triangle that swings out on its way up."""
    neutral = triangle_rig().neutral
    target = neutral.with_vertices(neutral.vertices + [0, 0, 1.0])
    shapes = {t: neutral.with_vertices(neutral.vertices + [0.3, 0, t * t]) for t in times}
    return Rig(neutral, {"a": through(neutral, target, shapes, method=law)})


def test_a_timing_shapes_the_clip_and_not_the_path() -> None:
    """At every moment of the clip the weights are t and b_k(t) at t = timing(moment)."""
    neutral = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    target = neutral.with_vertices(neutral.vertices + [0, 0, 1.0])
    morph = Morph(neutral, target, np.full((1, 3, 3), 0.2), (BendCurve.power(2),))
    rig = Rig(neutral, {"a": morph})
    law = timing.minimum_jerk
    clip = slider_clips(rig, MorphTargets.of(rig, 0.0), 1e-4, 30, law)[0]
    moments = np.linspace(0, 1, 301)
    played = [np.interp(moments, clip.times, column) for column in clip.weights.T]
    t = law.at(moments)
    away = (played[0] - t)[:, None, None] * morph.delta
    away = away + (played[1] - (t**2 - t))[:, None, None] * morph.bends[0]
    assert np.linalg.norm(away, axis=2).max() <= (clip.key_error + 1e-6) * neutral.diameter
    assert clip.key_error <= 1e-4
