"""Strips show the faces of their methods, times and expressions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from elastomorph.draw.closures import closure_comparison
from elastomorph.draw.face_strip import face_strip
from elastomorph.draw.stage import Stage
from elastomorph.draw.strips import error_strip, expression_strip, method_strip, side_by_side
from elastomorph.errors import MeshError, ParameterError, TopologyError
from elastomorph.evaluation import Evaluation
from elastomorph.paths import interpolate
from scenes import ball

FACE = (64, 80)


def _differ(one: np.ndarray, other: np.ndarray) -> bool:
    return bool((np.abs(one.astype(int) - other.astype(int)) > 30).any())


def test_rows_and_columns_make_the_size_of_a_strip() -> None:
    mesh = ball()
    poses = np.stack([mesh.vertices, 1.2 * mesh.vertices])
    one = face_strip({"a": (mesh, poses)}, [0, 1], face=FACE)
    two = face_strip({"a": (mesh, poses), "b": (mesh, poses)}, [0, 1], face=FACE)
    three = face_strip({"a": (mesh, np.concatenate([poses, poses]))}, [0, 0.3, 0.6, 1], face=FACE)
    assert two.shape[0] - one.shape[0] >= FACE[1]
    assert three.shape[1] - one.shape[1] == 2 * (FACE[0] + 4)


def test_equal_poses_look_equal_and_different_ones_differ() -> None:
    """One camera for the whole strip."""
    mesh = ball()
    small, large = 0.5 * mesh.vertices, mesh.vertices
    rows = {"one": (mesh, np.stack([small, large])), "two": (mesh, np.stack([large, small]))}
    strip = face_strip(rows, [0, 1], face=FACE)
    half = strip.shape[1] - 2 * (FACE[0] + 4)
    top = strip.shape[0] - 2 * (FACE[1] + 4)
    cells = [
        strip[
            top + r * (FACE[1] + 4) : top + r * (FACE[1] + 4) + FACE[1],
            half + c * (FACE[0] + 4) : half + c * (FACE[0] + 4) + FACE[0],
        ]
        for r in range(2)
        for c in range(2)
    ]
    np.testing.assert_array_equal(cells[0], cells[3])
    np.testing.assert_array_equal(cells[1], cells[2])
    assert _differ(cells[0], cells[1])


def test_poses_that_rows_share_are_drawn_once(monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = ball()
    drawn: list[np.ndarray] = []
    picture = Stage.picture

    def counted(stage: Stage, vertices: np.ndarray) -> np.ndarray:
        drawn.append(vertices)
        return picture(stage, vertices)

    monkeypatch.setattr(Stage, "picture", counted)
    ends = np.stack([mesh.vertices, 1.2 * mesh.vertices])
    rows = {
        name: (mesh, np.stack([ends[0], size * mesh.vertices, ends[1]]))
        for name, size in (("slow", 1.05), ("even", 1.1), ("fast", 1.15))
    }
    face_strip(rows, [0, 0.5, 1], face=FACE)
    assert len(drawn) == 2 + len(rows)


def test_strips_that_do_not_fit_are_refused() -> None:
    mesh = ball()
    with pytest.raises(ParameterError, match="at least one"):
        face_strip({}, [0.0])
    with pytest.raises(MeshError, match="'a'"):
        face_strip({"a": (mesh, mesh.vertices[None])}, [0.0, 1.0])
    other = ball(meridians=12)
    with pytest.raises(TopologyError):
        face_strip({"a": (mesh, mesh.vertices[None]), "b": (other, other.vertices[None])}, [0.0])


def test_a_strip_of_methods_has_a_row_for_each_and_one_for_the_truth(
    evaluation: Evaluation, tmp_path: Path
) -> None:
    strip = method_strip(evaluation, tmp_path / "strip.png", face=FACE, count=3)
    np.testing.assert_array_equal(np.asarray(Image.open(tmp_path / "strip.png")), strip)
    few = method_strip(evaluation, labels=["linear"], face=FACE, count=3)
    assert strip.shape[0] - few.shape[0] == 4 * (FACE[1] + 4)
    with pytest.raises(ParameterError, match="2 columns"):
        method_strip(evaluation, count=1)
    with pytest.raises(ParameterError, match="no method"):
        method_strip(evaluation, labels=["beam R=7"], face=FACE)


def test_side_by_side_shows_the_truth_and_the_methods(
    evaluation: Evaluation, tmp_path: Path
) -> None:
    sheet = side_by_side(evaluation, tmp_path / "side.png", face=FACE, time=0.7)
    assert (tmp_path / "side.png").exists()
    assert sheet.shape[1] >= 3 * FACE[0]


def test_where_nothing_errs_the_heat_map_is_of_one_colour(evaluation: Evaluation) -> None:
    """At t = 0 every method is exact; halfway none is."""
    start, half = (
        error_strip(evaluation, time=time, labels=["linear"], face=FACE, highest=0.5)
        for time in (0.0, 0.5)
    )
    assert start.shape == half.shape
    face = np.s_[4 : 4 + FACE[1], 4 : 4 + FACE[0]]
    assert _differ(start[face], half[face])
    with pytest.raises(ParameterError, match="range"):
        error_strip(evaluation, highest=0.0, face=FACE)
    with pytest.raises(ParameterError, match="column"):
        error_strip(evaluation, columns=0, face=FACE)


def test_expressions_start_from_one_neutral(tmp_path: Path) -> None:
    mesh = ball()
    wide = mesh.with_vertices(mesh.vertices * [1.5, 1, 1])
    tall = mesh.with_vertices(mesh.vertices * [1, 1.5, 1])
    morphs = {name: interpolate(mesh, end, "linear") for name, end in (("w", wide), ("t", tall))}
    strip = expression_strip(morphs, tmp_path / "e.png", times=[0, 1], face=FACE, title="")
    left = strip.shape[1] - 2 * (FACE[0] + 4)
    top = strip.shape[0] - 2 * (FACE[1] + 4)
    first, second = (
        strip[top + r * (FACE[1] + 4) :][: FACE[1], left : left + FACE[0]] for r in range(2)
    )
    np.testing.assert_array_equal(first, second)
    with pytest.raises(ParameterError, match="at least one"):
        expression_strip({})


def test_closures_are_compared_in_columns(evaluation: Evaluation, tmp_path: Path) -> None:
    truth = evaluation.truth
    options = {"curves": evaluation.curves, "width": 60}
    two = closure_comparison(truth.neutral, truth.target, tmp_path / "c.png", **options)
    one = closure_comparison(truth.neutral, truth.target, closures=["limit"], **options)
    assert two.shape[1] > one.shape[1]
    assert (tmp_path / "c.png").exists()
    with pytest.raises(ParameterError, match="closure"):
        closure_comparison(truth.neutral, truth.target, closures=["ajar"], **options)
    with pytest.raises(ParameterError, match="closure"):
        closure_comparison(truth.neutral, truth.target, closures=[], **options)
