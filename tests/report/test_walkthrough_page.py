"""The page of the demonstration on the built-in head: whole, and small enough to be mailed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from parsed_page import parsed
from stand_in import VIEWER

from elastomorph.curves import extract_curves
from elastomorph.errors import FileError
from elastomorph.evaluation import Evaluation, evaluate, every_method
from elastomorph.evaluation.target_paths import TargetPath, TargetPaths
from elastomorph.model.morph import Choice
from elastomorph.report import Picture
from elastomorph.report.subject import Subject, built_in_subject
from elastomorph.report.walkthrough_page import BeamTiming, beam_words, write_walkthrough_report
from elastomorph.viewer.page import shipped_page

BEAM = BeamTiming("sneer", 0.0002)
PATHS = TargetPaths(
    12.0,
    (
        TargetPath("jawOpen", Choice(0.011, 5e-4), 2, 5484, 1.7e-5, 0),
        TargetPath("eyeBlink", Choice(0.002, 5e-4), 1, 336, 0.0, 0),
        TargetPath("sneer", Choice(1e-4, 5e-4, exact=False), 0, 0, 0.0, 0),
    ),
)


def subject_of(evaluation: Evaluation) -> Subject:
    truth = evaluation.truth
    return Subject("ball", truth.mesh, {"sneer": truth.target}, {}, "grow", take=truth, unit="cm")


def test_further_pictures_and_findings_are_in_it(
    evaluation: Evaluation, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("elastomorph.viewer.page.shipped_page", lambda: VIEWER)
    grey = np.full((20, 30, 3), 128, dtype=np.uint8)
    shown = [Picture("Expressions", grey, "Five faces.", "Look at them.")]
    file = tmp_path / "report.html"
    write_walkthrough_report(
        subject_of(evaluation), PATHS, evaluation, None, BEAM, shown, file, call="elastomorph demo"
    )
    root = parsed(file.read_text(encoding="utf-8"))
    assert [each.attributes["alt"] for each in root.all("img")] == ["Five faces."]
    assert beam_words(BEAM, 1) in [each.text for each in root.all("li")]
    assert "sneer" in beam_words(BEAM, 1)
    first = root.all("section")[0]
    assert first.one("h2").text == "What each target needs"


def test_a_rig_without_anything_to_compare_has_its_targets_told(
    evaluation: Evaluation, tmp_path: Path
) -> None:
    """No recording and no rigid jaw: the table of targets is still what a rigger came for."""
    file = tmp_path / "report.html"
    write_walkthrough_report(subject_of(evaluation), PATHS, None, None, BEAM, [], file)
    root = parsed(file.read_text(encoding="utf-8"))
    assert [section.one("h2").text for section in root.all("section")] == ["What each target needs"]


def test_every_target_is_in_the_table(evaluation: Evaluation, tmp_path: Path) -> None:
    """Name, need, distance in % of D, further targets, bytes, and how exactly it is stored."""
    file = tmp_path / "report.html"
    write_walkthrough_report(subject_of(evaluation), PATHS, None, None, BEAM, [], file)
    root = parsed(file.read_text(encoding="utf-8"))
    rows = [[cell.text for cell in row.all("th", "td")] for row in root.all("tr")]
    told = {row[0]: row[1:] for row in rows if row[0] != "Target"}
    pays = "rotation; an in-between would pay here"
    assert told == {
        "jawOpen": [pays, "1.100", "2", "87,744", "0.0017"],
        "eyeBlink": ["rotation", "0.200", "1", "5,376", "exact"],
        "sneer": ["straight is enough", "≤\u00a00.010", "none", "none", "exact"],
    }
    folded = root.one("details")
    assert "sneer" in folded.text
    assert "jawOpen" not in folded.text
    assert PATHS.summary in [each.text for each in root.all("p")]
    assert "0.05\u00a0% of D halfway" in root.text
    assert "12.0\u00a0cm" in root.text


@pytest.mark.slow
def test_the_page_of_the_built_in_head_is_small(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    try:
        shipped_page()
    except FileError:  # not built in this checkout: with its limit of 900 kB instead
        monkeypatch.setattr("elastomorph.viewer.page.shipped_page", lambda: VIEWER + 900_000 * " ")
    subject = built_in_subject()
    assert subject.take is not None
    curves = extract_curves(subject.neutral)
    found = evaluate(subject.take, every_method(subject.take, curves), curves)
    file = tmp_path / "report.html"
    write_walkthrough_report(subject, PATHS, found, None, BEAM, [], file)
    assert file.stat().st_size < 8_000_000
    root = parsed(file.read_text(encoding="utf-8"))
    assert root.one("iframe")
    assert len(root.all("svg")) == 3
    labels = {row.all("th")[0].text for row in root.named("report").all("tr") if row.all("th")}
    assert {"linear", "beam R=2", "plate R=2", "arc", "rotation", "auto"} <= labels
