"""Graphs stand in a page without touching each other or anything outside."""

from __future__ import annotations

import re
from pathlib import Path

from parsed_page import Element, parsed

from elastomorph.draw.graphs import error_graphs, time_graphs
from elastomorph.evaluation import Evaluation
from elastomorph.report.document import inline_svg


def both(evaluation: Evaluation) -> Element:
    first = inline_svg(lambda file: error_graphs(evaluation, file, title="A & B"), "one", "First")
    second = inline_svg(lambda file: time_graphs(evaluation, file), "two", "Second <2>")
    return parsed(f"<div>{first}{second}</div>")


def test_ids_are_unique_and_every_reference_is_met(evaluation: Evaluation) -> None:
    root = both(evaluation)
    ids = [each.attributes["id"] for each in root.all() if "id" in each.attributes]
    assert len(ids) == len(set(ids)) > 4
    used = set()
    for each in root.all():
        for name, value in each.attributes.items():
            used.update(re.findall(r"url\(#([^)]+)\)", value))
            if name == "href":
                assert value.startswith("#")
                used.add(value[1:])
    assert used == set(ids)


def test_nothing_leads_outside_and_no_style_leaks(evaluation: Evaluation) -> None:
    root = both(evaluation)
    assert not root.all("style", "metadata", "script", "image")
    for each in root.all():
        assert not any("http" in value for value in each.attributes.values())


def test_words_stay_words_and_have_a_name(evaluation: Evaluation) -> None:
    root = both(evaluation)
    first, second = root.all("svg")
    assert first.attributes["aria-label"] == "First"
    assert second.attributes["aria-label"] == "Second <2>"
    assert first.attributes["role"] == "img"
    assert "viewbox" in first.attributes
    words = [each.text for each in first.all("text")]
    for label in ("A & B", "linear", "beam R=2", "% of D"):
        assert label in words
    for each in first.all("text"):
        assert "sans-serif" in each.attributes["style"]


def test_the_lines_are_those_of_the_file(evaluation: Evaluation, tmp_path: Path) -> None:
    """Rounded to hundredths of a point, in the same order."""
    time_graphs(evaluation, tmp_path / "graph.svg")
    source = (tmp_path / "graph.svg").read_text(encoding="utf-8")
    original = [_numbers(d) for d in re.findall(r'<path[^>]* d="([^"]+)"', source)]
    made = inline_svg(lambda file: time_graphs(evaluation, file), "g", "Graph")
    shown = [_numbers(each.attributes["d"]) for each in parsed(made).all("path")]
    assert len(made) < 0.8 * len(source)
    assert len(shown) == len(original) > 20
    for mine, theirs in zip(shown, original, strict=True):
        assert len(mine) == len(theirs)
        assert all(abs(a - b) <= 0.0051 for a, b in zip(mine, theirs, strict=True))


def _numbers(path: str) -> list[float]:
    return [float(text) for text in re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", path)]
