"""``elastomorph demo``: the whole paper on the built-in face, or on a rig."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from elastomorph.cli import options
from elastomorph.cli.call_words import call_words

if TYPE_CHECKING:
    from elastomorph.report.walkthrough import Walkthrough

__all__ = ["add_to"]


def add_to(app: typer.Typer) -> None:
    """Add the verb to the command line."""
    app.command()(demo)


def demo(
    context: typer.Context,
    data: Annotated[
        Path | None,
        typer.Option(help="A folder with a rig: a neutral and its targets. Default: built-in."),
    ] = None,
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Folder for everything it makes.")
    ] = Path("out"),
    settings: options.SettingsFile = None,
    as_json: options.AsJson = False,
) -> None:
    """Run the paper on a face: curves, in-betweens by every method, errors, graphs and pictures.

    Example: elastomorph demo --data path/to/rig -o out
    """
    from elastomorph.report.subject import built_in_subject, rig_subject
    from elastomorph.report.walkthrough import walk_through

    start = time.perf_counter()
    with options.progress(as_json) as say:
        # The targets are what counts, for every method is tried: the straight lines cost nothing.
        chosen = options.settings_of(data, settings, "linear")
        if chosen is not None:
            from elastomorph.settings import rig_from_settings

            rig = rig_from_settings(chosen, say=say)
            subject = rig_subject(chosen.character.folder, say, rig)
        else:
            say("building the head" if data is None else f"reading {data}")
            subject = built_in_subject() if data is None else rig_subject(data, say)
        found = walk_through(subject, output, say, call=call_words(context))
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

    from elastomorph.report.walkthrough_report import motion_words, target_words

    console = Console()
    subject = found.subject
    console.print(
        f"{subject.name}: {len(subject.neutral.vertices):,} vertices on {len(found.curves):,} "
        f"curves, {len(found.targets)} targets"
    )
    if found.evaluation is not None:
        console.print("\n" + motion_words(subject), soft_wrap=True, highlight=False)
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
    console.print(target_words(found.targets), highlight=False)
    console.print(f"\n{len(found.written)} files in {output}/, {seconds:.1f} s", highlight=False)
    if (output / "report.html") in found.written:
        console.print(f"Begin with {output / 'report.html'}", highlight=False)
