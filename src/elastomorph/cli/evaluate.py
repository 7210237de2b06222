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
    every: Annotated[
        bool, typer.Option("--all", help="Every method, scanned in-betweens too, ranked.")
    ] = False,
    rigid: Annotated[
        str | None,
        typer.Option(help="Vertices known to be rigid: a .json list, or 0-99,120."),
    ] = None,
    method: Annotated[
        list[str] | None,
        typer.Option(help="linear, cosine, ease:R, beam:R[:closure]; may be given repeatedly."),
    ] = None,
    mass: options.Mass = 1.0,
    damping: options.Damping = 1.0,
    stiff: options.Rigidity = 1.0,
    keep: options.CurveFile = None,
    pictures: Annotated[
        bool, typer.Option(help="Draw graphs and faces into the output folder.")
    ] = True,
    as_json: options.AsJson = False,
) -> None:
    """Interpolate from the first recorded frame to the last and compare with those between.

    Example: elastomorph evaluate scan.####.obj -o out --method linear --method beam:2
    """
    from elastomorph.errors import ParameterError
    from elastomorph.evaluation import DEFAULT_METHODS, every_method, rigidity
    from elastomorph.evaluation import evaluate as compare
    from elastomorph.evaluation.summary import rankings, summaries
    from elastomorph.io import read_sequence
    from elastomorph.io.region_file import read_region

    if every and method:
        raise ParameterError("give --all or --method, not both")

    with options.progress(as_json) as say:
        say("reading")
        motion = read_sequence(truth)
        material = options.material(mass, damping, stiff)
        network = options.network(motion.mesh, keep)
        result = compare(
            motion,
            every_method(motion, network, material=material, progress=say)
            if every
            else method or DEFAULT_METHODS,
            network,
            material=None if every else material,
            progress=say,
        )
        bodies = {}
        if rigid is not None:
            body = read_region(rigid)
            for each in result.results:
                bodies[each.label] = rigidity(each.morph, body, motion.times[1:-1])
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
    for sentence in rankings(summaries(result)) if every else ():
        console.print(sentence, highlight=False)
    if bodies:
        ends = next(iter(bodies.values())).ends
        console.print(f"\nrigid body, as its ends show within {ends:.3%} of D", highlight=False)
        console.print("change of distances, distance from its screw, % of D:")
    for label, found in bodies.items():
        console.print(
            f"  {label:<22}{100 * found.change:8.3f}{100 * found.off_screw:8.3f}", highlight=False
        )
    if output is not None:
        console.print(f"written to {output}/", highlight=False)
