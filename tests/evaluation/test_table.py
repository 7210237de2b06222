"""The table and its text forms say what was measured."""

from __future__ import annotations

import csv
import io
import json
import math
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from rich.console import Console
from rich.table import Table

import elastomorph as em
from elastomorph.curves import CurveNetwork
from elastomorph.evaluation import DEFAULT_METHODS, Evaluation, evaluate
from elastomorph.evaluation.conclusions import conclusions, rankings
from elastomorph.evaluation.summary import summaries
from elastomorph.evaluation.table import (
    PAPER_TABLE_1,
    evaluation_html,
    method_table,
    plain_text,
    table_1,
)
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence
from elastomorph.paths import Method


@pytest.fixture(scope="module")
def evaluation(curved: Morph, rows: CurveNetwork) -> Evaluation:
    frames = curved.at(np.linspace(0, 1, 6))
    truth = MeshSequence(curved.neutral, frames, names=[f"scan.{i:04d}" for i in range(6)])
    return evaluate(truth, curves=rows)


def test_every_method_is_in_the_table(evaluation: Evaluation) -> None:
    """With its numbers in % of D."""
    text = str(evaluation)
    for result in evaluation.results:
        row = next(part for part in text.splitlines() if result.label in part)
        assert f"{100 * result.lme:.3f}" in row
        assert f"{100 * result.path_lae:.3f}" in row
        assert f"{result.stretch:.3f}" in row
    assert "\x1b" not in text
    for sentence in conclusions(summaries(evaluation)):
        assert sentence in " ".join(text.split())


def test_it_fits_a_terminal_of_a_hundred_columns(evaluation: Evaluation) -> None:
    """No number is cut short."""
    narrow = plain_text(evaluation.table(), width=100)
    assert "…" not in narrow
    for result in evaluation.results:
        assert f"{100 * result.mean_lme:.3f}" in narrow


def bold_cells(table: Table) -> dict[str, list[int]]:
    """Rows that are bold, by the header of their column."""
    found = {}
    for column in table.columns[1:]:
        cells = list(column.cells)
        found[str(column.header)] = [i for i, cell in enumerate(cells) if cell.style == "bold"]
    return found


def test_the_best_of_each_column_is_bold(evaluation: Evaluation) -> None:
    """What reads the same is equally good, and a column of one value has no best."""
    first = replace(summaries(evaluation)[0], label="a", lme=0.02, lae=0.01, flips=0)
    second = replace(first, label="b", lme=0.0100001, lae=0.01, flips=2)
    third = replace(first, label="c", lme=0.01, lae=0.01, flips=1)
    bold = bold_cells(method_table([first, second, third], "three"))
    assert bold["LME"] == [1, 2]
    assert bold["LAE"] == []
    assert bold["flips"] == [0]


def test_csv_has_one_line_a_method(evaluation: Evaluation) -> None:
    """In full precision."""
    read = list(csv.DictReader(io.StringIO(evaluation.to_csv())))
    assert [row["label"] for row in read] == [Method.parse(m).label for m in DEFAULT_METHODS]
    for row, result in zip(read, evaluation.results, strict=True):
        for name in ("lme", "lae", "mean_lme", "path_lme", "path_mean_lae", "seam", "stretch"):
            assert float(row[name]) == getattr(result, name)
        assert int(row["flips"]) == result.flips


def test_long_csv_has_every_curve_and_frame(evaluation: Evaluation) -> None:
    """The arrays can be put together again from its lines."""
    read = list(csv.DictReader(io.StringIO(evaluation.to_long_csv())))
    shape = (len(evaluation.results), len(evaluation.curves), len(evaluation.truth))
    assert len(read) == np.prod(shape)
    for name in ("average", "maximum", "path_average", "path_maximum"):
        rebuilt = np.array([float(row[name]) for row in read]).reshape(shape)
        for own, result in zip(rebuilt, evaluation.results, strict=True):
            np.testing.assert_array_equal(own, getattr(result, name))
    assert read[0]["curve"] == "row 0"
    assert read[-1]["frame"] == "scan.0005"
    assert float(read[-1]["time"]) == 1


def test_json_holds_the_arrays(evaluation: Evaluation) -> None:
    """Strictly: no NaN, no infinity, every number as measured."""
    page = json.loads(evaluation.to_json(), parse_constant=pytest.fail)
    assert page["diameter"] == evaluation.diameter
    assert page["times"] == evaluation.truth.times.tolist()
    assert [curve["name"] for curve in page["curves"]] == [c.name for c in evaluation.curves]
    assert len(page["conclusions"]) == 3
    for method, result in zip(page["methods"], evaluation.results, strict=True):
        assert method["label"] == result.label
        for name in ("path_times", "path_average_times", "average", "maximum", "path_average"):
            np.testing.assert_array_equal(method[name], getattr(result, name))
        for name in ("lme", "path_mean_lme", "seam", "flips", "stretch"):
            assert method[name] == getattr(result, name)


def test_json_of_an_edge_that_collapsed(evaluation: Evaluation) -> None:
    """An infinite stretch has no number in JSON, and is not hidden in the table."""
    collapsed = replace(evaluation.results[0], stretch=math.inf)
    page = Evaluation(evaluation.truth, evaluation.curves, (collapsed,))
    assert json.loads(page.to_json())["methods"][0]["stretch"] is None
    assert "inf" in str(page)


def test_labels_are_text_and_not_markup(evaluation: Evaluation) -> None:
    """Square brackets in a label of one's own are printed."""
    odd = replace(evaluation.results[0], label="[bold]mine[/bold]")
    page = Evaluation(evaluation.truth, evaluation.curves, (odd,))
    out = io.StringIO()
    Console(file=out, width=160).print(page.table())
    assert "[bold]mine[/bold]" in out.getvalue()


class ReadTable(HTMLParser):
    """Cells by row, which of them are marked, and the paragraphs."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self.marked: list[list[bool]] = []
        self.words: list[str] = []
        self._into: list[str] | None = None
        self.feed(page)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag == "tr":
            self.rows.append([])
            self.marked.append([])
        elif tag in ("td", "th"):
            self._into = self.rows[-1]
            self.marked[-1].append(False)
            self._into.append("")
        elif tag in ("p", "caption"):
            self._into = self.words
            self._into.append("")
        elif tag == "strong":
            self.marked[-1][-1] = True
        elif tag == "br":
            self.handle_data(" ")

    def handle_data(self, data: str) -> None:
        if self._into is not None and data != "\n":
            self._into[-1] += data


@pytest.fixture(scope="module")
def small() -> Evaluation:
    """A tip that rises late and swings aside on its way."""
    times = np.linspace(0, 1, 5)
    mesh = em.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3]])
    frames = np.repeat(mesh.vertices[None], 5, axis=0)
    frames[:, 3, 2] += times**2
    frames[:, 3, 0] += times * (1 - times)
    return em.evaluate(em.MeshSequence(mesh, frames, times), ["linear", "ease:2", "beam:3"])


def test_the_numbers_are_those_of_the_csv(small: Evaluation) -> None:
    table = ReadTable(evaluation_html(small))
    header, *rows = table.rows
    names = ["method", "LME", "LAE", "mean LME", "mean LAE", "path LME", "path LAE"]
    assert header[:7] == names
    assert header[7:] == ["seam", "flips", "stretch"]
    for row, line in zip(rows, summaries(small), strict=True):
        assert row[0] == line.label
        for text, name in zip(row[1:7], names[1:], strict=True):
            expected = 100 * getattr(line, name.lower().replace(" ", "_"))
            assert float(text) == pytest.approx(expected, abs=5.1e-4)


def test_the_least_of_each_column_is_marked_unless_all_are_alike(small: Evaluation) -> None:
    table = ReadTable(evaluation_html(small))
    for column in range(1, len(table.rows[0])):
        texts = [row[column] for row in table.rows[1:]]
        least = min(texts, key=float)
        expected = [text == least and len(set(texts)) > 1 for text in texts]
        assert [row[column] for row in table.marked[1:]] == expected


def test_the_words_are_those_of_the_terminal(small: Evaluation) -> None:
    lines = summaries(small)
    words = ReadTable(evaluation_html(small)).words
    assert words[1:] == [*conclusions(lines), *rankings(lines)]
    assert words[0].startswith("5 frames, ")


def test_two_methods_need_no_order(small: Evaluation) -> None:
    two = replace(small, results=small.results[:2])
    words = ReadTable(evaluation_html(two)).words
    assert words[1:] == conclusions(summaries(two))


def test_the_table_has_no_colour_of_its_own(small: Evaluation) -> None:
    """Readable on light and on dark: lines and text have the colour of what is around them."""
    html = evaluation_html(small)
    assert not re.search(r"#[0-9a-f]{3}|rgb|background|color: (?!inherit)", html)
    assert "color: inherit" in html


def test_labels_are_text(small: Evaluation) -> None:
    hostile = replace(small.results[0], label="<script>&amp;")
    html = evaluation_html(replace(small, results=(hostile,)))
    assert "<script>" not in html
    assert ReadTable(html).rows[1][0] == "<script>&amp;"


def test_markers_have_no_columns_of_shape() -> None:
    frames = np.random.default_rng(0).normal(size=(4, 6, 3))
    curves = em.CurveNetwork([em.Curve(np.arange(6))], 6)
    markers = em.evaluate(em.MeshSequence(em.Mesh(frames[0]), frames), ["linear"], curves)
    assert "seam" not in ReadTable(evaluation_html(markers)).rows[0]


def test_table_1_stands_as_in_the_paper(evaluation: Evaluation) -> None:
    """Its ratios are those of its text: 2.33 and 1.65 times the errors of the quadratic one."""
    rows = dict(table_1(evaluation))
    assert list(rows) == ["LME, the paper", "LAE, the paper", "LME, here", "LAE, here"]
    _, quadratic, _, linear = (float(text) for text in rows["LME, the paper"])
    assert round(linear / quadratic, 2) == 2.33
    _, quadratic, _, linear = (float(text) for text in rows["LAE, the paper"])
    assert round(linear / quadratic, 2) == 1.65
    for row, name in (("LME, here", "lme"), ("LAE, here", "lae")):
        found = [getattr(evaluation[label], name) for label in PAPER_TABLE_1]
        np.testing.assert_allclose([float(text) for text in rows[row]], found, atol=5e-7)


def test_there_is_no_table_1_without_its_methods(evaluation: Evaluation) -> None:
    assert table_1(evaluate(evaluation.truth, ["linear", "beam:2"], evaluation.curves)) == []
