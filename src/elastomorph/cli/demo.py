"""``elastomorph demo``: the whole paper on the built-in face, or on a rig."""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from elastomorph.cli import options

if TYPE_CHECKING:
    from elastomorph.report.walkthrough import Walkthrough

__all__ = ["add_to"]


def add_to(app: typer.Typer) -> None:
    """Add the verb to the command line."""
    app.command()(demo)


def demo(
    data: Annotated[
        Path | None,
        typer.Option(help="A folder with a rig: a neutral and its targets. Default: built-in."),
    ] = None,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Folder for everything it makes.")
    ] = Path("out"),
    as_json: options.AsJson = False,
) -> None:
    """Run the paper on a face: curves, in-betweens by every method, errors, graphs and pictures.

    Example: elastomorph demo --data path/to/rig -o out
    """
    from elastomorph.report.subject import built_in_subject, rig_subject
    from elastomorph.report.walkthrough import walk_through

    start = time.perf_counter()
    with options.progress(as_json) as say:
        say("building the head" if data is None else f"reading {data}")
        subject = built_in_subject() if data is None else rig_subject(data, say)
        found = walk_through(subject, output, say)
    seconds = time.perf_counter() - start
    if as_json:
        options.print_json(_facts(found, seconds))
    else:
        _tell(found, seconds, output)


def _facts(found: Walkthrough, seconds: float) -> dict[str, object]:
    return {
        "face": found.subject.name,
        "vertices": len(found.subject.neutral.vertices),
        "curves": len(found.curves),
        "targets": len(found.targets),
        "seams": {seam.closure: seam.shape.seam for seam in found.seams},
        "flips": {seam.closure: seam.shape.flips for seam in found.seams},
        "methods": {
            result.label: {"LME": result.lme, "LAE": result.lae, "path LME": result.path_lme}
            for result in (found.evaluation.results if found.evaluation else ())
        },
        "files": [str(path) for path in found.written],
        "seconds": round(seconds, 2),
    }


def _tell(found: Walkthrough, seconds: float, output: Path) -> None:
    from rich.console import Console
    from rich.table import Table

    console = Console()
    subject = found.subject
    console.print(
        f"{subject.name}: {len(subject.neutral.vertices):,} vertices on {len(found.curves):,} "
        f"curves, {len(found.targets)} targets"
    )
    if found.evaluation is not None:
        console.print("\n" + _what_is_compared(found), soft_wrap=True, highlight=False)
        console.print(found.evaluation.table())
    table = Table(title=f"{subject.jaw}, quadratic beam at t = 0.5", title_justify="left")
    for column in ("closure", "seam, % of D", "flips", "stretch"):
        table.add_column(column, justify="left" if column == "closure" else "right")
    for seam in found.seams:
        shape = seam.shape
        table.add_row(
            seam.closure, f"{100 * shape.seam:.3f}", f"{shape.flips:,}", f"{shape.stretch:.2f}"
        )
    console.print(table)
    farthest = max(found.targets, key=lambda facts: facts.from_ease)
    console.print(
        f"Of {len(found.targets)} targets, the quadratic beam differs from the ease t² by at most "
        f"{farthest.from_ease:.3%} of D ({farthest.name}, t = 0.5): on these materials it changes "
        "when a shape arrives, hardly the way it takes.",
        highlight=False,
    )
    console.print(f"\n{len(found.written)} files in {output}/, {seconds:.1f} s", highlight=False)


def _what_is_compared(found: Walkthrough) -> str:
    parts = found.subject.rigid_parts
    if found.subject.motion is not None or parts is None:
        return "Against the recorded motion of 11 poses, from an anatomical model without the PDE:"
    degrees = math.degrees(parts.screw.angle)
    return (
        f"Against the {parts.components} parts ({len(parts.vertices):,} vertices, their own D) "
        f"that turn rigidly with {found.subject.jaw}, by {degrees:.1f}°. Their arc is known, their "
        "timing is not: only the path columns count."
    )
