"""Texts that name what an evaluation is to judge."""

from __future__ import annotations

import numpy as np
import pytest

from elastomorph.curves import CurveNetwork
from elastomorph.errors import ParameterError
from elastomorph.evaluation import evaluate
from elastomorph.evaluation.evaluation import method_of
from elastomorph.evaluation.inbetweens import suggest_inbetweens
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence
from elastomorph.paths import Method
from elastomorph.physics import Material


@pytest.fixture(scope="module")
def motion(neutral: Mesh) -> MeshSequence:
    steps = np.random.default_rng(4).normal(size=(8, *neutral.vertices.shape)).cumsum(axis=0)
    return MeshSequence(neutral, neutral.vertices + steps - steps[0])


def test_a_method_is_that_of_its_own_text(motion: MeshSequence, rows: CurveNetwork) -> None:
    soft = Material(rigidity=0.1)
    assert method_of("beam:3", motion, rows) == ("beam R=3", Method.parse("beam:3"))
    _, found = method_of("beam:3", motion, rows, material=soft)
    assert found == Method.parse("beam:3").with_material(soft)


@pytest.mark.parametrize(
    ("text", "count", "law"),
    [
        ("through:1", 1, None),
        ("through:2:piecewise", 2, "piecewise"),
        ("through:1:spline", 1, "spline"),
    ],
)
def test_recorded_frames_as_in_betweens(
    motion: MeshSequence, rows: CurveNetwork, text: str, count: int, law: str | None
) -> None:
    """The path is that of the suggestion, and its row is called by the text."""
    label, morph = method_of(text, motion, rows)
    expected = suggest_inbetweens(motion, count, curves=rows, method=law)[count].morph
    assert label == text.replace(":", " ")
    assert isinstance(morph, Morph)
    np.testing.assert_array_equal(morph.at(motion.times), expected.at(motion.times))


def test_laws_compete_in_one_evaluation(motion: MeshSequence, rows: CurveNetwork) -> None:
    """Without a law, the row is that of the better of the smooth two."""
    texts = ["linear", "through:1", "through:1:smooth", "through:1:spline"]
    linear, best, smooth, spline = evaluate(motion, texts, rows).results
    assert best.lme == min(smooth.lme, spline.lme) < linear.lme


@pytest.mark.parametrize("text", ["through", "through:smooth", "through:1:smooth:2", "through:²"])
def test_a_number_of_frames_is_needed(motion: MeshSequence, rows: CurveNetwork, text: str) -> None:
    with pytest.raises(ParameterError, match="through:1, through:2:spline"):
        method_of(text, motion, rows)


def test_laws_and_room_are_checked(motion: MeshSequence, rows: CurveNetwork) -> None:
    with pytest.raises(ParameterError, match="smooth, spline, piecewise, found 'cubic'"):
        method_of("through:1:cubic", motion, rows)
    with pytest.raises(ParameterError, match="room for 0 to 6 in-betweens, found 7"):
        method_of("through:7", motion, rows)
