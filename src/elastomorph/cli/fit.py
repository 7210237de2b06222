"""``elastomorph fit``: materials and loads from captured motion."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from elastomorph.cli import options
from elastomorph.cli.comparing import read_motion
from elastomorph.cli.output import Say
from elastomorph.cli.verb import Answer, verb

Motions = Annotated[
    list[str], typer.Argument(help=f"Motions of one mesh, each {options.RECORDED}.")
]
Closure = Annotated[
    str,
    typer.Option(help="Time law of a curve's mean: limit, compatible, rest, unforced, linear."),
]


@verb
def fit(
    motions: Motions,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Write what was found as JSON.")
    ] = None,
    degree: Annotated[
        int | None,
        typer.Option(help="Degree of the load, 1 to 6; the best of 1 to 4 by default."),
    ] = None,
    per_curve: Annotated[
        bool, typer.Option("--per-curve", help="Also fit every curve alone.")
    ] = False,
    closure: Closure = "limit",
    clip: options.ClipName = None,
    keep: options.CurveFile = None,
    settings: options.SettingsFile = None,
    *,
    say: Say,
) -> Answer:
    """Estimate material and load common to recorded motions.

    Each motion goes from its first frame to its last; with several, each is also compared with
    the fit of all others.

    Example: elastomorph fit smile1.npz smile2.npz smile3.npz -o fit.json
    """
    from rich.console import Console

    from elastomorph.fitting import fit as estimate
    from elastomorph.io.atomic import replacing
    from elastomorph.io.sequences import whole

    say("reading")
    named = options.curve_file(keep, settings)
    read = [read_motion(motion, named, clip) for motion in motions]
    found = estimate(
        [whole(motion, taken) for motion, (taken, _) in zip(motions, read, strict=True)],
        read[0][1],
        degree=degree,
        per_curve=per_curve,
        closure=closure,
        progress=say,
    )
    facts = {"sources": motions, **found.to_dict()}
    if output is not None:
        text = json.dumps(facts, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
        with replacing(output) as file:
            file.write(text.encode())

    def tell() -> None:
        console = Console()
        console.print(found.text(console.width), markup=False, highlight=False, soft_wrap=True)
        if output is not None:
            console.print(f"written to {output}", markup=False, highlight=False)

    return Answer(facts, tell)
