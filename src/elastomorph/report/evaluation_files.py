"""Everything an evaluation has to show, written into one folder."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from elastomorph.evaluation import Evaluation
from elastomorph.io.atomic import replacing
from elastomorph.report.graphs import error_graphs, time_graphs
from elastomorph.report.strips import error_strip, method_strip, side_by_side

__all__ = ["write_evaluation", "write_text"]


def write_evaluation(
    evaluation: Evaluation,
    folder: Path,
    *,
    graphs: bool = True,
    faces: bool = True,
    say: Callable[[str], None] = lambda _: None,
) -> list[Path]:
    """Write the table, the errors, the graphs and the pictures of an evaluation.

    Args:
        evaluation: Methods compared with a recorded motion.
        folder: Where to write; it must exist.
        graphs: Draw graphs too, which needs the extra ``demo``.
        faces: Draw the recorded and the interpolated faces too, where there are polygons.
        say: Told what is being done.

    Returns:
        The files written.

    Raises:
        FileError: A file cannot be written.
        MissingExtraError: matplotlib or vtk is not installed.
    """
    written = [
        write_text(folder / "table.csv", evaluation.to_csv()),
        write_text(folder / "errors.csv", evaluation.to_long_csv()),
        write_text(folder / "evaluation.json", evaluation.to_json()),
    ]
    if graphs:
        say("drawing graphs")
        for name, draw in (("errors-by-curve", error_graphs), ("errors-by-time", time_graphs)):
            for suffix in (".png", ".svg"):
                written.append(folder / f"{name}{suffix}")
                draw(evaluation, written[-1])
    if faces and len(evaluation.truth.mesh.faces):
        say("drawing faces")
        method_strip(evaluation, folder / "in-betweens.png")
        side_by_side(evaluation, folder / "side-by-side.png", labels=_pair(evaluation))
        error_strip(evaluation, folder / "error-heat-map.png")
        for name in ("in-betweens", "side-by-side", "error-heat-map"):
            written.append(folder / f"{name}.png")
    return written


def write_text(path: Path, text: str) -> Path:
    """Write a text file, the whole of it or nothing."""
    with replacing(path) as file:
        file.write(text.encode())
    return path


def _pair(evaluation: Evaluation) -> list[str]:
    """The quadratic beam beside the straight line as in the paper, or what there is."""
    labels = [result.label for result in evaluation.results]
    wanted = [label for label in labels if label in ("beam R=2", "linear")]
    return sorted(wanted) or labels[:2]
