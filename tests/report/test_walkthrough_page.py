"""The page of the demonstration on the built-in head: whole, and small enough to be mailed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from parsed_page import Element, parsed
from stand_in import VIEWER

from elastomorph.curves import extract_curves
from elastomorph.errors import FileError
from elastomorph.evaluation import Evaluation, evaluate, every_method
from elastomorph.evaluation.target_paths import TargetPath, TargetPaths
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.morph import Choice, Morph
from elastomorph.paths import interpolate
from elastomorph.report import Picture
from elastomorph.report.subject import Subject, built_in_subject
from elastomorph.report.walkthrough import (
    BeamTiming,
    TargetPictures,
    advice,
    beam_words,
    targets_table,
    write_walkthrough_report,
)
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


EMPTY = (TargetPath("cheekPuff", Choice(0.0, 5e-4), 0, 0, 0.0, 0, empty=True),)


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
    subject = subject_of(evaluation)
    first = [advice(PATHS, {}, subject), targets_table(PATHS, "cm")]
    call = "elastomorph demo"
    write_walkthrough_report(subject, evaluation, first, BEAM, [], shown, file, call=call)
    root = parsed(file.read_text(encoding="utf-8"))
    assert [each.attributes["alt"] for each in root.all("img")] == ["Five faces."]
    assert beam_words(BEAM, 1) in [each.text for each in root.all("li")]
    assert "sneer" in beam_words(BEAM, 1)
    first = root.all("section")[0]
    assert first.one("h2").text == "What to do with each target"


def test_a_rig_without_anything_to_compare_has_its_targets_told(
    evaluation: Evaluation, tmp_path: Path
) -> None:
    """No recording and no rigid jaw: what to do is still what a rigger came for."""
    root = advised(evaluation, tmp_path)
    headings = [section.one("h2").text for section in root.all("section")]
    assert headings == ["What to do with each target", "Each target in numbers"]


def advised(evaluation: Evaluation, tmp_path: Path, paths: TargetPaths = PATHS) -> Element:
    file, subject = tmp_path / "report.html", subject_of(evaluation)
    first = [advice(paths, {}, subject), targets_table(paths, "cm")]
    write_walkthrough_report(subject, None, first, BEAM, [], [], file)
    return parsed(file.read_text(encoding="utf-8"))


def test_every_target_is_in_the_table(evaluation: Evaluation, tmp_path: Path) -> None:
    """Name, need, distance in % of D, further targets, bytes, and how exactly it is stored."""
    root = advised(evaluation, tmp_path)
    rows = [[cell.text for cell in row.all("th", "td")] for row in root.all("tr")]
    told = {row[0]: row[1:] for row in rows if row[0] != "Target"}
    pays = "rotation; an in-between would pay here"
    assert told == {
        "jawOpen": [pays, "1.100", "2", "87,744", "0.0017"],
        "eyeBlink": ["rotation", "0.200", "1", "5,376", "exact"],
        "sneer": ["straight is enough", "≤\u00a00.010", "none", "none", "exact"],
    }
    assert "0.05\u00a0% of D halfway" in root.text
    assert "12.0\u00a0cm" in root.text


def test_each_target_is_told_what_to_do_with_it(evaluation: Evaluation, tmp_path: Path) -> None:
    """0.011 of 12 cm is 0.132 cm, 0.0025 of them 0.03 cm. What pictures mean stands before them."""
    section = advised(evaluation, tmp_path).all("section")[0]
    said = [each.text for each in section.all("p") if each.attributes.get("class") == "headline"]
    assert said == ["Bend 2 targets, sculpt an in-between for 1 of them and keep 1 straight."]
    assert "cost 3 more morph targets, 0.093\u00a0MB" in section.text
    groups = [heading.text for heading in section.all("h3")]
    assert groups == ["Bend, and sculpt an in-between: 1", "Bend: 1", "Keep straight: 1"]
    cards = [
        [card.one("b").text, *(e.text for e in card.all("span"))] for card in section.all("li")
    ]
    assert cards == [
        ["jawOpen", "0.132\u00a0cm, +2 targets"],
        ["eyeBlink", "0.0240\u00a0cm, +1 target"],
        ["sneer"],
    ]
    assert "sneer" in section.one("details").text
    assert "more than 0.0300\u00a0cm (0.250\u00a0% of D) off" in section.text
    assert "[inbetweens.jawOpen]" in section.text


def test_where_nobody_knows_the_unit_shares_of_d_are_told(evaluation: Evaluation) -> None:
    """A name of any letters is a key of TOML in quotation marks."""
    named = replace(PATHS.targets[0], name="jaw open")
    grey = {"jaw open": Picture("", np.zeros((2, 2, 3), np.uint8), "", "")}
    content = advice(
        TargetPaths(12.0, (named, *EMPTY)), grey, replace(subject_of(evaluation), unit="")
    ).content
    assert content["scale"] == "0.250\u00a0% of D and more"
    pays, empty = content["groups"]  # type: ignore[misc]
    assert pays["shown"][0]["words"] == "1.10\u00a0% of D, +2 targets"
    assert '[inbetweens."jaw open"]' in pays["then"]
    assert [empty["title"], *(each["name"] for each in empty["folded"])] == [
        "Empty: 1",
        "cheekPuff",
    ]


@pytest.mark.parametrize(
    ("paths", "said"),
    [
        ([], "There are no targets."),
        (PATHS.targets[:1], "Bend 1 target and sculpt an in-between for it."),
        (PATHS.targets[1:2], "Bend 1 target."),
        (PATHS.targets[2:], "Keep 1 target straight."),
        (PATHS.targets[2:] * 3, "Keep all 3 targets straight."),
        (EMPTY * 2, "2 targets move nothing."),
        (PATHS.targets[2:] + EMPTY, "Keep 1 target straight; 1 target moves nothing."),
    ],
)
def test_the_headline_is_a_sentence_for_every_rig(
    evaluation: Evaluation, tmp_path: Path, paths: Sequence[TargetPath], said: str
) -> None:
    root = advised(evaluation, tmp_path, TargetPaths(12.0, tuple(paths)))
    assert root.all("p")[2].text == said


def test_pictures_show_the_target_and_where_its_path_bends(evaluation: Evaluation) -> None:
    """A straight target has the colours of the face, a bent one is dark off the straight line."""
    subject = subject_of(evaluation)
    neutral, target = subject.neutral, subject.targets["sneer"]
    off = np.zeros(neutral.vertices.shape)
    off[:, 2] = np.where(neutral.vertices[:, 0] > 0, 0.01 * neutral.diameter, 0.0)
    curve = BendCurve.power(2)
    bent = Morph(neutral, target, off[None], (curve,))
    with TargetPictures(replace(subject, jaw="sneer")) as cards:
        cards.draw("straight", interpolate(neutral, target, "linear"), neutral.diameter)
        cards.draw("bent", bent, neutral.diameter)
    straight, coloured = (cards.drawn[name].image.astype(int) for name in ("straight", "bent"))
    width = coloured.shape[1]
    assert coloured[:, width // 2 + 4 :].min() < 30 < coloured[:, : width // 2 - 4].min()
    assert abs(straight - straight[:, ::-1]).mean() < abs(coloured - coloured[:, ::-1]).mean()


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
    first = [advice(PATHS, {}, subject), targets_table(PATHS, subject.unit)]
    write_walkthrough_report(subject, found, first, BEAM, [], [], file)
    assert file.stat().st_size < 8_000_000
    root = parsed(file.read_text(encoding="utf-8"))
    assert root.one("iframe")
    assert len(root.all("svg")) == 3
    labels = {row.all("th")[0].text for row in root.named("report").all("tr") if row.all("th")}
    assert {"linear", "beam R=2", "plate R=2", "arc", "rotation", "auto"} <= labels
