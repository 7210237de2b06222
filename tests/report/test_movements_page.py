"""The page of a take: every movement, their means, and a graph."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from parsed_page import Element, parsed

from elastomorph.curves import Curve, CurveNetwork
from elastomorph.draw.graphs import movement_graph
from elastomorph.errors import ParameterError
from elastomorph.evaluation import every_method
from elastomorph.evaluation.movements import JudgedMovement, evaluate_movements, mean_lines
from elastomorph.model.mesh import Mesh
from elastomorph.model.sequence import MeshSequence
from elastomorph.report import About, movements_page, write_movements_report


@pytest.fixture(scope="module")
def take() -> MeshSequence:
    """Eight markers that twice leave their rest and come back, slowly out, quickly in."""
    rng = np.random.default_rng(7)
    points = rng.normal(size=(8, 3))
    push = 0.2 * rng.normal(size=(8, 3))
    out, back = np.linspace(0, 1, 40) ** 2, np.linspace(1, 0, 25)
    still = np.zeros(60)
    level = np.concatenate([still, out, back, still, 0.7 * out, 0.7 * back, still])
    return MeshSequence(Mesh(points), points + level[:, None, None] * push)


@pytest.fixture(scope="module")
def judged(take: MeshSequence) -> list[JudgedMovement]:
    curves = CurveNetwork([Curve(range(8))], 8)
    return evaluate_movements(take, curves, lambda part: every_method(part, curves))


@pytest.fixture(scope="module")
def root(judged: list[JudgedMovement], take: MeshSequence) -> Element:
    return parsed(movements_page(judged, take, About("jaw <1>", call="elastomorph evaluate")))


def test_tables_hold_the_means(judged: list[JudgedMovement], root: Element) -> None:
    means = mean_lines(judged)
    tables = [t for t in root.all("table") if t.attributes["class"] == "errors"]
    assert [t.one("caption").text for t in tables] == list(means)
    for table, lines in zip(tables, means.values(), strict=True):
        rows = table.one("tbody").all("tr")
        for row, line in zip(rows, lines, strict=True):
            assert row.one("th").text.startswith(line.label)
            (lme, *_), path = row.all("td"), row.all("td")[4]
            assert f"{100 * line.lme:.3f}" in lme.text
            assert f"{100 * line.path_lme:.3f}" in path.text
            assert len(row.all("td")) == 8


def test_every_movement_has_its_line(judged: list[JudgedMovement], root: Element) -> None:
    assert len(judged) == 4
    (table,) = (t for t in root.all("table") if t.attributes["class"] == "movements")
    rows = table.one("tbody").all("tr")
    for row, one in zip(rows, judged, strict=True):
        kind, frames, linear, closest, _ = (cell.text for cell in row.all("td"))
        assert kind == one.movement.kind
        assert frames == f"{one.movement.start} to {one.movement.stop}"
        assert linear == f"{100 * one.evaluation['linear'].lme:.3f}"
        known = [r for r in one.evaluation.results if not r.label.startswith("through")]
        assert closest.endswith(f"{100 * min(r.lme for r in known):.3f}")
        assert "through" not in closest


def test_the_page_is_whole_and_closed_in_itself(root: Element) -> None:
    assert root.one("h1").text == "jaw <1>"
    sections = [each.attributes["aria-labelledby"] for each in root.all("section")]
    assert sections == ["outcome", "movements", "compared", "errors", "recipe"]
    assert len(root.all("svg")) == 1
    assert not root.all("img", "iframe")
    facts = root.one("main").text
    assert "2 onsets and 2 offsets" in facts
    assert "at the best frames of each" in facts
    assert not re.search(r"\d cm", facts)


def test_the_graph_shows_every_error(
    judged: list[JudgedMovement], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from contextlib import contextmanager

    from elastomorph.draw import graphs as module
    from elastomorph.draw.graphs import new_figure

    kept = []

    @contextmanager
    def keeping(*arguments):
        with new_figure(*arguments) as figure:
            yield figure
            kept.append(figure)

    monkeypatch.setattr(module, "new_figure", keeping)
    movement_graph(judged, tmp_path / "graph.svg", title="Four")
    for axes, name in zip(kept[0].axes, ("lme", "path_lme"), strict=True):
        for line in axes.lines:
            errors = [100 * getattr(one.evaluation[line.get_label()], name) for one in judged]
            np.testing.assert_allclose(line.get_ydata(), errors)
    with pytest.raises(ParameterError, match="no movement"):
        movement_graph([], tmp_path / "none.svg")
    assert not (tmp_path / "none.svg").exists()


def test_it_is_written_as_any_report(
    judged: list[JudgedMovement], take: MeshSequence, tmp_path: Path
) -> None:
    write_movements_report(judged, take, tmp_path / "take.html", draw=False)
    written = (tmp_path / "take.html").read_text(encoding="utf-8")
    assert written == movements_page(judged, take, draw=False) or "<svg" not in written
