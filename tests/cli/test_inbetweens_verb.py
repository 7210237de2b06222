"""``elastomorph inbetweens``, from files to table, JSON and graph."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from calls import printed_by

import elastomorph as em
from elastomorph.draw.graphs import inbetween_graph
from elastomorph.errors import ParameterError
from elastomorph.evaluation.inbetweens import suggest_inbetweens
from elastomorph.paths.through import through
from small_meshes import grid

SIZE = 5


@pytest.fixture
def motion(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> em.MeshSequence:
    """scan.01.obj … scan.09.obj: a natural spline through the shape of scan.04."""
    monkeypatch.chdir(tmp_path)
    neutral = grid(SIZE, SIZE, lambda x, y: np.sin(x))
    target = neutral.with_vertices(neutral.vertices + [0, 0, 2.0])
    between = neutral.with_vertices(neutral.vertices + [0.5, 0, 0.3] * np.sin(neutral.vertices))
    path = through(neutral, target, {3 / 8: between}, method="spline")
    found = em.MeshSequence(neutral, path.at(np.linspace(0, 1, 9)))
    em.write_sequence("scan.##.obj", found)
    return found


def run(*words: object, width: int = 100) -> str:
    """What the verb prints."""
    return printed_by("inbetweens", *words, width=width)


@pytest.mark.usefixtures("motion")
def test_the_table_names_frames_and_errors() -> None:
    printed = run("suggest", "scan.##.obj")
    lines = [line.split() for line in printed.splitlines()]
    numbers = [line[0] for line in lines if line and line[0].isdigit()]
    assert numbers == ["0", "1", "2", "3", "4"]
    assert "scan.04.obj (0.375)" in printed
    assert "linear" in printed


def test_json_has_what_the_library_finds(motion: em.MeshSequence) -> None:
    facts = json.loads(run("suggest", "scan.##.obj", "-n", 2, "--measure", "lae", "--json"))
    assert facts["frames"] == 9
    assert facts["measure"] == "lae"
    found = suggest_inbetweens(em.read_sequence("scan.##.obj"), 2, measure="lae")
    assert [each["indices"] for each in facts["suggestions"]] == [
        list(each.frames) for each in found
    ]
    one = facts["suggestions"][1]
    assert one["frames"] == ["scan.04.obj"]
    assert one["times"] == [3 / 8]
    assert one["lme"] < 1e-12 < facts["suggestions"][0]["lme"]
    assert one["all_compared"] is True
    assert facts["diameter"] == pytest.approx(motion.mesh.diameter)


@pytest.mark.usefixtures("motion")
def test_straight_pieces_can_be_asked_for() -> None:
    words = ("suggest", "scan.##.obj", "-n", 2, "--json", "--method")
    spline, straight = (json.loads(run(*words, law))["suggestions"] for law in ("spline", "linear"))
    assert [one["method"] for one in spline] == ["linear", "spline", "spline"]
    assert [one["method"] for one in straight] == ["linear", "piecewise", "piecewise"]
    assert straight[0] == spline[0]
    assert straight[1]["lme"] > spline[1]["lme"]


@pytest.mark.usefixtures("motion")
def test_the_law_that_won_is_named_and_its_overshoot_told() -> None:
    """The motion is a spline through its fourth frame, which rises to 1.03.

    One at τ = 1/8 has, x = (1 - t)/(1 - τ) before the end, b = x + 3.5(x - x³): 1.964 at most.
    """
    (_, one) = json.loads(run("suggest", "scan.##.obj", "-n", 1, "--json"))["suggestions"]
    assert one["method"] == "spline"
    assert 1 < one["largest_weight"] < 1.2
    assert "overshoots" not in run("suggest", "scan.##.obj", "-n", 1)
    for number in (3, 4, 5, 6, 7, 8):
        Path(f"scan.{number:02}.obj").unlink()
    printed = " ".join(run("suggest", "scan.##.obj", "--method", "spline").split())
    assert "The path overshoots, by weights up to 1.96 for 1; smooth never does." in printed


@pytest.mark.usefixtures("motion")
def test_four_at_most_are_usual_and_never_more_than_there_are_frames() -> None:
    for number in range(4, 9):
        Path(f"scan.{number:02}.obj").unlink()
    facts = json.loads(run("suggest", "scan.##.obj", "--json"))
    assert [each["count"] for each in facts["suggestions"]] == [0, 1, 2]
    assert "missing from the numbering" in run("suggest", "scan.##.obj")


@pytest.mark.usefixtures("motion")
def test_more_than_there_are_frames_is_an_error() -> None:
    with pytest.raises(ParameterError, match="room for 0 to 7 in-betweens, found 8"):
        run("suggest", "scan.##.obj", "-n", 8)


@pytest.mark.usefixtures("motion")
def test_a_graph_is_drawn() -> None:
    printed = run("suggest", "scan.##.obj", "-n", 2, "-o", "graph.svg")
    assert "written to graph.svg" in printed
    drawn = Path("graph.svg").read_text()
    for words in ("error by number of in-betweens", "largest error over time", "LME", "LAE"):
        assert words in drawn
    assert "In-betweens for scan.##.obj" in drawn


def test_a_graph_of_many_lines_is_drawn_without_a_legend(motion: em.MeshSequence) -> None:
    found = suggest_inbetweens(motion, 2)
    inbetween_graph(found * 6, motion.times, "many.svg")
    assert ">linear<" not in Path("many.svg").read_text()
    inbetween_graph(found[:1], motion.times, "linear.png")
    assert Path("linear.png").read_bytes().startswith(b"\x89PNG")


def test_a_graph_needs_suggestions(motion: em.MeshSequence) -> None:
    with pytest.raises(ParameterError, match="no suggestion"):
        inbetween_graph([], motion.times, "none.png")
    with pytest.raises(ParameterError, match="written as"):
        inbetween_graph(suggest_inbetweens(motion, 0), motion.times, "graph.jpg")


def test_a_table_is_legible_on_a_narrow_terminal(motion: em.MeshSequence) -> None:
    printed = run("suggest", "scan.##.obj", width=80)
    assert max(map(len, printed.splitlines())) <= 80
    assert "scan.04.obj (0.375)" in printed
    assert "> 1000" in printed  # nothing but rounding is left, which is no number to divide by
    assert len(motion) == 9
