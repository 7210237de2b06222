"""The table of an evaluation as HTML says what the one in the terminal says."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

import elastomorph as em
from elastomorph.evaluation import Evaluation
from elastomorph.evaluation.conclusions import conclusions, rankings
from elastomorph.evaluation.summary import summaries
from elastomorph.evaluation.table import evaluation_html


class Table(HTMLParser):
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
def evaluation() -> Evaluation:
    """A tip that rises late and swings aside on its way."""
    times = np.linspace(0, 1, 5)
    mesh = em.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3]])
    frames = np.repeat(mesh.vertices[None], 5, axis=0)
    frames[:, 3, 2] += times**2
    frames[:, 3, 0] += times * (1 - times)
    return em.evaluate(em.MeshSequence(mesh, frames, times), ["linear", "ease:2", "beam:3"])


def test_the_numbers_are_those_of_the_csv(evaluation: Evaluation) -> None:
    table = Table(evaluation_html(evaluation))
    header, *rows = table.rows
    names = ["method", "LME", "LAE", "mean LME", "mean LAE", "path LME", "path LAE"]
    assert header[:7] == names
    assert header[7:] == ["seam", "flips", "stretch"]
    for row, line in zip(rows, summaries(evaluation), strict=True):
        assert row[0] == line.label
        for text, name in zip(row[1:7], names[1:], strict=True):
            expected = 100 * getattr(line, name.lower().replace(" ", "_"))
            assert float(text) == pytest.approx(expected, abs=5.1e-4)


def test_the_least_of_each_column_is_marked_unless_all_are_alike(evaluation: Evaluation) -> None:
    table = Table(evaluation_html(evaluation))
    for column in range(1, len(table.rows[0])):
        texts = [row[column] for row in table.rows[1:]]
        least = min(texts, key=float)
        expected = [text == least and len(set(texts)) > 1 for text in texts]
        assert [row[column] for row in table.marked[1:]] == expected


def test_the_words_are_those_of_the_terminal(evaluation: Evaluation) -> None:
    lines = summaries(evaluation)
    words = Table(evaluation_html(evaluation)).words
    assert words[1:] == [*conclusions(lines), *rankings(lines)]
    assert words[0].startswith("5 frames, ")


def test_two_methods_need_no_order(evaluation: Evaluation) -> None:
    two = replace(evaluation, results=evaluation.results[:2])
    words = Table(evaluation_html(two)).words
    assert words[1:] == conclusions(summaries(two))


def test_the_table_has_no_colour_of_its_own(evaluation: Evaluation) -> None:
    """Readable on light and on dark: lines and text have the colour of what is around them."""
    html = evaluation_html(evaluation)
    assert not re.search(r"#[0-9a-f]{3}|rgb|background|color: (?!inherit)", html)
    assert "color: inherit" in html


def test_labels_are_text(evaluation: Evaluation) -> None:
    hostile = replace(evaluation.results[0], label="<script>&amp;")
    html = evaluation_html(replace(evaluation, results=(hostile,)))
    assert "<script>" not in html
    assert Table(html).rows[1][0] == "<script>&amp;"


def test_markers_have_no_columns_of_shape() -> None:
    frames = np.random.default_rng(0).normal(size=(4, 6, 3))
    curves = em.CurveNetwork([em.Curve(np.arange(6))], 6)
    markers = em.evaluate(em.MeshSequence(em.Mesh(frames[0]), frames), ["linear"], curves)
    assert "seam" not in Table(evaluation_html(markers)).rows[0]
