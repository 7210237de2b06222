"""Strips show the faces of their methods, times and expressions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import elastomorph as em
from elastomorph.draw.stage import Stage
from elastomorph.draw.strips import (
    contact_sheet,
    expression_strip,
    face_strip,
    method_strip,
    method_words,
    telling_frames,
)
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

    def counted(stage: Stage, vertices: np.ndarray, **options: Any) -> np.ndarray:
        drawn.append(vertices)
        return picture(stage, vertices, **options)

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


def test_the_most_active_frame_then_the_least_alike() -> None:
    """Frame 9 does most; 3 and 4 are alike, so only the farther one of them comes next."""
    weights = np.zeros((10, 2))
    weights[3, 0] = 0.5
    weights[4, 0] = 0.6
    weights[9] = [0, 1]
    assert telling_frames(weights, 1).tolist() == [9]
    assert telling_frames(weights, 2).tolist() == [4, 9]
    assert telling_frames(weights[:1], 5).tolist() == [0]
    assert telling_frames(weights[:4], 9).tolist() == [0, 1, 2, 3]


@pytest.mark.parametrize(
    ("method", "words"),
    [
        ("linear", "method linear, even timing"),
        ("auto", "method auto, even timing"),
        ("rotation", "method rotation, even timing"),
        ("ease:2", "method ease R=2, uneven timing"),
        ("beam:2", "method beam R=2, uneven timing"),
        ("cosine", "method cosine, uneven timing"),
    ],
)
def test_method_and_pace(method: str, words: str) -> None:
    """At an even pace a straight line is halfway at t = 0.5; an ease is not, a cosine is."""
    neutral = ball()
    target = neutral.with_vertices(neutral.vertices * [1, 1.5, 1])
    assert method_words([em.interpolate(neutral, target, method)] * 2) == words


def test_several_methods_are_all_named() -> None:
    neutral = ball()
    target = neutral.with_vertices(neutral.vertices * 2)
    paths = [em.interpolate(neutral, target, name) for name in ("linear", "ease:3")]
    assert method_words(paths) == "methods linear, ease R=3, uneven timing"


def test_strips_and_sheets_have_a_title_without_being_asked(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    titles: list[str] = []

    def grid(*_: object, title: str, **__: object) -> np.ndarray:
        titles.append(title)
        return np.zeros((1, 1, 3), dtype=np.uint8)

    monkeypatch.setattr("elastomorph.draw.sheet.picture_grid", grid)
    neutral = ball()
    grown = em.interpolate(neutral, neutral.with_vertices(neutral.vertices * 2), "ease:2")
    expression_strip({"grow": grown}, times=[0.5], face=(16, 20))
    contact_sheet(em.Rig(neutral, {"grow": grown}), np.ones((1, 1)), face=(16, 20), title="faces")
    words = "method ease R=2, uneven timing"
    assert titles == [words, f"faces ({words})"]
