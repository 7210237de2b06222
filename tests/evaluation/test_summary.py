"""What a table says in words must follow from its numbers."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from elastomorph.curves import CurveNetwork
from elastomorph.evaluation import evaluate, every_method
from elastomorph.evaluation.conclusions import conclusions, rankings
from elastomorph.evaluation.summary import MethodSummary, mean_summaries, summaries
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence
from elastomorph.paths import interpolate

LINEAR = MethodSummary("linear", 0.04, 0.02, 0.03, 0.015, 0.02, 0.01, 0.015, 0.008, 0.0, 0, 1.0)


def facts(sentence: str) -> list[str]:
    """The methods and the numbers in per cent that a sentence names, in its order."""
    return re.findall(r"linear|(?:beam|ease) R=\d|through \d|curved|[\d.]+(?=\s%)", sentence)


def line(label: str, lme: float, path_lme: float, path_lae: float) -> MethodSummary:
    return replace(LINEAR, label=label, lme=lme, path_lme=path_lme, path_lae=path_lae)


def test_a_win_with_the_path_of_the_straight_line_is_timing_alone() -> None:
    """And an ease of nearly the same error is said to share it."""
    lines = [LINEAR, line("ease R=2", 0.0301, 0.02, 0.01), line("beam R=2", 0.03, 0.02001, 0.01)]
    first, errors, *more = conclusions(lines)
    assert first == "Closest to the motion: beam R=2, ease R=2, by timing alone."
    assert facts(errors) == ["beam R=2", "3.00", "linear", "4.00", "25"]
    assert more[0].endswith(": ease R=2.")
    assert facts(more[1])[-2:] == ["2.00", "50"]


def test_a_path_that_is_worse_is_no_win_of_path() -> None:
    """A smaller error in time with a path farther away was timing."""
    first, *_ = conclusions([LINEAR, line("beam R=3", 0.03, 0.025, 0.012)])
    assert first.endswith("by timing alone; closest path: linear.")


def test_a_closer_path_is_said_to_be_one() -> None:
    """Half the path error of linear cannot be timing."""
    first, *_ = conclusions([LINEAR, line("curved", 0.01, 0.01, 0.005)])
    assert first.endswith("by path too.")


def test_less_than_one_part_in_a_hundred_is_no_closer_path() -> None:
    """Both path errors smaller by half a percent: still timing alone."""
    first, *_ = conclusions([LINEAR, line("beam R=2", 0.03, 0.0199, 0.00995)])
    assert first.endswith("by timing alone.")


@pytest.mark.parametrize(("path_lme", "path_lae"), [(0.01, 0.01), (0.02, 0.005), (0.01, 0.005)])
def test_where_a_path_is_closer_is_told(path_lme: float, path_lae: float) -> None:
    """In the largest of the maxima, the largest of the averages, or both: each with its size."""
    first, *_, paths = conclusions([LINEAR, line("curved", 0.03, path_lme, path_lae)])
    assert first.endswith("by path too.")
    given = [f"{100 * each:#.3g}" for each in (path_lme, 0.02, path_lae, 0.01)]
    assert facts(paths)[-4:] == given


@pytest.mark.parametrize("lme", [0.05, 0.04, 0.0398])
def test_no_win_is_claimed_where_there_is_none(lme: float) -> None:
    """A method that is worse, equal, or better by less than one part in a hundred."""
    first, *_ = conclusions([LINEAR, line("beam R=2", lme, 0.02, 0.01)])
    assert "no method is closer than straight lines" in first


@pytest.mark.parametrize("path_lme", [0.0398, 0.04, 0.045])
def test_an_error_that_timing_does_not_lower_is_one_of_path(path_lme: float) -> None:
    """Free timing lowers squared errors, and may even raise the largest."""
    linear = replace(LINEAR, path_lme=path_lme)
    said = conclusions([linear, line("beam R=2", 0.05, 0.02, 0.01)])
    assert "does not bring linear closer" in said[2]


def test_without_linear_nothing_is_compared() -> None:
    """Only the smallest error is named."""
    said = conclusions([line("ease R=2", 0.03, 0.02, 0.01), line("beam R=2", 0.02, 0.02, 0.01)])
    assert said[0] == "Closest to the motion: beam R=2."
    assert [facts(each) for each in said[1:]] == [["beam R=2", "2.00"]]


def test_computed_on_motions_whose_nature_is_known(curved: Morph, rows: CurveNetwork) -> None:
    """An ease is won by timing alone; a curved path is not."""
    times = np.linspace(0, 1, 7)
    eased = interpolate(curved.neutral, curved.target, "ease:2")
    own = {"linear": "linear", "ease R=2": "ease:2", "curved": curved}
    for morph, timing_alone in ((eased, True), (curved, False)):
        truth = MeshSequence(curved.neutral, morph.at(times))
        first, *_ = conclusions(summaries(evaluate(truth, own, rows)))
        assert ("timing alone" in first) is timing_alone
        assert f"motion: {'ease R=2' if timing_alone else 'curved'}" in first


def test_means_over_motions(curved: Morph, rows: CurveNetwork) -> None:
    """Each number is averaged for each method."""
    both = []
    for power in (1, 2):
        frames = curved.at(np.linspace(0, 1, 6) ** power)
        truth = MeshSequence(curved.neutral, frames)
        both.append(evaluate(truth, ["linear", "beam:2"], rows))
    means = mean_summaries(both)
    for number, mean in enumerate(means):
        own = [evaluation.results[number] for evaluation in both]
        assert mean.label == own[0].label
        assert mean.lme == pytest.approx((own[0].lme + own[1].lme) / 2)
        assert mean.path_mean_lae == pytest.approx(
            (own[0].path_mean_lae + own[1].path_mean_lae) / 2
        )


def test_rankings_share_places_where_the_table_reads_the_same() -> None:
    lines = [LINEAR, line("a", 0.0301, 0.02, 0.01), line("b", 0.03, 0.01, 0.01)]
    assert rankings(lines) == [
        "At the captured times (LME): 1. b, a; 2. linear.",
        "With free timing (LME): 1. b; 2. linear, a.",
    ]


def test_who_knows_frames_of_the_recording_wins_nothing() -> None:
    """It has a sentence of its own, and the rest is judged as if it were not there."""
    lines = [LINEAR, line("cosine", 0.03, 0.02, 0.01), line("through 2", 0.001, 0.001, 0.001)]
    *said, told = conclusions(lines, ["through 2"])
    assert said == conclusions(lines[:2])
    assert facts(told) == ["through 2", "0.100"]
    assert conclusions(lines[2:], ["through 2"]) == [told]


def test_means_are_of_the_methods_that_every_motion_has(
    neutral: Mesh, target: Mesh, rows: CurveNetwork
) -> None:
    """A motion of three frames has no room for two in-betweens; the others keep their numbers."""
    found = []
    for count in (3, 5):
        times = np.linspace(0, 1, count)
        ends = neutral.vertices, target.vertices
        frames = np.stack([(1 - time**2) * ends[0] + time**2 * ends[1] for time in times])
        truth = MeshSequence(neutral, frames, times)
        found.append(evaluate(truth, every_method(truth, rows), rows))
    assert "through 2" in [line.label for line in summaries(found[1])]
    means = {line.label: line for line in mean_summaries(found)}
    assert "through 2" not in means
    assert list(means) == [line.label for line in summaries(found[0])]
    for label, mean in means.items():
        assert mean.lme == pytest.approx((found[0][label].lme + found[1][label].lme) / 2)
