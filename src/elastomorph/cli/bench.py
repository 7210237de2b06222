"""``elastomorph bench``: how fast faces come on this machine."""

from __future__ import annotations

from typing import Annotated

import typer

from elastomorph.cli import completion, options
from elastomorph.cli.output import Say
from elastomorph.cli.verb import Answer, verb


@verb
def bench(
    rig: options.OptionalRig = None,
    expressions: completion.Expressions = None,
    method: Annotated[
        str,
        typer.Option(
            help="linear, cosine, ease:R, beam:R or beam:R:closure.",
            autocompletion=completion.methods,
        ),
    ] = "beam:3",
    mesh: options.MeshNames = None,
    settings: options.SettingsFile = None,
    levels: Annotated[int, typer.Option(help="Values of each weight.", min=2)] = 6,
    t: Annotated[float, typer.Option("--time", "-t", help="Common time of all faces.")] = 0.5,
    repeats: Annotated[int, typer.Option(help="Runs; the shortest counts.", min=1, max=1000)] = 5,
    *,
    say: Say,
) -> Answer:
    """Time the paper's experiment: all combinations of five expressions, beside its bounds.

    Example: elastomorph bench path/to/rig --levels 4
    """
    from elastomorph.evaluation.speed import PAPER_MILLISECONDS, PAPER_VERTICES, face_speeds

    face_rig = options.NamedRig.of(rig, settings, method, mesh).expressions(say, expressions)
    targets = list(face_rig.targets.values())
    count, speeds = face_speeds(
        face_rig.neutral, targets, method=method, levels=levels, t=t, repeats=repeats, say=say
    )
    vertices = len(face_rig.neutral.vertices)

    def tell() -> None:
        typer.echo(f"{count:,} faces of {vertices:,} vertices, {method}, t = {t:g}\n")
        typer.echo(f"{'':<22}{'faces/s':>10}{'µs/face':>11}{'ns/vertex':>11}{'paper ÷ it':>12}")
        for row in speeds:
            size = PAPER_VERTICES if row.name.startswith("the paper") else vertices
            microseconds = 1e6 * row.seconds_a_face
            typer.echo(
                f"{row.name:<22}{1e6 / microseconds:>10,.0f}{microseconds:>11,.1f}"
                f"{1e3 * microseconds / size:>11,.2f}"
                f"{1e3 * PAPER_MILLISECONDS / microseconds:>12,.0f}   {row.note}"
            )

    rows = {row.name: {"us_per_face": 1e6 * row.seconds_a_face} for row in speeds}
    return Answer({"faces": count, "vertices": vertices, "rows": rows}, tell)
