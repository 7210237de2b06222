"""``elastomorph inbetweens``: where scanned in-betweens pay."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastomorph.cli import options
from elastomorph.cli.comparing import confidence_for, read_motion
from elastomorph.cli.output import Say, plain_table, times_smaller
from elastomorph.cli.verb import Answer, verb

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.table import Table

    from elastomorph.evaluation.inbetweens import Suggestion

_USUAL = 4

Frames = Annotated[str, typer.Argument(help=f"A recorded motion: {options.RECORDED}.")]
Count = Annotated[
    int | None,
    typer.Option("--count", "-n", help=f"Most in-betweens; {_USUAL} where there are frames."),
]
Measure = Annotated[
    str, typer.Option(help="Choose by lme (largest error), lae (largest of a curve) or mean.")
]
Method = Annotated[
    str | None,
    typer.Option(help="smooth, spline or piecewise; by default smooth or spline, the better."),
]


@verb
def suggest(
    truth: Frames,
    count: Count = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="A graph: .png, .svg or .pdf.")
    ] = None,
    measure: Measure = "lme",
    method: Method = None,
    clip: options.ClipName = None,
    keep: options.CurveFile = None,
    settings: options.SettingsFile = None,
    *,
    say: Say,
) -> Answer:
    """Find the recorded frames that pay most as in-betweens.

    Example: elastomorph inbetweens suggest scan.####.obj -n 2 -o inbetweens.png
    """
    from rich.console import Console

    from elastomorph.evaluation.confidence import counted_of
    from elastomorph.evaluation.inbetweens import suggest_inbetweens

    say("reading")
    recording, network = read_motion(truth, options.curve_file(keep, settings), clip)
    motion = recording.motion
    found = suggest_inbetweens(
        motion,
        min(_USUAL, len(motion) - 2) if count is None else count,
        curves=network,
        measure=measure,
        method=method,
        counted=counted_of(confidence_for(truth, recording, None, None)),
        progress=say,
    )
    if output is not None:
        from elastomorph.draw.graphs import inbetween_graph

        say("drawing")
        inbetween_graph(found, motion.times, output, title=f"In-betweens for {truth}")

    def tell() -> None:
        console = Console()
        if motion.missing:
            console.print(f"missing from the numbering: {', '.join(motion.missing)}")
        console.print(_table(found))
        if output is not None:
            console.print(f"written to {output}", highlight=False)

    facts = {
        "motion": truth,
        "frames": len(motion),
        "diameter": motion.mesh.diameter,
        "measure": measure,
        "suggestions": [_facts(suggestion) for suggestion in found],
    }
    return Answer(facts, tell)


def _facts(suggestion: Suggestion) -> dict[str, Any]:
    return {
        "count": len(suggestion.frames),
        "method": suggestion.law,
        "largest_weight": suggestion.largest_weight,
        "frames": list(suggestion.names),
        "indices": list(suggestion.frames),
        "times": list(suggestion.times),
        "lme": suggestion.lme,
        "lae": suggestion.lae,
        "mean_lme": suggestion.mean_lme,
        "mean_lae": suggestion.mean_lae,
        "all_compared": suggestion.certain,
    }


def _table(suggestions: Sequence[Suggestion]) -> Table:
    from rich.text import Text

    from elastomorph.paths.through import OVERSHOOT

    legend = "Errors in % of D; ÷: how many times smaller the LME is than without in-betweens."
    if not all(suggestion.certain for suggestion in suggestions):
        legend += " ~: not every choice of frames was compared."
    swinging = [each for each in suggestions if each.largest_weight > OVERSHOOT]
    if swinging:
        weights = ", ".join(
            f"{each.largest_weight:.2f} for {len(each.frames)}" for each in swinging
        )
        legend += f" The path overshoots, by weights up to {weights}; smooth never does."
    headers = ("n", "LME", "÷", "LAE", "mean\nLME", "mean\nLAE", "method")
    table = plain_table(("method",), headers, caption=legend, caption_justify="left")
    table.add_column("frames (t)")
    linear = suggestions[0]
    for each in suggestions:
        errors = (each.lme, each.lae, each.mean_lme, each.mean_lae)
        lme, lae, mean_lme, mean_lae = (f"{100 * error:.3f}" for error in errors)
        ratio = times_smaller(linear.lme, each.lme) if each.frames else ""
        where = ", ".join(
            f"{name} ({time:.3f})" for name, time in zip(each.names, each.times, strict=True)
        )
        number = str(len(each.frames)) + ("" if each.certain else "~")
        table.add_row(number, lme, ratio, lae, mean_lme, mean_lae, each.law, Text(where))
    return table
