"""Graphs show the numbers of the evaluation, under their names."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from elastomorph.draw import graphs
from elastomorph.draw.graphs import (
    error_graphs,
    mode_law_graph,
    new_figure,
    styles_for,
    time_graphs,
    time_law_graph,
)
from elastomorph.errors import ParameterError
from elastomorph.evaluation import Evaluation
from elastomorph.physics import Load, Material, modal_response


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The figures drawn in a test."""
    kept: list[Any] = []

    @contextmanager
    def keeping(*arguments: Any) -> Iterator[Any]:
        with new_figure(*arguments) as figure:
            yield figure
            kept.append(figure)

    monkeypatch.setattr(graphs, "new_figure", keeping)
    monkeypatch.setattr(graphs, "new_figure", keeping)
    return kept


def _line(figure: Any, title: str, label: str) -> Any:
    """The line with this label in the panel whose title starts so."""
    (axes,) = (each for each in figure.axes if each.get_title("left").startswith(title))
    (line,) = (each for each in axes.lines if each.get_label() == label)
    return line


def test_an_svg_names_every_method(evaluation: Evaluation, tmp_path: Path) -> None:
    for draw in (error_graphs, time_graphs):
        draw(evaluation, tmp_path / "graph.svg", title="Growing & going")
        text = (tmp_path / "graph.svg").read_text(encoding="utf-8")
        for result in evaluation.results:
            assert f">{result.label}<" in text
        assert "% of D" in text
        assert "Growing &amp; going" in text


def test_lines_are_the_errors_in_percent(
    evaluation: Evaluation, tmp_path: Path, drawn: list[Any]
) -> None:
    error_graphs(evaluation, tmp_path / "graph.png")
    for result in evaluation.results:
        average = _line(drawn[0], "(a)", result.label)
        np.testing.assert_array_equal(average.get_xdata(), np.arange(1, 14))
        np.testing.assert_allclose(average.get_ydata(), 100 * result.average.max(axis=1))
        maximum = _line(drawn[0], "(b)", result.label)
        np.testing.assert_allclose(maximum.get_ydata(), 100 * result.maximum.max(axis=1))
        over_time = _line(drawn[0], "(d)", result.label)
        np.testing.assert_allclose(over_time.get_xdata(), evaluation.truth.times)
        np.testing.assert_allclose(over_time.get_ydata(), 100 * result.maximum.max(axis=0))
    worst = max(_line(drawn[0], "(b)", r.label).get_ydata().max() for r in evaluation.results)
    assert worst == pytest.approx(100 * max(result.lme for result in evaluation.results))


def test_free_timing_is_drawn_from_the_path_errors(
    evaluation: Evaluation, tmp_path: Path, drawn: list[Any]
) -> None:
    time_graphs(evaluation, tmp_path / "graph.png", labels=["ease R=2"])
    result = evaluation["ease R=2"]
    line = _line(drawn[0], "(c)", "ease R=2")
    np.testing.assert_allclose(line.get_ydata(), 100 * result.path_average.max(axis=0))
    assert len(drawn[0].axes[0].lines) == 1


def test_one_moment_can_be_chosen(evaluation: Evaluation, tmp_path: Path, drawn: list[Any]) -> None:
    error_graphs(evaluation, tmp_path / "graph.png", time=0.45)
    title = drawn[0].axes[0].get_title("left")
    assert "t = 0.5" in title
    shown = _line(drawn[0], "(b)", "linear").get_ydata()
    np.testing.assert_allclose(shown, 100 * evaluation["linear"].maximum[:, 2])


def test_curves_are_ordered_as_asked(
    evaluation: Evaluation, tmp_path: Path, drawn: list[Any]
) -> None:
    """The parallels of a ball are longest at the equator; poles have no length."""
    error_graphs(evaluation, tmp_path / "graph.png", order="error")
    assert (np.diff(_line(drawn[0], "(b)", "linear").get_ydata()) <= 0).all()
    error_graphs(evaluation, tmp_path / "graph.png", order="length")
    by_curve = 100 * evaluation["linear"].maximum.max(axis=1)
    shown = _line(drawn[1], "(b)", "linear").get_ydata()
    assert shown[0] == pytest.approx(by_curve[5])
    assert sorted(shown[-2:]) == pytest.approx(sorted(by_curve[11:]))
    assert sorted(shown) == pytest.approx(sorted(by_curve))


def test_unknown_orders_and_methods_are_refused(evaluation: Evaluation, tmp_path: Path) -> None:
    with pytest.raises(ParameterError, match="length"):
        error_graphs(evaluation, tmp_path / "graph.png", order="alphabet")
    with pytest.raises(ParameterError, match="beam R=9"):
        error_graphs(evaluation, tmp_path / "graph.png", labels=["beam R=9"])
    with pytest.raises(ParameterError, match="no method"):
        time_graphs(evaluation, tmp_path / "graph.png", labels=[])
    assert not list(tmp_path.iterdir())


def test_methods_keep_their_style_and_differ_from_each_other() -> None:
    known = ["linear", "cosine", "ease R=2", "ease R=3", "beam R=1", "beam R=2", "beam R=3"]
    styles = styles_for([*known, "my own", "another"])
    assert len(set(styles.values())) == len(styles)
    assert styles_for(["beam R=2"])["beam R=2"] == styles["beam R=2"]
    # what coincides is told apart: a broad line under a narrow dashed one
    for under, over in (("linear", "beam R=1"), ("ease R=2", "beam R=2"), ("ease R=3", "beam R=3")):
        assert styles[under].layer < styles[over].layer
        assert styles[under].width > 2 * styles[over].width
        assert styles[over].dashes


def test_time_laws_are_those_of_the_theory(tmp_path: Path, drawn: list[Any]) -> None:
    """At m = c = k = 1 and R = 2: φ₀ at rest is 1.5t² - 0.5t³, φ₁ is (Bt² - 2t)/(B - 2)."""
    time_law_graph(tmp_path / "laws.png")
    rest = _line(drawn[0], "(a)", "φ₀ rest")
    t = rest.get_xdata()
    np.testing.assert_allclose(rest.get_ydata(), 1.5 * t**2 - 0.5 * t**3, atol=1e-12)
    limit = _line(drawn[0], "(a)", "φ₀ limit")
    np.testing.assert_allclose(limit.get_ydata(), t**2, atol=1e-12)
    stiffness = 16 * np.pi**4
    gap = np.abs((stiffness * t**2 - 2 * t) / (stiffness - 2) - t**2)
    first = _line(drawn[0], "(b)", "n = 1").get_ydata()
    np.testing.assert_allclose(first[1:-1], gap[1:-1], rtol=1e-9)


def test_a_linear_load_follows_the_limit_law_and_says_so(tmp_path: Path) -> None:
    time_law_graph(tmp_path / "laws.svg", load=1)
    assert "every mode follows" in (tmp_path / "laws.svg").read_text(encoding="utf-8")


def test_singular_laws_are_named_instead_of_drawn(tmp_path: Path, drawn: list[Any]) -> None:
    """φ₀ at rest is singular at c = 3m for R = 2."""
    time_law_graph(tmp_path / "laws.png", Material(mass=1, damping=3), load=Load([0, 1]))
    assert len(_line(drawn[0], "(a)", "φ₀ rest (singular)").get_xdata()) == 0


def test_laws_of_modes_are_those_of_the_theory(tmp_path: Path, drawn: list[Any]) -> None:
    """R = 2: φ₁ is (Bt² - 2ct)/(B - 2c), whatever the mass; R = 1 is t in every mode."""
    materials = [Material(rigidity=0.01), Material(mass=9, damping=4, rigidity=0.01)]
    mode_law_graph(tmp_path / "laws.png", materials, loads=(1, 2))
    straight, quadratic = drawn[0].axes[:2], drawn[0].axes[2:]
    for axes in straight:
        for line in axes.lines:
            np.testing.assert_allclose(line.get_ydata(), line.get_xdata(), atol=1e-12)
    stiffness = 0.16 * np.pi**4
    for axes, c in zip(quadratic, (1, 4), strict=True):
        first = next(line for line in axes.lines if line.get_label() == "n = 1")
        t = first.get_xdata()
        law = (stiffness * t**2 - 2 * c * t) / (stiffness - 2 * c)
        np.testing.assert_allclose(first.get_ydata(), law, atol=1e-12)


def test_a_singular_law_of_a_mode_is_named(
    tmp_path: Path, drawn: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    def second_is_singular(*given: Any) -> Any:
        laws = modal_response(*given)
        laws[1] = np.inf
        return laws

    monkeypatch.setattr(graphs, "modal_response", second_is_singular)
    mode_law_graph(tmp_path / "laws.png", [Material()], loads=(2,))
    labels = [line.get_label() for line in drawn[0].axes[0].lines]
    assert labels[1:] == ["n = 1", "n = 2 (singular)", "n = 3"]
