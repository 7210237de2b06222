"""Everything an evaluation has to show, written into one folder."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from elastomorph.draw.graphs import error_graphs, time_graphs
from elastomorph.draw.pictures import write_picture
from elastomorph.evaluation import Evaluation
from elastomorph.io.atomic import replacing
from elastomorph.report.images import Picture

__all__ = ["write_evaluation", "write_text"]


def write_evaluation(
    evaluation: Evaluation,
    folder: Path,
    *,
    graphs: bool = True,
    faces: Sequence[Picture] = (),
    say: Callable[[str], None] = lambda _: None,
) -> list[Path]:
    """Write the table, the errors and the graphs of an evaluation, and pictures of it.

    Args:
        evaluation: Methods compared with a recorded motion.
        folder: Where to write; it must exist.
        graphs: Draw graphs too, which needs the extra ``demo``.
        faces: Pictures drawn already, see `evaluation_pictures`; they need the extra too.
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
    for picture in faces:
        written.append(folder / f"{picture.name}.png")
        write_picture(picture.image, written[-1])
    return written


def write_text(path: Path, text: str) -> Path:
    """Write a text file, the whole of it or nothing."""
    with replacing(path) as file:
        file.write(text.encode())
    return path
