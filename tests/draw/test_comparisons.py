"""Methods side by side, where they err, and what closures do."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from elastomorph.draw.strips import closure_comparison, error_strip, side_by_side
from elastomorph.errors import ParameterError
from elastomorph.evaluation import Evaluation
from elastomorph.evaluation.confidence import Confidence

FACE = (64, 80)


def _differ(one: np.ndarray, other: np.ndarray) -> bool:
    return bool((np.abs(one.astype(int) - other.astype(int)) > 30).any())


def test_side_by_side_shows_the_truth_and_the_methods(
    evaluation: Evaluation, tmp_path: Path
) -> None:
    sheet = side_by_side(evaluation, tmp_path / "side.png", face=FACE, time=0.7)
    assert (tmp_path / "side.png").exists()
    assert sheet.shape[1] >= 3 * FACE[0]


def test_of_vertices_that_are_not_trusted_no_error_is_drawn(evaluation: Evaluation) -> None:
    """Halfway all err; if none counts, the face is as pale as where none errs."""
    truth = evaluation.truth
    values = np.ones((len(truth), len(truth.mesh.vertices)))
    values[2] = 0.0
    masked = replace(evaluation, confidence=Confidence(values))
    how: dict[str, Any] = {"labels": ["linear"], "face": FACE, "highest": 0.5, "time": 0.5}
    plain, pale = error_strip(evaluation, **how), error_strip(masked, **how)
    face = np.s_[4 : 4 + FACE[1], 4 : 4 + FACE[0]]
    assert _differ(plain[face], pale[face])
    nowhere = replace(masked, confidence=Confidence(values, least=0.0))
    np.testing.assert_array_equal(error_strip(nowhere, **how), plain)


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
