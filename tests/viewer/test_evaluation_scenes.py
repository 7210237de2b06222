"""The recorded motion as a path, and the scene of an evaluation."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pages import read_back

import elastomorph as em
from elastomorph.evaluation import Evaluation
from elastomorph.viewer import evaluation_scene, motion_morph
from small_head import recorded_motion

TETRAHEDRON = ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3]])


def random_motion(frames: int, seed: int) -> em.MeshSequence:
    random = np.random.default_rng(seed)
    times = np.cumsum(random.uniform(0.1, 1.0, frames))
    return em.MeshSequence(em.Mesh(*TETRAHEDRON), random.normal(size=(frames, 4, 3)), times)


@given(st.integers(2, 24), st.integers(0, 1000))
def test_the_path_is_each_frame_at_its_time_and_straight_between(frames: int, seed: int) -> None:
    motion = random_motion(frames, seed)
    path = motion_morph(motion)
    np.testing.assert_allclose(path.at(motion.times), motion.frames, atol=1e-14)
    parts = np.linspace(0, 1, 5)
    for (t, start), (u, end) in itertools.pairwise(zip(motion.times, motion.frames, strict=True)):
        chord = start + parts[:, None, None] * (end - start)
        np.testing.assert_allclose(path.at(t + parts * (u - t)), chord, atol=1e-13)


@given(st.integers(25, 90), st.integers(2, 24))
def test_of_a_long_take_evenly_spread_frames_are_kept(frames: int, most: int) -> None:
    """So many as asked for, both ends among them, gaps that differ by one frame at most."""
    motion = random_motion(frames, 3)
    path = motion_morph(motion, most)
    assert len(path.bends) == most - 2
    breaks = path.bend_curves[0].breaks if path.bend_curves else np.array([0.0, 1.0])
    kept = np.searchsorted(motion.times, breaks)
    np.testing.assert_array_equal(motion.times[kept], breaks)
    assert kept[0] == 0
    assert kept[-1] == frames - 1
    assert np.ptp(np.diff(kept)) <= 1
    np.testing.assert_allclose(path.at(breaks), motion.frames[kept], atol=1e-14)


def test_fewer_than_two_frames_are_no_motion() -> None:
    with pytest.raises(em.ParameterError, match="at least 2"):
        motion_morph(random_motion(5, 0), 1)


def test_the_file_holds_the_recorded_frames(tmp_path: Path) -> None:
    """The recorded motion through its GLB file: every frame within single precision."""
    motion = recorded_motion()
    methods = em.evaluate(motion, ["linear"])
    truth = evaluation_scene(methods).models[-1]
    rig = read_back(truth.glb, tmp_path)
    np.testing.assert_allclose(
        rig.morphs["motion"].at(motion.times), motion.frames, atol=2e-6 * motion.neutral.diameter
    )
    middle = (motion.frames[3] + motion.frames[4]) / 2
    np.testing.assert_allclose(
        rig.pose({"motion": 0.35}), middle, atol=2e-6 * motion.neutral.diameter
    )


def test_every_method_stands_beside_the_truth(evaluation: Evaluation, tmp_path: Path) -> None:
    scene = evaluation_scene(evaluation, unit="mm")
    assert [(m.name, m.role) for m in scene.models] == [
        ("linear", "method"),
        ("ease R=2", "method"),
        ("beam R=2", "method"),
        ("recorded", "truth"),
    ]
    assert scene.diameter == evaluation.diameter
    assert scene.curves == evaluation.curves
    for model, result in zip(scene.models, evaluation.results, strict=False):
        path = read_back(model.glb, tmp_path).morphs["motion"]
        np.testing.assert_allclose(path.at([0, 0.3, 1]), result.morph.at([0, 0.3, 1]), atol=1e-6)


def test_a_motion_that_was_not_recorded_is_not_called_so(evaluation: Evaluation) -> None:
    assert evaluation_scene(evaluation, truth="known way").models[-1].name == "known way"


def test_it_begins_with_the_best_beside_the_truth(evaluation: Evaluation) -> None:
    start = evaluation_scene(evaluation).start
    errors = [result.lme for result in evaluation.results]
    assert start["shown"][0] == 0
    assert errors[start["shown"][-2]] == min(errors)
    assert start["shown"][-1] == start["against"] == 3
    assert len(set(start["shown"])) == len(start["shown"])


def test_the_title_says_how_much_of_a_take_is_shown(evaluation: Evaluation) -> None:
    assert evaluation_scene(evaluation, title="jaw").title == "jaw"
    assert evaluation_scene(evaluation, title="jaw", frames=3).title == "jaw (3 of 5 frames)"


def test_markers_are_refused() -> None:
    random = np.random.default_rng(0)
    frames = random.normal(size=(4, 6, 3))
    markers = em.MeshSequence(em.Mesh(frames[0]), frames)
    curves = em.CurveNetwork([em.Curve(np.arange(6))], 6)
    with pytest.raises(em.ParameterError, match="no polygons"):
        evaluation_scene(em.evaluate(markers, ["linear"], curves))
