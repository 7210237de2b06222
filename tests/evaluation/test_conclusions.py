"""The outcome in words says what the numbers say, and no more."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from elastomorph.evaluation.conclusions import Verdict, conclusions, reach_verdict
from elastomorph.evaluation.inbetweens import Suggestion
from elastomorph.evaluation.summary import MethodSummary, same
from elastomorph.evaluation.words import Lengths, percent, significant

HEAD = Lengths(30.0, "cm")
ZERO = MethodSummary("linear", *[0.0] * 10, 1.0)


def line(label: str, timed: float, free: float, **more: float) -> MethodSummary:
    return replace(
        ZERO,
        label=label,
        lme=timed,
        lae=timed / 2,
        path_lme=free,
        path_lae=free / 2,
        **more,
    )


def text_of(verdict: Verdict) -> str:
    return " ".join([verdict.headline, *verdict.reasons]).replace("\u00a0", " ")


def test_a_win_of_timing_is_called_one_and_shared_with_the_ease() -> None:
    lines = [line("linear", 0.04, 0.01), line("ease R=2", 0.02, 0.01), line("beam R=2", 0.02, 0.01)]
    lines[1] = replace(lines[1], lme=0.02001)
    verdict = reach_verdict(lines, HEAD)
    assert verdict.timing_alone
    assert verdict.headline == "Closest to this recording: beam R=2, ease R=2, by timing alone."
    said = text_of(verdict)
    assert "on straight lines, at another pace: ease R=2." in said
    # 2 % of 30 cm, 4 % of it, and what lies between
    assert "beam R=2 0.600 cm (2.00 % of D), linear 1.20 cm (4.00 % of D); 50 % less" in said
    assert "75 % of its error was a matter of when" in said


def test_beside_a_win_of_timing_the_headline_names_the_closest_path() -> None:
    """A cosine may win at the recorded times; where the face goes, rotation is closer."""
    lines = [line("linear", 0.04, 0.014), line("cosine", 0.03, 0.014)]
    plain = reach_verdict(lines, HEAD).headline
    lines += [line("rotation", 0.041, 0.010), line("auto", 0.041, 0.010)]
    told = reach_verdict(lines, HEAD)
    assert told.timing_alone
    assert told.headline == f"{plain[:-1]}; closest path: rotation, auto."


def test_a_closer_path_is_called_one() -> None:
    verdict = reach_verdict([line("linear", 0.04, 0.01), line("arc", 0.02, 0.004)], HEAD)
    assert not verdict.timing_alone
    assert verdict.headline == "Closest to this recording: arc, by path too."
    assert "largest error 0.400 % of D against 1.00 % of D" in text_of(verdict)


def test_the_closest_path_is_named_though_another_method_won() -> None:
    lines = [line("linear", 0.04, 0.014), line("cosine", 0.03, 0.014), line("arc", 0.04, 0.011)]
    lines.append(line("rotation", 0.041, 0.01101))
    said = text_of(reach_verdict(lines, HEAD))
    assert "Closest path: arc, rotation, with free timing 0.330 cm" in said
    assert "cosine 0.420 cm" in said
    assert "Closest path" not in text_of(reach_verdict(lines[:2], HEAD))


def test_a_small_win_is_called_narrow() -> None:
    verdict = reach_verdict([line("linear", 0.04, 0.01), line("cosine", 0.039, 0.01)], HEAD)
    assert verdict.headline == "Closest to this recording: cosine, narrowly, by timing alone."


def test_nobody_wins_where_nobody_does() -> None:
    verdict = reach_verdict([line("linear", 0.02, 0.02), line("beam R=2", 0.04, 0.02)], HEAD)
    assert "no method is closer than straight lines" in verdict.headline
    assert "its error is one of path, not of timing" in text_of(verdict)


def test_methods_that_know_the_recording_win_nothing() -> None:
    lines = [
        line("linear", 0.04, 0.01),
        line("cosine", 0.03, 0.01),
        line("through 1", 0.001, 0.001),
    ]
    verdict = reach_verdict(lines, HEAD, informed=["through 1"])
    assert verdict.headline.startswith("Closest to this recording: cosine,")
    assert "Given frames of this very recording, so no win: through 1 (0.100 % of D)" in text_of(
        verdict
    )


def test_without_times_only_paths_are_compared() -> None:
    """cosine is far off at the times, which nobody recorded, and closest by path."""
    lines = [line("linear", 0.01, 0.01), line("cosine", 0.09, 0.005)]
    verdict = reach_verdict(lines, HEAD, timing_known=False, what="the known way")
    assert verdict.headline == "Closest to the known way: cosine, by path."
    assert "recorded times" not in text_of(verdict)
    lines[1] = replace(lines[1], path_lme=0.01)
    verdict = reach_verdict(lines, HEAD, timing_known=False, what="the known way")
    assert "no method is closer than straight lines" in verdict.headline


def test_torn_faces_and_turned_polygons_are_named() -> None:
    lines = [line("linear", 0.04, 0.01), line("beam R=2 unforced", 0.05, 0.02, seam=0.04, flips=8)]
    said = text_of(reach_verdict(lines, HEAD))
    assert "Neighbouring curves part" in said
    assert "by up to: beam R=2 unforced 1.20 cm (4.00 % of D)." in said
    assert "Polygons turned over in the worst frame: beam R=2 unforced 8." in said
    assert "curves part" not in text_of(reach_verdict(lines[:1], HEAD))


def test_in_betweens_help_as_far_as_they_do() -> None:
    """Of three suggestions the last is no better than the second, and is not told."""
    found = [suggestion(0.04), suggestion(0.02, 0.5), suggestion(0.01, 0.3, 0.7)]
    found.append(suggestion(0.0101, 0.2, 0.3, 0.7))
    said = text_of(reach_verdict([line("linear", 0.04, 0.04)], HEAD, suggestions=found))
    assert (
        "falls from 1.20 cm to 0.600 cm (÷ 2) with 1 at t = 0.5; 0.300 cm (÷ 4) with 2 at "
        "t = 0.3, 0.7."
    ) in said
    assert "What would help" not in text_of(
        reach_verdict([line("linear", 0.04, 0.04)], HEAD, suggestions=found[:1])
    )


def suggestion(lme: float, *times: float) -> Suggestion:
    frames = tuple(range(1, len(times) + 1))
    errors = np.array([0.0, lme, 0.0])
    return Suggestion(frames, times, ("x",) * len(times), "smooth", True, None, errors, errors)  # type: ignore[arg-type]


def test_several_motions_have_no_one_length() -> None:
    lines = [line("linear", 0.04, 0.01), line("cosine", 0.02, 0.01)]
    said = text_of(reach_verdict(lines, Lengths(None, "cm"), what="these movements"))
    assert "cm" not in said
    assert "cosine 2.00 % of D, linear 4.00 % of D" in said


errors = st.floats(0.0, 0.3)
methods = st.lists(
    st.tuples(st.sampled_from(["cosine", "ease R=2", "beam R=2", "arc"]), errors, errors),
    min_size=1,
    max_size=4,
    unique_by=lambda each: each[0],
)


@given(methods, errors, errors)
def test_the_rule_is_that_of_the_table(
    others: list[tuple[str, float, float]], timed: float, free: float
) -> None:
    """The page and the terminal agree on whether a win is one of timing alone."""
    lines = [line("linear", timed, free), *(line(*each) for each in others)]
    verdict = reach_verdict(lines, HEAD)
    terminal = " ".join(conclusions(lines))
    assert verdict.timing_alone == ("timing alone" in terminal)
    nobody = "no method is closer"
    assert (nobody in verdict.headline) == (nobody in terminal)
    best = min(each.lme for each in lines)
    if nobody not in verdict.headline:
        winner = verdict.headline.split(": ")[1].rstrip(".").split(",")[0]
        assert same(next(each.lme for each in lines if each.label == winner), best)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0, "0"),
        (1.2, "1.20"),
        (30.08, "30.1"),
        (123.4, "123"),
        (0.00973, "0.00973"),
        (26719, "26,719"),
        (1.87e-16, "0"),
        (-3e-13, "0"),
        (2e-9, "2.00e-09"),
    ],
)
def test_numbers_have_three_digits(value: float, text: str) -> None:
    assert significant(value) == text
    assert percent(0.0138) == "1.38\u00a0% of D"
