"""The table shows the numbers of the evaluation and marks its best by more than a colour."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any

from hypothesis import given
from hypothesis import strategies as st
from parsed_page import Element, shown

from elastomorph.evaluation import Evaluation
from elastomorph.evaluation.conclusions import rankings
from elastomorph.evaluation.summary import MethodSummary, summaries
from elastomorph.evaluation.words import Lengths
from elastomorph.report import About
from elastomorph.report.outcome import error_table, errors, ranked

NUMBERS = [field.name for field in fields(MethodSummary) if field.name != "label"]
OTHER = ("flips", "stretch", "unmasked_lme", "unmasked_lae")  # no error of every table
PERCENT = [name for name in NUMBERS if name not in OTHER]


def table_of(lines: Sequence[MethodSummary], caption: str, **told: Any) -> Element:
    table = error_table(lines, caption, **told)
    return shown(errors([table], [], Lengths(None), shape=True, informed=())).one("table")


def rankings_of(lines: Sequence[MethodSummary], **about: Any) -> list[Element]:
    rankings = ranked(lines, About(**about))
    return shown(errors([], rankings, Lengths(None), shape=True, informed=())).all("ol")


def rows_of(table: Element) -> dict[str, list[Element]]:
    body = table.one("tbody")
    return {row.one("th").text: row.all("td") for row in body.all("tr")}


def number(cell: Element) -> str:
    """What is seen in a cell but its star and the words for those who do not see it."""
    return cell.text.replace("★", "").replace(" best", "")


def test_numbers_are_those_of_the_evaluation(evaluation: Evaluation) -> None:
    lines = summaries(evaluation)
    rows = rows_of(table_of(lines, "Errors"))
    assert list(rows) == [line.label for line in lines]
    for line in lines:
        cells = [number(cell) for cell in rows[line.label]]
        assert cells[:-2] == [f"{100 * getattr(line, name):.3f}" for name in PERCENT]
        assert cells[-2:] == [f"{line.flips:.0f}", f"{line.stretch:.3f}"]


def test_headers_say_what_they_head(evaluation: Evaluation) -> None:
    root = table_of(summaries(evaluation), "Errors & more")
    assert root.one("caption").text == "Errors & more"
    groups = [th for th in root.all("th") if th.attributes["scope"] == "colgroup"]
    assert [int(th.attributes["colspan"]) for th in groups] == [4, 4, 3]
    assert len([th for th in root.all("th") if th.attributes["scope"] == "col"]) == 12
    assert len([th for th in root.all("th") if th.attributes["scope"] == "row"]) == 5
    assert len(root.all("col")) == 12


def test_the_best_is_marked_in_words_and_so_is_what_reads_the_same(evaluation: Evaluation) -> None:
    lines = [replace(line, lme=value) for line, value in zip(
        summaries(evaluation), [0.04, 0.0301, 0.05, 0.03, 0.06], strict=True)]  # fmt: skip
    rows = rows_of(table_of(lines, "Errors"))
    marked = {label for label, cells in rows.items() if "★" in cells[0].text}
    assert marked == {"ease R=2", "beam R=2"}
    for label in marked:
        assert rows[label][0].text.endswith("best")


def test_all_alike_marks_nobody(evaluation: Evaluation) -> None:
    lines = [replace(line, lme=0.02) for line in summaries(evaluation)]
    rows = rows_of(table_of(lines, "Errors"))
    assert not any("★" in cells[0].text for cells in rows.values())


def test_methods_that_know_the_recording_are_told_apart(evaluation: Evaluation) -> None:
    lines = summaries(evaluation)
    lines.append(replace(lines[0], label="through 1", **dict.fromkeys(PERCENT, 1e-6)))
    root = table_of(lines, "Errors", informed=["through 1"])
    rows = rows_of(root)
    (told,) = (cells for label, cells in rows.items() if label.startswith("through 1 †"))
    assert not any("★" in cell.text for cell in told)
    assert any("★" in cells[0].text for cells in rows.values())


def test_without_times_no_timed_column_has_a_best(evaluation: Evaluation) -> None:
    rows = rows_of(table_of(summaries(evaluation), "Errors", timing_known=False))
    assert not any("★" in cell.text for cells in rows.values() for cell in cells[:4])
    assert any("★" in cell.text for cells in rows.values() for cell in cells[4:])


def test_markers_have_no_seams(evaluation: Evaluation) -> None:
    rows = rows_of(table_of(summaries(evaluation), "Errors", shape=False))
    assert {len(cells) for cells in rows.values()} == {8}


def test_an_edge_that_collapses_has_infinite_stretch(evaluation: Evaluation) -> None:
    lines = summaries(evaluation)
    lines[0] = replace(lines[0], stretch=float("inf"))
    rows = rows_of(table_of(lines, "Errors"))
    assert rows["linear"][-1].text == "inf"


def test_rankings_are_those_of_the_terminal(evaluation: Evaluation) -> None:
    lines = summaries(evaluation)
    for ranking, said in zip(rankings_of(lines), rankings(lines), strict=True):
        for place, item in enumerate(ranking.all("li"), start=1):
            names = item.text.removesuffix(item.one("span").text).strip()
            assert f"{place}. {names}" in said
    assert len(rankings_of(lines, timing_known=False)) == 1


@given(st.text(st.characters(exclude_categories=("Cs", "Cc")), min_size=1))
def test_any_name_is_shown_as_it_is(name: str) -> None:
    line = MethodSummary(name, *[0.01] * 9, 0, 1.0)
    assert rows_of(table_of([line], name))[name]
    assert rankings_of([line])[0].all("li")[0].text.startswith(name)
