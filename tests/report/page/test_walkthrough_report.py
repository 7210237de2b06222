"""The page of the demonstration on the built-in head: whole, and small enough to be mailed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from parsed_page import parsed
from stand_in import VIEWER

from elastomorph.errors import FileError
from elastomorph.evaluation import Evaluation, evaluate
from elastomorph.report.page import Picture
from elastomorph.report.subject import Subject, built_in_subject
from elastomorph.report.walkthrough import TargetFacts
from elastomorph.report.walkthrough_report import target_words, write_walkthrough_report
from elastomorph.viewer.page import shipped_page

FACTS = [TargetFacts("jawOpen", (0, 1), 0.02, 0.0001), TargetFacts("sneer", (0, 1), 0.01, 0.0002)]


def test_further_pictures_and_findings_are_in_it(
    evaluation: Evaluation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("elastomorph.viewer.page.shipped_page", lambda: VIEWER)
    truth = evaluation.truth
    subject = Subject("ball", truth.mesh, {}, {}, "grow", motion=truth, unit="cm")
    grey = np.full((20, 30, 3), 128, dtype=np.uint8)
    shown = [Picture("Expressions", grey, "Five faces.", "Look at them.")]
    file = tmp_path / "report.html"
    write_walkthrough_report(subject, evaluation, FACTS, shown, file, call="elastomorph demo")
    root = parsed(file.read_text(encoding="utf-8"))
    assert [each.attributes["alt"] for each in root.all("img")][-1] == "Five faces."
    assert target_words(FACTS) in [each.text for each in root.all("li")]
    assert "sneer" in target_words(FACTS)


@pytest.mark.slow
def test_the_page_of_the_built_in_head_is_small(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    try:
        shipped_page()
    except FileError:  # not built in this checkout: with its limit of 900 kB instead
        monkeypatch.setattr("elastomorph.viewer.page.shipped_page", lambda: VIEWER + 900_000 * " ")
    subject = built_in_subject()
    assert subject.motion is not None
    found = evaluate(subject.motion)
    file = tmp_path / "report.html"
    write_walkthrough_report(subject, found, FACTS, [], file)
    assert file.stat().st_size < 8_000_000
    root = parsed(file.read_text(encoding="utf-8"))
    assert root.one("iframe")
    assert len(root.all("img")) == 3
    assert len(root.all("svg")) == 3
