"""``elastomorph evaluate``: compare methods with a recorded motion."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from elastomorph.cli import options

__all__ = ["add_to"]


def add_to(app: typer.Typer) -> None:
    """Add the verb to the command line."""
    app.command()(evaluate)


def evaluate(
    truth: Annotated[
        str, typer.Argument(help="Recorded frames: scan.####.obj, a folder, 'scan.*.ply', .npz.")
    ],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="Folder for tables, graphs and pictures."),
    ] = None,
    method: Annotated[
        list[str] | None,
        typer.Option(help="linear, cosine, ease:R, beam:R[:closure]; may be given repeatedly."),
    ] = None,
    mass: options.Mass = 1.0,
    damping: options.Damping = 1.0,
    rigidity: options.Rigidity = 1.0,
    keep: options.CurveFile = None,
    pictures: Annotated[
        bool, typer.Option(help="Draw graphs and faces into the output folder.")
    ] = True,
    as_json: options.AsJson = False,
) -> None:
    """Interpolate from the first recorded frame to the last and compare with those between.

    Example: elastomorph evaluate scan.####.obj -o out --method linear --method beam:2
    """
    from elastomorph.evaluation import DEFAULT_METHODS
    from elastomorph.evaluation import evaluate as compare
    from elastomorph.io import read_sequence

    with options.progress(as_json) as say:
        say("reading")
        motion = read_sequence(truth)
        result = compare(
            motion,
            method or DEFAULT_METHODS,
            options.network(motion.mesh, keep),
            material=options.material(mass, damping, rigidity),
            progress=say,
        )
        if output is not None:
            from elastomorph.report.evaluation_files import write_evaluation

            output.mkdir(parents=True, exist_ok=True)
            write_evaluation(result, output, graphs=pictures, faces=pictures, say=say)
    if as_json:
        typer.echo(result.to_json(), nl=False)
        return
    from rich.console import Console

    console = Console()
    if motion.missing:
        console.print(f"missing from the numbering: {', '.join(motion.missing)}")
    console.print(result.table())
    if output is not None:
        console.print(f"written to {output}/", highlight=False)
