"""The table and its text forms say what was measured."""

from __future__ import annotations

import csv
import io
import json
import math
from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console
from rich.table import Table

from elastomorph.curves import CurveNetwork
from elastomorph.evaluation import DEFAULT_METHODS, Evaluation, evaluate
from elastomorph.evaluation.conclusions import conclusions
from elastomorph.evaluation.summary import summaries
from elastomorph.evaluation.table import method_table, plain_text
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
    assert len(page["conclusions"]) == 2
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
