"""Rivals at one table: the same figures for all, and nobody is told more than it may know."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

import elastomorph as em
from elastomorph.curves import Curve, CurveNetwork
from elastomorph.rivals import RIVALS, Rival, VertexCubic, with_rivals
from elastomorph.rivals.comparison import run, run_apart, through_poses
from elastomorph.rivals.rival import Faces


@dataclass(frozen=True)
class Straight(Rival):
    """The straight line, and what it was told."""

    name = "straight"
    source = "here"

    moved: float = 0.0

    def faces(
        self, recording: em.MeshSequence, curves: CurveNetwork, times: NDArray[np.float64]
    ) -> Faces:
        assert len(recording) == 2
        first, last = recording.frames
        for time in times:
            yield (1 - time) * first + time * last + self.moved


@pytest.fixture(scope="module")
def bent(sheet: em.Mesh) -> em.MeshSequence:
    """Five frames of a sheet that rises on a parabola."""
    times = np.linspace(0, 1, 5)
    up = np.zeros_like(sheet.vertices)
    up[6:, 2] = 1.0
    return em.MeshSequence(sheet, sheet.vertices + (times**2)[:, None, None] * up, times)


def test_a_rival_is_measured_as_a_method_is(bent: em.MeshSequence) -> None:
    """What is the straight line has the numbers of ``linear``; what is moved misses both ends."""
    judged = em.evaluate(bent, ["linear"])
    found = with_rivals(judged, [Straight(), Straight(moved=0.1)], own=["linear"], runner=run)
    linear, own, moved = found.evaluation.results
    for name in ("lme", "lae", "path_lme", "path_lae", "seam", "flips"):
        assert getattr(own, name) == pytest.approx(getattr(linear, name), abs=1e-9), name
    assert [cost.label for cost in found.costs] == ["linear", "straight", "straight moved=0.1"]
    assert found.costs[1].ends == pytest.approx(0, abs=1e-15)
    expected = 0.1 * np.sqrt(3) / bent.mesh.diameter
    assert found.costs[2].ends == pytest.approx(expected)
    assert moved.maximum[:, 0].max() == pytest.approx(expected)
    assert "straight moved=0.1" in found.evaluation.results[2].label


def test_who_knows_the_frames_wins_nothing(bent: em.MeshSequence) -> None:
    found = with_rivals(em.evaluate(bent, ["linear"]), [VertexCubic()], own=[], runner=run)
    assert found.evaluation["vertex-cubic"].informed
    assert found.evaluation["vertex-cubic"].lme < 1e-12


def test_markers_and_missing_packages_are_left_out_in_a_sentence(
    bent: em.MeshSequence, monkeypatch: pytest.MonkeyPatch
) -> None:
    points = em.Mesh(bent.mesh.vertices)
    markers = em.MeshSequence(points, bent.frames, bent.times)
    curves = CurveNetwork((Curve(np.arange(6), False),), len(points.vertices))
    monkeypatch.setattr("elastomorph.rivals.rival.find_spec", lambda name: None)
    found = with_rivals(
        em.evaluate(markers, ["linear"], curves), RIVALS, own=["linear"], runner=run
    )
    assert found.evaluation["vertex-cubic"].lme < 1e-12
    for rival in RIVALS:
        if rival.on_surfaces:
            assert "surface" in found.left_out[rival.label]
        elif rival.package:
            assert "pip install 'elastomorph[rivals]'" in found.left_out[rival.label]
    assert all(sentence.endswith(".") for sentence in found.sentences())


def test_a_process_of_its_own_gives_the_same_faces(bent: em.MeshSequence) -> None:
    made = run_apart(VertexCubic(), bent, em.extract_curves(bent.mesh))
    np.testing.assert_array_equal(made.poses, VertexCubic().poses(bent, bent.times))
    assert made.first > 0
    assert made.further >= 0


@dataclass(frozen=True)
class Broken(Rival):
    """Fails in one way or another."""

    name = "broken"
    source = "here"

    way: str = "sleep"

    def faces(
        self, recording: em.MeshSequence, curves: CurveNetwork, times: NDArray[np.float64]
    ) -> Faces:
        if self.way == "say":
            raise em.MeshError("it has no inside.")
        raise RuntimeError("out of luck")
        yield


def test_a_rival_that_fails_is_left_out(bent: em.MeshSequence) -> None:
    found = with_rivals(em.evaluate(bent, ["linear"]), [Broken("say")], own=[], runner=run)
    assert [result.label for result in found.evaluation.results] == ["linear"]
    assert list(found.left_out.values()) == ["it has no inside"]


def test_a_process_that_breaks_is_one_error(bent: em.MeshSequence) -> None:
    with pytest.raises(em.ElastomorphError, match=r"its process broke: .*out of luck"):
        run_apart(Broken("die"), bent, em.extract_curves(bent.mesh))


def test_a_process_that_takes_too_long_is_ended(bent: em.MeshSequence) -> None:
    with pytest.raises(em.ElastomorphError, match="took longer than 0 s"):
        run_apart(VertexCubic(), bent, em.extract_curves(bent.mesh), longest=0.01)


def test_the_path_between_faces_is_a_spline_through_them(bent: em.MeshSequence) -> None:
    path = through_poses(bent.mesh, bent.frames, bent.times, "mine")
    np.testing.assert_allclose(path.at(bent.times), bent.frames, atol=1e-12)
    assert path.method == "mine"


@pytest.mark.parametrize("times", [[0.5, 0.2], [], [0.0, 1.2], [np.nan], "half"])
def test_times_must_rise_from_0_to_1(bent: em.MeshSequence, times: object) -> None:
    with pytest.raises(em.ParameterError, match="times must be numbers"):
        VertexCubic().poses(bent, times)  # type: ignore[arg-type]
